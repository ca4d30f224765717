"""How hypotheses of a point are updated with a view's detections, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import HypothesisBank, cell, copy
from pawnb.core.paws.offline.gap_closing.mht_parameters import MHTParameters
from pawnb.core.sorting_kernels import nth


class Cameras(NamedTuple):
    """The views.

    Parameters
    ----------
    table : ndarray, shape (V, 11)
        DLT coefficients.
    paw_width : ndarray, shape (V,)
        Width of a paw, px.
    tracked_in_view : ndarray of bool, shape (V,)
        Views that track the point.
    """

    table: np.ndarray
    paw_width: np.ndarray
    tracked_in_view: np.ndarray


class Projections(NamedTuple):
    """What hypotheses look like in a view.

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
    """Room for pairs of a hypothesis and a detection.

    Parameters
    ----------
    cost : ndarray, shape (p,)
        What each costs the hypothesis.
    hypothesis, detection, kind : ndarray of int, shape (p,)
        Their numbers, and which kind of detection is cheapest: 0 for a good one, 1 for a bad.
    """

    cost: np.ndarray
    hypothesis: np.ndarray
    detection: np.ndarray
    kind: np.ndarray


@compiled
def allocate_pairs(pairs: int) -> Pairs:
    """Return room for so many pairs."""
    return Pairs(
        np.empty(pairs), np.empty(pairs, np.int64), np.empty(pairs, np.int64),
        np.empty(pairs, np.int64),
    )  # fmt: skip


@compiled
def project_hypotheses(hypotheses: HypothesisBank, n: int, L: np.ndarray) -> Projections:
    """Return what the first ``n`` hypotheses look like in a view of DLT coefficients (11,)."""
    size = len(hypotheses.mean)
    d = size // 3
    at, slope, below = np.empty((2, n)), np.empty((2, d, n)), np.ones(n)
    for i in range(d):
        for b in range(n):
            below[b] += L[8 + i] * hypotheses.mean[i, b]
    for c in range(2):
        for b in range(n):
            at[c, b] = L[4 * c + 3]
        for i in range(d):
            for b in range(n):
                at[c, b] += L[4 * c + i] * hypotheses.mean[i, b]
        for b in range(n):
            at[c, b] /= below[b]
        for i in range(d):
            for b in range(n):
                slope[c, i, b] = (L[4 * c + i] - at[c, b] * L[8 + i]) / below[b]
    across, spread = _spreads(hypotheses, slope)
    return Projections(at, slope, across, spread)


@compiled
def _spreads(hypotheses: HypothesisBank, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return covariances of pictures with states, and of pictures; see :class:`Projections`."""
    (_, d, n), size = slope.shape, len(hypotheses.mean)
    across, spread = np.zeros((2, size, n)), np.zeros((3, n))
    for c in range(2):
        for j in range(size):
            for i in range(d):
                e = cell(j, i)
                for b in range(n):
                    across[c, j, b] += hypotheses.covariance[e, b] * slope[c, i, b]
        for e in range(c + 1):
            for i in range(d):
                for b in range(n):
                    spread[c + e, b] += slope[c, i, b] * across[e, i, b]
    return across, spread


@compiled
def gate(
    seen: Projections,
    at: np.ndarray,
    spread: tuple[float, float],
    extra: tuple[float, float],
    within: float,
    pairs: Pairs,
) -> int:
    """Gate: find the pairs of a hypothesis and a detection that fit, and return how many there are.

    Parameters
    ----------
    seen : Projections
        What the hypotheses look like.
    at : ndarray, shape (c, 2)
        The detections, px.
    spread, extra : tuple of float
        For a good and a bad detection its variance, px squared, and its cost.
    within : float
        Largest squared distance, in standard deviations.
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
                price[k, b] = 0.5 * square + base[k, b] if square <= within else np.inf
        for b in range(n):
            best = min(price[0, b], price[1, b])
            if best < np.inf:
                pairs.cost[count], pairs.hypothesis[count], pairs.detection[count] = best, b, c
                pairs.kind[count] = 1 if price[1, b] < price[0, b] else 0
                count += 1
    return count


@compiled
def associate(
    now: HypothesisBank,
    n: int,
    then: HypothesisBank,
    view: int,
    cameras: Cameras,
    at: np.ndarray,
    negative_log_odds: np.ndarray,
    parameters: MHTParameters,
    pairs: Pairs,
) -> tuple[HypothesisBank, HypothesisBank, int]:
    """Associate every hypothesis with one of a view's detections, or none.

    Parameters
    ----------
    now, then : HypothesisBank
        The hypotheses, and room for them.
    n : int
        How many there are.
    view : int
        Number of the view.
    cameras : Cameras
        The views.
    at : ndarray, shape (c, 2)
        Where each detection says the point is, px.
    negative_log_odds : ndarray, shape (2, c)
        What speaks against each: a poor look, or that another point explains it; and the same
        for a paw that has just lifted off.
    parameters : MHTParameters
        The parameters.
    pairs : Pairs
        Room for them.

    Returns
    -------
    hypotheses, room : HypothesisBank
        The hypotheses that are left: first those that took in none. And room for the next.
    n : int
        How many there are.
    """
    tracked_in_view, paw_width = cameras.tracked_in_view[view], cameras.paw_width[view]
    chance = parameters.seen if tracked_in_view else parameters.seen_across
    seen = project_hypotheses(now, n if len(at) else 0, cameras.table[view])
    spread = ((parameters.good * paw_width) ** 2, (parameters.bad * paw_width) ** 2)
    count = gate(seen, at, spread, (0.0, parameters.bad_cost), parameters.gate, pairs)
    nothing = np.log(parameters.clutter / paw_width**2 * 2.0 * np.pi / chance)
    for p in range(count):
        b = pairs.hypothesis[p]
        rises = 0 < now.since[b] <= parameters.rising
        pairs.cost[p] += now.cost[b] + nothing + negative_log_odds[int(rises), pairs.detection[p]]
    if not tracked_in_view:
        for b in range(n):
            now.cost[b] -= np.log(1.0 - chance)
    if count == 0 and n <= parameters.most_within:
        return now, then, n
    kept, many = most_likely(now.cost[:n], pairs.cost[:count], parameters.most_within)
    taken, whose = np.empty(len(kept) - many, np.int64), kept.copy()
    for k in range(len(taken)):
        taken[k] = kept[many + k] - n
        whose[many + k] = pairs.hypothesis[taken[k]]
    copy(now, whose, then)
    _kalman_update(then, many, seen, pairs, taken, at, spread)
    for k, pair in enumerate(taken):
        then.cost[many + k], then.taken[view, many + k] = pairs.cost[pair], pairs.detection[pair]
    return then, now, len(kept)


@compiled
def most_likely(missed: np.ndarray, cost: np.ndarray, most: int) -> tuple[np.ndarray, int]:
    """Return the likeliest of hypotheses that take in nothing and after them of pairs.

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
def _kalman_update(
    hypotheses: HypothesisBank,
    begin: int,
    seen: Projections,
    pairs: Pairs,
    taken: np.ndarray,
    at: np.ndarray,
    spread: tuple[float, float],
) -> None:
    """Update hypotheses from ``begin`` on with the detections of their pairs: a Kalman filter."""
    n, size = len(taken), len(hypotheses.mean)
    step, weight = np.empty((2, n)), np.empty((3, n))
    across, gain = np.empty((2, size, n)), np.empty((2, size, n))
    for k, p in enumerate(taken):
        b = pairs.hypothesis[p]
        uu, uv = seen.spread[0, b] + spread[pairs.kind[p]], seen.spread[1, b]
        vv = seen.spread[2, b] + spread[pairs.kind[p]]
        area = uu * vv - uv * uv
        weight[0, k], weight[1, k], weight[2, k] = vv / area, -uv / area, uu / area
        for c in range(2):
            step[c, k] = at[pairs.detection[p], c] - seen.at[c, b]
            for j in range(size):
                across[c, j, k] = seen.across[c, j, b]
    for j in range(size):
        for c in range(2):
            for k in range(n):
                gain[c, j, k] = across[0, j, k] * weight[c, k] + across[1, j, k] * weight[c + 1, k]
        for k in range(n):
            hypotheses.mean[j, begin + k] += gain[0, j, k] * step[0, k] + gain[1, j, k] * step[1, k]
    for j in range(size):
        for i in range(j + 1):
            e = cell(j, i)
            for k in range(n):
                hypotheses.covariance[e, begin + k] -= (
                    gain[0, j, k] * across[0, i, k] + gain[1, j, k] * across[1, i, k]
                )
