"""The energy of a frame given a pose: likelihood, Ising, contrast and shape prior.

Pullar 2009, Eq. 3.16. A frame is cut to a crop about the animal; outside it no pixel can be
subject in a labelling of least energy, so that nothing is lost.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from pawnb.core.compiled import compiled
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.contrast import neighbour_costs
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.pullar2009.likelihood import (
    EmptyScene,
    background_cost,
    subject_cost,
    subject_statistics,
)
from pawnb.core.pose.pullar2009.limb_steps import limit_cost, softplus
from pawnb.core.pose.pullar2009.mincut import cut_grid, grid_energy
from pawnb.core.pose.pullar2009.settings import (
    EnergyParameters,
    Pullar2009Settings,
    fill_parameters,
)
from pawnb.core.pose.pullar2009.sticks import (
    Sticks,
    distance_map,
    from_body,
    from_line,
    make_sticks,
)

Box = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class FrameCosts:
    """What a frame's grey values cost on a crop, whatever the pose.

    Parameters
    ----------
    box : tuple of int
        The crop: u0, v0, u1, v1, half open, px of the view.
    own : ndarray of float32, shape (H, W)
        Cost of calling a pixel subject less that of calling it background.
    right, down : ndarray of float32
        Cost of neighbours with different labels.
    background_sum : float
        Sum of the crop's cost if all of it is background.
    pairs : float
        Most that the neighbours of a pixel can cost together.
    """

    box: Box
    own: Float32Array
    right: Float32Array
    down: Float32Array
    background_sum: float
    pairs: float


@dataclass(frozen=True, eq=False)
class Cut:
    """The labelling of least energy for one pose.

    Parameters
    ----------
    labels : ndarray of bool, shape (H, W)
        True: subject; of the crop.
    energy : float
        Energy of the crop: all four terms, and joints beyond their ranges.
    """

    labels: BoolArray
    energy: float


class Pullar2009Energy:
    """The energy of one recording: the empty scene, the animal's size, the parameters.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    start : Poses
        Its pose in the start frame; the lengths in it are kept.
    picture : ndarray, shape (H, W) or (H, W, 3)
        The start frame, of which the parameters that are not set are estimated (Table 3.3).
    background : Background
        The empty scene.
    settings : Pullar2009Settings
        Settings.

    Attributes
    ----------
    sticks : Sticks
        The animal's shape.
    parameters : EnergyParameters
        What was set or estimated.
    middle_deg, half_deg : ndarray, shape (n_joints,)
        Middle and half of each free joint's range.
    span_px : float
        Leg span.
    """

    def __init__(
        self,
        animal: StickAnimal,
        start: Poses,
        *,
        picture: ByteArray,
        background: EmptyScene,
        settings: Pullar2009Settings,
    ) -> None:
        self.animal = animal
        self.settings = settings
        self.background = background
        self.sticks: Sticks = make_sticks(animal, start)
        seen = grey(picture)
        cost = background_cost(seen, background, sd_floor_grey=settings.sd_floor_grey)
        self.parameters: EnergyParameters = fill_parameters(
            settings,
            animal,
            scale=float(start.scale[0]),
            sigma=float(cost.std(dtype=float)),
            subject=subject_statistics(seen, cost, box_share=settings.box_share),
        )
        self.middle_deg, self.half_deg = animal.natural_deg, animal.range_deg / 2
        self.span_px = animal.span * float(start.scale[0])
        self.stiffness = settings.limit_stiffness * self.parameters.sigma

    def with_sticks(self, sticks: Sticks) -> Pullar2009Energy:
        """Return the energy of an animal of another shape; the parameters stay as they are."""
        other = copy.copy(self)
        other.sticks = sticks
        return other

    def frame(self, picture: ByteArray, pose: FloatArray, *, slack_px: float) -> FrameCosts:
        """Return a frame's costs on the crop that holds the animal.

        Parameters
        ----------
        picture : ndarray, shape (H, W) or (H, W, 3)
            The frame.
        pose : ndarray, shape (3 + n_joints,)
            Where the animal is expected.
        slack_px : float
            How far parts of the animal may move from there.

        Returns
        -------
        FrameCosts
            The costs.

        Notes
        -----
        A pixel so far from the shape that it costs more as subject than its own likelihood and
        all its neighbours together can make good is background in every labelling of least
        energy. The crop holds all others.
        """
        seen, p = grey(picture), self.parameters
        whole = background_cost(seen, self.background, sd_floor_grey=self.settings.sd_floor_grey)
        height, width = whole.shape
        level = float(whole.mean(dtype=float))
        if self.settings.subject == "gaussian":
            level = math.log(p.subject_sd)  # the least that a subject pixel can cost
        pairs = 4 * (p.ising + p.contrast)
        most = p.thickness_px + (max(0.0, float(whole.max()) - level) + pairs) / p.steepness
        wide = self._box(pose, most + slack_px, (width, height))
        inner = self._box(pose, slack_px, (width, height))
        box = u0, v0, u1, v1 = _needed(
            whole, wide, inner, (level, pairs, p.thickness_px, p.steepness)
        )
        crop, back = seen[v0:v1, u0:u1], whole[v0:v1, u0:u1]
        if self.settings.subject == "gaussian":
            own = subject_cost(crop, mean=p.subject_mean, sd=p.subject_sd) - back
        else:
            own = np.float32(level) - back
        right, down = neighbour_costs(
            crop, ising=p.ising, contrast=p.contrast, edge_grey=p.edge_grey
        )
        return FrameCosts(
            box=box,
            own=np.ascontiguousarray(own),
            right=right,
            down=down,
            background_sum=float(back.sum(dtype=float)),
            pairs=pairs,
        )

    def cut(self, frame: FrameCosts, pose: FloatArray) -> Cut:
        """Return the labelling of least energy for a pose (Eq. 3.16), and that energy."""
        p, sticks = self.parameters, self.sticks
        u0, v0, u1, v1 = frame.box
        points, parts = sticks.points(pose), sticks.parts(pose)
        near_px = p.thickness_px + frame.pairs / p.steepness + 1.0
        away = distance_map(
            (u0, v0), (v1 - v0, u1 - u0), pose[2], points, sticks.n_links, parts, near_px
        )
        _refine(
            away, frame.own, (u0, v0), pose[2], points, sticks.n_links, parts, near_px,
            frame.pairs, p.thickness_px, p.steepness,
        )  # fmt: skip
        own, near = _with_shape(frame.own, away, p.thickness_px, p.steepness)
        labels = cut_grid(own, frame.right, frame.down)
        pixels, pairs = grid_energy(labels, own, right=frame.right, down=frame.down)
        total = frame.background_sum + near + pixels + pairs + self.limits(pose)
        return Cut(labels, total)

    def limits(self, pose: FloatArray) -> float:
        """Return the cost of joints beyond their ranges."""
        return float(limit_cost(pose[3:], self.middle_deg, self.half_deg, self.stiffness))

    def extent(self, pose: FloatArray) -> Box:
        """Return the box of the stick animal: u0, v0, u1, v1, half open, not cut at the picture."""
        points, parts = self.sticks.points(pose), self.sticks.parts(pose)
        half = parts[:, 2:].max(axis=1, keepdims=True)
        low = np.minimum(np.nanmin(points, axis=(0, 1)), (parts[:, :2] - half).min(axis=0))
        high = np.maximum(np.nanmax(points, axis=(0, 1)), (parts[:, :2] + half).max(axis=0))
        (a, b), (c, d) = np.floor(low).astype(int), np.ceil(high).astype(int) + 1
        return int(a), int(b), int(c), int(d)

    def _box(self, pose: FloatArray, margin: float, size: tuple[int, int]) -> Box:
        """Return the crop: the animal's box and a margin, cut at the picture's edges."""
        u0, v0, u1, v1 = self.extent(pose)
        m = math.ceil(min(margin, sum(size)))
        left, top = min(max(u0 - m, 0), size[0] - 2), min(max(v0 - m, 0), size[1] - 2)
        return left, top, max(min(u1 + m, size[0]), left + 2), max(min(v1 + m, size[1]), top + 2)


@compiled
def _with_shape(
    own: np.ndarray, away: np.ndarray, thickness: float, steepness: float
) -> tuple[np.ndarray, float]:
    """Add the shape prior: own costs, and its sum over the crop if all of it is background.

    The logarithms of the two probabilities of Eq. 3.15 differ by mu (d - d_r) exactly.
    """
    out = np.empty_like(own)
    near = 0.0
    for v in range(own.shape[0]):
        for u in range(own.shape[1]):
            x = steepness * (away[v, u] - thickness)
            out[v, u] = own[v, u] + x
            near += softplus(-x)
    return out, near


@compiled
def _refine(
    away: np.ndarray,
    own: np.ndarray,
    origin: tuple[int, int],
    heading: float,
    points: np.ndarray,
    n_links: np.ndarray,
    parts: np.ndarray,
    near_px: float,
    pairs: float,
    thickness: float,
    steepness: float,
) -> None:
    """Put exact distances where the map was cut off and a pixel may be subject all the same."""
    limit = pairs - steepness * (near_px - thickness)
    cos, sin = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    for v in range(away.shape[0]):
        for u in range(away.shape[1]):
            if away[v, u] >= np.float32(near_px) and own[v, u] < limit:
                x, y = float(u + origin[0]), float(v + origin[1])
                best = from_body(x, y, cos, sin, parts, np.inf)
                for i in range(len(n_links)):
                    best = min(best, from_line(x, y, points[i], n_links[i]))
                away[v, u] = best


@compiled
def _needed(
    cost: np.ndarray,
    wide: tuple[int, int, int, int],
    inner: tuple[int, int, int, int],
    numbers: tuple[float, float, float, float],
) -> tuple[int, int, int, int]:
    """Return the smallest box about ``inner`` outside which every pixel is background.

    ``numbers``: the subject's cost, the most that neighbours cost, d_r and mu. The animal is
    within ``inner``, which bounds the distance of pixels outside from below.
    """
    level, pairs, thickness, steepness = numbers
    u0, v0, u1, v1 = inner
    for v in range(wide[1], wide[3]):
        dv = max(inner[1] - v, v - inner[3] + 1, 0)
        for u in range(wide[0], wide[2]):
            du = max(inner[0] - u, u - inner[2] + 1, 0)
            if du == 0 and dv == 0:
                continue
            away = math.sqrt(float(du * du + dv * dv))
            if level - cost[v, u] + steepness * (away - thickness) <= pairs:
                u0, v0 = min(u0, u), min(v0, v)
                u1, v1 = max(u1, u + 1), max(v1, v + 1)
    return u0, v0, u1, v1
