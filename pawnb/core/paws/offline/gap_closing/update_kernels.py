"""What stories of a point take in of a view's candidates, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import Stories, cell, copy
from pawnb.core.paws.offline.gap_closing.mht_parameters import Telling
from pawnb.core.sorting_kernels import nth

_GATE = 16.0
"""Largest squared distance of a candidate, in standard deviations."""


class Cameras(NamedTuple):
    """The views.

    Parameters
    ----------
    table : ndarray, shape (V, 11)
        DLT coefficients.
    thickness : ndarray, shape (V,)
        Thickness of a paw, px.
    own : ndarray of bool, shape (V,)
        Views that track the point.
    """

    table: np.ndarray
    thickness: np.ndarray
    own: np.ndarray


class Pictures(NamedTuple):
    """What stories look like in a view.

    Parameters
    ----------
    at : ndarray, shape (2, b)
        Where they are, px.
    slope : ndarray, shape (2, d, b)
        How that changes with the position.
    across : ndarray, shape (2, 3 d, b)
        Covariances of it with the states.
    spread : ndarray, shape (3, b)
        Its own: of u, of u and v, of v.
    """

    at: np.ndarray
    slope: np.ndarray
    across: np.ndarray
    spread: np.ndarray


class Pairs(NamedTuple):
    """Room for pairs of a story and a candidate.

    Parameters
    ----------
    cost : ndarray, shape (p,)
        What each costs the story.
    story, candidate, kind : ndarray of int, shape (p,)
        Their numbers, and which kind of candidate is cheapest: 0 for a good one, 1 for a bad.
    """

    cost: np.ndarray
    story: np.ndarray
    candidate: np.ndarray
    kind: np.ndarray


@compiled
def room_for_pairs(pairs: int) -> Pairs:
    """Return room for so many pairs."""
    return Pairs(
        np.empty(pairs), np.empty(pairs, np.int64), np.empty(pairs, np.int64),
        np.empty(pairs, np.int64),
    )  # fmt: skip


@compiled
def pictures(stories: Stories, n: int, L: np.ndarray) -> Pictures:
    """Return what the first ``n`` stories look like in a view of DLT coefficients (11,)."""
    size = len(stories.mean)
    d = size // 3
    at, slope, below = np.empty((2, n)), np.empty((2, d, n)), np.ones(n)
    for i in range(d):
        for b in range(n):
            below[b] += L[8 + i] * stories.mean[i, b]
    for c in range(2):
        for b in range(n):
            at[c, b] = L[4 * c + 3]
        for i in range(d):
            for b in range(n):
                at[c, b] += L[4 * c + i] * stories.mean[i, b]
        for b in range(n):
            at[c, b] /= below[b]
        for i in range(d):
            for b in range(n):
                slope[c, i, b] = (L[4 * c + i] - at[c, b] * L[8 + i]) / below[b]
    across, spread = _spreads(stories, slope)
    return Pictures(at, slope, across, spread)


@compiled
def _spreads(stories: Stories, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return covariances of pictures with states, and of pictures; see :class:`Pictures`."""
    (_, d, n), size = slope.shape, len(stories.mean)
    across, spread = np.zeros((2, size, n)), np.zeros((3, n))
    for c in range(2):
        for j in range(size):
            for i in range(d):
                e = cell(j, i)
                for b in range(n):
                    across[c, j, b] += stories.covariance[e, b] * slope[c, i, b]
        for e in range(c + 1):
            for i in range(d):
                for b in range(n):
                    spread[c + e, b] += slope[c, i, b] * across[e, i, b]
    return across, spread


@compiled
def find_pairs(
    seen: Pictures,
    at: np.ndarray,
    spread: tuple[float, float],
    extra: tuple[float, float],
    pairs: Pairs,
) -> int:
    """Find the pairs of a story and a candidate within the gate, and return how many there are.

    Parameters
    ----------
    seen : Pictures
        What the stories look like.
    at : ndarray, shape (c, 2)
        The candidates, px.
    spread, extra : tuple of float
        For a good and a bad candidate its variance, px squared, and its cost.
    pairs : Pairs
        Where they go.
    """
    n, count = seen.at.shape[1], 0
    inverse, base, price = np.empty((2, n)), np.empty((2, n)), np.empty((2, n))
    for k in range(2):
        for b in range(n):
            area = (seen.spread[0, b] + spread[k]) * (seen.spread[2, b] + spread[k])
            area -= seen.spread[1, b] * seen.spread[1, b]
            inverse[k, b], base[k, b] = 1.0 / area, 0.5 * np.log(area) + extra[k]
    for c in range(len(at)):
        for k in range(2):
            wide, u, v = spread[k], at[c, 0], at[c, 1]
            for b in range(n):
                du, dv = u - seen.at[0, b], v - seen.at[1, b]
                square = (seen.spread[2, b] + wide) * du * du - 2.0 * seen.spread[1, b] * du * dv
                square += (seen.spread[0, b] + wide) * dv * dv
                square *= inverse[k, b]
                price[k, b] = 0.5 * square + base[k, b] if square <= _GATE else np.inf
        for b in range(n):
            best = min(price[0, b], price[1, b])
            if best < np.inf:
                pairs.cost[count], pairs.story[count], pairs.candidate[count] = best, b, c
                pairs.kind[count] = 1 if price[1, b] < price[0, b] else 0
                count += 1
    return count


@compiled
def see(
    now: Stories,
    n: int,
    then: Stories,
    view: int,
    cameras: Cameras,
    at: np.ndarray,
    against: np.ndarray,
    told: Telling,
    pairs: Pairs,
) -> tuple[Stories, Stories, int]:
    """Take in one of a view's candidates, or none.

    Parameters
    ----------
    now, then : Stories
        The stories, and room for them.
    n : int
        How many there are.
    view : int
        Number of the view.
    cameras : Cameras
        The views.
    at : ndarray, shape (c, 2)
        Where each candidate says the point is, px.
    against : ndarray, shape (2, c)
        What speaks against each: a poor look, or that another point explains it; and the same
        for a paw that has just lifted off.
    told : Telling
        How stories are told.
    pairs : Pairs
        Room for them.

    Returns
    -------
    stories, room : Stories
        The stories that are left: first those that took in none. And room for the next.
    n : int
        How many there are.
    """
    own, thickness = cameras.own[view], cameras.thickness[view]
    chance = told.seen if own else told.seen_across
    seen = pictures(now, n if len(at) else 0, cameras.table[view])
    spread = ((told.good * thickness) ** 2, (told.bad * thickness) ** 2)
    count = find_pairs(seen, at, spread, (0.0, told.bad_cost), pairs)
    nothing = np.log(told.clutter / thickness**2 * 2.0 * np.pi / chance)
    for p in range(count):
        b = pairs.story[p]
        rises = 0 < now.since[b] <= told.rising
        pairs.cost[p] += now.cost[b] + nothing + against[int(rises), pairs.candidate[p]]
    if not own:
        for b in range(n):
            now.cost[b] -= np.log(1.0 - chance)
    if count == 0 and n <= told.most_within:
        return now, then, n
    kept, many = likeliest(now.cost[:n], pairs.cost[:count], told.most_within)
    taken, whose = np.empty(len(kept) - many, np.int64), kept.copy()
    for k in range(len(taken)):
        taken[k] = kept[many + k] - n
        whose[many + k] = pairs.story[taken[k]]
    copy(now, whose, then)
    _learn(then, many, seen, pairs, taken, at, spread)
    for k, pair in enumerate(taken):
        then.cost[many + k], then.taken[view, many + k] = pairs.cost[pair], pairs.candidate[pair]
    return then, now, len(kept)


@compiled
def likeliest(missed: np.ndarray, cost: np.ndarray, most: int) -> tuple[np.ndarray, int]:
    """Return the likeliest of stories that take in nothing and after them of pairs.

    And how many the first are. Of those that cost the same, the first are left.
    """
    total = np.empty(len(missed) + len(cost))
    for k in range(len(total)):
        total[k] = missed[k] if k < len(missed) else cost[k - len(missed)]
    kept = np.empty(min(len(total), most), np.int64)
    limit, count, ties, many = np.inf, 0, len(kept), 0
    if len(total) > most:
        limit = nth(total.copy(), most - 1)
        for price in total:
            ties -= int(price < limit)
    for j, price in enumerate(total):
        if price < limit or (price == limit and ties > 0):
            ties -= int(price == limit)
            kept[count] = j
            count += 1
            many += j < len(missed)
    return kept[:count], many


@compiled
def _learn(
    stories: Stories,
    begin: int,
    seen: Pictures,
    pairs: Pairs,
    taken: np.ndarray,
    at: np.ndarray,
    spread: tuple[float, float],
) -> None:
    """Let stories from ``begin`` on learn from the candidates of their pairs: a Kalman filter."""
    n, size = len(taken), len(stories.mean)
    step, weight = np.empty((2, n)), np.empty((3, n))
    across, gain = np.empty((2, size, n)), np.empty((2, size, n))
    for k, p in enumerate(taken):
        b = pairs.story[p]
        uu, uv = seen.spread[0, b] + spread[pairs.kind[p]], seen.spread[1, b]
        vv = seen.spread[2, b] + spread[pairs.kind[p]]
        area = uu * vv - uv * uv
        weight[0, k], weight[1, k], weight[2, k] = vv / area, -uv / area, uu / area
        for c in range(2):
            step[c, k] = at[pairs.candidate[p], c] - seen.at[c, b]
            for j in range(size):
                across[c, j, k] = seen.across[c, j, b]
    for j in range(size):
        for c in range(2):
            for k in range(n):
                gain[c, j, k] = across[0, j, k] * weight[c, k] + across[1, j, k] * weight[c + 1, k]
        for k in range(n):
            stories.mean[j, begin + k] += gain[0, j, k] * step[0, k] + gain[1, j, k] * step[1, k]
    for j in range(size):
        for i in range(j + 1):
            e = cell(j, i)
            for k in range(n):
                stories.covariance[e, begin + k] -= (
                    gain[0, j, k] * across[0, i, k] + gain[1, j, k] * across[1, i, k]
                )
