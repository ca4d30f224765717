"""What of a paw's limb is taken for a paw: where detections lie about a tracked paw.

A wrist, a heel or the edge of a sleeve of fur makes detections too, always at about the same
place from its own paw. Where a paw meets another, they are what the other is mistaken for.
How often they are where is learnt from the recording itself, for each point in each view,
and so is how often other paws are as near: their ratio says whose a detection is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING


@dataclass(frozen=True)
class LimbClutter:
    """What speaks for detections being part of a point's limb.

    Parameters
    ----------
    cost : ndarray, shape (P, V, bins, bins)
        What speaks against a detection being another paw, a logarithm of odds, by how far
        (row) it lies below the point and (column) to the right of it.
    """

    cost: FloatArray

    def negative_log_odds(
        self, uv: FloatArray, observations: Observations, point: int, *, paw_width_px: FloatArray
    ) -> FloatArray:
        """Return what the limb of a point says against every detection being another's.

        Parameters
        ----------
        uv : ndarray, shape (n, V, 2)
            Where the point is, px.
        observations : Observations
            What every view shows.
        point : int
            Its number.
        paw_width_px : ndarray, shape (V,)
            Width of a paw in each view.

        Returns
        -------
        ndarray, shape (n, V, C)
            The cost.
        """
        row, column, inside = _bins(uv, observations.at[:, point], paw_width_px)
        view = np.arange(len(paw_width_px))[:, None]
        grade = np.digitize(observations.detection_probability, GAP_CLOSING.limb_clutter_grades)
        return np.where(inside, self.cost[point][view, grade, row, column], 0.0)


def learn_limb_clutter(
    uv: FloatArray, trust: FloatArray, observations: Observations, *, paw_width_px: FloatArray
) -> LimbClutter:
    """Learn where detections lie about each point that are no point's.

    Parameters
    ----------
    uv : ndarray, shape (n, P, V, 2)
        Where the points are thought to be, px.
    trust : ndarray, shape (n, P)
        How much that is to be believed, 0 to 1; 0 where nothing is known.
    observations : Observations
        What every view shows.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.

    Returns
    -------
    LimbClutter
        What was learnt.
    """
    n_points, n_views = uv.shape[1:3]
    n_grades = len(GAP_CLOSING.limb_clutter_grades) + 1
    bins = _bins_across()
    count = np.zeros((n_points, n_views, n_grades * bins**2))
    # sightings of each point, those with all others elsewhere, and other points near them
    observed, apart, met = (np.zeros((n_points, n_views, 1, 1, 1)) for _ in range(3))
    grade = np.digitize(observations.detection_probability, GAP_CLOSING.limb_clutter_grades)
    for p in range(n_points):
        row, column, inside = _bins(uv[:, p], observations.at[:, p], paw_width_px)
        step = (observations.at[:, p] - uv[:, p, :, None]) / paw_width_px[:, None, None]
        near = (
            np.hypot(step[..., 0], step[..., 1]) < GAP_CLOSING.limb_clutter_at
        ) & observations.is_there
        # a point tells where it is seen and where every other is known to be elsewhere
        seen = trust[:, p, None] * near.any(axis=-1)
        others = np.delete(uv, p, axis=1) - uv[:, p, None]
        away = np.abs(others / paw_width_px[:, None]).max(axis=-1)
        alone = seen * np.delete(trust, p, axis=1).min(axis=1, initial=1.0)[:, None]
        alone = alone * (away > GAP_CLOSING.limb_clutter_reach + 1.0).all(axis=1)
        observed[p, :, 0, 0, 0], apart[p, :, 0, 0, 0] = seen.sum(axis=0), alone.sum(axis=0)
        met[p, :, 0, 0, 0] = (seen[:, None] * (away < GAP_CLOSING.limb_clutter_reach)).sum(
            axis=(0, 1)
        )
        for v in range(n_views):
            limb = inside[:, v] & observations.is_there[:, v] & ~near[:, v]
            number = (grade[:, v][limb] * bins + row[:, v][limb]) * bins + column[:, v][limb]
            weight = np.broadcast_to(alone[:, v, None], limb.shape)[limb]
            count[p, v] = np.bincount(number, weight, n_grades * bins**2)
    count = count.reshape(n_points, n_views, n_grades, bins, bins)
    smooth = gaussian_filter(
        count,
        (0, 0, 0, GAP_CLOSING.limb_clutter_smooth, GAP_CLOSING.limb_clutter_smooth),
        mode="constant",
    )
    rate = smooth / (apart + GAP_CLOSING.limb_clutter_before)
    # what is as common everywhere is no limb
    usual = np.median(rate, axis=(3, 4), keepdims=True)
    # other paws come from everywhere: one is assumed to have come beforehand
    other = (met + 1.0) / (observed + GAP_CLOSING.limb_clutter_before) / bins**2
    return LimbClutter(np.log1p(np.maximum(rate - usual, 0.0) / (usual + other)))


def _bins_across() -> int:
    """Return how many bins there are along each axis."""
    return round(2 * GAP_CLOSING.limb_clutter_reach / GAP_CLOSING.limb_clutter_bin)


def _bins(
    uv: np.ndarray, at: np.ndarray, paw_width_px: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return row and column of detections (n, V, C) about a point, and whether they are near."""
    step = (at - uv[:, :, None]) / paw_width_px[:, None, None]
    number = np.floor((step + GAP_CLOSING.limb_clutter_reach) / GAP_CLOSING.limb_clutter_bin)
    inside = ((number >= 0) & (number < _bins_across())).all(axis=-1)
    number = np.where(inside[..., None], number, 0.0).astype(int)
    return number[..., 1], number[..., 0], inside
