"""Tracks that leave a click at once: what lies beyond it is another place than what was clicked."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.quality.labels import Labels, Measure, QualityLimits, in_views
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.schema import ORIGIN_CODE


def departs_from_clicks(labels: Labels, limits: QualityLimits) -> Measure:
    """Measure which labels follow a jump from a click to the frame beside it.

    A click is certain. A track that is, one frame from it, further away than errors of both and
    the point's own largest usual step together, was brought there by something else, and
    all its labels up to the next click on that side with it.

    Parameters
    ----------
    labels : Labels
        Of the tracks; without clicks nothing is measured.
    limits : QualityLimits
        How far from the truth labels may be.

    Returns
    -------
    Measure
        What is left of the probability of each label.
    """
    n, _, n_points = labels.origin.shape
    departs = np.zeros((n, n_points), dtype=bool)
    placed = (labels.origin == ORIGIN_CODE["edited"]).any(axis=1)
    clicked = np.asarray(labels.clicked & placed)  # corrections need not have been followed
    for p in range(n_points):
        rows = np.flatnonzero(clicked[:, p])
        far = _departures(labels, limits, p, clicked[:, p])
        for i, row in enumerate(rows.tolist()):
            before = rows[i - 1] + 1 if i else 0
            after = rows[i + 1] if i + 1 < len(rows) else n
            if row and far[row - 1]:
                departs[before:row, p] = True
            if row + 1 < n and far[row]:
                departs[row + 1 : after, p] = True
    left = np.where(departs, QUALITY.departed_left, 1.0)
    return Measure("{point} does not go on from where it was clicked", in_views(left, labels))


def _departures(labels: Labels, limits: QualityLimits, p: int, clicked: BoolArray) -> BoolArray:
    """Return for each pair of neighbouring frames (n - 1,) whether a jump lies between them."""
    steps = np.linalg.norm(np.diff(labels.uv[:, :, p], axis=0), axis=-1) / labels.body_px
    at_click = clicked[1:] | clicked[:-1]
    return np.asarray(
        _median(np.where(at_click[:, None], steps, np.nan))
        > max(2.0 * limits.right + _usual_most(steps[~at_click]), QUALITY.departs * limits.leap)
    )


def _median(steps: FloatArray) -> FloatArray:
    """Return the median over views (n, V); NaN, which is no jump, where no view has one."""
    median = np.full(len(steps), np.nan)
    some = np.isfinite(steps).any(axis=1)
    median[some] = np.nanmedian(steps[some], axis=1)
    return median


def _usual_most(steps: FloatArray) -> float:
    """Return how far a point moves in a frame in which it moves much, away from clicks."""
    known = steps[np.isfinite(steps)]
    return float(np.quantile(known, QUALITY.usual_most)) if len(known) else 0.0
