"""From chosen places to exact tracks: every view's detections again, then smoothing.

A path says which places a point took. Smoothed, it says where the point must be in every
view and frame, also where no two views met; the detections there are taken in, view by
view, and the track is smoothed again through them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.association.network_flow.priors.lateral_prior import LateralPrior
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.state import GapClosing
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.smoothing import refinement_kernels as loops
from pawnb.core.paws.offline.smoothing.forward_backward_distance import NormalEquations
from pawnb.core.paws.offline.smoothing.parameters import SMOOTHING
from pawnb.core.paws.offline.smoothing.smoother import covariances, diagonals, smooth
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.stride.cycle import Cycle
from pawnb.core.paws.offline.stride.stance import expected_jerks
from pawnb.core.paws.offline.stride.swing import Swings


@dataclass(frozen=True)
class MeasurementModel:
    """What refining needs to know besides the paths.

    Parameters
    ----------
    geometry : Projection
        The views.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.
    paw_width : float
        The same in space.
    jerk : float
        Standard deviation of the change of acceleration from frame to frame.
    unsure : ndarray, shape (P,)
        Standard error of the offsets of the tracked points, in paw widths.
    """

    geometry: Projection
    paw_width_px: FloatArray
    paw_width: float
    jerk: float
    unsure: FloatArray


def refine(
    start: FloatArray,
    observations: Observations,
    gap_closing: GapClosing,
    *,
    certain: FloatArray,
    measurement: MeasurementModel,
    cycle: Cycle | None = None,
    lateral_prior: LateralPrior | None = None,
    swings: Swings | None = None,
) -> SmoothedTracks:
    """Refine tracks.

    Parameters
    ----------
    start : ndarray, shape (n, P, d)
        Chosen places, NaN where occluded.
    observations : Observations
        What every view shows.
    gap_closing : GapClosing
        What was taken where paths are not certain.
    certain : ndarray, shape (n, P, V, 2)
        Image positions placed by hand, NaN elsewhere.
    measurement : MeasurementModel
        The rest.
    cycle : Cycle, optional
        Where points are expected.
    lateral_prior : LateralPrior, optional
        Where they usually are to the side.
    swings : Swings, optional
        Where they swing.

    Returns
    -------
    SmoothedTracks
        The tracks.
    """
    held = np.full_like(start, np.nan) if gap_closing.held is None else gap_closing.held
    standing, is_open = np.isfinite(held[..., 0]), gap_closing.is_open
    changes = _jerk_model(gap_closing, start.shape, measurement.jerk, swings)
    hold = np.where(standing, 1.0 / (SMOOTHING.refinement_hold * measurement.paw_width) ** 2, 0.0)
    expected = _Expected(held, hold[..., None], changes, cycle, lateral_prior, swings)
    x, factors = _through_places(start, held, gap_closing, measurement, changes)
    near = np.where(is_open & ~standing, SMOOTHING.near_open, SMOOTHING.refinement_near)
    against = SMOOTHING.refinement_against * gap_closing.negative_log_odds
    negative_log_odds = np.where(is_open[..., None, None], against, 0.0)
    by_hand = np.isfinite(certain[..., 0])
    taken = _taken(gap_closing, observations)
    for k in range(SMOOTHING.refinement_rounds):
        measured, detection_probability = _associate(
            x, near, negative_log_odds, observations, measurement
        )
        if k < SMOOTHING.refinement_bridged:
            measured[is_open], detection_probability[is_open] = (part[is_open] for part in taken)
        measured[by_hand], detection_probability[by_hand] = certain[by_hand], 1.0
        for step in range(SMOOTHING.refinement_steps):
            weight = _weights(x, measured, detection_probability, measurement, robust=k + step > 0)
            weight[by_hand] = np.broadcast_to(
                1.0 / (SMOOTHING.by_hand * measurement.paw_width_px + SMOOTHING.by_hand_px) ** 2,
                weight.shape,
            )[by_hand]
            W, z = _normal(x, measured, weight, measurement)
            expected.add(W, z, np.isfinite(measured[..., 0]))
            for p in range(start.shape[1]):
                x[:, p], factors[p] = changes.smooth(p, W[:, p], z[:, p])
    return _smoothed(x, factors, measured, detection_probability, (W, z, changes, measurement))


def _smoothed(
    x: FloatArray,
    factors: FloatArray,
    measured: FloatArray,
    detection_probability: FloatArray,
    solved: tuple[FloatArray, FloatArray, _JerkModel, MeasurementModel],
) -> SmoothedTracks:
    """Return tracks, with their standard deviations and what they ``solved``."""
    W, z, changes, measurement = solved
    covariance = covariances(factors, x.shape[-1], axes=changes.axes)
    sd = np.sqrt(diagonals(covariance)).swapaxes(0, 1)
    # what is alike from frame to frame does not average out
    alike = (SMOOTHING.alike**2 + measurement.unsure**2) * measurement.paw_width**2
    not_known = np.full(x.shape[:2], np.nan)
    return SmoothedTracks(
        x,
        np.sqrt(2.0 * sd**2 + alike[:, None]),
        measured,
        detection_probability,
        not_known,
        np.full(detection_probability.shape, np.nan),
        not_known.copy(),
        NormalEquations(
            W, z, changes.jerk2, changes.jerk_mean, changes.axes, covariance.swapaxes(0, 1)
        ),
    )


@dataclass(frozen=True)
class _Expected:
    """What draws points besides detections."""

    held: FloatArray  # (n, P, d), where they stand, NaN elsewhere
    hold: FloatArray  # (n, P, 1), information of that
    changes: _JerkModel
    cycle: Cycle | None
    lateral_prior: LateralPrior | None
    swings: Swings | None

    def add(self, W: FloatArray, z: FloatArray, is_measured: BoolArray) -> None:
        """Add it to information (n, P, d, d) and target (n, P, d) of measurements (n, P, V)."""
        W += self.hold[..., None] * np.eye(z.shape[-1])
        z += self.hold * np.nan_to_num(self.held)
        if self.lateral_prior is not None:
            self.lateral_prior.add(W, z, is_measured.sum(axis=-1))
        seen, cycle, swings = np.asarray(is_measured.any(axis=-1)), self.cycle, self.swings
        if cycle is not None:
            _pull(W, z, _expected(seen), to=cycle.mean, sd=cycle.sd, axes=cycle.axes)
        if swings is not None and self.changes.axes is not None:
            on_arc = np.where(_is_followed(seen), 0.0, SMOOTHING.refinement_pull)
            _pull(W, z, on_arc, to=swings.place, sd=swings.sd, axes=self.changes.axes)


def deviations(detection_probability: FloatArray, measurement: MeasurementModel) -> FloatArray:
    """Return standard deviations (n, V, C), px, of detections of a quality (n, V, C)."""
    share = SMOOTHING.refinement_sigma / np.clip(detection_probability, SMOOTHING.least_clear, 1.0)
    return np.asarray(share * measurement.paw_width_px[:, None])


@dataclass(frozen=True)
class _JerkModel:
    """How accelerations change from frame to frame.

    Parameters
    ----------
    jerk2, jerk_mean : ndarray, shape (n, P, d)
        Variance along each axis, and mean.
    axes : ndarray, shape (d, d), optional
        The axes.
    """

    jerk2: FloatArray
    jerk_mean: FloatArray
    axes: FloatArray | None

    def smooth(self, point: int, W: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the smoothed track of a point, and its factor."""
        return smooth(
            W, z, self.jerk2[:, point], jerk_mean=self.jerk_mean[:, point], axes=self.axes
        )


def _jerk_model(
    gap_closing: GapClosing, shape: tuple[int, ...], jerk: float, swings: Swings | None
) -> _JerkModel:
    """Return how accelerations change: as on the arcs, and at lift-off a paw goes up at once."""
    jerk2, substrate = np.full(shape, jerk**2), gap_closing.substrate
    if substrate is None:
        return _JerkModel(jerk2, np.zeros(shape), None)
    jerk_mean, near = expected_jerks(gap_closing.lift_offs, substrate.liftoff_velocity, shape[0])
    unsure = (SMOOTHING.unsure_lift * np.linalg.norm(substrate.liftoff_velocity, axis=-1)) ** 2
    jerk2[..., -1] += np.where(near, unsure, 0.0)
    if swings is not None:
        on_arc = np.isfinite(swings.jerk_mean[..., 0])
        jerk_mean = np.where(on_arc[..., None], swings.jerk_mean, jerk_mean)
        occluded = on_arc & gap_closing.is_open & np.isfinite(swings.place[..., 0]) & ~near
        jerk2[occluded] *= SMOOTHING.on_arc
    return _JerkModel(jerk2, jerk_mean, substrate.motion_model.axes)


def _through_places(
    start: FloatArray,
    held: FloatArray,
    gap_closing: GapClosing,
    measurement: MeasurementModel,
    changes: _JerkModel,
) -> tuple[FloatArray, FloatArray]:
    """Return the smoothest path through the certain places, and room for its factors."""
    n, n_points, d = start.shape
    places = np.where(gap_closing.is_open[..., None], held, start)
    information = 1.0 / (SMOOTHING.first_sd * measurement.paw_width) ** 2
    x = np.empty_like(start)
    factors = np.empty((n_points, n * d, 3 * d + 1))
    for p in range(n_points):
        seen = np.isfinite(places[:, p, 0])
        W = seen[:, None, None] * np.eye(d) * information
        x[:, p], factors[p] = changes.smooth(p, W, np.nan_to_num(places[:, p]) * information)
    return x, factors


def _taken(gap_closing: GapClosing, observations: Observations) -> tuple[FloatArray, FloatArray]:
    """Return positions (n, P, V, 2) and qualities (n, P, V) of the detections chosen."""
    n, n_points, n_views = gap_closing.choice.shape
    measured = np.full((n, n_points, n_views, 2), np.nan)
    detection_probability = np.zeros((n, n_points, n_views))
    t, p, v = np.nonzero(gap_closing.choice >= 0)
    number = gap_closing.choice[t, p, v]
    # the choice counts only the detections that are there, and those come first
    measured[t, p, v] = observations.at[t, p, v, number]
    detection_probability[t, p, v] = observations.detection_probability[t, v, number]
    return measured, detection_probability


def _associate(
    x: FloatArray,
    near: FloatArray,
    negative_log_odds: FloatArray,
    observations: Observations,
    measurement: MeasurementModel,
) -> tuple[FloatArray, FloatArray]:
    """Take for each point and view the detection where it must be."""
    uv = measurement.geometry.project(x)
    return loops.take_nearest(
        uv,
        near,
        observations.at,
        observations.detection_probability,
        observations.is_there,
        measurement.paw_width_px,
        negative_log_odds,
    )


def _weights(
    x: FloatArray,
    measured: FloatArray,
    detection_probability: FloatArray,
    measurement: MeasurementModel,
    *,
    robust: bool,
) -> FloatArray:
    """Return the weight (n, P, V), px^-2, of each measurement: less for doubtful ones."""
    base = SMOOTHING.refinement_sigma / np.clip(detection_probability, SMOOTHING.least_clear, 1.0)
    weight = 1.0 / (base * measurement.paw_width_px) ** 2
    away = (
        np.linalg.norm(measured - measurement.geometry.project(x), axis=-1)
        / measurement.paw_width_px
    )
    if robust:
        weight = weight * np.minimum(
            (SMOOTHING.refinement_tail + 1.0) / (SMOOTHING.refinement_tail + (away / base) ** 2),
            1.0,
        )
    return np.where(np.isfinite(away), weight, 0.0)


def _normal(
    x: FloatArray, measured: FloatArray, weight: FloatArray, measurement: MeasurementModel
) -> tuple[FloatArray, FloatArray]:
    """Return information (n, P, d, d) and target (n, P, d) of the measurements."""
    return loops.normal_equations(x, measured, weight, measurement.geometry.rows)


def _expected(seen: BoolArray) -> FloatArray:
    """Return what the cycle tells in each frame (n, P), given where points have detections."""
    before = np.logical_or.accumulate(seen, axis=0)
    between = before & _is_followed(seen)
    return np.where(seen, 0.0, np.where(between, SMOOTHING.pull_between, SMOOTHING.refinement_pull))


def _is_followed(seen: BoolArray) -> BoolArray:
    """Tell in which frames (n, P) points have detections there or later."""
    return np.asarray(np.logical_or.accumulate(seen[::-1], axis=0)[::-1])


def _pull(
    W: FloatArray,
    z: FloatArray,
    weight: FloatArray,
    *,
    to: FloatArray,
    sd: FloatArray,
    axes: FloatArray,
) -> None:
    """Draw occluded points weakly towards where they are expected, where that is known."""
    there = np.isfinite(to)
    information = weight[..., None] / np.where(there, sd, np.inf) ** 2
    extra = np.einsum("ki,npk,kj->npij", axes, information, axes, optimize=True)
    W += extra
    z += np.einsum("npij,npj->npi", extra, np.where(there, to, 0.0))
