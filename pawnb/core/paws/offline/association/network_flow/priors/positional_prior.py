"""Where each point usually is relative to the body: front paws ahead of hind ones, and so on.

Learnt from the recording itself: tracks that are mostly right say where a point is
how often, relative to the slowly moving middle of all points; a second look then knows
that a front paw does not ride backwards to where hind paws leave the ground.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.offline.association.network_flow.contralateral import (
    lateral_cost,
)
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.tracklets import (
    Tracklet,
    joined,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses
from pawnb.core.paws.offline.scene.geometry import Anchors
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.treadmill.median import median

_USUAL_REACH = 1.5
"""Layout: the distribution holds distances up to so many spans; what is farther is in the
last bins."""


def follow_body(x: FloatArray, frames: int) -> FloatArray:
    """Return the slowly moving middle (n, d) of tracks (n, P, d) with NaN where occluded.

    Parameters
    ----------
    x : ndarray
        Tracks.
    frames : int
        Frames over which the middle is averaged, about two strides.
    """
    n, n_points, d = x.shape
    filled = np.full_like(x, np.nan)
    time = np.arange(n)
    for p in range(n_points):
        seen = np.isfinite(x[:, p, 0])
        if not seen.any():
            continue  # nobody clicked it and it was never found: it tells nothing
        for c in range(d):
            filled[:, p, c] = np.interp(time, time[seen], x[seen, p, c])
    middle = np.nanmean(filled, axis=1)
    return np.asarray(uniform_filter1d(middle, min(frames, n), axis=0, mode="nearest"))


def learn_positional_prior(
    x: FloatArray,
    body: FloatArray,
    *,
    axes: Sequence[FloatArray],
    groups: Sequence[Sequence[str]],
    body_scale: float,
) -> list[list[FloatArray]]:
    """Learn how often each point is where, along some axes.

    Parameters
    ----------
    x, body : ndarray, shape (n, P, d) and (n, d)
        Tracks, NaN where occluded, and the middle of the body.
    axes : sequence of ndarray, shape (d,)
        Unit vectors.
    groups : sequence
        For each axis the group of each point; points of one group share their prior.
    body_scale : float
        Distance of front from hind paws.

    Returns
    -------
    list of list of ndarray
        For each axis and point, the cost of every bin of :func:`positional_cost`.
    """
    costs = []
    for axis, names in zip(axes, groups, strict=True):
        along = (x - body[:, None]) @ axis
        own = []
        for name in names:
            part = along[:, [other == name for other in names]]
            part = part[np.isfinite(part)]
            count = np.bincount(
                _bin(part, body_scale), minlength=NETWORK_FLOW.positional_prior_bins
            ).astype(float)
            sd = (
                NETWORK_FLOW.positional_prior_blur
                * NETWORK_FLOW.positional_prior_bins
                / (2 * _USUAL_REACH)
            )
            density = gaussian_filter1d(count, sd)
            density = density / max(density.max(), 1e-9)
            own.append(
                np.minimum(
                    -np.log(density + NETWORK_FLOW.positional_prior_rare),
                    NETWORK_FLOW.positional_prior_most,
                )
            )
        costs.append(own)
    return costs


def positional_cost(
    tracklets: Sequence[Tracklet],
    body: FloatArray,
    *,
    axes: Sequence[FloatArray],
    positional_prior: Sequence[Sequence[FloatArray]],
    body_scale: float,
) -> FloatArray:
    """Return the cost (P, tracklets) of each tracklet for each point.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        The tracklets.
    body : ndarray, shape (n, d)
        The middle of the body in each frame.
    axes : sequence of ndarray, shape (d,)
        Unit vectors along which places are counted.
    positional_prior : sequence of sequence of ndarray
        For each axis and point, the cost of each bin of places about the body.
    body_scale : float
        Length of the body, in units of the places.

    Returns
    -------
    ndarray, shape (P, tracklets)
        Costs.
    """
    if not tracklets:
        return np.zeros((len(positional_prior[0]), 0))
    frame, at, first = joined(tracklets)
    at = at - body[frame]
    total = np.zeros((len(positional_prior[0]), len(tracklets)))
    for axis, own in zip(axes, positional_prior, strict=True):
        number = _bin(at @ axis, body_scale)
        for p, cost in enumerate(own):
            total[p] += np.add.reduceat(cost[number], first)
    return total


def _bin(along: FloatArray, body_scale: float) -> IntArray:
    """Return the bin of positions, from -``_USUAL_REACH`` to ``_USUAL_REACH`` spans."""
    return np.clip(
        (
            (along / body_scale + _USUAL_REACH)
            / (2 * _USUAL_REACH)
            * NETWORK_FLOW.positional_prior_bins
        ).astype(int),
        0,
        NETWORK_FLOW.positional_prior_bins - 1,
    )


def first_positional_cost(
    tracklets: Sequence[Tracklet],
    usual: Sequence[FloatArray],
    anchors: Anchors,
    *,
    scene: Scene,
) -> FloatArray:
    """Return the cost of being far from where each point is before all tracking.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        The tracklets.
    usual : sequence of ndarray, shape (n,)
        For each point, where those of its kind are along forward, see :func:`where_kinds_are`.
    anchors : Anchors
        What is certain.
    scene : Scene
        Views and animal.

    Returns
    -------
    ndarray, shape (P, tracklets)
        Costs.
    """
    cost = np.zeros((len(usual), len(tracklets)))
    if not tracklets:
        return cost
    clicked = {
        p: np.mean([h[p] for h in anchors.values() if p in h], axis=0)
        for p in sorted({p for here in anchors.values() for p in here})
    }
    across = scene.geometry.across
    wanders = NETWORK_FLOW.tracklet_association_wanders if len(clicked) < len(usual) else 1.0
    frame, at, first = joined(tracklets)
    along = at @ scene.forward
    for p, expected in enumerate(usual):
        if len(expected):
            away = np.abs(along - expected[frame]) / scene.body_scale - NETWORK_FLOW.kinds_reach
            far = np.maximum(away, 0.0) / NETWORK_FLOW.kinds_sd
            cost[p] += 0.5 * np.add.reduceat(np.minimum(far**2, NETWORK_FLOW.usual_farthest), first)
        if p in clicked:
            aside = lateral_cost((at - clicked[p]) @ across, wanders * scene.body_scale)
            cost[p] += np.add.reduceat(aside, first)
    return cost


def where_kinds_are(
    places: Sequence[PointHypotheses],
    anchors: Anchors,
    scene: Scene,
    *,
    kinds: Sequence[str],
    frames: int,
) -> list[FloatArray]:
    """Return where the points of each point's kind are along forward, before all tracking.

    That is where they were clicked, moved as the middle of all places, followed over some
    frames, has moved since: an animal may run through the picture. Where front and hind paws
    were clicked beside each other, it is where the foremost and the hindmost quarter of all
    places begin.

    Parameters
    ----------
    places : sequence of PointHypotheses
        Those of each frame.
    anchors : Anchors
        What is certain.
    scene : Scene
        Views and animal.
    kinds : sequence of str
        Kind of each point.
    frames : int
        Frames over which the middle is followed.

    Returns
    -------
    list of ndarray, shape (n,)
        One for each point, empty for a kind of which nothing is known.
    """
    n = len(places)
    good = [
        place.at[place.cost < NETWORK_FLOW.tracklet_association_good] @ scene.forward
        for place in places
    ]
    middle = np.array([median(one) if len(one) else np.nan for one in good])
    known = np.flatnonzero(np.isfinite(middle))
    if len(known):
        middle = np.interp(np.arange(n), known, middle[known])
        middle = uniform_filter1d(middle, min(frames, n), mode="nearest")
    else:
        middle = np.zeros(n)
    since = [
        (kinds[p], float(x @ scene.forward) - middle[t]) for t, h in anchors.items()
        for p, x in h.items()
    ]  # fmt: skip
    mean = {
        kind: float(np.mean([at for other, at in since if other == kind]))
        for kind in {kind for kind, _ in since}
    }
    told = {kind: middle + at for kind, at in mean.items() if kind != "other"}
    beside = {"front", "hind"} <= set(mean) and mean["front"] - mean["hind"] < (
        NETWORK_FLOW.kinds_apart * scene.body_scale
    )
    if beside and len(known):
        away = np.concatenate([one - at for one, at in zip(good, middle, strict=True)])
        told = {
            kind: middle + np.quantile(away, share)
            for kind, share in zip(("front", "hind"), NETWORK_FLOW.kinds_quantiles, strict=True)
        }
    return [told.get(kind, np.empty(0)) for kind in kinds]
