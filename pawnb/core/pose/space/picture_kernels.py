"""The animal in space painted on the second view, and how that picture changes: compiled loops.

The unknowns of a frame are a vector: the body's height, then x, y, z of every joint of every leg,
body-coxa joint to tip.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.rendering.paint_kernels import (
    NOTHING,
    clear,
    leg_pull,
    misfit,
    paint_leg,
    slope,
    step,
)


class Known(NamedTuple):
    """What is known of a frame but for its second picture.

    Attributes
    ----------
    axis, about : ndarray, shape (3,)
        Direction and origin of heights.
    top : ndarray, shape (11,)
        DLT coefficients of the first view.
    seen : ndarray, shape (legs, joints, 2)
        Places in the first view, px.
    weight : ndarray, shape (legs, joints, 3)
        Precisions there, per px squared: of uu, uv and vv.
    length, length_sd : ndarray, shape (legs, segments)
        Lengths in space.
    bend_sd : float
        Change of direction between segments, radians.
    root_sd : float
        How far the body-coxa joints are from the body's height.
    expected, expected_sd : ndarray, shape (1 + legs * joints,), float
        Heights expected from other frames, the body's first; NaN where unknown.
    ground, ground_sd : float
        Height of the ground, NaN where it is not known, and how near to it a foot stands.
    lifted : float
        Standard deviations above it from which a foot counts as lifted.
    """

    axis: np.ndarray
    about: np.ndarray
    top: np.ndarray
    seen: np.ndarray
    weight: np.ndarray
    length: np.ndarray
    length_sd: np.ndarray
    bend_sd: float
    root_sd: float
    expected: np.ndarray
    expected_sd: float
    ground: float
    ground_sd: float
    lifted: float


@compiled
def project_point(coefs: np.ndarray, x: float, y: float, z: float) -> tuple[float, float]:
    """Return u and v of a point in one view."""
    w = coefs[8] * x + coefs[9] * y + coefs[10] * z + 1.0
    u = (coefs[0] * x + coefs[1] * y + coefs[2] * z + coefs[3]) / w
    v = (coefs[4] * x + coefs[5] * y + coefs[6] * z + coefs[7]) / w
    return u, v


@compiled
def ground_cost(above: float, foot: bool, lifted: float) -> float:
    """Return the cost of a place ``above`` the ground in standard deviations.

    Nothing is below it; a foot stands on it or is lifted.
    """
    square = above * above
    if above < 0.0:
        return 0.5 * square
    return 0.5 * square / (1.0 + square / lifted**2) if foot else 0.0


@compiled
def project_slope(coefs: np.ndarray, xyz: np.ndarray, out: np.ndarray) -> tuple[float, float]:
    """Write how u and v change with a point into ``out`` (2, 3); return u and v."""
    u, v = project_point(coefs, xyz[0], xyz[1], xyz[2])
    w = coefs[8] * xyz[0] + coefs[9] * xyz[1] + coefs[10] * xyz[2] + 1.0
    for c in range(3):
        out[0, c] = (coefs[c] - u * coefs[8 + c]) / w
        out[1, c] = (coefs[4 + c] - v * coefs[8 + c]) / w
    return u, v


@compiled
def _outside(du: float, dv: float, shape: np.ndarray) -> tuple[float, float, float]:
    """Return how far outside an ellipse a place is, px, and the normal there (first order).

    ``shape`` holds uu, uv, vv of the inverse of the ellipse's matrix.
    """
    gu, gv = shape[0] * du + shape[1] * dv, shape[1] * du + shape[2] * dv
    f = math.sqrt(max(du * gu + dv * gv, 0.0))
    if f < 1e-6:
        return -1.0 / math.sqrt(max(shape[0], shape[2])), 0.0, 0.0
    size = max(math.hypot(gu, gv), 1e-12)
    return (f - 1.0) * f / size, gu / size, gv / size


@compiled
def paint_parts(
    parts: np.ndarray, shift: float, blur: float, box: np.ndarray, value: np.ndarray,
    owner: np.ndarray,
) -> None:  # fmt: skip
    """Paint the body's parts.

    ``parts`` (n, 10): u, v at height 0, their change with the height, uu, uv, vv of the
    ellipse's inverse matrix, half the extent in u and in v, darkness. ``shift`` is the height.
    """
    height, width = value.shape
    for e in range(len(parts)):
        cu = parts[e, 0] + shift * parts[e, 2] - box[0]
        cv = parts[e, 1] + shift * parts[e, 3] - box[1]
        ru, rv = parts[e, 7] + blur + 1.0, parts[e, 8] + blur + 1.0
        for v in range(max(0, int(cv - rv)), min(height, int(cv + rv) + 2)):
            for u in range(max(0, int(cu - ru)), min(width, int(cu + ru) + 2)):
                outside, _, _ = _outside(u - cu, v - cv, parts[e, 4:7])
                if outside >= blur:
                    continue
                here = parts[e, 9] * step(-outside / blur)
                if here > value[v, u]:
                    value[v, u] = here
                    owner[v, u] = -2 - e


@compiled
def place_joints(layout: PoseLayout, x: np.ndarray, coefs: np.ndarray, joints: np.ndarray) -> None:
    """Write where the joints of the unknowns ``x`` appear in the second view."""
    legs, most = joints.shape[0], joints.shape[1]
    for i in range(legs):
        for j in range(layout.n_segments[i] + 1):
            k = 1 + 3 * (i * most + j)
            joints[i, j, 0], joints[i, j, 1] = project_point(coefs, x[k], x[k + 1], x[k + 2])


@compiled
def paint_space(
    layout: PoseLayout, x: np.ndarray, coefs: np.ndarray, parts: np.ndarray, shown: np.ndarray,
    blur: float, box: np.ndarray, value: np.ndarray, owner: np.ndarray, along: np.ndarray,
    joints: np.ndarray,
) -> None:  # fmt: skip
    """Paint the animal as the second view sees it; legs where ``shown`` says so."""
    clear(value, owner)
    paint_parts(parts, x[0], blur, box, value, owner)
    place_joints(layout, x, coefs, joints)
    for i in range(joints.shape[0]):
        if shown[i]:
            paint_leg(layout, joints[i], i, blur, box, value, owner, along)


@compiled
def add_picture(
    layout: PoseLayout, x: np.ndarray, coefs: np.ndarray, parts: np.ndarray, blur: float,
    box: np.ndarray, value: np.ndarray, owner: np.ndarray, along: np.ndarray, joints: np.ndarray,
    seen: np.ndarray, weight: np.ndarray, soft: float, share: float, matrix: np.ndarray,
    vector: np.ndarray,
) -> float:  # fmt: skip
    """Add the painted picture's Gauss-Newton matrix and gradient; return its cost."""
    legs, most = joints.shape[0], joints.shape[1]
    slopes = np.empty((legs, most, 2, 3))
    for i in range(legs):
        for j in range(layout.n_segments[i] + 1):
            k = 1 + 3 * (i * most + j)
            project_slope(coefs, x[k : k + 3], slopes[i, j])
    row, pull = np.zeros(6), np.zeros(4)
    total = 0.0
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            piece = owner[v, u]
            if piece == NOTHING:
                continue
            error = value[v, u] - seen[v, u]
            w = share * weight[v, u]
            total += w * (misfit(error, soft) - misfit(seen[v, u], soft))
            w /= (1.0 + error * error / (soft * soft)) ** 2
            pu, pv = u + box[0], v + box[1]
            if piece < 0:
                part = parts[-2 - piece]
                cu, cv = part[0] + x[0] * part[2], part[1] + x[0] * part[3]
                outside, nu, nv = _outside(pu - cu, pv - cv, part[4:7])
                g = part[9] * slope(-outside / blur) / blur * (nu * part[2] + nv * part[3])
                matrix[0, 0] += w * g * g
                vector[0] += w * g * error
                continue
            i, s = piece // 64, piece % 64
            t = along[v, u]
            if not leg_pull(layout, joints[i], i, s, t, blur, pu, pv, pull):
                continue
            for c in range(3):
                row[c] = (1.0 - t) * (pull[0] * slopes[i, s, 0, c] + pull[1] * slopes[i, s, 1, c])
                row[3 + c] = t * (
                    pull[0] * slopes[i, s + 1, 0, c] + pull[1] * slopes[i, s + 1, 1, c]
                )
            k = 1 + 3 * (i * most + s)
            for a in range(6):
                vector[k + a] += w * row[a] * error
                for b in range(6):
                    matrix[k + a, k + b] += w * row[a] * row[b]
    return total


@compiled
def _add_row(
    matrix: np.ndarray, vector: np.ndarray, first: int, row: np.ndarray, n: int, error: float,
    precision: float,
) -> float:  # fmt: skip
    """Add one residual of n neighbouring unknowns; return its cost."""
    for a in range(n):
        vector[first + a] += precision * row[a] * error
        for b in range(n):
            matrix[first + a, first + b] += precision * row[a] * row[b]
    return 0.5 * precision * error * error


@compiled
def add_known(
    layout: PoseLayout, x: np.ndarray, known: Known, matrix: np.ndarray, vector: np.ndarray
) -> float:
    """Add matrix and gradient of what is known without the second picture; return its cost."""
    legs, most = known.seen.shape[0], known.seen.shape[1]
    total = 0.0
    for i in range(legs):
        n = layout.n_segments[i]
        for j in range(most):
            k = 1 + 3 * (i * most + j)
            if j > n:
                for c in range(3):
                    matrix[k + c, k + c] += 1.0
                continue
            total += _add_first_view(x, known, i, j, k, matrix, vector)
            if j < n:
                total += _add_length(x, known, i, j, k, matrix, vector)
            if j < n - 1:
                total += _add_bend(x, known, i, j, k, matrix, vector)
            height = 0.0
            for c in range(3):
                height += known.axis[c] * (x[k + c] - known.about[c])
            total += _add_height(height, known, 1 + i * most + j, k, j == n, matrix, vector)
            if j == 0:
                total += _add_root(height - x[0], known, k, matrix, vector)
    if not math.isnan(known.expected[0]):
        error = x[0] - known.expected[0]
        matrix[0, 0] += 1.0 / known.expected_sd**2
        vector[0] += error / known.expected_sd**2
        total += 0.5 * (error / known.expected_sd) ** 2
    return total


@compiled
def _add_bend(
    x: np.ndarray, known: Known, i: int, j: int, k: int, matrix: np.ndarray, vector: np.ndarray
) -> float:
    """Add the change of direction from one segment to the next."""
    a, b = known.length[i, j], known.length[i, j + 1]
    precision = 1.0 / known.bend_sd**2
    row = np.zeros(9)
    total = 0.0
    for c in range(3):
        row[:] = 0.0
        row[c], row[3 + c], row[6 + c] = 1.0 / a, -1.0 / a - 1.0 / b, 1.0 / b
        error = row[c] * x[k + c] + row[3 + c] * x[k + 3 + c] + row[6 + c] * x[k + 6 + c]
        total += _add_row(matrix, vector, k, row, 9, error, precision)
    return total


@compiled
def _add_height(
    height: float, known: Known, at: int, k: int, foot: bool, matrix: np.ndarray,
    vector: np.ndarray,
) -> float:  # fmt: skip
    """Add what the frames beside and the ground say of a joint's height."""
    total = 0.0
    expected = known.expected[at]
    if not math.isnan(expected):
        precision = 1.0 / known.expected_sd**2
        total += _add_row(matrix, vector, k, known.axis, 3, height - expected, precision)
    if not math.isnan(known.ground):
        above = (height - known.ground) / known.ground_sd
        total += ground_cost(above, foot, known.lifted)
        if above < 0.0 or foot:
            # robust: weighted as in iteratively reweighted least squares
            w = 1.0 if above < 0.0 else (1.0 + (above / known.lifted) ** 2) ** -2
            precision = w / known.ground_sd**2
            _add_row(matrix, vector, k, known.axis, 3, height - known.ground, precision)
    return total


@compiled
def _add_root(error: float, known: Known, k: int, matrix: np.ndarray, vector: np.ndarray) -> float:
    """Add how far a body-coxa joint is from the body's height."""
    precision = 1.0 / known.root_sd**2
    matrix[0, 0] += precision
    vector[0] -= precision * error
    for c in range(3):
        matrix[0, k + c] -= precision * known.axis[c]
        matrix[k + c, 0] -= precision * known.axis[c]
    return _add_row(matrix, vector, k, known.axis, 3, error, precision)


@compiled
def _add_first_view(
    x: np.ndarray, known: Known, i: int, j: int, k: int, matrix: np.ndarray, vector: np.ndarray
) -> float:
    """Add what the first view says of one joint."""
    change = np.empty((2, 3))
    u, v = project_slope(known.top, x[k : k + 3], change)
    du, dv = u - known.seen[i, j, 0], v - known.seen[i, j, 1]
    uu, uv, vv = known.weight[i, j]
    gu, gv = uu * du + uv * dv, uv * du + vv * dv
    for a in range(3):
        vector[k + a] += change[0, a] * gu + change[1, a] * gv
        for b in range(3):
            matrix[k + a, k + b] += (
                uu * change[0, a] * change[0, b] + vv * change[1, a] * change[1, b]
                + uv * (change[0, a] * change[1, b] + change[1, a] * change[0, b])
            )  # fmt: skip
    return 0.5 * (du * gu + dv * gv)


@compiled
def _add_length(
    x: np.ndarray, known: Known, i: int, j: int, k: int, matrix: np.ndarray, vector: np.ndarray
) -> float:
    """Add how far one segment is from its length."""
    row = np.empty(6)
    square = 0.0
    for c in range(3):
        square += (x[k + 3 + c] - x[k + c]) ** 2
    size = math.sqrt(max(square, 1e-18))
    for c in range(3):
        row[3 + c] = (x[k + 3 + c] - x[k + c]) / size
        row[c] = -row[3 + c]
    precision = 1.0 / known.length_sd[i, j] ** 2
    return _add_row(matrix, vector, k, row, 6, size - known.length[i, j], precision)
