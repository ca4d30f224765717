"""What a leg does when one of its joints, or its tip, is dragged.

``widgets/static/stick.js`` follows the mouse with the same rules, so that what is seen while
dragging is what is kept afterwards: change both together.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray, Points2D
from pawnb.core.pose.animal import Leg

DRAG_STEPS = 40
"""Steps of the search for angles that bring the tip to a place."""
_DRAG_DAMPING = 0.004
"""Damping of these steps, as a share of the leg's squared length."""
_STIFF_JOINT = 0.05
"""How freely a joint turns further beyond its range, compared with one within."""


def handles(leg: Leg) -> dict[str, int]:
    """Return what can be dragged of a leg: name to number of the place, 0 the body-coxa joint.

    Joints that do not turn are no handles: the leg is straight there. The tip has the leg's
    name, a joint ``<leg>.<joint>``.
    """
    n = len(leg.segments)
    out = {f"{leg.name}.{leg.joints[k]}": k for k in range(1, n) if leg.free[k]}
    return out | {leg.name: n}


def leg_places(
    leg: Leg, root: Points2D, *, heading_deg: float, angles_deg: FloatArray, steps_px: FloatArray
) -> Points2D:
    """Return the places of a leg's joints and tip.

    Parameters
    ----------
    leg : Leg
        The leg.
    root : ndarray, shape (2,)
        Place of its body-coxa joint, px.
    heading_deg : float
        Direction of the body.
    angles_deg : ndarray, shape (n_segments,)
        Every joint, also those that do not turn.
    steps_px : ndarray, shape (n_segments,)
        Lengths of the segments in the picture.

    Returns
    -------
    ndarray, shape (n_segments + 1, 2)
        u, v, px.
    """
    turn = np.radians(heading_deg + leg.side * (90.0 - np.cumsum(angles_deg)))
    steps = steps_px[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return np.concatenate([root[None], root + np.cumsum(steps, axis=0)])


def turn_joint(
    leg: Leg, places: Points2D, angles_deg: FloatArray, *, at: int, to: Points2D
) -> FloatArray:
    """Return a leg's angles after one of its places was dragged; what is further out follows.

    The next free joint inwards turns, so that the place dragged lies in the direction of the
    mouse; lengths stay.

    Parameters
    ----------
    leg : Leg
        The leg.
    places : ndarray, shape (n_segments + 1, 2)
        Its joints and tip before, px.
    angles_deg : ndarray, shape (n_segments,)
        Every joint before.
    at : int
        Number of the place dragged, from 1.
    to : ndarray, shape (2,)
        Where the mouse is, px.

    Returns
    -------
    ndarray, shape (n_segments,)
        Every joint after, the turned one in [-180, 180).
    """
    turning = next((j for j in range(at - 1, -1, -1) if leg.free[j]), None)
    out = np.array(angles_deg, dtype=float)
    if turning is None:
        return out
    was, now = places[at] - places[turning], np.asarray(to) - places[turning]
    by = np.degrees(np.arctan2(now[1], now[0]) - np.arctan2(was[1], was[0]))
    out[turning] = (out[turning] - leg.side * by + 180.0) % 360.0 - 180.0
    return out


def reach_tip(
    leg: Leg,
    root: Points2D,
    *,
    heading_deg: float,
    angles_deg: FloatArray,
    steps_px: FloatArray,
    to: Points2D,
) -> FloatArray:
    """Return angles that bring the tip of a leg to a place, all free joints turning together.

    Damped least squares (Wampler 1986); joints turn reluctantly further out of their range.
    Towards a place out of reach the leg is straight: steps towards the place itself never settle.

    Parameters
    ----------
    leg : Leg
        The leg.
    root : ndarray, shape (2,)
        Place of its body-coxa joint, px.
    heading_deg : float
        Direction of the body.
    angles_deg : ndarray, shape (n_segments,)
        Every joint before.
    steps_px : ndarray, shape (n_segments,)
        Lengths of the segments in the picture.
    to : ndarray, shape (2,)
        Where the tip is wanted, px.

    Returns
    -------
    ndarray, shape (n_segments,)
        Every joint after.
    """
    angles = np.array(angles_deg, dtype=float)
    natural, half = np.array(leg.natural_deg), np.array(leg.range_deg) / 2
    # joints with a wide range do most of the turning
    freedom = np.array(leg.free) * (half / 60.0 + 0.05)
    size = float(steps_px.sum())
    damping = _DRAG_DAMPING * size**2
    out = np.asarray(to) - root
    to = root + out * min(1.0, size / max(float(np.hypot(*out)), 1e-9))
    for _ in range(DRAG_STEPS):
        places = leg_places(
            leg, root, heading_deg=heading_deg, angles_deg=angles, steps_px=steps_px
        )
        miss = np.asarray(to) - places[-1]
        if np.hypot(*miss) < 0.01:
            break
        miss = miss * min(1.0, 0.25 * size / max(float(np.hypot(*miss)), 1e-9))
        arm = places[-1] - places[:-1]
        # a joint that turns forwards by an angle moves the tip across its arm
        across = -leg.side * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        wish = across @ miss  # which way each joint would turn
        beyond = (np.abs(angles - natural) > half) & (wish * (angles - natural) > 0)
        weight = freedom * np.where(beyond, _STIFF_JOINT, 1.0)
        a = float(weight @ across[:, 0] ** 2) + damping
        b = float(weight @ (across[:, 0] * across[:, 1]))
        d = float(weight @ across[:, 1] ** 2) + damping
        pull = np.array([d * miss[0] - b * miss[1], a * miss[1] - b * miss[0]]) / (a * d - b * b)
        angles += np.degrees(weight * (across @ pull))
    return angles


def beyond_range(leg: Leg, angles_deg: FloatArray) -> FloatArray:
    """Return by how much each joint is beyond its range, degrees, 0 within; (n_segments,)."""
    off = np.abs(np.asarray(angles_deg) - np.array(leg.natural_deg))
    return np.maximum(off - np.array(leg.range_deg) / 2, 0.0)
