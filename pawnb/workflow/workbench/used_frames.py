"""Fields that the workbench writes into ``trial.toml``: frames, offsets, corrected tracks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pawnb.core.edits.log import EDIT_LINES
from pawnb.errors import InputError
from pawnb.files import MOST_TEXT_BYTES, keep_copy, locked, parse_toml, read_text
from pawnb.io.journal import read_journal
from pawnb.io.tables import write_text
from pawnb.trial import Trial, load_trial
from pawnb.trial.one_field import says, with_field
from pawnb.workflow.calibration.name_in_trial import WAIT_FOR_TRIAL_S
from pawnb.workflow.provenance.results import results_folder


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


def write_offsets(trial: Trial, offsets: Mapping[str, int]) -> Path | None:
    """Write the ``offset`` of each view into a trial's ``trial.toml``.

    Clicks are of the pictures as they were aligned before: their file is set aside.

    Parameters
    ----------
    trial : Trial
        A trial that was read from its ``trial.toml``.
    offsets : mapping of str to int
        View to the frame of its file that belongs to frame 0 of the trial.

    Returns
    -------
    Path or None
        Where the clicks are kept; None where there were none, or no offset has changed.

    Raises
    ------
    InputError
        If points were corrected in the pictures as they are, or ``trial.toml`` cannot be changed
        here.
    """
    if all(offsets[view.name] == view.offset for view in trial.views):
        return None
    edits = results_folder(trial) / "edits.jsonl"
    if edits.exists() and read_journal(edits, EDIT_LINES)[0]:
        raise InputError(
            f"{edits} holds corrections of the pictures as they are aligned now; take them back in "
            "the review, or move that file elsewhere, and align again."
        )
    path = trial.path("trial.toml")
    with locked(path, remedy="press again in a moment", wait_s=WAIT_FOR_TRIAL_S):
        before = read_text(path, expected="a trial.toml", most_bytes=MOST_TEXT_BYTES)
        expected = parse_toml(before, where=str(path))
        after = before
        for k, view in enumerate(expected.get("views", [])):
            view.pop("offset", None)
            offset = offsets[view["name"]] or None
            if offset is not None:
                view["offset"] = offset
            after = with_field(after, "views", "offset", value=offset, item=k)
        if not says(after, expected):
            lines = ", ".join(f"{offset} of {name}" for name, offset in offsets.items())
            raise InputError(
                f"{path}: its views are not written as sections [[views]]; write the offsets there "
                f"yourself: {lines}."
            )
        write_text(after, path)
    name = trial.start_pose_file() if trial.is_jointed else trial.start_file()
    if name is None or not (clicks := trial.path(name)).exists():
        return None
    kept = keep_copy(clicks, "before")
    clicks.unlink()
    return kept


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
