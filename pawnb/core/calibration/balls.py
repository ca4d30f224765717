"""The centre of a ball or a round mark near a click."""

from __future__ import annotations

import cv2
import numpy as np

from pawnb.arrays import ByteArray

_REACHES_PX = (10, 20, 40, 80)
"""Half sides of the squares around a click that are looked at, smallest first."""
_LEAST_CONTRAST = 20.0
"""Grey values between a mark and what is around it; less is noise of most cameras (by hand)."""
_LEAST_AREA_PX = 8
_ROUND = 0.6
"""Area of a mark over that of the circle around it: a disc has 1, a square 0.64."""
_NEAR_RADII = 1.5
"""A mark is meant where the click is within that many of its radii of the centre."""


def snap_to_ball(grey: ByteArray, u: float, v: float) -> tuple[float, float] | None:
    """Find the centre of the round mark that a click is on.

    The square around the click is split into bright and dark (Otsu 1979); a piece that the click is
    on, round and whole, is the mark, and its centre the mean of its pixels, each weighted by how
    far it stands out. Larger squares are tried where it does not fit into the smaller.

    Parameters
    ----------
    grey : ndarray of uint8, shape (H, W)
        The picture.
    u, v : float
        The click, px.

    Returns
    -------
    tuple of float or None
        u and v of the centre; None where no such mark is there.
    """
    height, width = grey.shape
    at_u, at_v = round(u), round(v)
    for reach in _REACHES_PX:
        left, top = max(at_u - reach, 0), max(at_v - reach, 0)
        part = grey[top : min(at_v + reach + 1, height), left : min(at_u + reach + 1, width)]
        if min(part.shape, default=0) < 5:
            return None
        for patch in (part, 255 - part):
            found = _round_piece(patch, u - left, v - top)
            if found is not None:
                return found[0] + left, found[1] + top
    return None


def _round_piece(patch: np.ndarray, u: float, v: float) -> tuple[float, float] | None:
    """Return the centre of the bright, round, whole piece that a place is on."""
    _, mask = cv2.threshold(patch, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    inner, outer = patch[mask > 0], patch[mask == 0]
    if not inner.size or not outer.size or inner.mean() - outer.mean() < _LEAST_CONTRAST:
        return None
    n, labels, stats, centres = cv2.connectedComponentsWithStats(mask, connectivity=4)
    for k in range(1, n):
        x, y, w, h, area = stats[k]
        touches = x == 0 or y == 0 or x + w == patch.shape[1] or y + h == patch.shape[0]
        radius = max(w, h) / 2
        near = np.hypot(centres[k, 0] - u, centres[k, 1] - v) <= _NEAR_RADII * radius
        if touches or not near or area < max(_LEAST_AREA_PX, _ROUND * np.pi * radius**2):
            continue
        around = cv2.dilate((labels == k).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        weight = np.clip(patch.astype(float) - float(np.median(outer)), 0.0, None) * around
        rows, columns = np.indices(patch.shape)
        total = weight.sum()
        return float((columns * weight).sum() / total), float((rows * weight).sum() / total)
    return None
