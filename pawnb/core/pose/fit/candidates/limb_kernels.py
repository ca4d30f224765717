"""Limbs found in the silhouette: chains of links that follow dark pixels outwards from the body.

A beam search: the ends of a link found so far are each continued by the next link, turned and
foreshortened in all ways that anatomy allows, and those that lie on the darkest pixels go on.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled_inside, compiled_loosely
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import Prior
from pawnb.core.sorting_kernels import ascending

_UNREACHABLE = 1e18
"""Guard: farther than anything, squared px."""


class LimbSearch(NamedTuple):
    """How limbs are searched for: the ``limb_...`` of the stage, where unit and evidence stand.

    Parameters
    ----------
    beam : int
        Chains kept after each link.
    turns : ndarray, shape (m,)
        Turns of a link that are tried, as shares of its range.
    shorter : ndarray, shape (k,)
        Logarithms of a link's foreshortening that are tried.
    shorter_worth : float
        Minus the cost of the square of that.
    hidden, step_px, least_dark, direction_rad : float
        As of the stage.
    """

    beam: int
    turns: np.ndarray
    shorter: np.ndarray
    shorter_worth: float
    hidden: float
    step_px: float
    least_dark: float
    direction_rad: float


@compiled_inside
def sample(seen: np.ndarray, u: float, v: float) -> float:
    """Return the darkness at a place between pixels; 0 outside the picture, NaN near NaN."""
    left, top = math.floor(u), math.floor(v)
    if left < 0 or top < 0 or left + 1 >= seen.shape[1] or top + 1 >= seen.shape[0]:
        return 0.0
    a, b = u - left, v - top
    upper = seen[top, left] * (1 - a) + seen[top, left + 1] * a
    lower = seen[top + 1, left] * (1 - a) + seen[top + 1, left + 1] * a
    return upper * (1 - b) + lower * b


@compiled_inside
def follow_link(
    layout: PoseLayout, leg: int, link: int, start: np.ndarray, forwards: float, shorter: float,
    heading: float, seen: np.ndarray, box: np.ndarray, search: LimbSearch, end: np.ndarray,
) -> float:  # fmt: skip
    """Return the support of one link laid from ``start``, px; write where it ends."""
    u, v, total = start[0], start[1], 0.0
    for s in range(layout.n_segments[leg]):
        if layout.link[leg, s] != link:
            continue
        direction = heading + layout.side[leg] * (math.pi / 2 - forwards - layout.turn[leg, s])
        length = layout.length[leg, s] * math.exp(shorter)
        n = max(2, int(length / search.step_px))
        du, dv = length * math.cos(direction), length * math.sin(direction)
        for i in range(n):
            t = (i + 0.5) / n
            dark = layout.dark[leg, s] + (layout.dark[leg, s + 1] - layout.dark[leg, s]) * t
            here = sample(seen, u + t * du - box[0], v + t * dv - box[1]) / max(
                dark, search.least_dark
            )
            share = search.hidden if math.isnan(here) else min(max(here, 0.0), 1.0)
            total += (2.0 * share - 1.0) * length / n
        u, v = u + du, v + dv
    end[0], end[1] = u, v
    return total


@compiled_loosely
def find_limbs(
    layout: PoseLayout, pose: np.ndarray, leg: int, seen: np.ndarray, box: np.ndarray,
    prior: Prior, search: LimbSearch, most: int, apart: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return ways to lay a leg on dark pixels, best first.

    Parameters
    ----------
    layout, pose : PoseLayout, ndarray
        The animal; of the pose only the body is used.
    leg : int
        Which leg.
    seen, box : ndarray
        Darkness, slightly blurred, NaN where nothing can be seen; left and top of the crop.
    prior : Prior
        Middles, spread and limits of the leg's angles and foreshortening.
    search : LimbSearch
        How limbs are searched for.
    most : int
        Chains returned at most.
    apart : float
        Chains that are nowhere further from each other are one and the same, px.

    Returns
    -------
    numbers : ndarray, shape (found, 2 links)
        The leg's part of the pose vector.
    support : ndarray, shape (found,)
        Length on dark pixels less that on light ones and the prior's share, px.
    """
    n_links, first, width = layout.n_links[leg], layout.first[leg], search.beam
    beam = np.zeros((width, 2 * n_links))
    places = np.zeros((width, n_links + 1, 2))
    forwards, support = np.zeros(width), np.zeros(width)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    f, r = layout.attach[leg, 0], layout.attach[leg, 1]
    places[0, 0, 0] = pose[0] + f * cos - r * sin
    places[0, 0, 1] = pose[1] + f * sin + r * cos
    filled = 1
    tries = width * len(search.turns) * len(search.shorter)
    ends, scores = np.zeros((tries, 2)), np.zeros(tries)
    source, turns, short = np.zeros(tries, np.int64), np.zeros(tries), np.zeros(tries)
    for k in range(n_links):
        a, q = first + k, first + n_links + k
        n = 0
        for b in range(filled):
            for i in range(len(search.turns)):
                turn = prior.low[a] + (prior.high[a] - prior.low[a]) * search.turns[i]
                for shorter in search.shorter:
                    factor = prior.middle[q] + shorter
                    if factor > max(prior.high[q], prior.middle[q]):
                        continue
                    gain = follow_link(
                        layout, leg, k, places[b, k], forwards[b] + turn, factor, pose[2], seen,
                        box, search, ends[n],
                    )  # fmt: skip
                    strange = (turn - prior.middle[a]) ** 2 * prior.precision[a]
                    worth = gain - strange + shorter**2 * search.shorter_worth
                    scores[n] = worth + support[b]
                    source[n], turns[n], short[n] = b, turn, factor
                    n += 1
        kept, filled_next = _unlike(
            scores[:n], ends, forwards, source, turns, search, apart, k == n_links - 1
        )
        old_beam, old_places, old_forwards = beam.copy(), places.copy(), forwards.copy()
        for j in range(filled_next):
            i = kept[j]
            b = source[i]
            for c in range(2):
                for m in range(n_links):
                    beam[j, c * n_links + m] = old_beam[b, c * n_links + m]
                for m in range(n_links + 1):
                    places[j, m, c] = old_places[b, m, c]
                places[j, k + 1, c] = ends[i, c]
            beam[j, k], beam[j, n_links + k] = turns[i], short[i]
            forwards[j] = old_forwards[b] + turns[i]
            support[j] = scores[i]
        filled = filled_next
    return _distinct(beam, places, support, filled, most, apart)


@compiled_loosely
def _unlike(
    scores: np.ndarray, ends: np.ndarray, forwards: np.ndarray, source: np.ndarray,
    turns: np.ndarray, search: LimbSearch, apart: float, is_last: bool,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """Return the best tries that end apart, or at the same place from another direction."""
    kept, filled = np.zeros(search.beam, np.int64), 0
    for i in ascending(-scores):
        same = False
        for j in range(filled):
            other = kept[j]
            du, dv = ends[i, 0] - ends[other, 0], ends[i, 1] - ends[other, 1]
            near = du * du + dv * dv < (0.5 * apart) ** 2
            angle = forwards[source[i]] + turns[i] - forwards[source[other]] - turns[other]
            same = same or (near and (abs(angle) < search.direction_rad or is_last))
        if not same:
            kept[filled] = i
            filled += 1
            if filled == search.beam:
                break
    return kept, filled


@compiled_loosely
def point_to_chain(u: float, v: float, chain: np.ndarray, n: int) -> float:
    """Return the squared distance of a place to a chain of n segments."""
    best = _UNREACHABLE
    for s in range(n):
        du, dv = chain[s + 1, 0] - chain[s, 0], chain[s + 1, 1] - chain[s, 1]
        square = max(du * du + dv * dv, 1e-9)
        t = ((u - chain[s, 0]) * du + (v - chain[s, 1]) * dv) / square
        t = min(max(t, 0.0), 1.0)
        eu, ev = u - chain[s, 0] - t * du, v - chain[s, 1] - t * dv
        best = min(best, eu * eu + ev * ev)
    return best


@compiled_loosely
def chains_apart(one: np.ndarray, other: np.ndarray, n: int) -> float:
    """Return the greatest distance between two chains of n segments, px.

    That of any joint or middle of a segment to the nearest place of the other chain, so that
    joints may lie elsewhere along the same limb.
    """
    far = 0.0
    for s in range(n + 1):
        far = max(far, point_to_chain(one[s, 0], one[s, 1], other, n))
        far = max(far, point_to_chain(other[s, 0], other[s, 1], one, n))
        if s < n:
            u, v = (one[s, 0] + one[s + 1, 0]) / 2, (one[s, 1] + one[s + 1, 1]) / 2
            far = max(far, point_to_chain(u, v, other, n))
            u, v = (other[s, 0] + other[s + 1, 0]) / 2, (other[s, 1] + other[s + 1, 1]) / 2
            far = max(far, point_to_chain(u, v, one, n))
    return math.sqrt(far)


@compiled_loosely
def chains_cross(one: np.ndarray, n_one: int, other: np.ndarray, n_other: int) -> bool:
    """Return whether two chains of segments cross anywhere."""
    for i in range(n_one):
        au, av = one[i, 0], one[i, 1]
        bu, bv = one[i + 1, 0] - au, one[i + 1, 1] - av
        for j in range(n_other):
            cu, cv = other[j, 0] - au, other[j, 1] - av
            du, dv = other[j + 1, 0] - other[j, 0], other[j + 1, 1] - other[j, 1]
            det = bu * dv - bv * du
            if abs(det) > 1e-9:
                t = (cu * dv - cv * du) / det
                s = (cu * bv - cv * bu) / det
                if 0.0 <= t <= 1.0 and 0.0 <= s <= 1.0:
                    return True
    return False


@compiled_loosely
def _distinct(
    beam: np.ndarray, places: np.ndarray, support: np.ndarray, filled: int, most: int,
    apart: float,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return the best chains that lie further than ``apart`` from each other somewhere."""
    chosen = np.zeros(most, np.int64)
    n = 0
    for i in range(filled):
        same = False
        for j in range(n):
            same = same or chains_apart(places[i], places[chosen[j]], places.shape[1] - 1) < apart
        if not same:
            chosen[n] = i
            n += 1
            if n == most:
                break
    return beam[chosen[:n]].copy(), support[chosen[:n]].copy()
