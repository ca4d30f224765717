"""The stick animal as lines and ellipses in the picture, and distances of pixels from it.

Straight runs of segments (joints that do not turn) are one line, a *link*. Everything compiled
here works on one pose: body and angles as numbers, no objects.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.compiled import compiled
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses

HALF_LINE_PX = 0.5
"""Definition: half the width of a rasterised line, px: what is as near is part of the shape."""


@dataclass(frozen=True, eq=False)
class Sticks:
    """Shape of one animal at one size, as arrays.

    Parameters
    ----------
    length : ndarray, shape (n_legs, most links)
        Lengths of the links, px.
    joint : ndarray of int, shape (n_legs, most links)
        Place of the free joint at the link's inner end among the leg's free joints, or -1.
    fixed_deg : ndarray, shape (n_legs, most links)
        Turn at the link's inner end that is not free.
    n_links : ndarray of int, shape (n_legs,)
        Links of each leg.
    attach : ndarray, shape (n_legs, 2)
        Body-coxa joints in the body's frame, px forward and to the right.
    side : ndarray, shape (n_legs,)
        1 on the right, -1 on the left.
    first : ndarray of int, shape (n_legs + 1,)
        Free joints of leg i are ``first[i]`` to ``first[i + 1] - 1`` of the animal's.
    ellipses : ndarray, shape (n_parts, 4)
        Centre in the body's frame and half axes along and across it, px.
    """

    length: FloatArray
    joint: IntArray
    fixed_deg: FloatArray
    n_links: IntArray
    attach: FloatArray
    side: FloatArray
    first: IntArray
    ellipses: FloatArray

    def points(self, pose: FloatArray) -> FloatArray:
        """Return where the links of all legs end.

        Parameters
        ----------
        pose : ndarray, shape (3 + n_joints,)
            u, v, heading and angles, px and degrees.

        Returns
        -------
        ndarray, shape (n_legs, most links + 1, 2)
            Body-coxa joint, ends of the links outwards, tip; NaN beyond the tip.
        """
        return all_points(
            pose, self.length, self.joint, self.fixed_deg, self.n_links, self.attach, self.side,
            self.first,
        )  # fmt: skip

    def parts(self, pose: FloatArray) -> FloatArray:
        """Return the body's ellipses in the picture: (n_parts, 4) u, v, half axes."""
        turn = math.radians(pose[2])
        out = self.ellipses.copy()
        cos, sin = math.cos(turn), math.sin(turn)
        x, y = self.ellipses[:, 0], self.ellipses[:, 1]
        out[:, 0], out[:, 1] = pose[0] + x * cos - y * sin, pose[1] + x * sin + y * cos
        return out


def make_sticks(animal: StickAnimal, pose: Poses) -> Sticks:
    """Return the shape of an animal as large as in one pose.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    pose : Poses
        One frame: its scale and the projected lengths of its segments are used.

    Returns
    -------
    Sticks
        The shape.
    """
    scale, lengths = float(pose.scale[0]), pose.lengths_px[0]
    legs, done = [], 0
    for leg in animal.legs:
        links: list[list[float]] = []
        free = 0
        for i in range(len(leg.segments)):
            turn = 0.0 if leg.free[i] else leg.natural_deg[i]
            if links and not leg.free[i] and turn == 0:
                links[-1][0] += lengths[done + i]
            else:
                links.append([lengths[done + i], free if leg.free[i] else -1, turn])
            free += leg.free[i]
        done += len(leg.segments)
        legs.append(links)
    most = max(len(links) for links in legs)
    table = np.zeros((3, len(legs), most))
    for i, links in enumerate(legs):
        table[:, i, : len(links)] = np.transpose(links)
    return Sticks(
        length=table[0],
        joint=table[1].astype(np.int64),
        fixed_deg=table[2],
        n_links=np.array([len(links) for links in legs]),
        attach=scale * np.array([leg.attach for leg in animal.legs], dtype=float),
        side=np.array([leg.side for leg in animal.legs], dtype=float),
        first=np.cumsum([0] + [sum(leg.free) for leg in animal.legs]),
        ellipses=scale
        * np.array([[*part.centre, part.length / 2, part.width / 2] for part in animal.body]),
    )


def pose_vector(pose: Poses) -> FloatArray:
    """Return one pose as u, v, heading and angles, shape (3 + n_joints,)."""
    return np.concatenate([pose.xy[0], pose.heading_deg[:1], pose.angles_deg[0]]).astype(float)


@compiled
def leg_points(
    u: float,
    v: float,
    heading: float,
    angles: np.ndarray,
    length: np.ndarray,
    joint: np.ndarray,
    fixed_deg: np.ndarray,
    n_links: int,
    attach: np.ndarray,
    side: float,
    out: np.ndarray,
) -> None:
    """Write the ends of one leg's links to ``out``, shape (n_links + 1 or more, 2)."""
    turn = math.radians(heading)
    cos, sin = math.cos(turn), math.sin(turn)
    out[0, 0] = u + attach[0] * cos - attach[1] * sin
    out[0, 1] = v + attach[0] * sin + attach[1] * cos
    forwards = 0.0
    for i in range(n_links):
        forwards += fixed_deg[i]
        if joint[i] >= 0:
            forwards += angles[joint[i]]
        direction = math.radians(heading + side * (90.0 - forwards))
        out[i + 1, 0] = out[i, 0] + length[i] * math.cos(direction)
        out[i + 1, 1] = out[i, 1] + length[i] * math.sin(direction)


@compiled
def all_points(
    pose: np.ndarray,
    length: np.ndarray,
    joint: np.ndarray,
    fixed_deg: np.ndarray,
    n_links: np.ndarray,
    attach: np.ndarray,
    side: np.ndarray,
    first: np.ndarray,
) -> np.ndarray:
    """Return the ends of the links of all legs, (n_legs, most links + 1, 2)."""
    out = np.full((len(n_links), length.shape[1] + 1, 2), np.nan)
    for i in range(len(n_links)):
        angles = pose[3 + first[i] : 3 + first[i + 1]]
        leg_points(
            pose[0], pose[1], pose[2], angles, length[i], joint[i], fixed_deg[i], n_links[i],
            attach[i], side[i], out[i],
        )  # fmt: skip
    return out


@compiled
def from_line(u: float, v: float, points: np.ndarray, n_links: int) -> float:
    """Return the distance of a pixel's centre from a leg's line, less half a line, not below 0."""
    best = np.inf
    for i in range(n_links):
        du, dv = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
        pu, pv = u - points[i, 0], v - points[i, 1]
        along = (pu * du + pv * dv) / max(du * du + dv * dv, 1e-12)
        along = min(max(along, 0.0), 1.0)
        au, av = pu - along * du, pv - along * dv
        best = min(best, au * au + av * av)
    return max(0.0, math.sqrt(best) - HALF_LINE_PX)


@compiled
def from_ellipse(x: float, y: float, a: float, b: float) -> float:
    """Return the distance of a point from an ellipse about the origin, 0 inside it.

    The nearest point is found by following the centre of curvature: from a guess on the
    ellipse, the circle that fits it there is met on the way to the point, four times.
    """
    if (x / a) ** 2 + (y / b) ** 2 <= 1.0:
        return 0.0
    x, y = abs(x), abs(y)
    cos, sin = math.sqrt(0.5), math.sqrt(0.5)
    for _ in range(4):
        # centre of curvature at the guess
        eu = (a * a - b * b) * cos**3 / a
        ev = (b * b - a * a) * sin**3 / b
        radius = math.hypot(a * cos - eu, b * sin - ev)
        far = max(math.hypot(x - eu, y - ev), 1e-12)
        cos = min(1.0, max(0.0, ((x - eu) * radius / far + eu) / a))
        sin = min(1.0, max(0.0, ((y - ev) * radius / far + ev) / b))
        norm = max(math.hypot(cos, sin), 1e-12)
        cos, sin = cos / norm, sin / norm
    return math.hypot(x - a * cos, y - b * sin)


@compiled
def from_body(u: float, v: float, cos: float, sin: float, parts: np.ndarray, best: float) -> float:
    """Return the distance of a pixel's centre from the body, 0 inside it, or ``best`` if less.

    ``cos`` and ``sin`` are those of the heading.
    """
    for i in range(len(parts)):
        du, dv = u - parts[i, 0], v - parts[i, 1]
        if math.sqrt(du * du + dv * dv) - max(parts[i, 2], parts[i, 3]) < best:
            x, y = du * cos + dv * sin, dv * cos - du * sin
            best = min(best, from_ellipse(x, y, parts[i, 2], parts[i, 3]))
    return best


@compiled
def distance_map(
    origin: tuple[int, int],
    shape: tuple[int, int],
    heading: float,
    points: np.ndarray,
    n_links: np.ndarray,
    parts: np.ndarray,
    most: float,
) -> np.ndarray:
    """Return the distance of every pixel of a crop from the stick animal, cut off at ``most``.

    Parameters
    ----------
    origin : tuple of int
        u, v of the crop's first pixel.
    shape : tuple of int
        Height and width of the crop.
    heading : float
        Direction of the body, degrees.
    points : ndarray, shape (n_legs, most links + 1, 2)
        Ends of the links.
    n_links : ndarray of int, shape (n_legs,)
        Links of each leg.
    parts : ndarray, shape (n_parts, 4)
        The body's ellipses in the picture.
    most : float
        Distance from which the exact value does not matter, px.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Distances, px: 0 in the shape.
    """
    out = np.full(shape, np.float32(most))
    cos, sin = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    for i in range(len(parts)):
        reach = max(parts[i, 2], parts[i, 3]) + most
        u0, u1, v0, v1 = _box(
            parts[i, 0], parts[i, 0], parts[i, 1], parts[i, 1], reach, origin, shape
        )
        for v in range(v0, v1):
            for u in range(u0, u1):
                du, dv = u + origin[0] - parts[i, 0], v + origin[1] - parts[i, 1]
                x, y = du * cos + dv * sin, dv * cos - du * sin
                if math.sqrt(du * du + dv * dv) - max(parts[i, 2], parts[i, 3]) < out[v, u]:
                    away = from_ellipse(x, y, parts[i, 2], parts[i, 3])
                    out[v, u] = min(out[v, u], np.float32(away))
    for leg in range(len(n_links)):
        for i in range(n_links[leg]):
            _line_into(out, points[leg, i : i + 2], origin, most)
    return out


@compiled
def _line_into(out: np.ndarray, ends: np.ndarray, origin: tuple[int, int], most: float) -> None:
    """Lower distances to those from one line."""
    (a, b), (c, d) = ends[0], ends[1]
    reach = most + HALF_LINE_PX
    u0, u1, v0, v1 = _box(min(a, c), max(a, c), min(b, d), max(b, d), reach, origin, out.shape)
    du, dv = np.float32(c - a), np.float32(d - b)
    per = np.float32(1.0) / max(du * du + dv * dv, np.float32(1e-12))
    for v in range(v0, v1):
        pv = np.float32(v + origin[1] - b)
        for u in range(u0, u1):
            pu = np.float32(u + origin[0] - a)
            along = min(max((pu * du + pv * dv) * per, np.float32(0.0)), np.float32(1.0))
            au, av = pu - along * du, pv - along * dv
            away = np.sqrt(au * au + av * av) - np.float32(HALF_LINE_PX)
            out[v, u] = min(out[v, u], max(np.float32(0.0), away))


@compiled
def _box(
    left: float,
    right: float,
    top: float,
    bottom: float,
    reach: float,
    origin: tuple[int, int],
    shape: tuple[int, int],
) -> tuple[int, int, int, int]:
    """Return the pixels of the crop within reach of a box: u0, u1, v0, v1."""
    return (
        min(max(math.floor(left - reach) - origin[0], 0), shape[1]),
        max(min(math.ceil(right + reach) + 1 - origin[0], shape[1]), 0),
        min(max(math.floor(top - reach) - origin[1], 0), shape[0]),
        max(min(math.ceil(bottom + reach) + 1 - origin[1], shape[0]), 0),
    )
