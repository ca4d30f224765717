r"""Another program's predictions as evidence, with log-odds calibrated in the recording itself.

A prediction is right with probability :math:`\pi` and then lies about the point with standard
deviation :math:`\sigma`; otherwise it lies anywhere in an area :math:`A` about the animal. The
point is therefore likelier at the place predicted than at any other by

.. math:: L = 1 + \frac{\pi}{1 - \pi} \, \frac{A}{2 \pi_0 \sigma^2}, \qquad \pi_0 = 3.14...

A program that is elsewhere stays there for :math:`D` frames on average (30 at most here), so that
neighbouring frames repeat each other: each counts for :math:`1 / D`, and the log-odds of a
Detection are :math:`\log(L^{1/D} - 1)` (:func:`.evidence.paint` adds the 1). :math:`\pi`
and :math:`D` are those of :mod:`.prediction_reliability`, :math:`A` is the square of the extent
(:func:`find_extent`), and

.. math:: \sigma^2 = \frac{2 \nu \sigma_0^2 + \sum_i w_i r_i^2}{2 \nu + 2 \sum_i w_i}

from distances :math:`r_i` between predictions and clicks, each with its probability
:math:`w_i` of being right, and :math:`\nu = 2` clicks' worth of :math:`\sigma_0` (0.03 extents).
It is at least 1 px and 0.01 extents. What has a likelihood below 0.02 carries nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.detection.parameters import PREDICTIONS
from pawnb.core.paws.offline.detection.prediction_reliability import (
    EXCHANGE,
    LIKELIHOOD_EDGES,
    RIGHT_STATE,
    STEP_EDGES,
    UNKNOWN_STATE,
    estimate_rates,
    first_rates,
    smooth_states,
)


@dataclass(frozen=True)
class Predictions:
    """What another program predicts in one view; n frames from the first that is tracked.

    Parameters
    ----------
    file : str
        The file's name.
    points : tuple of str
        Names of its points, as the trial calls them; P in all.
    uv : ndarray, shape (n, P, 2)
        Positions, px of the view; NaN where there is none.
    likelihood : ndarray, shape (n, P)
        The program's own, from 0 to 1.
    """

    file: str
    points: tuple[str, ...]
    uv: np.ndarray
    likelihood: np.ndarray

    def of(self, points: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
        """Return positions and likelihoods of points by number; NaN and 0 of other points."""
        n = len(self.uv)
        uv, likelihood = np.full((n, len(points), 2), np.nan), np.zeros((n, len(points)))
        for i, name in enumerate(points):
            if name in self.points:
                uv[:, i] = self.uv[:, self.points.index(name)]
                likelihood[:, i] = self.likelihood[:, self.points.index(name)]
        return uv, likelihood


@dataclass(frozen=True)
class PredictionQuality:
    """How good predictions are, as the recording and its clicks say.

    Parameters
    ----------
    right : ndarray, shape (n, P)
        Probability that a prediction is right; 0 where there is none.
    sd_px : float
        Standard deviation of those that are right, along each axis, px of the view.
    stays_wrong : float
        Mean number of frames for which the program stays wrong.
    extent_px : float
        Extent of the clicks, px of the view.
    """

    right: FloatArray
    sd_px: float
    stays_wrong: float
    extent_px: float


def predictions_as_detections(
    uv: FloatArray, likelihood: FloatArray, annotations: Annotations, *, size: tuple[int, int]
) -> Detections:
    """Return predictions with log-odds that mean what they say.

    Parameters
    ----------
    uv : ndarray, shape (n, P, 2)
        Positions, px of the view; NaN where there is none. n frames from row 0 of the
        annotations; P points by number.
    likelihood : ndarray, shape (n, P)
        The program's own, from 0 to 1.
    annotations : Annotations
        What was placed in the view by hand.
    size : (int, int)
        Width and height of the view, px.

    Returns
    -------
    Detections
        At most one for each point and row.
    """
    quality = judge_predictions(uv, likelihood, annotations, size=size)
    row, point = np.nonzero(quality.right > 0)
    right = np.minimum(quality.right[row, point], PREDICTIONS.sure)
    area = quality.extent_px**2 / (2 * np.pi * quality.sd_px**2)
    exponent = 1 / min(quality.stays_wrong, PREDICTIONS.longest_wrong)
    ratio = np.expm1(exponent * np.log1p(right / (1 - right) * area))
    return Detections(
        row=row,
        point=point,
        uv=uv[row, point],
        log_odds=np.log(np.maximum(ratio, 1e-12)),
        sd_px=np.full(len(row), quality.sd_px),
    )


def judge_predictions(
    uv: FloatArray, likelihood: FloatArray, annotations: Annotations, *, size: tuple[int, int]
) -> PredictionQuality:
    """Return how good predictions are; parameters as :func:`predictions_as_detections`.

    Parameters
    ----------
    uv : ndarray, shape (n, P, 2)
        Predicted positions, px.
    likelihood : ndarray, shape (n, P)
        What the program says of each.
    annotations : Annotations
        What is certain.
    size : tuple of int
        Width and height of the picture, px.

    Returns
    -------
    PredictionQuality
        How good they are.
    """
    there = np.isfinite(uv).all(axis=2) & (likelihood >= PREDICTIONS.least_likelihood)
    uv = np.where(there[..., None], uv, np.nan)
    extent = find_extent(uv, annotations, size)
    kinds = np.where(there, np.digitize(likelihood, LIKELIHOOD_EDGES), -1)
    steps = _kinds_of_steps(uv, extent)
    apart = distances_from_clicks(uv, annotations)
    sd, rates = PREDICTIONS.sd * extent, first_rates()
    for _ in range(PREDICTIONS.rounds):
        at_clicks = _at_clicks(uv, annotations, sd=sd, extent=extent)
        state, pairs = smooth_states(kinds, steps, at_clicks=at_clicks, rates=rates)
        sd = _estimate_sd(apart, state[..., RIGHT_STATE], extent)
        rates = estimate_rates(kinds, state, pairs)
    return PredictionQuality(
        np.where(there, state[..., RIGHT_STATE], 0.0), sd, rates.stays_wrong, extent
    )


def find_extent(uv: FloatArray, annotations: Annotations, size: tuple[int, int]) -> float:
    """Return the extent of the animal, px: of the clicks or, where that is larger, of predictions.

    Where few points are clicked in one frame they may just meet there. Parameters as for
    :func:`predictions_as_detections`.

    Parameters
    ----------
    uv : ndarray, shape (n, P, 2)
        Predicted positions, px.
    annotations : Annotations
        What is certain.
    size : tuple of int
        Width and height of the picture, px.

    Returns
    -------
    float
        The extent, px.
    """
    apart = np.linalg.norm(uv[:, :, None] - uv[:, None], axis=-1).reshape(len(uv), -1)
    largest = np.where(np.isnan(apart), 0.0, apart).max(axis=1, initial=0.0)
    predicted = float(np.median(largest[largest > 0])) if largest.any() else 0.0
    extent = float(np.nanmax([annotations.extent(), predicted]))
    return extent if extent > 0 else PREDICTIONS.unknown_extent * min(size)


def distances_from_clicks(uv: FloatArray, annotations: Annotations) -> FloatArray:
    """Return how far predictions are from clicks, px, shape (n, P); NaN where there is no click."""
    apart = np.full(uv.shape[:2], np.nan)
    for row, here in annotations.places.items():
        for point, clicked in here.items():
            if 0 <= row < len(uv):
                apart[row, point] = np.linalg.norm(uv[row, point] - clicked)
    return apart


def _kinds_of_steps(uv: FloatArray, extent: float) -> IntArray:
    """Tell how far predictions step from the ones before, beside what they mostly do."""
    n, n_points = uv.shape[:2]
    before, gap = _ones_before(uv)
    straight = np.linalg.norm(uv - before, axis=2)
    single = straight[gap == 1]
    mostly = (
        PREDICTIONS.mostly_times * np.percentile(single, PREDICTIONS.mostly) if len(single) else 0.0
    )
    mostly = np.clip(mostly, PREDICTIONS.least_step * extent, PREDICTIONS.most_step * extent)
    known = (gap > 0) & (gap <= PREDICTIONS.step_gap)
    kinds = np.full((n, n_points), UNKNOWN_STATE)
    kinds[known] = np.digitize(straight[known] / (mostly * gap[known]), STEP_EDGES)
    for a in range(n_points):
        for b in range(a):
            crossed = np.linalg.norm(uv[:, a] - before[:, b], axis=1)
            crossed += np.linalg.norm(uv[:, b] - before[:, a], axis=1)
            both = straight[:, a] + straight[:, b]
            exchanged = (crossed < PREDICTIONS.crossed * both) & (both > 2 * STEP_EDGES[0] * mostly)
            exchanged &= known[:, a] & known[:, b]
            kinds[exchanged, a] = kinds[exchanged, b] = EXCHANGE
    return kinds


def _ones_before(uv: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the last position before each frame, and how many frames ago; 0 where none is."""
    n = len(uv)
    there = np.isfinite(uv[..., 0])
    last = np.where(there, np.arange(n)[:, None], -1)
    last = np.concatenate([np.full((1, uv.shape[1]), -1), np.maximum.accumulate(last)[:-1]])
    before = np.take_along_axis(uv, np.maximum(last, 0)[..., None], axis=0)
    gap = np.where(there & (last >= 0), np.arange(n)[:, None] - last, 0)
    return before, gap


def _at_clicks(uv: FloatArray, annotations: Annotations, *, sd: float, extent: float) -> FloatArray:
    """Return how much likelier predictions at clicks are where they are right than where not.

    One that is not right is anywhere, or as near to another click of that frame as one that is
    right to its own.
    """
    ratio = np.ones(uv.shape[:2])
    height = extent**2 / (2 * np.pi * sd**2)
    for row, here in annotations.places.items():
        if not 0 <= row < len(uv):
            continue
        for point in here:
            density = {
                other: height * np.exp(-((uv[row, point] - at) ** 2).sum() / (2 * sd**2))
                for other, at in here.items()
            }
            own = density.pop(point)
            if np.isfinite(own):
                wrong = np.mean(list(density.values()) or [1.0])
                right = (1 - PREDICTIONS.misplaced) * own + PREDICTIONS.misplaced
                ratio[row, point] = right / (
                    (1 - PREDICTIONS.on_another) + PREDICTIONS.on_another * wrong
                )
    return ratio


def _estimate_sd(apart: FloatArray, right: FloatArray, extent: float) -> float:
    """Return the standard deviation of predictions that are right, px."""
    clicked = np.isfinite(apart)
    weight = right[clicked]
    total = (
        2 * PREDICTIONS.sd_clicks * (PREDICTIONS.sd * extent) ** 2
        + (weight * apart[clicked] ** 2).sum()
    )
    sd = np.sqrt(total / (2 * PREDICTIONS.sd_clicks + 2 * weight.sum()))
    return float(max(sd, PREDICTIONS.sd_least * extent, PREDICTIONS.sd_least_px))
