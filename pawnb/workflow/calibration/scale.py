"""Px per unit of a trial: from a grid of known spacing in its empty scene, and into its file."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from pawnb.core.pose.pixel_scale import PxPerUnit, scale_from_grid
from pawnb.core.video import open_views
from pawnb.errors import InputError
from pawnb.files import MOST_TEXT_BYTES, locked, parse_toml, read_text
from pawnb.io.tables import write_text
from pawnb.trial import Calibration, Trial, load_trial
from pawnb.trial.one_field import says, with_field
from pawnb.workflow.calibration.name_in_trial import WAIT_FOR_TRIAL_S
from pawnb.workflow.start.propose_pose import trial_background


def find_grid_scale(trial: Trial | str | Path, *, spacing: float) -> PxPerUnit:
    """Measure the grid under the animal in the empty scene of a trial's first view.

    :func:`write_scale` writes it into ``trial.toml``.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    spacing : float
        Distance of neighbouring lines in the unit wanted, for instance 10 for a 1 cm grid
        in mm.

    Returns
    -------
    PxPerUnit
        The scale and its standard error.

    Raises
    ------
    InputError
        If there is no grid that can be measured.
    """
    trial = trial if isinstance(trial, Trial) else load_trial(trial)
    with open_views(trial) as views:
        return scale_from_grid(trial_background(trial, views).mean, spacing=spacing)


def write_scale(trial: Trial, px_per_unit: float) -> Trial:
    """Write ``px_per_unit`` into ``[calibration]`` of a trial's ``trial.toml``.

    Everything else in the file, comments included, stays as it is.

    Parameters
    ----------
    trial : Trial
        A trial that was read from its ``trial.toml``.
    px_per_unit : float
        Px of the view per unit of the calibration (mm where it names none).

    Returns
    -------
    Trial
        The trial with that scale.

    Raises
    ------
    InputError
        If the trial is calibrated by DLT coefficients, has no ``trial.toml``, or writes its
        calibration in a way that cannot be changed here; if the file has another scale than
        the trial, since it was changed after the trial was read.
    """
    calibration = trial.calibration or Calibration()
    if calibration.of_views is not None:
        raise InputError(
            f"trial {trial.name!r} is calibrated by {calibration.of_views}, which has its own "
            "scale; px_per_unit is for a single view."
        )
    path = trial.path("trial.toml")
    value = float(f"{px_per_unit:.6g}")
    if not path.is_file():
        raise InputError(
            f"{path}: no such file; write px_per_unit = {value:g} under [calibration] of the "
            "trial's file."
        )
    with locked(path, remedy="press again in a moment", wait_s=WAIT_FOR_TRIAL_S):
        _put_scale(path, value, calibration)
    return dataclasses.replace(
        trial, calibration=dataclasses.replace(calibration, px_per_unit=value)
    )


def _put_scale(path: Path, value: float, known: Calibration) -> None:
    """Change the scale in a file; raise InputError where it is not as it was read."""
    before = read_text(path, expected="a trial.toml", most_bytes=MOST_TEXT_BYTES)
    expected = parse_toml(before, where=str(path))
    section = expected.setdefault("calibration", {"unit": known.unit})
    there = section.get("px_per_unit")
    if there != known.px_per_unit:
        was = "none" if known.px_per_unit is None else f"{known.px_per_unit:g}"
        raise InputError(
            f"{path}: px_per_unit is {'gone' if there is None else there} there and was {was} when "
            "the trial was read, so another window or program has changed it; it was left as it "
            f"is, and {value:g} was not written: open the trial again."
        )
    section["px_per_unit"] = value
    start = before
    if "calibration" not in parse_toml(before, where=str(path)):
        start = with_field(before, "calibration", "unit", value="mm")
    after = with_field(start, "calibration", "px_per_unit", value=value)
    if not says(after, expected):
        raise InputError(
            f"{path}: its calibration is not written as a section [calibration]; write "
            f"px_per_unit = {value:g} there yourself."
        )
    write_text(after, path)
