"""Turning limbs while the labels of the pixels stay: the shape prior's cost, and its descent.

With the labels given, only the shape prior depends on the pose (Pullar 2009, Eq. 3.14, 3.15): a
subject pixel costs more the further it is from the stick animal, a background pixel costs where
it is nearer than d_r. What a limb adds is known from the subject pixels that no other part is as
near to, and from the background pixels along the limb.
"""

from __future__ import annotations

import math

import numpy as np

from pawnb.core.compiled import compiled
from pawnb.core.pose.pullar2009.sticks import (
    HALF_LINE_PX,
    distance_map,
    from_body,
    from_line,
    leg_points,
)

FLAT_EXPONENT = 30.0
"""Numerics: log(1 + exp(-x)) beyond this is nothing."""
_NEAR_PX = 8.0
"""Resource: distances up to this come from a map of all of them, larger ones one by one."""


@compiled
def softplus(x: float) -> float:
    """Return log(1 + exp(x))."""
    if x > FLAT_EXPONENT:
        return x
    if x < -FLAT_EXPONENT:
        return 0.0
    return math.log1p(math.exp(x))


@compiled
def limit_cost(angles: np.ndarray, middle: np.ndarray, half: np.ndarray, stiffness: float) -> float:
    """Return the cost of joints beyond their ranges: stiffness times squared degrees beyond."""
    cost = 0.0
    for i in range(len(angles)):
        over = abs(angles[i] - middle[i]) - half[i]
        if over > 0:
            cost += stiffness * over * over
    return cost


@compiled
def part_distances(
    pixels: np.ndarray, heading: float, points: np.ndarray, n_links: np.ndarray, parts: np.ndarray
) -> np.ndarray:
    """Return the distance of each pixel (n, 2; u, v) from the body and each leg: (1 + legs, n)."""
    out = np.empty((1 + len(n_links), len(pixels)))
    cos, sin = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    for k in range(len(pixels)):
        u, v = pixels[k, 0], pixels[k, 1]
        out[0, k] = from_body(u, v, cos, sin, parts, np.inf)
        for i in range(len(n_links)):
            out[1 + i, k] = from_line(u, v, points[i], n_links[i])
    return out


@compiled
def shape_cost(
    labels: np.ndarray,
    origin: tuple[int, int],
    heading: float,
    points: np.ndarray,
    n_links: np.ndarray,
    parts: np.ndarray,
    thickness: float,
    steepness: float,
) -> float:
    """Return the cost of the shape prior for labels that stay, Eq. 3.14 summed over the crop.

    Parameters
    ----------
    labels : ndarray of bool, shape (H, W)
        Labels of the crop.
    origin : tuple of int
        u, v of the crop's first pixel.
    heading : float
        Direction of the body, degrees.
    points, n_links, parts : ndarray
        The stick animal in the picture.
    thickness, steepness : float
        d_r and mu.

    Returns
    -------
    float
        The cost.
    """
    most = max(_NEAR_PX, thickness + FLAT_EXPONENT / steepness)
    near = distance_map(origin, labels.shape, heading, points, n_links, parts, most)
    cos, sin = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    cost = 0.0
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            away = float(near[y, x])
            if not labels[y, x]:
                cost += softplus(steepness * (thickness - away))
                continue
            if away >= np.float32(most):
                u, v = float(x + origin[0]), float(y + origin[1])
                away = from_body(u, v, cos, sin, parts, np.inf)
                for i in range(len(n_links)):
                    away = min(away, from_line(u, v, points[i], n_links[i]))
            cost += softplus(steepness * (away - thickness))
    return cost


@compiled
def _leg_cost(
    points: np.ndarray,
    n_links: int,
    pixels: np.ndarray,
    others: np.ndarray,
    without: np.ndarray,
    near: np.ndarray,
    labels: np.ndarray,
    origin: tuple[int, int],
    thickness: float,
    steepness: float,
) -> float:
    """Return by how much this leg changes what the shape prior costs without it.

    ``others`` is the distance of each subject pixel from the other parts, ``without`` its cost
    for that, and ``near`` the map of distances from them, cut off where background pixels no
    longer cost.
    """
    left, top, right, bottom = points[0, 0], points[0, 1], points[0, 0], points[0, 1]
    step = np.empty((n_links, 3))
    for i in range(n_links):
        u, v = points[i + 1, 0], points[i + 1, 1]
        left, right, top, bottom = min(left, u), max(right, u), min(top, v), max(bottom, v)
        step[i, 0], step[i, 1] = u - points[i, 0], v - points[i, 1]
        step[i, 2] = 1.0 / max(step[i, 0] ** 2 + step[i, 1] ** 2, 1e-12)
    cost = 0.0
    for k in range(len(pixels)):
        u, v, far = pixels[k, 0], pixels[k, 1], others[k] + HALF_LINE_PX
        if u < left - far or u > right + far or v < top - far or v > bottom + far:
            continue
        best = np.inf
        for i in range(n_links):
            pu, pv = u - points[i, 0], v - points[i, 1]
            share = (pu * step[i, 0] + pv * step[i, 1]) * step[i, 2]
            share = min(max(share, 0.0), 1.0)
            pu, pv = pu - share * step[i, 0], pv - share * step[i, 1]
            best = min(best, pu * pu + pv * pv)
        if best < far * far:
            away = max(0.0, math.sqrt(best) - HALF_LINE_PX)
            cost += softplus(steepness * (away - thickness)) - without[k]
    most = thickness + FLAT_EXPONENT / steepness
    for i in range(n_links):
        cost += _along_link(i, points, n_links, near, labels, origin, most, thickness, steepness)
    return cost


@compiled
def _along_link(
    link: int,
    points: np.ndarray,
    n_links: int,
    near: np.ndarray,
    labels: np.ndarray,
    origin: tuple[int, int],
    most: float,
    thickness: float,
    steepness: float,
) -> float:
    """Return the cost of background pixels along a link that no earlier link is as near to.

    Pixels are visited along the link: at each step along its longer direction, those across it
    that are within ``most``. Beyond the crop every pixel is background and far from the rest, also
    beyond the picture: else a leg that is too long would be bent out of it.
    """
    du, dv = points[link + 1, 0] - points[link, 0], points[link + 1, 1] - points[link, 1]
    length = max(math.hypot(du, dv), 1e-9)
    reach = most + 0.5
    steep = abs(dv) > abs(du)
    one, other = (1, 0) if steep else (0, 1)
    start = min(points[link, one], points[link + 1, one])
    stop = max(points[link, one], points[link + 1, one])
    slope = (du / dv if steep else dv / du) if max(abs(du), abs(dv)) > 1e-9 else 0.0
    across = reach * length / max(abs(du), abs(dv), 1e-9)
    cost = 0.0
    for a in range(math.floor(start - reach), math.ceil(stop + reach) + 1):
        at = min(max(float(a), start), stop)
        middle = points[link, other] + slope * (at - points[link, one])
        for b in range(math.floor(middle - across), math.ceil(middle + across) + 1):
            u, v = (b, a) if steep else (a, b)
            mine = from_line(float(u), float(v), points[link:], 1)
            if mine >= most:
                continue
            if link > 0 and from_line(float(u), float(v), points, link) <= mine:
                continue
            if (
                link + 1 < n_links
                and from_line(float(u), float(v), points[link + 1 :], n_links - link - 1) < mine
            ):
                continue
            x, y = u - origin[0], v - origin[1]
            if 0 <= x < labels.shape[1] and 0 <= y < labels.shape[0]:
                if labels[y, x]:
                    continue
                rest = float(near[y, x])
            else:
                rest = most
            if mine < rest:
                cost += softplus(steepness * (thickness - mine))
                cost -= softplus(steepness * (thickness - rest))
    return cost


@compiled
def turn_leg(
    body: np.ndarray,
    angles: np.ndarray,
    trials: np.ndarray,
    length: np.ndarray,
    joint: np.ndarray,
    fixed_deg: np.ndarray,
    n_links: int,
    attach: np.ndarray,
    side: float,
    middle: np.ndarray,
    half: np.ndarray,
    stiffness: float,
    pixels: np.ndarray,
    others: np.ndarray,
    near: np.ndarray,
    labels: np.ndarray,
    origin: tuple[int, int],
    thickness: float,
    steepness: float,
) -> float:
    """Try turns of one leg's joints, keep each that lowers the energy; ``angles`` change.

    Parameters
    ----------
    body : ndarray, shape (3,)
        u, v and heading.
    angles : ndarray, shape (n_free,)
        The leg's free joints, degrees; changed in place.
    trials : ndarray, shape (n, n_free)
        Turns to try, one after the other, degrees.
    length, joint, fixed_deg, n_links, attach, side
        The leg, see :class:`pawnb.core.pose.pullar2009.sticks.Sticks`.
    middle, half, stiffness
        Ranges of the joints and the cost of leaving them.
    pixels, others, near, labels, origin, thickness, steepness
        The labelled picture and the shape prior, see :func:`shape_cost`; ``others`` and
        ``near`` are distances from the other parts.

    Returns
    -------
    float
        By how much the energy was lowered.
    """
    points = np.empty((n_links + 1, 2))
    without = np.empty(len(others))
    for k in range(len(others)):
        without[k] = softplus(steepness * (others[k] - thickness))
    first, lowest = 0.0, 0.0
    trial = angles.copy()
    for t in range(-1, len(trials)):
        for i in range(len(angles)):
            trial[i] = angles[i] + (trials[t, i] if t >= 0 else 0.0)
        leg_points(
            body[0],
            body[1],
            body[2],
            trial,
            length,
            joint,
            fixed_deg,
            n_links,
            attach,
            side,
            points,
        )
        cost = limit_cost(trial, middle, half, stiffness) + _leg_cost(
            points,
            n_links,
            pixels,
            others,
            without,
            near,
            labels,
            origin,
            thickness,
            steepness,
        )
        if t < 0:
            first = lowest = cost
        elif cost < lowest:
            lowest = cost
            for i in range(len(angles)):
                angles[i] = trial[i]
    return first - lowest
