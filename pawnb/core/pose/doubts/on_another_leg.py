"""Legs that lie along another one in most frames: the animal may lack them."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, joint_positions

_ON_OTHER_LEG = 0.03
"""A leg lies along another where no joint of its outer half is further from it, of the leg span."""
_MOSTLY_ON_OTHER_LEG = 0.5
"""Legs that do so in more of the frames are named. By hand, on 40 to 109 frames each: a true leg
does in at most 0.32 of them in sixteen rendered spiders, in none in 12 of spider-nephila and 60 of
flies-topview; a leg that the animal lacks in 1.00, 1.00 and 0.53 of 30 where it went onto a
neighbour (L1, L2 and L3 painted over in a rendered spider; R3 and R4 went elsewhere)."""


def legs_on_another(animal: StickAnimal, poses: Poses) -> dict[str, tuple[str, float]]:
    """Return the legs that lie along another one in most frames.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses; NaN where it is not there.

    Returns
    -------
    dict of str to (str, float)
        The leg, the one that it lies along most often, and in what share of the frames.
    """
    rows = np.flatnonzero(np.isfinite(poses.xy).all(axis=1))
    if not len(rows):
        return {}
    places, near = joint_positions(animal, poses.take(rows)), _ON_OTHER_LEG * animal.span
    limit = near * poses.scale[rows, None]
    found = {}
    for i, leg in enumerate(animal.legs):
        n = len(leg.segments)
        outer = places[:, i, n // 2 : n + 1]
        shares = {
            other.name: _all_near(outer, places[:, j, : len(other.segments) + 1], limit)
            for j, other in enumerate(animal.legs)
            if j != i
        }
        most = max(shares, key=lambda name: shares[name], default="")
        if most and shares[most] > _MOSTLY_ON_OTHER_LEG:
            found[leg.name] = (most, shares[most])
    return found


def _all_near(points: FloatArray, chain: FloatArray, limit: FloatArray) -> float:
    """Return in what share of n frames points (n, k, 2) are all near a chain (n, m, 2)."""
    away = np.full(points.shape[:2], np.inf)
    for begin, end in zip(
        np.moveaxis(chain[:, :-1], 1, 0), np.moveaxis(chain[:, 1:], 1, 0), strict=True
    ):
        way, off = (end - begin)[:, None], points - begin[:, None]
        square = np.maximum((way**2).sum(axis=-1), 1e-9)
        share = np.clip((off * way).sum(axis=-1) / square, 0.0, 1.0)
        away = np.minimum(away, np.linalg.norm(off - share[..., None] * way, axis=-1))
    return float((away <= limit).all(axis=1).mean())
