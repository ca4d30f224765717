"""Places in space where a paw may be: detections of two views that meet."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, Float32Array, FloatArray, IntArray
from pawnb.core import dlt
from pawnb.core.paws.offline.association.network_flow import triangulation_kernels as loops
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.detection.colour.detections import (
    ColourDetections,
    InFrames,
    pad_and_stack,
)
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.sightlines import find_fundamental_matrix


@dataclass(frozen=True)
class Volume:
    """Where paws can be, as limits of coordinates along some directions.

    Parameters
    ----------
    up, across : ndarray, shape (3,)
        Unit vectors.
    height : tuple of float
        Lowest and highest coordinate along ``up``.
    width : tuple of float
        Lowest and highest coordinate along ``across``.
    """

    up: FloatArray
    across: FloatArray
    height: tuple[float, float]
    width: tuple[float, float]

    def holds(self, xyz: FloatArray) -> BoolArray:
        """Tell which points (n, 3) lie inside."""
        h, w = xyz @ self.up, xyz @ self.across
        return np.asarray(
            (h >= self.height[0]) & (h <= self.height[1])
            & (w >= self.width[0]) & (w <= self.width[1])
        )  # fmt: skip


@dataclass(frozen=True)
class PointHypotheses:
    """Hypotheses of one frame.

    Parameters
    ----------
    at : ndarray, shape (k, d)
        Positions.
    cost : ndarray, shape (k,)
        Cost of taking each for a paw; lower is better.
    """

    at: FloatArray
    cost: FloatArray

    def take(self, which: BoolArray) -> PointHypotheses:
        """Return some of the hypotheses."""
        return PointHypotheses(self.at[which], self.cost[which])

    def distance(self, points: FloatArray) -> FloatArray:
        """Return the distance (k,) of each from the nearest of some points (m, d)."""
        away = np.linalg.norm(self.at[:, None] - points[None], axis=-1)
        return np.asarray(away.min(axis=1, initial=np.inf))


class StereoMatcher:
    """Makes hypotheses of detections; holds what depends on the rig alone.

    Parameters
    ----------
    coefs : ndarray, shape (11, V)
        DLT coefficients.
    volume : Volume
        Where paws can be.
    tolerance_px : ndarray, shape (V,)
        Distance at which detections of two views still count as one point.
    likelihood : AppearanceLikelihood
        Tells how much detections look like paws.
    apart : float
        Hypotheses closer than this are one.
    most : int
        Hypotheses kept.
    """

    def __init__(
        self,
        coefs: FloatArray,
        volume: Volume,
        *,
        tolerance_px: FloatArray,
        likelihood: AppearanceLikelihood,
        apart: float,
        most: int,
    ) -> None:
        self.likelihood = likelihood
        self.coefs, self.volume, self.tolerance_px = coefs, volume, tolerance_px
        self.apart, self.most = apart, most
        matrices = [dlt.to_matrix(coefs[:, v]) for v in range(coefs.shape[1])]
        self.pairs = [
            (a, b, find_fundamental_matrix(matrices[a], matrices[b]))
            for a, b in itertools.combinations(range(len(matrices)), 2)
        ]

    def places(self, found: InFrames) -> list[PointHypotheses]:
        """Return the hypotheses of every frame from the detections of its views."""
        every: list[PointHypotheses] = []
        for first in range(0, len(found), NETWORK_FLOW.at_once):
            every += self._places_of(found[first : first + NETWORK_FLOW.at_once])
        return every

    def _places_of(self, found: InFrames) -> list[PointHypotheses]:
        """Return the hypotheses of some frames, all at once."""
        every, is_there = pad_and_stack(found)
        frame, xyz = self._meeting(every.uv, is_there)
        inside = self.volume.holds(xyz)
        frame, xyz = frame[inside], xyz[inside]
        support = self._seen(frame, xyz, every, is_there).sum(axis=1)
        # best first, frame by frame
        order = np.lexsort((-support, frame))
        frame, xyz, support = frame[order], xyz[order], support[order]
        first = np.searchsorted(frame, np.arange(len(found) + 1))
        cost = NETWORK_FLOW.unlike * np.maximum(0.0, 2.0 - support)
        keep = loops.distinct(xyz, first, self.apart, self.most)
        return [
            PointHypotheses(xyz[a:b][keep[a:b]], cost[a:b][keep[a:b]])
            for a, b in itertools.pairwise(first.tolist())
        ]

    def _meeting(self, uv: Float32Array, is_there: BoolArray) -> tuple[IntArray, FloatArray]:
        """Return frames (k,) and positions (k, 3) where rays of two views meet."""
        frames, positions = [np.empty(0, int)], [np.empty((0, 3))]
        point = np.concatenate([uv, np.ones_like(uv[..., :1])], axis=-1).astype(float)
        for a, b, F in self.pairs:
            pa, pb = point[:, a], point[:, b]
            line_b, line_a = pa @ F.T, pb @ F
            value = np.abs(line_b @ pb.transpose(0, 2, 1))
            away_b = value / np.hypot(line_b[..., 0], line_b[..., 1])[:, :, None]
            away_a = value / np.hypot(line_a[..., 0], line_a[..., 1])[:, None]
            meet = (away_b < self.tolerance_px[b]) & (away_a < self.tolerance_px[a])
            t, i, j = np.nonzero(meet & is_there[:, a, :, None] & is_there[:, b, None])
            both = np.stack([pa[t, i, :2], pb[t, j, :2]], axis=1)
            frames.append(t)
            positions.append(triangulate(self.coefs[:, [a, b]], both))
        return np.concatenate(frames), np.concatenate(positions)

    def seen(self, frame: IntArray, xyz: FloatArray, found: InFrames) -> FloatArray:
        """Return how much each view shows a paw at points, softly counted.

        Parameters
        ----------
        frame : ndarray of int, shape (k,)
            Frame of each point.
        xyz : ndarray, shape (k, 3)
            The points.
        found : sequence
            Detections of every frame and view.

        Returns
        -------
        ndarray, shape (k, V)
            From 0, nothing there, to 1.
        """
        return self._seen(frame, xyz, *pad_and_stack(found))

    def _seen(
        self, frame: IntArray, xyz: FloatArray, every: ColourDetections, is_there: BoolArray
    ) -> FloatArray:
        """Return the same for detections side by side."""
        good = np.stack(
            [
                self.likelihood.likeness(every.of_view(v), v).reshape(is_there[:, v].shape)
                for v in range(is_there.shape[1])
            ],
            axis=1,
        )
        at = np.ascontiguousarray(every.uv)
        uv = dlt.project(self.coefs, xyz)
        return loops.support(
            frame, uv, at, good, is_there, NETWORK_FLOW.support_reach * self.tolerance_px
        )


def triangulate(coefs: FloatArray, uv: FloatArray) -> FloatArray:
    """Triangulate (n, V, 2) by the normal equations: quick, for hypotheses only."""
    return loops.triangulate(np.ascontiguousarray(coefs.T), np.ascontiguousarray(uv))
