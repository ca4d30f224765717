"""Paws that a view shows but nobody clicked: those of the other side of the animal.

They look like the clicked ones and cross them in the picture. Followed as points of their
own, unlabelled targets, they are not taken for the clicked ones. Where two views give space its
depth, a paw stays at its side of the animal: that tells the two of a kind from each other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet, joined
from pawnb.core.paws.offline.scene.clicks import unlabelled_kinds
from pawnb.core.paws.offline.scene.geometry import Anchors, lateral_offset
from pawnb.core.paws.offline.scene.treadmill import Scene


def with_contralateral(tracked: BoolArray, kinds: Sequence[str], extra: Sequence[str]) -> BoolArray:
    """Return which view tracks which point (P + S, V): unlabelled targets are seen like their kind.

    Parameters
    ----------
    tracked : ndarray of bool, shape (V, P)
        Which view tracks which clicked point.
    kinds, extra : sequence of str
        Kinds of the clicked points, and of the unlabelled targets.

    Returns
    -------
    ndarray of bool, shape (P + S, V)
        Which view tracks which point or unlabelled target.
    """
    alike = [tracked[:, [kind == own for kind in kinds]].any(axis=1) for own in extra]
    return np.stack([*tracked.T, *alike])


def lateral_cost(away: FloatArray, body_scale: float) -> FloatArray:
    """Return the cost of places so far to the side of a click, half a squared deviation each.

    Parameters
    ----------
    away : ndarray, shape (n,)
        Distances to the side.
    body_scale : float
        Distance of front from hind paws, in the same unit.
    """
    return np.asarray(
        0.5
        * np.minimum(
            (away / (NETWORK_FLOW.aside_sd * body_scale)) ** 2, NETWORK_FLOW.usual_farthest
        )
    )


def side_cost(
    tracklets: Sequence[Tracklet],
    anchors: Anchors,
    scene: Scene,
    *,
    body: FloatArray,
    kinds: Sequence[str],
) -> FloatArray:
    """Return the cost of changing sides: clicked points to the other, unlabelled ones to this one.

    Only points of which the other side's was not clicked need it: where all four paws were,
    each holds its own tracklets.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        Tracklets.
    anchors : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    body : ndarray, shape (n, d)
        The slowly moving middle of the body.
    kinds : sequence of str
        Kind of each point; unlabelled targets come last.

    Returns
    -------
    ndarray, shape (P, tracklets)
        The cost of each tracklet for each point; 0 where no depth tells the sides apart.
    """
    cost = near_side_cost(tracklets, anchors, scene, body=body, kinds=kinds)
    if not tracklets:
        return cost
    across = scene.geometry.depth_axis
    clicked = sorted({p for here in anchors.values() for p in here})
    once = unlabelled_kinds([kinds[p] for p in clicked])
    frame, at, first = joined(tracklets)
    since = _from_body(anchors, body)
    for p in clicked:
        if kinds[p] in once:
            away = lateral_offset(at, since, body=body[frame], point=p, across=across)
            cost[p] = np.add.reduceat(lateral_cost(away, scene.body_scale), first)
    return cost


def near_side_cost(
    tracklets: Sequence[Tracklet],
    anchors: Anchors,
    scene: Scene,
    *,
    body: FloatArray,
    kinds: Sequence[str],
) -> FloatArray:
    """Return the cost of unlabelled targets that are no farther from the cameras than clicked ones.

    An unlabelled target that takes the place of an occluded paw keeps it: nothing else says whose
    it is. Parameters as for :func:`side_cost`.

    Parameters
    ----------
    tracklets : sequence of Tracklet
        The tracklets.
    anchors : Anchors
        What is certain.
    scene : Scene
        Views and animal.
    body : ndarray, shape (n, d)
        The middle of the body in each frame.
    kinds : sequence of str
        Kind of each point.

    Returns
    -------
    ndarray, shape (P, tracklets)
        The cost of each tracklet for each point; 0 where cameras stand on both sides of the animal.
    """
    cost = np.zeros((len(kinds), len(tracklets)))
    middle = np.mean([x for here in scene.anchors.values() for x in here.values()], axis=0)
    across, way = scene.geometry.depth_axis, scene.geometry.away_from_cameras(middle)
    if not tracklets or way == 0.0:
        return cost
    clicked = 1 + max(p for here in anchors.values() for p in here)
    frame, at, first = joined(tracklets)
    since = _from_body(anchors, body)
    for p in range(clicked, len(kinds)):
        point = kinds.index(kinds[p])
        away = way * lateral_offset(at, since, body=body[frame], point=point, across=across)
        short = np.maximum(NETWORK_FLOW.far_side * scene.body_scale - away, 0.0)
        cost[p] = np.add.reduceat(lateral_cost(short, scene.body_scale), first)
    return cost


def share_observed(
    x: FloatArray, anchors: Anchors, scene: Scene, *, body: FloatArray, kinds: Sequence[str]
) -> FloatArray:
    """Return in what share of all frames each unlabelled target was seen as a paw of its own.

    Where the paw of the other side is occluded its unlabelled target finds tracklets of the clicked
    one, and the two share one paw. In space such an unlabelled target is at the side of the click.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Chosen places, NaN where occluded; unlabelled targets come last.
    anchors : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    body : ndarray, shape (n, d)
        The slowly moving middle of the body.
    kinds : sequence of str
        Kind of each point.

    Returns
    -------
    ndarray, shape (S,)
        From 0 to 1, in the order of the unlabelled targets.
    """
    since, across = _from_body(anchors, body), scene.geometry.depth_axis
    clicked = 1 + max(p for here in anchors.values() for p in here)
    shares = []
    for p in range(clicked, len(kinds)):
        own = np.isfinite(x[:, p, 0])
        away = lateral_offset(
            np.nan_to_num(x[:, p]), since, body=body, point=kinds.index(kinds[p]), across=across
        )
        own &= scene.geometry.is_other_side(away, NETWORK_FLOW.same_side * scene.body_scale)
        shares.append(own.mean())
    return np.array(shares)


def assign_near_side(
    x: FloatArray,
    anchors: Anchors,
    scene: Scene,
    *,
    body: FloatArray,
    kinds: Sequence[str],
    clicked: int,
) -> FloatArray:
    """Exchange paths of clicked points and unlabelled targets where those fit the clicks better.

    In space, a clicked point stays at the side where it was clicked. In a picture, what was
    clicked is on the near side of the animal, and what is near is lower in the picture.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Chosen places, NaN where occluded; unlabelled targets come last.
    anchors : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    body : ndarray, shape (n, d)
        The slowly moving middle of the body.
    kinds : sequence of str
        Kind of each point, "front" or "hind" for unlabelled targets.
    clicked : int
        Number of clicked points.

    Returns
    -------
    ndarray, shape (n, P, d)
        The places of the points that they belong to.
    """
    x = x.copy()
    since = _from_body(anchors, body)
    for contralateral_point in range(clicked, len(kinds)):
        point = kinds.index(kinds[contralateral_point])
        if not np.isfinite(x[:, [point, contralateral_point], 0]).any(axis=0).all():
            continue
        away = [
            scene.geometry.misplacement(x[:, p], since, body=body, point=point)
            for p in (point, contralateral_point)
        ]
        if away[1] < away[0]:
            x[:, [point, contralateral_point]] = x[:, [contralateral_point, point]]
    for t, here in anchors.items():
        x[t] = np.nan
        for p, at in here.items():
            x[t, p] = at
    return x


def _from_body(anchors: Anchors, body: FloatArray) -> dict[int, dict[int, np.ndarray]]:
    """Return how far from the body certain positions are."""
    return {t: {p: at - body[t] for p, at in here.items()} for t, here in anchors.items()}
