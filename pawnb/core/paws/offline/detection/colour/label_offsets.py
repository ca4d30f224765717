"""Where the tracked points lie relative to detections: what the clicks say about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections, InViews
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR

_NEVER = -1e6
"""Guard: score of what is never taken."""


@dataclass(frozen=True)
class Offsets:
    """Where the tracked points lie relative to detections, in paw widths.

    Parameters
    ----------
    along, across : ndarray, shape (P,)
        Along the direction in which the limb ends, and to the right of it (down in a view
        in which the animal faces right).
    unsure : ndarray, shape (P,)
        Standard error of both, from how well the clicks agree.
    """

    along: FloatArray
    across: FloatArray
    unsure: FloatArray

    def apply(
        self, found: ColourDetections, point: int, *, paw_width_px: float, facing: int
    ) -> FloatArray:
        """Return the tracked point's position (n, 2) for detections of one view.

        Parameters
        ----------
        found : ColourDetections
            Detections of one view.
        point : int
            Number of the point.
        paw_width_px : float
            Thickness of a paw in that view, px.
        facing : int
            +1 or -1: the way the animal faces.

        Returns
        -------
        ndarray, shape (n, 2)
            Positions, px.
        """
        e = found.direction.astype(float)
        e /= np.maximum(np.hypot(e[:, 0], e[:, 1]), 1e-6)[:, None]
        side = np.column_stack([-e[:, 1], e[:, 0]]) * facing
        shift = self.along[point] * e + self.across[point] * side
        return found.uv + paw_width_px * shift


def learn_offsets(
    clicks: FloatArray,
    found: Mapping[int, InViews],
    *,
    paw_width_px: FloatArray,
    facing: Sequence[int],
    limb_direction: Sequence[tuple[float, float]],
    kinds: Sequence[str],
) -> Offsets:
    """Learn the offsets from the clicked frames.

    People click paws at their ends or, more often, in their middle; paths go through ends. So
    the detection of a click is the one that looks most like an end, not the nearest, which
    may be the heel. Clicks where only something else is near say nothing if others say more.

    Parameters
    ----------
    clicks : ndarray, shape (frames, P, V, 2)
        Clicks, NaN where there is none, in the order of ``found``.
    found : mapping
        Clicked frame to the detections of every view.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.
    facing : sequence of int
        +1 or -1 for each view.
    limb_direction : sequence of (float, float)
        See :class:`~pawnb.core.paws.offline.detection.colour.detector.DetectorConfig`.
    kinds : sequence of str
        Kind of each point; points of one kind share their offsets.

    Returns
    -------
    Offsets
        Offsets; of a point without a detection near its clicks, the mean of the others.
    """
    n_points = clicks.shape[1]
    seen: list[list[tuple[float, float, float]]] = [[] for _ in range(n_points)]
    for click, by_view in zip(clicks, found.values(), strict=True):
        for v, here in enumerate(by_view):
            clicked = np.flatnonzero(np.isfinite(click[:, v, 0]))
            if not len(here) or not len(clicked):
                continue
            step = (click[clicked, v, None] - here.uv) / paw_width_px[v]
            e = here.direction
            e = e / np.maximum(np.hypot(e[:, 0], e[:, 1]), 1e-6)[:, None]
            along = (step * e).sum(axis=-1)
            across = (step[..., 1] * e[:, 0] - step[..., 0] * e[:, 1]) * (facing[v] or 1)
            good = endpoint_score(here, limb_direction[v])
            away = np.hypot(step[..., 0], step[..., 1])
            score = good - COLOUR.label_offsets_far * (
                away + COLOUR.label_offsets_beside * np.abs(across)
            )
            score[away > COLOUR.label_offsets_reach] = _NEVER
            # each its own: where paws meet, the better end is near both
            for k, i in zip(*linear_sum_assignment(score, maximize=True), strict=True):
                if score[k, i] > _NEVER:
                    at = (float(along[k, i]), float(across[k, i]), float(good[i]))
                    seen[clicked[k]].append(at)
    every = [s for own in seen for s in own] or [(0.0, 0.0, 1.0)]
    alike = [
        [s for other, own in zip(kinds, seen, strict=True) if other == kind for s in own]
        for kind in kinds
    ]
    means = np.array([_usual(np.array(own or every)) for own in alike])
    unsure = np.array([_standard_error(np.array(own or every)) for own in alike])
    return Offsets(means[:, 0], means[:, 1], unsure)


def _usual(rows: FloatArray) -> FloatArray:
    """Return the median of each column but the last, which says how good each row is."""
    return np.asarray(np.median(_good(rows), axis=0))


def _good(rows: FloatArray) -> FloatArray:
    """Return the rows that look well enough, without the column that says so."""
    return rows[rows[:, -1] >= COLOUR.label_offsets_worse * rows[:, -1].max(), :-1]


def _standard_error(rows: FloatArray) -> float:
    """Return the standard error of :func:`_usual`, that of both columns together."""
    good = _good(rows)
    square = max(float(good.var(axis=0).mean()), COLOUR.label_offsets_click**2)
    # few clicks tell their spread too small
    return float(np.sqrt(square / len(good) * (1.0 + 1.0 / len(good))))
