"""Places of legs, along them and across, and what is seen there: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_inside, compiled_loosely


@compiled_inside
def cell_of(
    joints: np.ndarray, piece: int, t: float, at: tuple[float, float], cells: tuple[int, int, int]
) -> tuple[int, int, int, int]:
    """Return leg, segment, and the cell along it and across it that a place lies in.

    ``piece`` and ``t`` are as in :mod:`.paint_kernels`, ``at`` is u and v, ``cells`` how many there
    are along a segment and across, an odd number whose middle lies on the axis, and how many of
    those lie in a pixel.
    """
    leg, s = piece // 64, piece % 64
    u0, v0 = joints[leg, s, 0], joints[leg, s, 1]
    du, dv = joints[leg, s + 1, 0] - u0, joints[leg, s + 1, 1] - v0
    aside_px = (du * (at[1] - v0) - dv * (at[0] - u0)) / max(math.hypot(du, dv), 1e-6)
    row = min(int(t * cells[0]), cells[0] - 1)
    column = round(cells[2] * aside_px) + cells[1] // 2
    return leg, s, row, min(max(column, 0), cells[1] - 1)


@compiled_loosely
def add_differences(
    painted: tuple[np.ndarray, ...],
    seen: np.ndarray,
    box: np.ndarray,
    in_px: int,
    total: np.ndarray,
    count: np.ndarray,
) -> None:
    """Add what is seen less what is painted to the cells of all legs, and how many pixels.

    ``painted`` is the canvas of :func:`.paint_kernels.make_canvas`, ``in_px`` how many cells across
    lie in a pixel, ``total`` and ``count`` are (legs, segments, along, across).
    """
    value, owner, along, joints = painted
    cells = (total.shape[2], total.shape[3], in_px)
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            if owner[v, u] >= 0:
                at = (u + box[0], v + box[1])
                cell = cell_of(joints, owner[v, u], along[v, u], at, cells)
                total[cell] += seen[v, u] - value[v, u]
                count[cell] += 1.0


@compiled_loosely
def disregard_cells(
    painted: tuple[np.ndarray, ...],
    box: np.ndarray,
    leg_clutter: np.ndarray,
    in_px: int,
    weight: np.ndarray,
) -> None:
    """Take the weight of pixels of legs in cells that are ``leg_clutter``.

    ``in_px`` of these lie in a pixel, across the leg.
    """
    _, owner, along, joints = painted
    cells = (leg_clutter.shape[2], leg_clutter.shape[3], in_px)
    for v in range(owner.shape[0]):
        for u in range(owner.shape[1]):
            if owner[v, u] >= 0:
                at = (u + box[0], v + box[1])
                if leg_clutter[cell_of(joints, owner[v, u], along[v, u], at, cells)]:
                    weight[v, u] = 0.0
