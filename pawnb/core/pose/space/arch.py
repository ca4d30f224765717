"""A leg as an even arch: where its joints are when only its ends are known.

The first view shows the ends of a leg well and its joints badly: a leg that looks straight from
above may bend anywhere. An arc of the leg's whole length over its ends is a start.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray

_ARCH_STEPS = 40
"""Numerics: halvings of an interval, to one part in 1e12."""
_FLATTEST = 0.02
"""Numerics: least half angle of an arc, radians: a leg that is stretched beyond its length lies
nearly straight."""


def arch_angle(chord_share: float) -> float:
    """Return half the angle of an arc whose chord is this share of its length, radians."""
    low, high = _FLATTEST, np.pi
    for _ in range(_ARCH_STEPS):
        middle = 0.5 * (low + high)
        if np.sin(middle) / middle > chord_share:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def arch(lengths: FloatArray, reach: float, rise: float) -> tuple[FloatArray, FloatArray]:
    """Return the joints of a leg that lies in an even arch over its ends.

    Parameters
    ----------
    lengths : ndarray, shape (n,)
        Lengths of its segments.
    reach, rise : float
        How far the tip is from the first joint, horizontally and upwards.

    Returns
    -------
    out, up : ndarray, shape (n + 1,)
        Share of the reach, and height above the first joint, of every joint.
    """
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    half = arch_angle(min(float(np.hypot(reach, rise)) / along[-1], 1.0))
    start = np.arctan2(rise, reach) + half
    turned = start - 2.0 * half * along / along[-1]
    # the arc's points up to its size, then fitted to both ends
    place = np.stack([np.sin(start) - np.sin(turned), np.cos(turned) - np.cos(start)])
    size = along[-1] / (2.0 * half)
    out, up = place * size
    # an arc cannot reach further than the leg is long
    out = out / out[-1] if abs(out[-1]) > 1e-9 else np.linspace(0.0, 1.0, len(out))
    return out, up + (rise - up[-1]) * along / along[-1]


def slide(places: FloatArray, share: FloatArray) -> FloatArray:
    """Return points along a polyline.

    Parameters
    ----------
    places : ndarray, shape (n, 2)
        The polyline.
    share : ndarray, shape (m,)
        Shares of its length; beyond its ends it goes on straight.

    Returns
    -------
    ndarray, shape (m, 2)
        The points.
    """
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-9))])
    at = np.asarray(share) * along[-1]
    k = np.clip(np.searchsorted(along, at, side="right") - 1, 0, len(steps) - 1)
    rest = (at - along[k]) / (along[k + 1] - along[k])
    return np.asarray(places[k] + rest[:, None] * (places[k + 1] - places[k]))
