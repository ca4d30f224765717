"""Where points meet, tracklets are cut: who went on which way is decided later.

A hind paw that lands where a front paw lifts off takes over its place, and the front paw
its speed: the smoothest paths there are those of changed identities. So no tracklet leads
through a meeting, and where each point usually is decides between the ways on.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet


def split_at_crossings(tracklets: Sequence[Tracklet], apart: float) -> list[Tracklet]:
    """Cut tracklets where they come near each other: at the first, the nearest and the last frame.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        Tracklets.
    apart : float
        Distance at which points meet.

    Returns
    -------
    list of Tracklet
        The parts, in the order of their first frames.
    """
    cuts: list[set[int]] = [set() for _ in tracklets]
    order = sorted(range(len(tracklets)), key=lambda i: tracklets[i].first)
    for place, i in enumerate(order):
        for j in order[place + 1 :]:
            if tracklets[j].first > tracklets[i].last:
                break
            for one, other in ((i, j), (j, i)):
                cuts[one].update(_cuts(tracklets[one], tracklets[other], apart))
    parts = [
        part
        for tracklet, own in zip(tracklets, cuts, strict=True)
        for part in _split(tracklet, own)
    ]
    return sorted(parts, key=lambda tracklet: tracklet.first)


def _cuts(one: Tracklet, other: Tracklet, apart: float) -> set[int]:
    """Return the frames with which new parts of ``one`` begin because of ``other``."""
    first, last = max(one.first, other.first), min(one.last, other.last)
    if first > last:
        return set()
    step = one.at[first - one.first : last - one.first + 1]
    step = step - other.at[first - other.first : last - other.first + 1]
    away = np.linalg.norm(step, axis=1)
    near = np.concatenate([[False], away < apart, [False]])
    cuts = set()
    for start, end in np.flatnonzero(np.diff(near.astype(int))).reshape(-1, 2).tolist():
        nearest = start + int(away[start:end].argmin())
        cuts |= {first + start, first + nearest, first + end}
    return cuts


def split_sliding(
    tracklets: Sequence[Tracklet],
    *,
    substrate_velocity: FloatArray,
    axes: FloatArray,
    paw_width: float,
    frames: int,
) -> list[Tracklet]:
    """Cut tracklets that stand on one place of the ground and then on another close by.

    No paw slides on. A hind paw landed just where a front paw lifted off, and the tracklet of one
    goes on as the other; where that one had no tracklet of its own nothing else tells of it.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        Tracklets.
    substrate_velocity : ndarray, shape (d,)
        Speed of the ground, length per frame.
    axes : ndarray, shape (2, d)
        Unit vectors forward and up: that a paw stands is decided along them, as depth may be vague.
    paw_width : float
        Width of a paw.
    frames : int
        Frames for which a paw goes with the ground to be known to stand, three at least.

    Returns
    -------
    list of Tracklet
        The parts, in the order of their first frames.
    """
    parts = []
    for tracklet in tracklets:
        still = (
            tracklet.at - np.arange(len(tracklet.detection_indices))[:, None] * substrate_velocity
        )
        parts += _split(
            tracklet, {tracklet.first + i for i in _slides(still, axes, paw_width, frames)}
        )
    return sorted(parts, key=lambda tracklet: tracklet.first)


def _slides(still: FloatArray, axes: FloatArray, paw_width: float, frames: int) -> list[int]:
    """Return where places on the ground (n, d) slide: the first frame after each slide's middle."""
    apart = frames + 2 * NETWORK_FLOW.splitting_between
    if len(still) < apart + frames:
        return []
    window = np.lib.stride_tricks.sliding_window_view(still, frames, axis=0)
    place = np.median(window, axis=-1)
    stands = np.ptp(axes @ window, axis=-1).max(axis=1) < NETWORK_FLOW.splitting_stands * paw_width
    step = np.linalg.norm(place[apart:] - place[:-apart], axis=1)
    step = np.where(stands[apart:] & stands[:-apart], step, 0.0)
    slid = np.concatenate([[False], step > NETWORK_FLOW.splitting_slides * paw_width, [False]])
    edges = np.flatnonzero(np.diff(slid.astype(int))).reshape(-1, 2).tolist()
    return [(a + b - 1) // 2 + frames + NETWORK_FLOW.splitting_between for a, b in edges]


def _split(tracklet: Tracklet, cuts: set[int]) -> list[Tracklet]:
    """Return the parts of a tracklet; new ones begin with the frames of the cuts."""
    inside = sorted(cut - tracklet.first for cut in cuts if tracklet.first < cut <= tracklet.last)
    bounds = [0, *inside, len(tracklet.detection_indices)]
    return [
        Tracklet(
            tracklet.first + a,
            tracklet.detection_indices[a:b],
            tracklet.at[a:b],
            tracklet.cost[a:b],
        )
        for a, b in itertools.pairwise(bounds)
    ]
