"""Fields that the workbench writes into ``trial.toml``: frames that are used, corrected tracks."""

from __future__ import annotations

import json

from pawnb.errors import InputError
from pawnb.files import MOST_TEXT_BYTES, locked, parse_toml, read_text
from pawnb.io.tables import write_text
from pawnb.trial import Trial, load_trial
from pawnb.trial.one_field import says, with_field
from pawnb.workflow.calibration.name_in_trial import WAIT_FOR_TRIAL_S


def write_frames(trial: Trial, frames: tuple[int, int]) -> Trial:
    """Write ``frames`` into ``[trial]`` of a trial's ``trial.toml``.

    Everything else in the file, comments included, stays as it is.

    Parameters
    ----------
    trial : Trial
        A trial that was read from its ``trial.toml``.
    frames : tuple of int
        The first frame to use, and one past the last.

    Returns
    -------
    Trial
        The trial with these frames.

    Raises
    ------
    InputError
        If the trial has no ``trial.toml``, or one that cannot be changed here.
    """
    return _write(trial, "trial", "frames", [int(frame) for frame in frames])


def write_tracks_file(trial: Trial, file: str) -> Trial:
    """Write into ``[tracks]`` of a trial's ``trial.toml`` another file of tracks.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``tracks`` that was read from its ``trial.toml``.
    file : str
        The file, relative to the trial.

    Returns
    -------
    Trial
        The trial with these tracks.

    Raises
    ------
    InputError
        If the trial has no ``trial.toml``, or one that cannot be changed here.
    """
    return _write(trial, "tracks", "file", file)


def _write(trial: Trial, section: str, name: str, value: str | list[int]) -> Trial:
    """Write a field, and leave everything else as it is."""
    path = trial.path("trial.toml")
    with locked(path, remedy="press again in a moment", wait_s=WAIT_FOR_TRIAL_S):
        before = read_text(path, expected="a trial.toml", most_bytes=MOST_TEXT_BYTES)
        expected = parse_toml(before, where=str(path))
        expected.setdefault(section, {})[name] = value
        after = with_field(before, section, name, value=value)
        if not says(after, expected):
            raise InputError(
                f"{path}: its {name} is not written on a line of a section [{section}]; write "
                f"{name} = {json.dumps(value, ensure_ascii=False)} there yourself."
            )
        write_text(after, path)
    return load_trial(path)
