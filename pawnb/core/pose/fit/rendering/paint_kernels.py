"""Painting the stick animal, and how the painted picture changes with the pose: compiled loops.

A leg's segment is a capsule whose thickness and darkness change along it; the last is cut off
straight at the tip, for that is where a leg is seen to end. A part of the body is an ellipse; its
rim has a darkness of its own, so that a pattern in its middle does not move its edge. Where several
lie on one pixel, the darkest shows. The picture's blur is that of a parabolic kernel, whose
integral is a polynomial; ``blur`` is its half width in px, sqrt(5) times its standard deviation.

A pixel remembers which piece it shows: segment ``leg * 64 + segment``, part of the body
``-2 - part``, nothing -1; and how far along a segment it lies:
0 to 1, more beyond the tip, where the blurred end still shows.
"""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled_inside, compiled_loosely
from pawnb.core.pose.fit.layout import PoseLayout

NOTHING = -1
"""Definition: number of the part where nothing is painted."""
NARROWEST = 0.2
"""Guard: beyond its narrow end an egg has no width; this share of it is left there."""
_LEVEL = 1e-3
"""Guard: a line that rises by less, px, is level."""
_RIM_PX = 2.0
"""Mathematics: so far inside its edge, half widths of the blur, the rim of a part of the body
changes into its middle. No other value is possible: the change, two half widths wide, begins where
the blur of the edge ends, so that darkness is continuous."""


@compiled_loosely
def leg_chain(layout: PoseLayout, pose: np.ndarray, leg: int, joints: np.ndarray) -> None:
    """Write the joints of a leg, body-coxa joint to tip, into ``joints`` (segments + 1, 2)."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    forward, right = layout.attach[leg, 0], layout.attach[leg, 1]
    u = pose[0] + forward * cos - right * sin
    v = pose[1] + forward * sin + right * cos
    joints[0, 0], joints[0, 1] = u, v
    first, n_links = layout.first[leg], layout.n_links[leg]
    forwards, current = 0.0, -1
    for s in range(layout.n_segments[leg]):
        k = layout.link[leg, s]
        if k != current:
            forwards += pose[first + k]
            current = k
        turn = math.pi / 2 - forwards - layout.turn[leg, s]
        direction = pose[2] + layout.side[leg] * turn
        length = layout.length[leg, s] * math.exp(pose[first + n_links + k])
        u += length * math.cos(direction)
        v += length * math.sin(direction)
        joints[s + 1, 0], joints[s + 1, 1] = u, v


@compiled_inside
def step(x: float) -> float:
    """Return the integral of the parabolic kernel from minus infinity to x (half widths)."""
    if x <= -1.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    return 0.5 + 0.25 * x * (3.0 - x * x)


@compiled_inside
def slope(x: float) -> float:
    """Return the parabolic kernel at x, the derivative of :func:`step`."""
    if x <= -1.0 or x >= 1.0:
        return 0.0
    return 0.75 * (1.0 - x * x)


@compiled_loosely
def clear(value: np.ndarray, owner: np.ndarray) -> None:
    """Empty a painted picture."""
    value[:] = 0.0
    owner[:] = NOTHING


@compiled_inside
def egg_shape(
    x: float, y: float, half: float, across: float, egg: float
) -> tuple[float, float, float]:
    """Return how far outside an egg a place is, px, and the slope of that along x and y.

    The place is relative to the egg's middle. To first order near the outline.
    """
    a = x / half
    wide = max(1.0 + egg * a, NARROWEST)
    b = y / (across * wide)
    f = math.sqrt(a * a + b * b)
    if f < 1e-6:
        return -min(half, across), 0.0, 0.0
    ga, gb = (a - b * b * egg / wide) / half, b / (across * wide)
    size = max(math.sqrt(ga * ga + gb * gb), 1e-9)
    return (f - 1.0) * f / size, ga / size, gb / size


@compiled_inside
def part_dark(
    outside: float, dark: float, middle: float, blur: float
) -> tuple[float, float, float]:
    """Return how dark a part of the body is at a place, and how that changes.

    Parameters
    ----------
    outside : float
        How far outside the part the place lies, px; less than ``blur``.
    dark, middle : float
        Darkness of its rim and of its middle.
    blur : float
        Half width of the blur, px.

    Returns
    -------
    here, change, deep : float
        Its darkness, the change of that per px further inside, and how much the place belongs
        to the middle, 0 to 1.
    """
    inside = -outside / blur
    if inside < 1.0:
        return dark * step(inside), dark * slope(inside) / blur, 0.0
    deep = step(inside - _RIM_PX)
    return dark + (middle - dark) * deep, (middle - dark) * slope(inside - _RIM_PX) / blur, deep


@compiled_loosely
def paint_body(
    layout: PoseLayout, pose: np.ndarray, blur: float, box: np.ndarray, value: np.ndarray,
    owner: np.ndarray,
) -> None:  # fmt: skip
    """Paint the body's ellipses; ``box`` is the left and top of the picture."""
    height, width = value.shape
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for e in range(layout.ellipse.shape[0]):
        forward, right, along, across, dark, egg, middle = layout.ellipse[e]
        cu = pose[0] + forward * cos - right * sin - box[0]
        cv = pose[1] + forward * sin + right * cos - box[1]
        reach = max(along, across * (1.0 + abs(egg))) + blur + 1.0
        for v in range(max(0, int(cv - reach)), min(height, int(cv + reach) + 2)):
            for u in range(max(0, int(cu - reach)), min(width, int(cu + reach) + 2)):
                x, y = (u - cu) * cos + (v - cv) * sin, -(u - cu) * sin + (v - cv) * cos
                outside, _, _ = egg_shape(x, y, along, across, egg)
                if outside >= blur:
                    continue
                here, _, _ = part_dark(outside, dark, middle, blur)
                if here > value[v, u]:
                    value[v, u] = here
                    owner[v, u] = -2 - e


@compiled_loosely
def paint_leg(
    layout: PoseLayout, joints: np.ndarray, leg: int, blur: float, box: np.ndarray,
    value: np.ndarray, owner: np.ndarray, along: np.ndarray,
) -> None:  # fmt: skip
    """Paint one leg whose joints are given."""
    height, width = value.shape
    last = layout.n_segments[leg] - 1
    for s in range(last + 1):
        u0, v0 = joints[s, 0] - box[0], joints[s, 1] - box[1]
        du, dv = joints[s + 1, 0] - joints[s, 0], joints[s + 1, 1] - joints[s, 1]
        square = max(du * du + dv * dv, 1e-6)
        most = 1.0 + blur / math.sqrt(square) if s == last else 1.0
        r0, r1 = layout.radius[leg, s], layout.radius[leg, s + 1]
        d0, d1 = layout.dark[leg, s], layout.dark[leg, s + 1]
        reach = max(r0, r1) + blur
        top, bottom = min(v0, v0 + dv) - reach, max(v0, v0 + dv) + reach
        for v in range(max(0, math.ceil(top)), min(height, math.floor(bottom) + 1)):
            left, right = min(u0, u0 + du) - reach, max(u0, u0 + du) + reach
            if abs(dv) > _LEVEL:  # the part of this row within reach of the endless line
                middle = u0 + (v - v0) * du / dv
                half = reach * math.sqrt(square) / abs(dv)
                left, right = max(left, middle - half), min(right, middle + half)
            for u in range(max(0, math.ceil(left)), min(width, math.floor(right) + 1)):
                t = ((u - u0) * du + (v - v0) * dv) / square
                t = min(max(t, 0.0), most)
                eu, ev = u - u0 - t * du, v - v0 - t * dv
                inside = min(t, 1.0)
                radius = r0 + (r1 - r0) * inside
                distance2 = eu * eu + ev * ev
                if distance2 >= (radius + blur) ** 2:
                    continue
                distance = math.sqrt(distance2)
                cover = step((radius - distance) / blur) - step((-radius - distance) / blur)
                if s == last:
                    cover *= step((1.0 - t) / (most - 1.0))
                here = (d0 + (d1 - d0) * inside) * cover
                if here > value[v, u]:
                    value[v, u] = here
                    owner[v, u] = leg * 64 + s
                    along[v, u] = t


@compiled_loosely
def paint(
    layout: PoseLayout, pose: np.ndarray, blur: float, box: np.ndarray, value: np.ndarray,
    owner: np.ndarray, along: np.ndarray, joints: np.ndarray,
) -> None:  # fmt: skip
    """Paint the whole animal on an empty picture; ``joints`` (legs, segments + 1, 2) is filled."""
    clear(value, owner)
    paint_body(layout, pose, blur, box, value, owner)
    for leg in range(layout.side.shape[0]):
        leg_chain(layout, pose, leg, joints[leg])
        paint_leg(layout, joints[leg], leg, blur, box, value, owner, along)


@compiled_inside
def body_slope(
    layout: PoseLayout, pose: np.ndarray, part: int, blur: float, u: float, v: float,
    cos: float, sin: float, row: np.ndarray,
) -> bool:  # fmt: skip
    """Write how a pixel of the body changes with x, y, heading; False where it does not.

    ``cos`` and ``sin`` are those of the heading.
    """
    forward, right, half, across, dark, egg, middle = layout.ellipse[part]
    du = u - pose[0]
    dv = v - pose[1]
    x, y = du * cos + dv * sin - forward, -du * sin + dv * cos - right
    outside, na, nb = egg_shape(x, y, half, across, egg)
    if outside >= blur:
        return False
    _, change, _ = part_dark(outside, dark, middle, blur)
    if change == 0.0:
        return False
    nu, nv = na * cos - nb * sin, na * sin + nb * cos
    row[0], row[1] = change * nu, change * nv
    row[2] = change * (-nu * dv + nv * du)
    return True


@compiled_inside
def leg_pull(
    layout: PoseLayout, joints: np.ndarray, leg: int, s: int, t: float, blur: float, u: float,
    v: float, pull: np.ndarray,
) -> bool:  # fmt: skip
    """Write how a pixel of a leg changes as a point of the axis moves, the one nearest to it.

    ``pull`` receives the change per px of motion in u and v, and that point; False where the
    pixel does not change. Near a tip, which pulls at the pixel too, the point is the one at which
    both together have the same moments about the segment's first joint.
    """
    u0, v0 = joints[s, 0], joints[s, 1]
    du, dv = joints[s + 1, 0] - u0, joints[s + 1, 1] - v0
    qu, qv = u0 + t * du, v0 + t * dv
    eu, ev = u - qu, v - qv
    distance = math.sqrt(eu * eu + ev * ev)
    r0, r1 = layout.radius[leg, s], layout.radius[leg, s + 1]
    d0, d1 = layout.dark[leg, s], layout.dark[leg, s + 1]
    inside = min(t, 1.0)
    radius, dark = r0 + (r1 - r0) * inside, d0 + (d1 - d0) * inside
    sharp, square = 1.0 / blur, max(du * du + dv * dv, 1e-6)
    beyond = (t - 1.0) * math.sqrt(square) * sharp if s == layout.n_segments[leg] - 1 else -1.0
    end = step(-beyond)
    inner, outer = (radius - distance) * sharp, (-radius - distance) * sharp
    k_inner, k_outer = slope(inner), slope(outer)
    pull[0] = pull[1] = 0.0
    if distance > 1e-9:  # minus the change with distance
        across = end * dark * (k_inner - k_outer) * sharp / distance
        pull[0], pull[1] = across * eu, across * ev
    cover = step(inner) - step(outer)
    if 0.0 < t < 1.0:
        lengthwise = (d1 - d0) * cover + dark * (k_inner + k_outer) * sharp * (r1 - r0)
        lengthwise *= end / square
        pull[0] -= lengthwise * du
        pull[1] -= lengthwise * dv
    pull[2], pull[3] = qu, qv
    if beyond > -1.0:
        strength = dark * cover * slope(beyond) * sharp / math.sqrt(square)
        add_pull(pull, u0, v0, strength * du, strength * dv, u0 + du + eu, v0 + dv + ev)
    return abs(pull[0]) + abs(pull[1]) > 1e-7


@compiled_inside
def add_pull(
    pull: np.ndarray, u0: float, v0: float, gu: float, gv: float, u: float, v: float
) -> None:
    """Add to ``pull`` another one, (gu, gv) at (u, v): both moments about (u0, v0) are kept."""
    a, b, c, d = pull[2] - u0, pull[3] - v0, u - u0, v - v0
    turning = pull[1] * a - pull[0] * b + gv * c - gu * d
    stretching = pull[0] * a + pull[1] * b + gu * c + gv * d
    pull[0] += gu
    pull[1] += gv
    square = pull[0] ** 2 + pull[1] ** 2
    if square > 1e-18:
        pull[2] = u0 + (stretching * pull[0] + turning * pull[1]) / square
        pull[3] = v0 + (stretching * pull[1] - turning * pull[0]) / square


@compiled_loosely
def leg_slope(
    layout: PoseLayout, pose: np.ndarray, joints: np.ndarray, leg: int, s: int, pull: np.ndarray,
    row: np.ndarray, which: np.ndarray,
) -> int:  # fmt: skip
    """Write how a pixel changes with each number of the pose; return how many these are."""
    gu, gv, qu, qv = pull[0], pull[1], pull[2], pull[3]
    row[0], row[1] = gu, gv
    row[2] = -gu * (qv - pose[1]) + gv * (qu - pose[0])
    which[0], which[1], which[2] = 0, 1, 2
    last, first, n_links = layout.link[leg, s], layout.first[leg], layout.n_links[leg]
    start = 0
    for k in range(last + 1):
        end = start
        while end < layout.n_segments[leg] and layout.link[leg, end] == k:
            end += 1
        au, av = joints[start, 0], joints[start, 1]
        angle, length = 3 + k, 4 + last + k  # ascending: only the lower triangle is filled
        row[angle] = -layout.side[leg] * (-gu * (qv - av) + gv * (qu - au))
        which[angle] = first + k
        if k == last:
            row[length] = gu * (qu - au) + gv * (qv - av)
        else:
            row[length] = gu * (joints[end, 0] - au) + gv * (joints[end, 1] - av)
        which[length] = first + n_links + k
        start = end
    return 3 + 2 * (last + 1)


@compiled_inside
def misfit(error: float, soft: float) -> float:
    """Return the cost of a pixel's error: quadratic when small, level beyond ``soft``.

    The function of Geman and McClure.
    """
    square = error * error
    return 0.5 * square / (1.0 + square / (soft * soft))


@compiled_loosely
def picture_cost(
    value: np.ndarray, owner: np.ndarray, seen: np.ndarray, weight: np.ndarray, soft: float
) -> float:
    """Return the cost of the painted picture less that of an empty one."""
    total = 0.0
    for v in range(value.shape[0]):
        for u in range(value.shape[1]):
            if owner[v, u] != NOTHING:
                now = misfit(value[v, u] - seen[v, u], soft)
                total += weight[v, u] * (now - misfit(seen[v, u], soft))
    return total


def make_canvas(height: int, width: int, layout: PoseLayout) -> tuple[np.ndarray, ...]:
    """Return empty ``value``, ``owner``, ``along`` and ``joints`` for :func:`paint`.

    Parameters
    ----------
    height, width : int
        Size of the picture, working px.
    layout : PoseLayout
        The stick animal as arrays.

    Returns
    -------
    tuple of ndarray
        The four, each to be filled by :func:`paint`.
    """
    legs, most = layout.length.shape
    return (
        np.zeros((height, width)),
        np.full((height, width), NOTHING, np.int32),
        np.zeros((height, width)),
        np.zeros((legs, most + 1, 2)),
    )
