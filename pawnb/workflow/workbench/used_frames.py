"""The frames of a recording that are used, written into ``trial.toml``."""

from __future__ import annotations

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
    path = trial.path("trial.toml")
    value = [int(frame) for frame in frames]
    with locked(path, remedy="press again in a moment", wait_s=WAIT_FOR_TRIAL_S):
        before = read_text(path, expected="a trial.toml", most_bytes=MOST_TEXT_BYTES)
        expected = parse_toml(before, where=str(path))
        expected.setdefault("trial", {})["frames"] = value
        after = with_field(before, "trial", "frames", value=value)
        if not says(after, expected):
            raise InputError(
                f"{path}: its frames are not written on a line of a section [trial]; write frames "
                f"= {value} there yourself."
            )
        write_text(after, path)
    return load_trial(path)
