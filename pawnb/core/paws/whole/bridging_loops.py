"""The inner loops of :mod:`pawnb.core.paws.whole.bridging`, compiled.

States are position, speed and acceleration one after another: ``mean`` (b, 3 d) and
``covariance`` (b, 3 d, 3 d) of b stories.
"""

from __future__ import annotations

import numpy as np

from pawnb.core.compiled import compiled


@compiled
def advance(
    mean: np.ndarray, covariance: np.ndarray, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Go on by one frame at constant acceleration.

    Parameters
    ----------
    mean, covariance : ndarray
        The stories.
    noise : ndarray, shape (k, 3 d, 3 d)
        Covariances added; every story goes on with each of them.

    Returns
    -------
    mean, covariance : ndarray
        The stories with the first noise, then those with the second, and so on.
    """
    n, size = mean.shape
    d = size // 3
    many = len(noise)
    new = np.empty((many * n, size))
    spread = np.empty((many * n, size, size))
    half = np.empty((size, size))
    for b in range(n):
        for i in range(d):
            x, v, a = mean[b, i], mean[b, d + i], mean[b, 2 * d + i]
            new[b, i], new[b, d + i], new[b, 2 * d + i] = x + v + 0.5 * a, v + a, a
        P = covariance[b]
        for j in range(size):
            for i in range(d):
                x, v, a = P[i, j], P[d + i, j], P[2 * d + i, j]
                half[i, j], half[d + i, j], half[2 * d + i, j] = x + v + 0.5 * a, v + a, a
        for j in range(size):
            for i in range(d):
                x, v, a = half[j, i], half[j, d + i], half[j, 2 * d + i]
                P_x, P_v = x + v + 0.5 * a, v + a
                for k in range(many):
                    into = spread[k * n + b]
                    into[j, i] = P_x + noise[k, j, i]
                    into[j, d + i] = P_v + noise[k, j, d + i]
                    into[j, 2 * d + i] = a + noise[k, j, 2 * d + i]
        for k in range(1, many):
            new[k * n + b] = new[b]
    return new, spread


@compiled
def pictures(mean: np.ndarray, L: np.ndarray, d: int) -> tuple[np.ndarray, np.ndarray]:
    """Return image positions (b, 2) of stories in a view, and their derivatives (b, 2, d)."""
    n = len(mean)
    uv, J = np.empty((n, 2)), np.empty((n, 2, d))
    for b in range(n):
        top_u, top_v, below = L[3], L[7], 1.0
        for i in range(d):
            top_u += L[i] * mean[b, i]
            top_v += L[4 + i] * mean[b, i]
            below += L[8 + i] * mean[b, i]
        uv[b, 0], uv[b, 1] = top_u / below, top_v / below
        for i in range(d):
            J[b, 0, i] = (L[i] - uv[b, 0] * L[8 + i]) / below
            J[b, 1, i] = (L[4 + i] - uv[b, 1] * L[8 + i]) / below
    return uv, J


@compiled
def see(
    mean: np.ndarray,
    covariance: np.ndarray,
    missed: np.ndarray,
    cost: np.ndarray,
    L: np.ndarray,
    at: np.ndarray,
    against: np.ndarray,
    spread: np.ndarray,
    extra: np.ndarray,
    gate: float,
    most: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Take in one of a view's candidates, or none.

    Parameters
    ----------
    mean, covariance : ndarray
        The stories.
    missed, cost : ndarray, shape (b,)
        What each story costs if it takes in none, and before it takes in one.
    L : ndarray, shape (11,)
        DLT coefficients of the view.
    at, against : ndarray, shape (c, 2) and (c,)
        The candidates and what speaks against each.
    spread, extra : ndarray, shape (k,)
        For each kind of candidate its variance, px squared, and its cost.
    gate : float
        Largest squared distance, in standard deviations.
    most : int
        Stories kept.

    Returns
    -------
    mean, covariance, cost : ndarray
        The stories that are left: first those that took in none.
    origin, taken : ndarray of int
        Which story each was, and which candidate it took, -1 for none.
    """
    n = len(mean)
    uv, J = pictures(mean, L, mean.shape[1] // 3)
    PH, S = innovations(covariance, J)
    new, story, candidate, kind = pairs(uv, S, at, spread, extra, gate)
    total = np.concatenate((missed, new + against[candidate] + cost[story]))
    keep = np.argsort(total, kind="mergesort")[:most]
    plain, new_ones = keep[keep < n], keep[keep >= n] - n
    b, c = story[new_ones], candidate[new_ones]
    moved, left = updated(
        mean[b], covariance[b], PH[b], S[b], at[c] - uv[b], spread[kind[new_ones]]
    )  # fmt: skip
    return (
        np.concatenate((mean[plain], moved)), np.concatenate((covariance[plain], left)),
        np.concatenate((total[plain], total[new_ones + n])), np.concatenate((plain, b)),
        np.concatenate((np.full(len(plain), -1), c)),
    )  # fmt: skip


@compiled
def innovations(covariance: np.ndarray, J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return covariances of states with pictures (b, 3 d, 2) and of pictures (b, 2, 2)."""
    n, _, d = J.shape
    size = 3 * d
    PH, S = np.zeros((n, size, 2)), np.zeros((n, 2, 2))
    for b in range(n):
        for j in range(size):
            for i in range(d):
                for c in range(2):
                    PH[b, j, c] += covariance[b, j, i] * J[b, c, i]
        for i in range(d):
            for c in range(2):
                for e in range(2):
                    S[b, c, e] += J[b, c, i] * PH[b, i, e]
    return PH, S


@compiled
def pairs(
    uv: np.ndarray,
    S: np.ndarray,
    at: np.ndarray,
    spread: np.ndarray,
    extra: np.ndarray,
    gate: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the pairs of a story and a candidate within the gate.

    Their costs, numbers of story and candidate, and which kind of candidate is cheapest.
    """
    n, kinds = len(uv), len(spread)
    cost = np.empty(n * len(at))
    story = np.empty(n * len(at), np.int64)
    candidate, kind = story.copy(), story.copy()
    s0, s1, inverse, base = np.empty(kinds), np.empty(kinds), np.empty(kinds), np.empty(kinds)
    count = 0
    for b in range(n):
        for k in range(kinds):
            s0[k], s1[k] = S[b, 0, 0] + spread[k], S[b, 1, 1] + spread[k]
            area = s0[k] * s1[k] - S[b, 0, 1] * S[b, 1, 0]
            inverse[k], base[k] = 1.0 / area, 0.5 * np.log(area) + extra[k]
        across = S[b, 0, 1] + S[b, 1, 0]
        for c in range(len(at)):
            du, dv = at[c, 0] - uv[b, 0], at[c, 1] - uv[b, 1]
            best = np.inf
            for k in range(kinds):
                square = (s1[k] * du * du - across * du * dv + s0[k] * dv * dv) * inverse[k]
                if square <= gate and 0.5 * square + base[k] < best:
                    best, kind[count] = 0.5 * square + base[k], k
            if best < np.inf:
                cost[count], story[count], candidate[count] = best, b, c
                count += 1
    return cost[:count], story[:count], candidate[:count], kind[:count]


@compiled
def updated(
    mean: np.ndarray,
    covariance: np.ndarray,
    PH: np.ndarray,
    S: np.ndarray,
    step: np.ndarray,
    spread: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return means and covariances after what was seen: the Kalman filter's update.

    ``PH`` and ``S`` are those of :func:`innovations`, ``step`` (b, 2) how far the seen lies
    from the expected and ``spread`` (b,) its variance.
    """
    n, size = mean.shape
    mean, covariance = mean.copy(), covariance.copy()
    for b in range(n):
        s0, s1 = S[b, 0, 0] + spread[b], S[b, 1, 1] + spread[b]
        area = s0 * s1 - S[b, 0, 1] * S[b, 1, 0]
        for j in range(size):
            gain_u = (PH[b, j, 0] * s1 - PH[b, j, 1] * S[b, 1, 0]) / area
            gain_v = (PH[b, j, 1] * s0 - PH[b, j, 0] * S[b, 0, 1]) / area
            mean[b, j] += gain_u * step[b, 0] + gain_v * step[b, 1]
            for i in range(size):
                covariance[b, j, i] -= gain_u * PH[b, i, 0] + gain_v * PH[b, i, 1]
    return mean, covariance


@compiled
def stand(
    mean: np.ndarray, covariance: np.ndarray, cost: np.ndarray, at: np.ndarray, variance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the stories (mean, covariance, cost) after a place (d,) was seen for certain.

    Its coordinates are independent, so they are taken in one after the other.
    """
    n, size = mean.shape
    mean, covariance, cost = mean.copy(), covariance.copy(), cost.copy()
    across = np.empty(size)
    for b in range(n):
        P = covariance[b]
        for i in range(len(at)):
            spread = P[i, i] + variance
            step = at[i] - mean[b, i]
            cost[b] += 0.5 * step * step / spread + 0.5 * np.log(spread)
            across[:] = P[i]
            for j in range(size):
                gain = P[j, i] / spread
                mean[b, j] += gain * step
                for k in range(size):
                    P[j, k] -= gain * across[k]
    return mean, covariance, cost


@compiled
def beyond(x: np.ndarray, home: np.ndarray, reach: float) -> np.ndarray:
    """Tell which positions (b, d) are farther than ``reach`` from home (d,)."""
    far = np.empty(len(x), np.bool_)
    for b in range(len(x)):
        square = 0.0
        for i in range(len(home)):
            square += (x[b, i] - home[i]) ** 2
        far[b] = square > reach * reach
    return far


@compiled
def hiding(
    taken: np.ndarray,
    own: np.ndarray,
    was: np.ndarray,
    hide: float,
    stay: float,
    show: float,
    half: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return what being seen and hidden costs each story, and which are hidden.

    Parameters
    ----------
    taken : ndarray of int, shape (b, V)
        Candidate of each view, -1 where none.
    own : ndarray of bool, shape (V,)
        Views that track the point.
    was : ndarray of bool, shape (b,)
        Stories hidden in the frame before.
    hide, stay, show, half : float
        See :class:`~pawnb.core.paws.whole.bridging.Telling`.
    """
    price, hidden = np.empty(len(taken)), np.empty(len(taken), np.bool_)
    most = max(1, own.sum())
    for b in range(len(taken)):
        views = 0
        for v in range(len(own)):
            if own[v] and taken[b, v] >= 0:
                views += 1
        hidden[b] = views == 0
        if hidden[b]:
            price[b] = stay if was[b] else hide
        else:
            price[b] = (show if was[b] else 0.0) + half * (1.0 - views / most)
    return price, hidden


@compiled
def different(
    key: np.ndarray, grain: np.ndarray, cost: np.ndarray, lag: float, most: int
) -> np.ndarray:
    """Return the likeliest stories that are not the same, the likeliest first.

    Parameters
    ----------
    key, grain : ndarray, shape (b, k)
        What tells stories apart, and differences that do not.
    cost : ndarray, shape (b,)
        Their costs.
    lag : float
        Stories dearer than the best by this are forgotten.
    most : int
        Stories kept.
    """
    order = np.argsort(cost, kind="mergesort")
    kept = np.empty(most, np.int64)
    count = 0
    for b in order:
        if cost[b] >= cost[order[0]] + lag or count == most:
            break
        is_new = True
        for o in kept[:count]:
            same = True
            for i in range(key.shape[1]):
                if abs(key[b, i] - key[o, i]) > min(grain[b, i], grain[o, i]):
                    same = False
                    break
            if same:
                is_new = False
                break
        if is_new:
            kept[count] = b
            count += 1
    return kept[:count]


@compiled
def expect(
    mean: np.ndarray,
    covariance: np.ndarray,
    cost: np.ndarray,
    at: np.ndarray,
    axes: np.ndarray,
    variance: np.ndarray,
    most: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the stories (mean, covariance, cost) after a place was expected.

    Parameters
    ----------
    mean, covariance, cost : ndarray
        The stories.
    at, variance : ndarray, shape (d,)
        The expected place, and its variances along the axes.
    axes : ndarray, shape (d, d)
        Unit vectors.
    most : float
        Stories for which it would cost more are elsewhere for once: they cost this, and
        the expectation tells them nothing.
    """
    n, size = mean.shape
    d = len(at)
    mean, covariance, cost = mean.copy(), covariance.copy(), cost.copy()
    x, P, PH = np.empty(size), np.empty((size, size)), np.empty(size)
    for b in range(n):
        x[:], P[:] = mean[b], covariance[b]
        price = 0.0
        for k in range(d):
            step, spread = 0.0, variance[k]
            PH[:] = 0.0
            for i in range(d):
                step += axes[k, i] * (at[i] - x[i])
                for j in range(size):
                    PH[j] += P[j, i] * axes[k, i]
            for i in range(d):
                spread += axes[k, i] * PH[i]
            price += 0.5 * step * step / spread
            for j in range(size):
                gain = PH[j] / spread
                x[j] += gain * step
                for i in range(size):
                    P[j, i] -= gain * PH[i]
        if price < most:
            mean[b], covariance[b] = x, P
        cost[b] += min(price, most)
    return mean, covariance, cost
