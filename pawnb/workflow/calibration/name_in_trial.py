"""Naming a calibration in ``trial.toml``, everything else in the file left as it is."""

from __future__ import annotations

from pathlib import Path

from pawnb.errors import InputError
from pawnb.files import MOST_TEXT_BYTES, locked, parse_toml, read_text
from pawnb.io.tables import write_text
from pawnb.trial import Trial, load_trial
from pawnb.trial.one_field import says, with_field
from pawnb.workflow.calibration.written import Written

WAIT_FOR_TRIAL_S = 5.0


def name_calibration(trial: Trial, written: Written, *, unit: str) -> Trial:
    """Write into ``trial.toml`` that a trial is calibrated by what was just written.

    Parameters
    ----------
    trial : Trial
        A trial that was read from its ``trial.toml``.
    written : Written
        The calibration, of the whole, unmirrored pictures, in the trial's folder.
    unit : str
        The unit of its lengths.

    Returns
    -------
    Trial
        The trial with that calibration.

    Raises
    ------
    InputError
        If its cameras are not the trial's views, it lies elsewhere, or the trial is calibrated
        another way or writes its calibration so that it cannot be changed here.
    """
    views = [view.name for view in trial.views]
    if list(written.views) != views:
        raise InputError(
            f"the calibration is of {', '.join(written.views)}; the trial's views are "
            f"{', '.join(views)}."
        )
    if written.out.resolve().parent != trial.folder.resolve():
        raise InputError(f"{written.out} is not in the trial's folder, {trial.folder}.")
    fields = {"dlt": written.out.name, "unit": unit, "pixels": "file"}
    if written.lenses is not None:
        fields["lens"] = written.lenses.name
    path = trial.path("trial.toml")
    with locked(path, remedy="press again in a moment", wait_s=WAIT_FOR_TRIAL_S):
        _put(path, fields)
    return load_trial(path)


def _put(path: Path, fields: dict[str, str]) -> None:
    """Change the file; raise InputError, and leave it, where that is not all that changes."""
    before = read_text(path, expected="a trial.toml", most_bytes=MOST_TEXT_BYTES)
    expected = parse_toml(before, where=str(path))
    section = expected.setdefault("calibration", {})
    other = [name for name in ("px_per_unit", "anipose", "opencv") if name in section]
    if other:
        raise InputError(
            f"{path}: [calibration] has {', '.join(other)} already; take that out first, as a "
            "trial is calibrated one way."
        )
    section |= fields
    for name in ("lens", "v"):  # they belong to the coefficients that were there before
        if name not in fields:
            section.pop(name, None)
    after = before
    for name in ("dlt", "unit", "pixels", "lens", "v"):
        after = with_field(after, "calibration", name, value=fields.get(name))
    if not says(after, expected):
        lines = "; ".join(f'{name} = "{value}"' for name, value in fields.items())
        raise InputError(
            f"{path}: its calibration is not written as a section [calibration]; write {lines} "
            "there yourself."
        )
    write_text(after, path)
