"""How thick and how dark the animal is, learnt from frames whose pose is known: compiled loops."""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_loosely
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.paint_kernels import NARROWEST, egg_shape, part_dark, slope, step


@compiled_loosely
def look_equations(
    layout: PoseLayout, blur: float, box: np.ndarray, value: np.ndarray, owner: np.ndarray,
    along: np.ndarray, joints: np.ndarray, seen: np.ndarray, weight: np.ndarray, soft: float,
    matrix: np.ndarray, vector: np.ndarray,
) -> None:  # fmt: skip
    """Add the equations of every leg's thickness and darkness for one painted frame.

    Parameters
    ----------
    layout, blur, box, value, owner, along, joints, seen, weight, soft
        The painted animal and the picture, as in :mod:`.paint_kernels`.
    matrix, vector : ndarray, shape (legs, 2 nodes, 2 nodes) and (legs, 2 nodes)
        Of each leg: the logarithms of the radius at the ends of segments, then the darknesses.
    """
    nodes = layout.radius.shape[1]
    which, row = np.zeros(4, np.int64), np.zeros(4)
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            piece = owner[v, u]
            if piece < 0:
                continue
            leg, s, t = piece // 64, piece % 64, along[v, u]
            au, av = joints[leg, s, 0], joints[leg, s, 1]
            eu = u + box[0] - au - t * (joints[leg, s + 1, 0] - au)
            ev = v + box[1] - av - t * (joints[leg, s + 1, 1] - av)
            distance = math.sqrt(eu * eu + ev * ev)
            end = 1.0
            if s == layout.n_segments[leg] - 1:
                length = math.hypot(joints[leg, s + 1, 0] - au, joints[leg, s + 1, 1] - av)
                end = step((1.0 - t) * length / blur)
                t = min(t, 1.0)
            r0, r1 = layout.radius[leg, s], layout.radius[leg, s + 1]
            dark = layout.dark[leg, s] + (layout.dark[leg, s + 1] - layout.dark[leg, s]) * t
            radius = r0 + (r1 - r0) * t
            inner, outer = (radius - distance) / blur, (-radius - distance) / blur
            thicker = end * dark * (slope(inner) + slope(outer)) / blur
            cover = end * (step(inner) - step(outer))
            which[0], which[1], which[2], which[3] = s, s + 1, nodes + s, nodes + s + 1
            row[0], row[1] = thicker * (1 - t) * r0, thicker * t * r1
            row[2], row[3] = cover * (1 - t), cover * t
            error = value[v, u] - seen[v, u]
            w = weight[v, u] / (1.0 + error * error / (soft * soft)) ** 2
            for i in range(4):
                vector[leg, which[i]] += w * row[i] * error
                for j in range(4):
                    matrix[leg, which[i], which[j]] += w * row[i] * row[j]


@compiled_loosely
def body_equations(
    layout: PoseLayout, meets: np.ndarray, pose: np.ndarray, blur: float, box: np.ndarray,
    value: np.ndarray, owner: np.ndarray, seen: np.ndarray, weight: np.ndarray, soft: float,
    matrix: np.ndarray, vector: np.ndarray,
) -> None:  # fmt: skip
    """Add the equations of the body's parts and its place.

    Of each part: log length, log width, darkness, egg, by how much its middle is darker than its
    rim, overlap; then x, y, heading of the pose.

    A part that grows in length keeps its place relative to the origin: its middle moves too. The
    overlap is by how much the parts that meet at the origin (``meets``, see
    :func:`.layout.meeting`) reach beyond it. ``matrix`` and ``vector`` are (parts, 9, 9) and
    (parts, 9).
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    row = np.zeros(9)
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            part = -2 - owner[v, u]
            if part < 0:
                continue
            forward, right, half, across, dark, egg, middle = layout.ellipse[part]
            du, dv = u + box[0] - pose[0], v + box[1] - pose[1]
            x, y = du * cos + dv * sin, -du * sin + dv * cos
            outside, na, nb = egg_shape(x - forward, y - right, half, across, egg)
            here, edge, deep = part_dark(min(outside, blur), dark, middle, blur)
            a = (x - forward) / half
            row[0] = edge * na * x
            row[1] = edge * nb * (y - right)
            row[2] = (here - (middle - dark) * deep) / dark
            row[3] = edge * nb * (y - right) * a / max(1.0 + egg * a, NARROWEST)
            row[4] = deep
            row[5] = -meets[part] * edge * na
            row[6], row[7] = edge * (na * cos - nb * sin), edge * (na * sin + nb * cos)
            row[8] = row[7] * du - row[6] * dv
            error = value[v, u] - seen[v, u]
            w = weight[v, u] / (1.0 + error * error / (soft * soft)) ** 2
            for i in range(9):
                vector[part, i] += w * row[i] * error
                for j in range(9):
                    matrix[part, i, j] += w * row[i] * row[j]
