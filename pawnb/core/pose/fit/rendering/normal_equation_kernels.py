"""Gauss-Newton equations of a painted pose, summed over pixels: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_inside, compiled_loosely
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.paint_kernels import (
    NOTHING,
    body_slope,
    leg_pull,
    leg_slope,
    misfit,
)


@compiled_loosely
def add_segment(
    layout: PoseLayout, pose: np.ndarray, joints: np.ndarray, leg: int, s: int, moments: np.ndarray,
    rows: np.ndarray, which: np.ndarray, matrix: np.ndarray, vector: np.ndarray,
) -> None:  # fmt: skip
    """Add the Gauss-Newton matrix and gradient of all pixels of a segment.

    A pixel's row (:func:`leg_slope`) is linear in four numbers: its pulls ``gu`` and ``gv``, and
    the moments ``gv a - gu b`` and ``gu a + gv b`` of the pull at (a, b) from the segment's first
    joint. ``moments`` (14,) has the weighted sums over pixels of products of these (lower
    triangle, row by row), then of each times the error. ``rows`` (5, 64) and ``which`` (64,) are
    room to work in.
    """
    n, pull = 0, rows[4]
    for moment in range(2):
        for axis in range(2):
            pull[0], pull[1] = 1.0 - axis, float(axis)
            pull[2], pull[3] = joints[s, 0] + moment, joints[s, 1]
            # a pull along v at (1, 0) has only the first moment, one along u only the second
            to = axis if moment == 0 else 3 - axis
            n = leg_slope(layout, pose, joints, leg, s, pull, rows[to], which)
    for i in range(n):
        rows[3, i] -= rows[0, i]
        rows[2, i] -= rows[1, i]
    m = moments
    for i in range(n):
        a, b, c, d = rows[0, i], rows[1, i], rows[2, i], rows[3, i]
        vector[which[i]] += a * m[10] + b * m[11] + c * m[12] + d * m[13]
        along_a = a * m[0] + b * m[1] + c * m[3] + d * m[6]
        along_b = a * m[1] + b * m[2] + c * m[4] + d * m[7]
        along_c = a * m[3] + b * m[4] + c * m[5] + d * m[8]
        along_d = a * m[6] + b * m[7] + c * m[8] + d * m[9]
        for j in range(i + 1):
            matrix[which[i], which[j]] += (
                along_a * rows[0, j] + along_b * rows[1, j]
                + along_c * rows[2, j] + along_d * rows[3, j]
            )  # fmt: skip


@compiled_loosely
def add_segments(
    layout: PoseLayout, pose: np.ndarray, joints: np.ndarray, moments: np.ndarray,
    matrix: np.ndarray, vector: np.ndarray,
) -> None:  # fmt: skip
    """Add the equations of all segments that show; ``moments`` (legs, segments, 14)."""
    rows, which = np.zeros((5, 64)), np.zeros(64, np.int64)
    for leg in range(moments.shape[0]):
        for s in range(layout.n_segments[leg]):
            if moments[leg, s, 0] + moments[leg, s, 2] > 0.0:
                add_segment(
                    layout, pose, joints[leg], leg, s, moments[leg, s], rows, which, matrix, vector
                )


@compiled_loosely
def normal_equations(
    layout: PoseLayout, pose: np.ndarray, blur: float, box: np.ndarray, value: np.ndarray,
    owner: np.ndarray, along: np.ndarray, joints: np.ndarray, seen: np.ndarray,
    weight: np.ndarray, soft: float, moves: np.ndarray, matrix: np.ndarray, vector: np.ndarray,
) -> float:  # fmt: skip
    """Add the Gauss-Newton matrix and gradient of the cost; return the cost.

    Robust errors are weighted as in iteratively reweighted least squares. Of legs, and last the
    body, that do not move (``moves``, shape (legs + 1,)), only the cost counts.
    """
    row, pull, four = np.zeros(3), np.zeros(4), np.zeros(4)
    legs, most = layout.length.shape
    moments = np.zeros((legs, most, 14))
    last, chain, sums = NOTHING, joints[0], moments[0, 0]
    cos, sin, soft_2 = math.cos(pose[2]), math.sin(pose[2]), 1.0 / (soft * soft)
    total = 0.0
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            piece = owner[v, u]
            if piece == NOTHING:
                continue
            error = value[v, u] - seen[v, u]
            w = weight[v, u]
            heed = 1.0 / (1.0 + error * error * soft_2)
            total += w * (0.5 * error * error * heed - misfit(seen[v, u], soft))
            w *= heed * heed
            pu, pv = u + box[0], v + box[1]
            if not moves[-1 if piece < 0 else piece // 64]:
                continue
            if piece < 0:
                if body_slope(layout, pose, -2 - piece, blur, pu, pv, cos, sin, row):
                    for i in range(3):
                        vector[i] += w * row[i] * error
                        for j in range(i + 1):
                            matrix[i, j] += w * row[i] * row[j]
                continue
            leg, s = piece // 64, piece % 64
            if piece != last:
                last, chain, sums = piece, joints[leg], moments[leg, s]
            if leg_pull(layout, chain, leg, s, along[v, u], blur, pu, pv, pull):
                a, b = pull[2] - chain[s, 0], pull[3] - chain[s, 1]
                four[0], four[1] = pull[0], pull[1]
                four[2], four[3] = pull[1] * a - pull[0] * b, pull[0] * a + pull[1] * b
                add_moments(four, w, error, sums)
    add_segments(layout, pose, joints, moments, matrix, vector)
    return total


@compiled_inside
def add_moments(four: np.ndarray, w: float, error: float, moments: np.ndarray) -> None:
    """Add a pixel to the ``moments`` of its segment, see :func:`add_segment`."""
    a, b, c, d = four[0], four[1], four[2], four[3]
    wa, wb, wc, wd = w * a, w * b, w * c, w * d
    moments[0] += wa * a
    moments[1] += wb * a
    moments[2] += wb * b
    moments[3] += wc * a
    moments[4] += wc * b
    moments[5] += wc * c
    moments[6] += wd * a
    moments[7] += wd * b
    moments[8] += wd * c
    moments[9] += wd * d
    moments[10] += wa * error
    moments[11] += wb * error
    moments[12] += wc * error
    moments[13] += wd * error
