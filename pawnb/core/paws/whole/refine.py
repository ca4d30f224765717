"""From chosen places to exact tracks: every view's candidates again, then smoothing.

A path says which places a point took. Smoothed, it says where the point must be in every
view and frame, also where no two views met; the candidates there are taken in, view by
view, and the track is smoothed again through them. What a click says about
where the tracked point lies relative to the end of a paw is added to each candidate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.whole.candidates import worth
from pawnb.core.paws.whole.geometry import Geometry
from pawnb.core.paws.whole.side_by_side import side_by_side
from pawnb.core.paws.whole.smoothing import smooth, variances

_ROUNDS = 3
_JERK = 2.5
"""Usual change of the acceleration from frame to frame, in accelerations."""
_WORSE = 0.3
"""Candidates at clicks that look less like the end of a paw than this share of the best."""
_TAIL = 3.0
"""Residuals beyond this many standard deviations count less and less."""


@dataclass(frozen=True)
class Offsets:
    """Where the tracked points lie relative to candidates, in thicknesses of a paw.

    Parameters
    ----------
    along, across : ndarray, shape (P,)
        Along the direction in which the limb ends, and to the right of it (down in a view
        in which the animal faces right).
    """

    along: np.ndarray
    across: np.ndarray

    def apply(
        self, rows: np.ndarray, point: int, *, thickness_px: float, facing: int
    ) -> np.ndarray:
        """Return the tracked point's position (n, 2) for candidates of one view."""
        e = rows[:, 2:4].astype(float)
        e /= np.maximum(np.hypot(e[:, 0], e[:, 1]), 1e-6)[:, None]
        side = np.column_stack([-e[:, 1], e[:, 0]]) * facing
        shift = self.along[point] * e + self.across[point] * side
        return rows[:, :2] + thickness_px * shift


def learn_offsets(
    clicks: np.ndarray,
    found: Mapping[int, Sequence[np.ndarray]],
    *,
    thickness_px: np.ndarray,
    facing: Sequence[int],
    distal: Sequence[tuple[float, float]],
    kinds: Sequence[str],
) -> Offsets:
    """Learn the offsets from the clicked frames.

    The candidate of a click is the nearest one that looks like the end of a paw. Clicks
    where only something else is near, such as a heel, say nothing if others say more.

    Parameters
    ----------
    clicks : ndarray, shape (frames, P, V, 2)
        Clicks, NaN where there is none, in the order of ``found``.
    found : mapping
        Clicked frame to the candidates of every view.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.
    facing : sequence of int
        +1 or -1 for each view.
    distal : sequence of (float, float)
        See :class:`~pawnb.core.paws.whole.candidates.Look`.
    kinds : sequence of str
        Kind of each point; points of one kind share their offsets.

    Returns
    -------
    Offsets
        Offsets; of a point without a candidate near its clicks, the mean of the others.
    """
    n_points = clicks.shape[1]
    seen: list[list[tuple[float, float, float]]] = [[] for _ in range(n_points)]
    for click, rows_by_view in zip(clicks, found.values(), strict=True):
        for p, v in np.argwhere(np.isfinite(click[..., 0])):
            rows = rows_by_view[v]
            if not len(rows):
                continue
            step = click[p, v] - rows[:, :2]
            away = np.hypot(step[:, 0], step[:, 1]) / thickness_px[v]
            good = worth(rows, distal[v])
            i = int(np.argmin(np.where(away > 1.2, np.inf, away + 0.5 * (1.0 - good))))
            if away[i] > 1.2:
                continue
            e = rows[i, 2:4] / max(float(np.hypot(*rows[i, 2:4])), 1e-6)
            side = np.array([-e[1], e[0]]) * (facing[v] or 1)
            seen[p].append(
                (step[i] @ e / thickness_px[v], step[i] @ side / thickness_px[v], float(good[i]))
            )
    every = [s for own in seen for s in own] or [(0.0, 0.0, 1.0)]
    alike = [
        [s for other, own in zip(kinds, seen, strict=True) if other == kind for s in own]
        for kind in kinds
    ]
    means = np.array([_usual(np.array(own or every)) for own in alike])
    return Offsets(means[:, 0], means[:, 1])


def _usual(rows: np.ndarray) -> np.ndarray:
    """Return the median of each column but the last, which says how good each row is."""
    good = rows[:, -1] >= _WORSE * rows[:, -1].max()
    return np.asarray(np.median(rows[good, :-1], axis=0))


@dataclass
class Refined:
    """Smoothed tracks: n frames, P points, V views, d coordinates.

    Parameters
    ----------
    x, sd : ndarray, shape (n, P, d)
        Positions and their standard deviations.
    measured : ndarray, shape (n, P, V, 2)
        Candidates taken, corrected by the offsets, NaN where none.
    quality : ndarray, shape (n, P, V)
        How much each of them looks like the end of a paw, 0 to 1.
    """

    x: np.ndarray
    sd: np.ndarray
    measured: np.ndarray
    quality: np.ndarray


@dataclass(frozen=True)
class Refinement:
    """What refining needs to know besides the paths.

    Parameters
    ----------
    geometry : Geometry
        The views.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.
    thickness : float
        The same in space.
    facing : sequence of int
        +1 or -1 for each view.
    distal : sequence of (float, float)
        See :class:`~pawnb.core.paws.whole.candidates.Look`.
    offsets : Offsets
        Where the tracked points lie.
    acceleration : float
        Standard deviation of the acceleration, length per frame squared.
    own : ndarray of bool, shape (P, V)
        Which view tracks which point.
    """

    geometry: Geometry
    thickness_px: np.ndarray
    thickness: float
    facing: Sequence[int]
    distal: Sequence[tuple[float, float]]
    offsets: Offsets
    acceleration: float
    own: np.ndarray


def refine(
    start: np.ndarray,
    found: Sequence[Sequence[np.ndarray]],
    *,
    certain: np.ndarray,
    what: Refinement,
) -> Refined:
    """Refine tracks.

    Parameters
    ----------
    start : ndarray, shape (n, P, d)
        Chosen places, NaN where hidden.
    found : sequence
        Candidates of every frame and view.
    certain : ndarray, shape (n, P, V, 2)
        Image positions placed by hand, NaN elsewhere.
    what : Refinement
        The rest.

    Returns
    -------
    Refined
        The tracks.
    """
    n, n_points, d = start.shape
    x = np.empty_like(start)
    q = np.full((n, n_points), (_JERK * what.acceleration) ** 2)
    noise = 0.3 * what.thickness
    factors = np.empty((n_points, 3 * d + 1, n * d))
    for p in range(n_points):
        seen = np.isfinite(start[:, p, 0])
        W = seen[:, None, None] * np.eye(d) / noise**2
        x[:, p], factors[p] = smooth(W, np.nan_to_num(start[:, p]) / noise**2, q[:, p])
        q[:, p] = _jerk2(x[:, p], what.acceleration)
    spread = np.sqrt(np.minimum(variances(factors, d), 1e6).mean(axis=-1)).T
    sigma = 0.18
    for _ in range(_ROUNDS):
        measured, quality = _associate(x, spread, found, what)
        by_hand = np.isfinite(certain[..., 0])
        measured[by_hand] = certain[by_hand]
        quality[by_hand] = 1.0
        weight = _weights(x, measured, quality, sigma, what)
        weight[by_hand] = (
            1.0 / np.broadcast_to((0.05 * what.thickness_px + 0.3) ** 2, weight.shape)[by_hand]
        )
        J = what.geometry.jacobian(x)
        wanted = np.nan_to_num(measured - what.geometry.project(x)) + np.einsum(
            "npvij,npj->npvi", J, x
        )
        W = np.einsum("npv,npvik,npvil->npkl", weight, J, J)
        z = np.einsum("npv,npvik,npvi->npk", weight, J, wanted)
        for p in range(n_points):
            x[:, p], factors[p] = smooth(W[:, p], z[:, p], q[:, p])
            q[:, p] = _jerk2(x[:, p], what.acceleration)
        sd = np.sqrt(variances(factors, d)).swapaxes(0, 1)
        spread = sd.mean(axis=-1)
        sigma = _sigma(x, measured, what, by_hand)
    # what is alike from frame to frame does not average out
    sd = np.sqrt(sd**2 * 2.0 + (0.06 * what.thickness) ** 2)
    return Refined(x, sd, measured, quality)


def _jerk2(x: np.ndarray, acceleration: float) -> np.ndarray:
    """Return the variance of the jerk about each frame, from the track itself."""
    n = len(x)
    square = np.zeros(n)
    if n > 3:
        square[1:-2] = (np.diff(x, n=3, axis=0) ** 2).mean(axis=1)
    local = np.convolve(np.pad(square, 3, mode="edge"), np.ones(7) / 7, mode="valid")
    usual = _JERK * acceleration
    return np.asarray(np.clip(2.0 * local, (0.1 * usual) ** 2, (3.0 * usual) ** 2))


def _associate(
    x: np.ndarray,
    spread: np.ndarray,
    found: Sequence[Sequence[np.ndarray]],
    what: Refinement,
) -> tuple[np.ndarray, np.ndarray]:
    """Take for each point and view the candidate where it must be."""
    n, n_points, _ = x.shape
    uv = what.geometry.project(x)
    n_views = uv.shape[2]
    rows, is_there = side_by_side(found)
    good = np.empty(rows.shape[:3])
    at = np.empty((n, n_points, n_views, rows.shape[2], 2))
    for v in range(n_views):
        flat = rows[:, v].reshape(-1, rows.shape[-1])
        good[:, v] = worth(flat, what.distal[v]).reshape(n, -1)
        for p in range(n_points):
            scale, facing = what.thickness_px[v], what.facing[v] or 1
            moved = what.offsets.apply(flat, p, thickness_px=scale, facing=facing)
            at[:, p, v] = moved.reshape(n, -1, 2)
    away = np.linalg.norm(at - uv[..., None, :], axis=-1) / what.thickness_px[:, None]
    gate = np.minimum(0.7 + 4.0 * spread / what.thickness, 2.5)
    cost = away + 0.5 * (1.0 - good[:, None])
    cost[(away > gate[:, :, None, None]) | ~is_there[:, None]] = np.inf
    return _take_nearest(cost, at, good)


def _take_nearest(
    cost: np.ndarray, at: np.ndarray, good: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Give candidates to points, the cheapest pair (n, P, V, most) first, each only once."""
    n, n_points, n_views, most = cost.shape
    measured = np.full((n, n_points, n_views, 2), np.nan)
    quality = np.zeros((n, n_points, n_views))
    cost = np.moveaxis(cost, 2, 1).copy()
    for _ in range(min(n_points, most)):
        pairs = cost.reshape(n, n_views, -1)
        best = pairs.argmin(axis=-1)
        t, v = np.nonzero(np.isfinite(pairs.min(axis=-1)))
        p, i = np.divmod(best[t, v], most)
        measured[t, p, v], quality[t, p, v] = at[t, p, v, i], good[t, v, i]
        cost[t, v, p] = np.inf
        cost[t, v, :, i] = np.inf
    return measured, quality


def _weights(
    x: np.ndarray, measured: np.ndarray, quality: np.ndarray, sigma: float, what: Refinement
) -> np.ndarray:
    """Return the weight (n, P, V), px^-2, of each measurement: less for doubtful ones."""
    away = np.linalg.norm(measured - what.geometry.project(x), axis=-1) / what.thickness_px
    base = sigma / np.clip(quality, 0.15, 1.0)
    # a view from the other side sees less of the paw
    base = base * np.where(what.own[None], 1.0, 1.5)
    ratio = away / base
    robust = (_TAIL + 1.0) / (_TAIL + ratio**2)
    weight = np.minimum(robust, 1.0) / (base * what.thickness_px) ** 2
    return np.where(np.isfinite(weight), weight, 0.0)


def _sigma(x: np.ndarray, measured: np.ndarray, what: Refinement, by_hand: np.ndarray) -> float:
    """Return the standard deviation of measurements in thicknesses, from the median residual."""
    step = (measured - what.geometry.project(x)) / what.thickness_px[:, None]
    step = step[np.isfinite(step[..., 0]) & ~by_hand]
    if len(step) < 20:
        return 0.18
    return float(np.clip(1.4826 * np.median(np.abs(step)), 0.05, 0.4))
