"""From the uncertainty of the pose vector to that of places in the picture: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_loosely
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import NOTHING, leg_chain, leg_slope


@compiled_loosely
def place_sds(
    layout: PoseLayout, pose: np.ndarray, covariance: np.ndarray, joints: np.ndarray,
    out: np.ndarray,
) -> None:  # fmt: skip
    """Write the standard deviations of joints and tips, (legs, segments + 1, 2), px.

    ``joints`` of the same shape is room to work in. NaN stays beyond the tip of a short leg.
    """
    row, which, pull = np.zeros(64), np.zeros(64, np.int64), np.zeros(4)
    for leg in range(layout.side.shape[0]):
        leg_chain(layout, pose, leg, joints[leg])
        for place in range(layout.n_segments[leg] + 1):
            for axis in range(2):
                pull[0], pull[1] = 1.0 - axis, float(axis)
                pull[2], pull[3] = joints[leg, place, 0], joints[leg, place, 1]
                if place:
                    n = leg_slope(layout, pose, joints[leg], leg, place - 1, pull, row, which)
                else:
                    row[0], row[1] = pull[0], pull[1]
                    row[2] = -pull[0] * (pull[3] - pose[1]) + pull[1] * (pull[2] - pose[0])
                    which[0], which[1], which[2] = 0, 1, 2
                    n = 3
                total = 0.0
                for i in range(n):
                    for j in range(n):
                        total += row[i] * row[j] * covariance[which[i], which[j]]
                out[leg, place, axis] = math.sqrt(max(total, 0.0))


@compiled_loosely
def error_ratio(
    value: np.ndarray, owner: np.ndarray, image_evidence: ImageEvidence, soft: float
) -> float:
    """Return the robust mean square of weighted errors where the animal is painted."""
    total, n = 0.0, 0
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            if owner[v, u] != NOTHING:
                error = value[v, u] - image_evidence.seen[v, u]
                total += image_evidence.weight[v, u] * error * error / (1.0 + (error / soft) ** 2)
                n += 1
    return total / max(n, 1)
