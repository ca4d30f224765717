"""Positions of a single view in the unit of length that its scale gives."""

from __future__ import annotations

from pawnb.schema import Tracks
from pawnb.trial import Trial


def in_real_units(tracks: Tracks, trial: Trial, *, units: str | None = None) -> Tracks:
    """Bring positions of a single view from px to the calibrated unit.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; not modified.
    trial : Trial
        The trial they belong to.
    units : str, optional
        What positions are in; default what the tracks say. Tracks that were gone on with say
        what the earlier ones were in.

    Returns
    -------
    xarray.Dataset
        Tracks whose ``position``, ``sd`` and ``revision`` are divided by ``[calibration]
        px_per_unit``; the same Tracks where the trial has none, or where positions are not
        in px.
        ``image_position`` stays in px.
    """
    calibration = trial.calibration
    if calibration is None or calibration.px_per_unit is None:
        return tracks
    if (units or tracks.attrs["units"]) != "px":
        return tracks
    scaled = {
        name: (tracks[name] / calibration.px_per_unit).assign_attrs(units=calibration.unit)
        for name in ("position", "sd", "revision")
        if name in tracks
    }
    return tracks.assign(scaled).assign_attrs(units=calibration.unit)
