"""Axes of a calibration that are not those of the animal, told by the clicks on its paws."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.core.rig import Rig
from pawnb.workflow.start.propose import PAWS

MOST_TURNED_DEG = 45.0
"""Front paws lie ahead of hind paws within this (by hand: one paw in the air or beside another)."""

_LONGER = 1.2
"""And farther from them than left from right, by this: in a gallop they meet for a moment."""


def tell_turned_axes(rig: Rig, clicks: pd.DataFrame) -> list[str]:
    """Say where the clicks show an animal that does not lie along forward and up.

    Axes of a board or a wand are those of the animal only by care or by chance.

    Parameters
    ----------
    rig : Rig
        The calibrated views.
    clicks : pandas.DataFrame
        The start clicks: frame, view, point, u, v in px.

    Returns
    -------
    list of str
        At most a sentence for each frame in which all four paws of a mouse are seen in space.
    """
    said = []
    for frame, group in clicks.groupby("frame", sort=True):
        places = {str(p): _place_in_space(rig, own) for p, own in group.groupby("point")}
        if set(PAWS) <= places.keys() and all(np.isfinite(places[paw]).all() for paw in PAWS):
            text = _tell_of_paws(rig, places)
            said += [f"in frame {frame} {text}"] if text else []
    return said


def _place_in_space(rig: Rig, clicks: pd.DataFrame) -> FloatArray:
    """Return where a point is in space (3,); NaN where fewer than two views show it."""
    uv = np.full((len(rig.names), 2), np.nan)
    for row in clicks.itertuples():
        uv[rig.names.index(str(row.view))] = row.u, row.v
    return rig.triangulate(uv).xyz


def _tell_of_paws(rig: Rig, places: Mapping[str, FloatArray]) -> str:
    """Say what is turned, in words; nothing where all is well.

    Front paws behind hind paws are no reason alone: they are so for a moment in a gallop.
    """
    forward = np.array(rig.forward)
    FR, HR, FL, HL = (places[paw] for paw in PAWS)
    across, along = (FR + HR - FL - HL) / 2, (FR + FL - HR - HL) / 2
    to_right, ahead = float(across @ np.cross(forward, rig.up)), float(along @ forward)
    other_order = "or the columns of the calibration are in another order than the views"
    if to_right < 0 and ahead < 0:
        return (
            f"the animal is turned round: front paws lie {-ahead:.1f} {rig.unit} behind hind paws, "
            f"and left paws {-to_right:.1f} {rig.unit} to the right of right ones: [calibration] "
            f"forward is the wrong way round, {other_order}"
        )
    length = float(np.linalg.norm(along))
    turned_deg = float(np.degrees(np.arccos(np.clip(ahead / max(length, 1e-12), -1.0, 1.0))))
    if turned_deg > MOST_TURNED_DEG and length > _LONGER * float(np.linalg.norm(across)):
        x, y, z = along / length
        return (
            f"front paws lie towards ({x:.2f}, {y:.2f}, {z:.2f}) of hind paws, {turned_deg:.0f} "
            "degrees from [calibration] forward: the axes are those of the board or wand and not "
            "of the animal; write forward and up into trial.toml as they are in these axes, or "
            "calibrate with x along its way and z up"
        )
    if to_right >= 0:
        return ""
    return (
        f"left paws lie {-to_right:.1f} {rig.unit} to the right of right ones: they are clicked "
        f"under each other's names, [calibration] up is the wrong way round, {other_order}"
    )
