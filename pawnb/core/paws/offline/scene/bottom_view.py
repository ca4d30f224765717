"""A view from below leads: feet do not hide each other there, so it decides the association alone.

Seen from the side, feet hide each other and what they stand on looks like them, and every
detection from below pairs with several from the side. Paths are then chosen among the
detections of the view from below, laid on one plane at the height of the ground; the other
views tell the heights afterwards, along the whole path at once.
"""

# ruff: noqa: ARG002  (geometries are asked alike, and not each needs all that it is told)

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, Points3D
from pawnb.core import dlt
from pawnb.core.paws.layout import Placement
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.triangulation import (
    PointHypotheses,
    triangulate,
)
from pawnb.core.paws.offline.detection.colour.detections import InFrames, InViews
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.detection.colour.observations import Observations, tracked_points
from pawnb.core.paws.offline.scene.parameters import MOVEMENT
from pawnb.core.paws.offline.scene.views import InSpace


@dataclass(frozen=True)
class BottomView(InSpace):
    """Several views of which one leads: places lie on a plane, where that one sees them.

    Parameters
    ----------
    view : int
        Number of the view that leads.
    substrate : float
        Height of the plane.
    """

    view: int
    substrate: float

    @property
    def from_below(self) -> BoolArray:
        """The view that leads."""
        return np.arange(len(self.paw_width_px)) == self.view

    def flat(self, x: FloatArray) -> FloatArray:
        """Return where points (..., 3) seem to be on the plane."""
        uv = dlt.project(self.coefs[:, [self.view]], x)[..., 0, :]
        return self.on_plane(uv, np.full(uv.shape[:-1], self.substrate))

    def on_plane(self, uv: FloatArray, height: FloatArray) -> FloatArray:
        """Return the points (..., 3) at some heights (...) that the view sees at ``uv``."""
        L = self.coefs[:, self.view]
        rows = np.stack(
            [
                L[0:3] - uv[..., :1] * L[8:11],
                L[4:7] - uv[..., 1:] * L[8:11],
                np.broadcast_to(self.volume.up, (*uv.shape[:-1], 3)),
            ],
            axis=-2,
        )
        right = np.stack([uv[..., 0] - L[3], uv[..., 1] - L[7], height], axis=-1)
        return np.asarray(np.linalg.solve(rows, right[..., None])[..., 0])

    def at_height(self, x: Points3D, height: FloatArray) -> Points3D:
        """Move points (n, 3) along the line of sight to other heights (n,)."""
        return self.on_plane(dlt.project(self.coefs[:, [self.view]], x)[..., 0, :], height)

    def hypotheses(
        self,
        found: InFrames,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return the places of every frame on the plane, the best first."""
        return [self._places_of(here, most) for here in found]

    def anchors_of_paths(
        self,
        here: Mapping[int, FloatArray],
        found: InViews,
        observations: Observations,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> dict[int, FloatArray]:
        """Return where placed points seem to be on the plane: from below middles were clicked."""
        return {p: self.flat(x) for p, x in here.items()}

    def tracked_points(
        self, places: FloatArray, observations: Observations, *, acceleration: float
    ) -> FloatArray:
        """Return where the tracked points are, with heights; the view that leads tells the rest."""
        return tracked_points(
            self.to_space(places, observations, acceleration), observations,
            geometry=self.projection, paw_width_px=self.paw_width_px, view=self.view,
        )  # fmt: skip

    def appearance_cost(self, total: FloatArray) -> FloatArray:
        """Return a share of the costs: no second view has confirmed the places."""
        return np.asarray(NETWORK_FLOW.look_below * total)

    def as_high(self, at: FloatArray, expected: Points3D) -> FloatArray:
        """Raise places on the plane as high as expected ones (n, 3)."""
        return self.at_height(at, expected @ self.volume.up)

    def _places_of(self, found: InViews, most: int) -> PointHypotheses:
        """Return the places of one frame."""
        own = found[self.view]
        if not len(own):
            return PointHypotheses(np.empty((0, 3)), np.empty(0))
        uv = own.uv.astype(float)
        good = [endpoint_score(one, self.limb_direction[v]) for v, one in enumerate(found)]
        _, price = self.heights(uv, [one.uv for one in found], good)
        confirmed = (price < MOVEMENT.bottom_view_reward).any(axis=1)
        cost = NETWORK_FLOW.unlike * (1.0 - good[self.view]) + np.where(
            confirmed, 0.0, MOVEMENT.bottom_view_alone
        )
        at = self.on_plane(uv, np.full(len(uv), self.substrate))
        kept: list[int] = []
        for i in np.argsort(cost, kind="stable").tolist():
            away = np.linalg.norm(at[kept] - at[i], axis=1)
            if len(kept) < most and away.min(initial=np.inf) >= self.paw_width:
                kept.append(i)
        return PointHypotheses(at[kept], cost[kept])

    def heights(
        self, uv: FloatArray, seen: Sequence[AnyArray], good: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Return what the other views say of the height of points.

        Parameters
        ----------
        uv : ndarray, shape (k, 2)
            Where the view sees them, px.
        seen : sequence of ndarray, shape (c, 2)
            Detections of every view in that frame, px.
        good : sequence of ndarray, shape (c,)
            How much each looks like the end of a paw, 0 to 1.

        Returns
        -------
        heights, price : ndarray, shape (k, m)
            The height at which each detection of another view meets the line of sight, and
            how badly it fits: from 0, infinite where it does not meet.
        """
        heights, price = [np.empty((len(uv), 0))], [np.empty((len(uv), 0))]
        for v, other in enumerate(seen):
            if v == self.view or not len(other):
                continue
            both = [self.view, v]
            pair = np.empty((len(uv), len(other), 2, 2))
            pair[:, :, 0], pair[:, :, 1] = uv[:, None], other
            flat = pair.reshape(-1, 2, 2)
            xyz = triangulate(self.coefs[:, both], flat)
            step = dlt.project(self.coefs[:, both], xyz) - flat
            away = (np.linalg.norm(step, axis=-1) / self.paw_width_px[both]).max(axis=1)
            # both views bear half of the distance
            cost = (away / MOVEMENT.bottom_view_apart) ** 2 + np.tile(1.0 - good[v], len(uv))
            height = xyz @ self.volume.up
            # what a paw stands on may look like one
            low = np.maximum(
                self.substrate - MOVEMENT.bottom_view_sunk * self.paw_width - height, 0.0
            )
            cost += 0.5 * (low / (MOVEMENT.bottom_view_sunk_sd * self.paw_width)) ** 2
            cost[(away > MOVEMENT.bottom_view_apart) | ~self.volume.holds(xyz)] = np.inf
            heights.append(height.reshape(pair.shape[:2]))
            price.append(cost.reshape(pair.shape[:2]))
        return np.concatenate(heights, axis=1), np.concatenate(price, axis=1)

    def to_space(
        self, flat: FloatArray, observations: Observations, acceleration: float
    ) -> FloatArray:
        """Give paths on the plane their heights.

        Parameters
        ----------
        flat : ndarray, shape (n, P, 3)
            Places on the plane, NaN where occluded.
        observations : Observations
            What every view shows.
        acceleration : float
            Standard deviation of the acceleration of a paw, length per frame squared.

        Returns
        -------
        ndarray, shape (n, P, 3)
            Places in space, NaN where occluded. Where no view tells the height it is
            interpolated, and where none ever does it is that of the ground.
        """
        uv = dlt.project(self.coefs[:, [self.view]], flat)[..., 0, :]
        lifted = np.full_like(flat, np.nan)
        for p in range(flat.shape[1]):
            seen = np.flatnonzero(np.isfinite(uv[:, p, 0]))
            choices = {t: self._told(uv[t, p], t, p, observations) for t in seen.tolist()}
            known = _likeliest(
                choices, max(2.0 * acceleration, MOVEMENT.bottom_view_height_sd * self.paw_width)
            )
            at = np.array(sorted(known), int)
            height = np.full(len(seen), self.substrate)
            if known:
                height = np.interp(seen, at, [known[t] for t in at.tolist()])
            lifted[seen, p] = self.on_plane(uv[seen, p], height)
        return lifted

    def _told(
        self, uv: FloatArray, t: int, point: int, observations: Observations
    ) -> tuple[FloatArray, FloatArray]:
        """Return the heights that views tell of one place, and what each costs."""
        there = observations.is_there[t]
        # all spots are moved alike
        shift = (observations.at[t, point, self.view] - observations.raw[t, self.view])[
            there[self.view]
        ]
        moved = uv + shift.mean(axis=0) if len(shift) else uv
        heights, price = self.heights(
            moved[None],
            [observations.at[t, point, v, there[v]] for v in range(len(there))],
            [observations.detection_probability[t, v, there[v]] for v in range(len(there))],
        )
        return heights[0], price[0]


def _likeliest(
    choices: Mapping[int, tuple[np.ndarray, np.ndarray]], speed: float
) -> dict[int, float]:
    """Return the likeliest course of a height: frame to height, some frames left out.

    ``choices`` has the heights of each frame and what each costs; ``speed`` is the standard
    deviation of a change from frame to frame.
    """
    ends: dict[int, tuple[np.ndarray, np.ndarray, list[tuple[int, int] | None]]] = {}
    lowest: tuple[float, tuple[int, int] | None] = (0.0, None)
    for t in sorted(choices):
        height, price = choices[t]
        good = np.flatnonzero(price < MOVEMENT.bottom_view_reward)
        if not len(good):
            continue
        total, before = (
            np.full(len(good), lowest[0] + MOVEMENT.bottom_view_new),
            [lowest[1]] * len(good),
        )
        for earlier in range(max(t - MOVEMENT.bottom_view_gap, min(ends, default=t)), t):
            if earlier not in ends:
                continue
            past, cost, _ = ends[earlier]
            step = (height[good][:, None] - past) / (speed * np.sqrt(t - earlier))
            chained = cost + 0.5 * np.minimum(
                step**2, MOVEMENT.bottom_view_step_most * MOVEMENT.bottom_view_new
            )
            best = chained.argmin(axis=1)
            for i, j in enumerate(best.tolist()):
                if chained[i, j] < total[i]:
                    total[i], before[i] = chained[i, j], (earlier, j)
        total = total + price[good] - MOVEMENT.bottom_view_reward
        ends[t] = (height[good], total, before)
        i = int(total.argmin())
        if total[i] < lowest[0]:
            lowest = (float(total[i]), (t, i))
    course: dict[int, float] = {}
    at = lowest[1]
    while at is not None:
        heights, _, links = ends[at[0]]
        course[at[0]] = float(heights[at[1]])
        at = links[at[1]]
    return course


def find_bottom_view(
    jacobian: FloatArray, up: FloatArray, here: Sequence[Placement], *, n_points: int
) -> int | None:
    """Return the view that leads, or None.

    Parameters
    ----------
    jacobian : ndarray, shape (V, 2, 3)
        Of the views, at the animal.
    up : ndarray, shape (3,)
        Unit vector.
    here : sequence of Placement
        What was placed in one frame.
    n_points : int
        Number of points; the view must have shown every one of them.

    Returns
    -------
    int or None
        Number of the view.
    """
    observation = np.cross(jacobian[:, 0], jacobian[:, 1])
    upright = np.abs(observation @ up) / np.maximum(np.linalg.norm(observation, axis=1), 1e-12)
    for v in np.argsort(-upright).tolist():
        placed = {place.point for place in here if place.view == v}
        if (
            len(jacobian) > 1
            and upright[v] > MOVEMENT.bottom_view_upright
            and len(placed) == n_points
        ):
            return int(v)
    return None
