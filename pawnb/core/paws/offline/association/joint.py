"""Points of one view distinguished over the recording, as factors of each one's likelihood."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from pawnb.arrays import AnyArray, Float32Array, FloatArray, IntArray
from pawnb.core.parallel import in_parts
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.identities import TrackletGraph
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.association.tracklets import (
    ViewTracklet,
    cut_at_meetings,
    cut_between_clicks,
    find_candidates,
    link,
)
from pawnb.core.paws.offline.detection.evidence import bump_at
from pawnb.core.paws.offline.parameters import IdentityParameters
from pawnb.core.paws.offline.scene.stack import BodyStack


def tell_apart(
    stack: BodyStack,
    annotations: Annotations,
    *,
    masses: Mapping[int, Float32Array],
    others: Mapping[int, Float32Array],
    looks: Mapping[int, Float32Array],
    prior: Mapping[int, Float32Array],
    trust: float,
    radius: float,
    parameters: IdentityParameters,
    sampled: bool = True,
) -> tuple[list[ViewTracklet], AnyArray, FloatArray]:
    """Cut what may be points into tracklets, and give them names.

    Parameters
    ----------
    stack : BodyStack
        The view.
    annotations : Annotations
        Its clicks.
    masses : mapping
        Point to the probability of every place (n, h, w), as far as known.
    others, looks : mapping
        Point to ratios of likelihoods (n, h, w) by all other kinds and views, and by appearance.
    prior : mapping
        Point to the probability of places without evidence (h, w).
    trust : float
        Power of the ratios by appearance.
    radius : float
        About half a paw, in places.
    parameters : IdentityParameters
        The stage's parameters.
    sampled : bool
        Whether shares are worked out; they are 1 otherwise.

    Returns
    -------
    tracklets : list of ViewTracklet
        N of them.
    names : ndarray of int, shape (N,)
        The point that each is, or -1.
    shares : ndarray, shape (N,)
        How surely it is that one (:meth:`.identities.TrackletGraph.name_shares`).
    """
    points = sorted(masses)
    n = stack.shape[0]
    placed = _clicked_places(stack, annotations, points)

    tracklets = _tracklets(
        stack, points, placed, masses=masses, looks=looks, radius=radius, parameters=parameters
    )
    if not tracklets:
        return [], np.empty(0, int), np.empty(0)
    clicked = {
        i: points.index(point)
        for i, one in enumerate(tracklets)
        for t, here in placed.items()
        for point, place in here
        if one.passes(t, place)
    }

    def gains_of(i: int, may: Sequence[int]) -> FloatArray:
        return _gains(
            tracklets[i], points, may=may, others=others, looks=looks, prior=prior, trust=trust,
            alike=parameters.alike,
        )  # fmt: skip

    columns = tuple(range(len(points)))
    gains = np.stack([gains_of(i, columns) for i in range(len(tracklets))])

    graph = TrackletGraph(tracklets, clicked, n=n, radius=radius, parameters=parameters)
    names = graph.decide(gains)
    # by elimination: what lasts beside named ones is compared among the points that are left
    for i in np.flatnonzero(names < 0).tolist():
        may = sorted(set(columns) - _elsewhere(tracklets[i], tracklets, names))
        if may:
            gains[i] = gains_of(i, may)
    names = graph.decide(gains)
    shares = graph.name_shares(gains, names) if sampled else np.ones(len(names))
    return tracklets, np.array([points[k] if k >= 0 else -1 for k in names], int), shares


def _clicked_places(
    stack: BodyStack, annotations: Annotations, points: Sequence[int]
) -> dict[int, list[tuple[int, np.ndarray]]]:
    """Return row to the points clicked in it and their places."""
    n = stack.shape[0]
    return {
        row: [(p, stack.grid_of(uv, row)) for p, uv in here.items() if p in points]
        for row, here in annotations.places.items()
        if 0 <= row < n
    }


def _tracklets(
    stack: BodyStack,
    points: Sequence[int],
    placed: Mapping[int, Sequence[tuple[int, np.ndarray]]],
    *,
    masses: Mapping[int, Float32Array],
    looks: Mapping[int, Float32Array],
    radius: float,
    parameters: IdentityParameters,
) -> list[ViewTracklet]:
    """Return what may be any of the points, each one thing as far as that can be told."""
    side = int(LINKS.taken_radii * radius) | 1

    def own(point: int, t: int) -> Float32Array:
        return looks[point][t] / (1 + looks[point][t])

    def candidates(t: int) -> FloatArray:
        score = np.minimum(np.sum([own(p, t) for p in points], axis=0), 1.0)
        for p in points:
            score = np.maximum(score, cv2.blur(masses[p][t], (side, side)) * side**2)
        return find_candidates(
            score, sure=[place for _, place in placed.get(t, [])], most=2 * len(points) + 2,
            radius=radius, parameters=parameters,
        )  # fmt: skip

    found = in_parts(candidates, range(stack.shape[0]))
    tracklets = [
        one
        for one in link(found, stack.forward, stack.backward, radius=radius, parameters=parameters)
        if len(one.places) > 1 or one.begin in placed
    ]
    tracklets = cut_at_meetings(tracklets, radius)
    for p in points:
        clicked = [(t, at) for t in sorted(placed) for point, at in placed[t] if point == p]
        tracklets = cut_between_clicks(tracklets, clicked)
    return tracklets


def _gains(
    one: ViewTracklet,
    points: Sequence[int],
    *,
    may: Sequence[int],
    others: Mapping[int, Float32Array],
    looks: Mapping[int, Float32Array],
    prior: Mapping[int, Float32Array],
    trust: float,
    alike: float,
) -> FloatArray:
    """Return the log-likelihood of a tracklet being each of the points."""
    h, w = prior[points[0]].shape
    x = np.clip(np.rint(one.places[:, 0]).astype(int), 0, w - 1)
    y = np.clip(np.rint(one.places[:, 1]).astype(int), 0, h - 1)
    t = one.rows
    look = np.stack([looks[p][t, y, x] for p in points], axis=1).astype(float)
    share = look / (1 + look)
    of_any = np.clip(share.sum(axis=1), LINKS.there_unsure, 1.0 - LINKS.there_unsure)
    there = np.clip(np.log(of_any / (1 - of_any)), -LINKS.most_there, LINKS.most_there)
    name = np.log(share + LINKS.names_unsure) - np.log(
        (share[:, may] + LINKS.names_unsure).mean(axis=1, keepdims=True)
    )
    motion = np.stack([others[p][t, y, x] for p in points], axis=1).astype(float)
    usual = np.stack([prior[p][y, x] for p in points], axis=1).astype(float)
    mean = usual.mean(axis=1, keepdims=True)
    at_all = np.clip(np.log(mean[:, 0] * h * w), -LINKS.most_there, LINKS.most_there / 2)
    log = (there + at_all)[:, None] + trust * name + np.log(motion)
    m = one.rows_before_cut or len(t)
    gains = log.sum(axis=0) / (1 + (m - 1) * alike)
    return np.asarray(gains + np.log(usual / mean).sum(axis=0) / m)


def paint_names(
    shape: tuple[int, int, int],
    tracklets: Sequence[ViewTracklet],
    names: IntArray,
    *,
    points: Sequence[int],
    radius: float,
    parameters: IdentityParameters,
) -> dict[int, Float32Array]:
    """Return how far every place is left to each point: what is decided is its own alone.

    Parameters
    ----------
    shape : tuple of int
        Frames, rows and columns of the grid.
    tracklets : sequence of ViewTracklet
        The tracklets.
    names : ndarray of int, shape (tracklets,)
        The point of each; below 0 for none.
    points : sequence of int
        The points.
    radius : float
        Half a paw, working px.
    parameters : IdentityParameters
        Of this stage.

    Returns
    -------
    dict
        Point to factors, shape ``shape``.
    """
    factors = {p: np.ones(shape, np.float32) for p in points}
    _, h, w = shape
    reach = int(np.ceil(4 * LINKS.decided_sd + radius))
    for one, name in zip(tracklets, names, strict=True):
        shut = set(points) - {int(name)} if name >= 0 else _elsewhere(one, tracklets, names)
        if not shut:
            continue
        for t, (cx, cy) in zip(one.rows, one.places, strict=True):
            x0, x1 = max(0, int(cx) - reach), min(w, int(cx) + reach + 1)
            y0, y1 = max(0, int(cy) - reach), min(h, int(cy) + reach + 1)
            if x0 >= x1 or y0 >= y1:
                continue
            off = (np.arange(x0, x1) - cx) ** 2 + ((np.arange(y0, y1) - cy) ** 2)[:, None]
            taken = off < (LINKS.closed_radii * radius) ** 2
            closed = np.where(taken, np.float32(1 - parameters.closed), np.float32(1))
            for p in shut:
                factors[p][t, y0:y1, x0:x1] *= closed
            if name >= 0:
                bump = bump_at(closed.shape, (cx - x0, cy - y0), LINKS.decided_sd)
                factors[int(name)][t, y0:y1, x0:x1] *= 1 + parameters.gain * bump
    return factors


def _elsewhere(one: ViewTracklet, tracklets: Sequence[ViewTracklet], names: IntArray) -> set[int]:
    """Return the points that a tracklet without a name cannot be: they are seen beside it.

    A point is in one place, and a tracklet is one thing: what lasts while a point is in another
    tracklet is not that point in its other rows either.
    """
    return {
        int(name)
        for other, name in zip(tracklets, names, strict=True)
        if name >= 0 and min(one.end, other.end) - max(one.begin, other.begin) >= LINKS.overlap_rows
    }
