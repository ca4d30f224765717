"""From chosen places to exact tracks: every view's candidates again, then smoothing.

A path says which places a point took. Smoothed, it says where the point must be in every
view and frame, also where no two views met; the candidates there are taken in, view by
view, and the track is smoothed again through them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.association.network_flow.lateral_prior import Beside
from pawnb.core.paws.offline.detection.colour.observations import Sights
from pawnb.core.paws.offline.gap_closing.gap_closing import Bridged
from pawnb.core.paws.offline.projection import Geometry
from pawnb.core.paws.offline.smoothing import refinement_kernels as loops
from pawnb.core.paws.offline.smoothing.forward_backward_distance import Equations
from pawnb.core.paws.offline.smoothing.smoother import covariances, diagonals, smooth
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.stride.stance import expected_bends
from pawnb.core.paws.offline.stride.swing import Swings

_NEAR, _NEAR_OPEN = 0.9, 2.2
"""A candidate may lie so many thicknesses from where its point must be, farther in open frames,
where that is told by what lies far before and after, but"""
_AGAINST = 0.3
"""there by this much less for each unit of what speaks against it: what lies where a point is
hidden is mostly a part of a limb. A paw that lifts off, dim and bent, looks poor as well, so
what looks poor is not left out altogether."""
_ROUNDS = 8
_BRIDGED = 3
"""Rounds in which open frames keep what was chosen there; then everything is open to all."""
_STEPS = 2
_SIGMA = 0.12
"""Standard deviation of a good candidate, in thicknesses."""
_TAIL = 3.0
"""Residuals beyond this many standard deviations count less and less."""
_HOLD = 0.05
"""Standard deviation of where a point stands that is not seen, in thicknesses: it goes exactly as
the ground does, and what is taken too freely there lets the swing begin too early."""
_UNSURE_LIFT = 0.3
"""Standard deviation of how lift-off changes the speed upwards, in that change. Forward it does
not: there a paw goes on with the ground and gains speed little by little."""
_ON_ARC = 0.1
"""Variance of how much a hidden paw bends off its arc, in that of how much paws bend."""
_PULL, _PULL_BETWEEN = 0.05, 0.01
"""Information, in that of one expectation, that the cycle gives a frame without candidates, and
less where candidates follow: the cycle of a paw that is hidden in every stride is no more than was
made of it before. Without any, a paw that is seen no more once it lifts off goes on as it began.
There the arc of its swing gives as much as the cycle."""


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
    revision : ndarray, shape (n, P)
        How far each position is from where an earlier decision had it, NaN where there was none.
    separation : ndarray, shape (n, P, V)
        How far candidates are ahead of the next best ones (:mod:`.association_odds`), NaN where
        none.
    apart : ndarray, shape (n, P)
        How far a pass forwards and one backwards are apart (:mod:`.forward_backward_distance`), NaN
        where not known.
    equations : Equations, optional
        What the tracks were smoothed from.
    """

    x: np.ndarray
    sd: np.ndarray
    measured: np.ndarray
    quality: np.ndarray
    revision: np.ndarray
    separation: np.ndarray
    apart: np.ndarray
    equations: Equations | None = None

    def take(self, which: np.ndarray, tracks: Refined) -> None:
        """Take in the tracks of some points: those that ``which`` (P,) picks out, in order."""
        self.x[:, which], self.sd[:, which] = tracks.x, tracks.sd
        self.measured[:, which], self.quality[:, which] = tracks.measured, tracks.quality
        self.revision[:, which] = tracks.revision
        self.separation[:, which], self.apart[:, which] = tracks.separation, tracks.apart


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
    jerk : float
        Standard deviation of the change of acceleration from frame to frame.
    own : ndarray of bool, shape (P, V)
        Which view tracks which point.
    unsure : ndarray, shape (P,)
        Standard error of the offsets of the tracked points, in thicknesses.
    """

    geometry: Geometry
    thickness_px: np.ndarray
    thickness: float
    jerk: float
    own: np.ndarray
    unsure: np.ndarray


def refine(
    start: np.ndarray,
    sights: Sights,
    bridged: Bridged,
    *,
    certain: np.ndarray,
    what: Refinement,
    cycle: Cycle | None = None,
    beside: Beside | None = None,
    swings: Swings | None = None,
) -> Refined:
    """Refine tracks.

    Parameters
    ----------
    start : ndarray, shape (n, P, d)
        Chosen places, NaN where hidden.
    sights : Sights
        What every view shows.
    bridged : Bridged
        What was taken where paths are not certain.
    certain : ndarray, shape (n, P, V, 2)
        Image positions placed by hand, NaN elsewhere.
    what : Refinement
        The rest.
    cycle : Cycle, optional
        Where points are expected.
    beside : Beside, optional
        Where they usually are to the side.
    swings : Swings, optional
        Where they swing.

    Returns
    -------
    Refined
        The tracks.
    """
    n, n_points, d = start.shape
    held = np.full_like(start, np.nan) if bridged.held is None else bridged.held
    standing = np.isfinite(held[..., 0])
    hold = np.where(standing, 1.0 / (_HOLD * what.thickness) ** 2, 0.0)[..., None]
    changes = _changes(bridged, start.shape, what.jerk, swings)
    x, factors = _through_places(start, held, bridged, what, changes)
    near = np.where(bridged.is_open & ~standing, _NEAR_OPEN, _NEAR)
    against = np.where(bridged.is_open[..., None, None], _AGAINST * bridged.against, 0.0)
    by_hand = np.isfinite(certain[..., 0])
    taken = _taken(bridged, sights)
    for k in range(_ROUNDS):
        measured, quality = _associate(x, near, against, sights, what)
        if k < _BRIDGED:
            measured[bridged.is_open], quality[bridged.is_open] = (
                part[bridged.is_open] for part in taken
            )
        measured[by_hand], quality[by_hand] = certain[by_hand], 1.0
        for step in range(_STEPS):
            weight = _weights(x, measured, quality, what, robust=k + step > 0)
            weight[by_hand] = np.broadcast_to(
                1.0 / (0.05 * what.thickness_px + 0.3) ** 2, weight.shape
            )[by_hand]
            W, z = _normal(x, measured, weight, what)
            W += hold[..., None] * np.eye(d)
            z += hold * np.nan_to_num(held)
            if beside is not None:
                beside.add(W, z, np.isfinite(measured[..., 0]).sum(axis=-1))
            seen = np.isfinite(measured[..., 0]).any(axis=-1)
            if cycle is not None:
                _pull(W, z, _expected(seen), to=cycle.mean, sd=cycle.sd, axes=cycle.axes)
            if swings is not None and changes.axes is not None:
                on_arc = np.where(_is_followed(seen), 0.0, _PULL)
                _pull(W, z, on_arc, to=swings.place, sd=swings.sd, axes=changes.axes)
            for p in range(n_points):
                x[:, p], factors[p] = changes.smooth(p, W[:, p], z[:, p])
    covariance = covariances(factors, d, axes=changes.axes)
    sd = np.sqrt(diagonals(covariance)).swapaxes(0, 1)
    # what is alike from frame to frame does not average out
    alike = (0.06**2 + what.unsure**2) * what.thickness**2
    not_known = np.full((n, n_points), np.nan)
    return Refined(
        x, np.sqrt(2.0 * sd**2 + alike[:, None]), measured, quality, not_known,
        np.full(quality.shape, np.nan), not_known.copy(),
        Equations(W, z, changes.jerk2, changes.bend, changes.axes, covariance.swapaxes(0, 1)),
    )  # fmt: skip


def deviations(quality: np.ndarray, what: Refinement) -> np.ndarray:
    """Return standard deviations (n, P, V, C), px, of candidates of a quality (n, V, C)."""
    base = (_SIGMA / np.clip(quality, 0.3, 1.0))[:, None] * _seen_worse(what)[..., None]
    return np.asarray(base * what.thickness_px[:, None])


def _seen_worse(what: Refinement) -> np.ndarray:
    """Return how much vaguer candidates of each point and view (P, V) are."""
    # a view from the other side sees less of the paw
    return np.where(what.own, 1.0, 1.5)


@dataclass(frozen=True)
class _Changes:
    """How accelerations change from frame to frame.

    Parameters
    ----------
    jerk2, bend : ndarray, shape (n, P, d)
        Variance along each axis, and mean.
    axes : ndarray, shape (d, d), optional
        The axes.
    """

    jerk2: np.ndarray
    bend: np.ndarray
    axes: np.ndarray | None

    def smooth(self, point: int, W: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the smoothed track of a point, and its factor."""
        return smooth(W, z, self.jerk2[:, point], bend=self.bend[:, point], axes=self.axes)


def _changes(
    bridged: Bridged, shape: tuple[int, ...], jerk: float, swings: Swings | None
) -> _Changes:
    """Return how accelerations change: as on the arcs, and at lift-off a paw goes up at once."""
    jerk2, ground = np.full(shape, jerk**2), bridged.ground
    if ground is None:
        return _Changes(jerk2, np.zeros(shape), None)
    bend, near = expected_bends(bridged.lifts, ground.lift, shape[0])
    unsure = (_UNSURE_LIFT * np.linalg.norm(ground.lift, axis=-1)) ** 2
    jerk2[..., -1] += np.where(near, unsure, 0.0)
    if swings is not None:
        on_arc = np.isfinite(swings.bend[..., 0])
        bend = np.where(on_arc[..., None], swings.bend, bend)
        hidden = on_arc & bridged.is_open & np.isfinite(swings.place[..., 0]) & ~near
        jerk2[hidden] *= _ON_ARC
    return _Changes(jerk2, bend, ground.manner.axes)


def _through_places(
    start: np.ndarray,
    held: np.ndarray,
    bridged: Bridged,
    what: Refinement,
    changes: _Changes,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the smoothest path through the certain places, and room for its factors."""
    n, n_points, d = start.shape
    places = np.where(bridged.is_open[..., None], held, start)
    information = 1.0 / (0.3 * what.thickness) ** 2
    x = np.empty_like(start)
    factors = np.empty((n_points, n * d, 3 * d + 1))
    for p in range(n_points):
        seen = np.isfinite(places[:, p, 0])
        W = seen[:, None, None] * np.eye(d) * information
        x[:, p], factors[p] = changes.smooth(p, W, np.nan_to_num(places[:, p]) * information)
    return x, factors


def _taken(bridged: Bridged, sights: Sights) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, P, V, 2) and qualities (n, P, V) of the candidates chosen."""
    n, n_points, n_views = bridged.choice.shape
    measured = np.full((n, n_points, n_views, 2), np.nan)
    quality = np.zeros((n, n_points, n_views))
    t, p, v = np.nonzero(bridged.choice >= 0)
    number = bridged.choice[t, p, v]
    # the choice counts only the candidates that are there, and those come first
    measured[t, p, v] = sights.at[t, p, v, number]
    quality[t, p, v] = sights.quality[t, v, number]
    return measured, quality


def _associate(
    x: np.ndarray, near: np.ndarray, against: np.ndarray, sights: Sights, what: Refinement
) -> tuple[np.ndarray, np.ndarray]:
    """Take for each point and view the candidate where it must be."""
    uv = what.geometry.project(x)
    return loops.take_nearest(
        uv, near, sights.at, sights.quality, sights.is_there, what.thickness_px, against
    )


def _weights(
    x: np.ndarray, measured: np.ndarray, quality: np.ndarray, what: Refinement, *, robust: bool
) -> np.ndarray:
    """Return the weight (n, P, V), px^-2, of each measurement: less for doubtful ones."""
    base = _SIGMA / np.clip(quality, 0.3, 1.0) * _seen_worse(what)
    weight = 1.0 / (base * what.thickness_px) ** 2
    away = np.linalg.norm(measured - what.geometry.project(x), axis=-1) / what.thickness_px
    if robust:
        weight = weight * np.minimum((_TAIL + 1.0) / (_TAIL + (away / base) ** 2), 1.0)
    return np.where(np.isfinite(away), weight, 0.0)


def _normal(
    x: np.ndarray, measured: np.ndarray, weight: np.ndarray, what: Refinement
) -> tuple[np.ndarray, np.ndarray]:
    """Return information (n, P, d, d) and target (n, P, d) of the measurements."""
    return loops.normal_equations(x, measured, weight, what.geometry.rows)


def _expected(seen: np.ndarray) -> np.ndarray:
    """Return what the cycle tells in each frame (n, P), given where points have candidates."""
    before = np.logical_or.accumulate(seen, axis=0)
    between = before & _is_followed(seen)
    return np.where(seen, 0.0, np.where(between, _PULL_BETWEEN, _PULL))


def _is_followed(seen: np.ndarray) -> np.ndarray:
    """Tell in which frames (n, P) points have candidates there or later."""
    return np.asarray(np.logical_or.accumulate(seen[::-1], axis=0)[::-1])


def _pull(
    W: np.ndarray,
    z: np.ndarray,
    weight: np.ndarray,
    *,
    to: np.ndarray,
    sd: np.ndarray,
    axes: np.ndarray,
) -> None:
    """Draw hidden points weakly towards where they are expected, where that is known."""
    there = np.isfinite(to)
    information = weight[..., None] / np.where(there, sd, np.inf) ** 2
    extra = np.einsum("ki,npk,kj->npij", axes, information, axes, optimize=True)
    W += extra
    z += np.einsum("npij,npj->npi", extra, np.where(there, to, 0.0))
