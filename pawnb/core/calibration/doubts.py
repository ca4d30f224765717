"""What looks wrong in a calibration that fits: mirrored views, clicks of other points."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from scipy.stats import f as f_distribution

from pawnb.arrays import IntArray, Points2D, Points3D
from pawnb.core import dlt
from pawnb.errors import CalibrationError

FEWEST_TO_DOUBT = 8
"""With fewer points the others determine a view too weakly to tell which one is wrong."""

_CHANCE = 1e-3
"""Clicks as scattered as these would look so, in one view of so many, by chance."""

_LEAST_OFF_PX = 2.0
"""A click nearer than this to where the other points show it is not doubted."""

_POOR_PX = 10.0
"""Points that fit worse than this, RMS, are said not to fit."""


def tell_mirrored(names: Sequence[str], signs: IntArray) -> list[str]:
    """Say which views show space mirrored.

    Parameters
    ----------
    names : sequence of str
        The views.
    signs : ndarray of int, shape (n_views,)
        Of :func:`pawnb.core.dlt.handedness`: 1 as it is, -1 mirrored, 0 not told.

    Returns
    -------
    list of str
        One sentence, or none.
    """
    flipped = [name for name, sign in zip(names, signs, strict=True) if sign < 0]
    sound = [name for name, sign in zip(names, signs, strict=True) if sign > 0]
    if not flipped:
        return []
    if not sound:
        return [
            f"the calibration shows space mirrored in {', '.join(flipped)}: its axes x, y, z are "
            "left-handed, or v was counted upwards or the pictures flipped when it was made; left "
            "and right, or up and down, may come out exchanged: turn one axis, or count v "
            'downwards ([calibration] v = "up" is for coefficients that were made otherwise)'
        ]
    return [
        f"the calibration shows space mirrored in {', '.join(flipped)} and as it is in "
        f"{', '.join(sound)}: unless one of them is filmed in a mirror, its picture was flipped or "
        "v counted upwards there when it was made; make both in the same pixels"
    ]


def doubt_points(names: Sequence[str], xyz: Points3D, uv: Points2D, *, view: str) -> list[str]:
    """Name the clicks of one view that do not belong to their points.

    Parameters
    ----------
    names : sequence of str
        The points.
    xyz : ndarray, shape (n_points, 3)
        Their positions.
    uv : ndarray, shape (n_points, 2)
        Where they were clicked, px.
    view : str
        The view.

    Returns
    -------
    list of str
        One sentence, or none.
    """
    n = len(names)
    error = dlt.fit_dlt(xyz, uv).residual_px
    rms = float(np.sqrt(np.mean(error**2)))
    poor = [
        f"view {view!r}: its points fit no camera well ({rms:.1f} px RMS): clicks lie on other "
        "points, positions are wrong or of another unit, or the lens bends strongly"
    ]
    if n < FEWEST_TO_DOUBT:
        return poor if rms > _POOR_PX else []
    total = float(np.sum(error**2))
    i, left, away = _worst(xyz, uv)
    if away > _LEAST_OFF_PX and _is_better(total, left, n=n, fewer=2, tries=n):
        return [
            f"view {view!r}: point {names[i]!r} lies {away:.1f} px from where the other {n - 1} "
            "show it: it was clicked wrongly, or its position is wrong; correct it, or leave it out"
        ]
    if rms <= _POOR_PX:
        return []
    (i, j), left = _exchanged(xyz, uv)
    if _is_better(total, left, n=n, fewer=4, tries=n * (n - 1) // 2):
        return [
            f"view {view!r}: the clicks of {names[i]!r} and {names[j]!r} are exchanged: exchanged "
            f"back all points fit within {np.sqrt(left / n):.1f} px RMS, now {rms:.1f}"
        ]
    return poor


def _worst(xyz: Points3D, uv: Points2D) -> tuple[int, float, float]:
    """Return the point without which the others fit best.

    With it the sum of their squared errors, px², and how far its click is from where they show it.
    """
    best = (0, np.inf, 0.0)
    for i in range(len(xyz)):
        try:
            fit = dlt.fit_dlt(np.delete(xyz, i, axis=0), np.delete(uv, i, axis=0))
        except CalibrationError:  # the others alone do not determine the view
            continue
        left = float(np.sum(fit.residual_px**2))
        if left < best[1]:
            away = float(np.linalg.norm(dlt.project(fit.coefs, xyz[i])[0] - uv[i]))
            best = (i, left, away)
    return best


def _exchanged(xyz: Points3D, uv: Points2D) -> tuple[tuple[int, int], float]:
    """Return the pair of points that fits best once exchanged, and the sum of squares, px²."""
    best = ((0, 0), np.inf)
    for pair in combinations(range(len(xyz)), 2):
        other = uv.copy()
        other[list(pair)] = uv[list(pair[::-1])]
        try:
            left = float(np.sum(dlt.fit_dlt(xyz, other, refine=False).residual_px ** 2))
        except CalibrationError:
            continue
        if left < best[1]:
            best = (pair, left)
    return best


def _is_better(total: float, left: float, *, n: int, fewer: int, tries: int) -> bool:
    """Say whether a sum of squares is lower than chance makes one of so many tries (F test)."""
    rest = 2 * n - 11 - fewer
    if not np.isfinite(left) or rest < 1:
        return False
    ratio = (total - left) / fewer / max(left / rest, 1e-12)
    return bool(f_distribution.sf(ratio, fewer, rest) * tries < _CHANCE)
