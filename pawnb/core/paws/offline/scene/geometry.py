"""How the views stand about the animal, and all that this alone decides.

Views are one picture by itself (:class:`SingleView`, :class:`SingleViewFromBelow`), several from
the side (:class:`.side_views.SideViews`) or several of which one from below leads
(:class:`.bottom_view.BottomView`). What differs between them is a method here: the other rooms
ask the geometry and need not know which one it is.
"""

# ruff: noqa: ARG002  (geometries are asked alike, and not each needs all that it is told)

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pawnb.core.paws.offline.association.network_flow.lateral_prior import (
    LateralPrior,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import (
    PointHypotheses,
    Volume,
)
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour.likelihood import (
    AppearanceLikelihood,
)
from pawnb.core.paws.offline.detection.colour.observations import Observations, tracked_points
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL

Anchors = Mapping[int, Mapping[int, np.ndarray]]
"""Frame to point number to position, certain."""


@dataclass(frozen=True)
class Geometry(ABC):
    """The views and the size of a paw in them.

    Parameters
    ----------
    projection : Projection
        From positions to pictures.
    paw_width : float
        Width of a paw, in the unit of positions.
    paw_width_px : ndarray, shape (V,)
        The same in each view, px.
    limb_direction : sequence of (float, float)
        Direction in each picture in which limbs tend to end.
    """

    projection: Projection
    paw_width: float
    paw_width_px: np.ndarray
    limb_direction: Sequence[tuple[float, float]]

    points_meet: ClassVar[bool] = True
    """Whether points meet on their paths that do not meet in space."""

    @property
    def from_below(self) -> np.ndarray:
        """Which views (V,) are from below: they show middles of paws, the others ends of limbs."""
        return np.zeros(len(self.paw_width_px), bool)

    @property
    @abstractmethod
    def across(self) -> np.ndarray:
        """Unit vector (d,) to the side of the animal; 0 where positions do not tell it."""

    @property
    def depth_axis(self) -> np.ndarray:
        """Unit vector (d,) to the side where places have a depth; 0 where they have none."""
        return np.zeros_like(self.across)

    def away_from_cameras(self, middle: np.ndarray) -> float:
        """Return the sign of ``depth_axis`` that leads away from all cameras; 0 if none does."""
        return 0.0

    def is_other_side(self, offset: np.ndarray, least: float) -> np.ndarray:
        """Tell which offsets (n,) along ``depth_axis`` are at another side than the clicks.

        Without a depth nothing speaks against it.
        """
        return np.ones(offset.shape, bool)

    @property
    def least_observed(self) -> float:
        """Share of frames in which an unlabelled target must be seen as a paw of its own."""
        return TREADMILL.least_seen

    @abstractmethod
    def misplacement(self, x: np.ndarray, since: Anchors, *, body: np.ndarray, point: int) -> float:
        """Return how little places (n, d) are where a point was clicked, see `lateral_offset`."""

    @abstractmethod
    def axes(self, up: np.ndarray, forward: np.ndarray) -> np.ndarray:
        """Return the axes (d, d) of movement: forward, across (in space only) and up."""

    def lowest(self, height: np.ndarray) -> float:
        """Return the height of what paws stand on, of heights of clicks."""
        return float(height.min())

    @abstractmethod
    def hypotheses(
        self,
        found: Sequence[Sequence[np.ndarray]],
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return where paws may be in every frame, from the detections of its views.

        Parameters
        ----------
        found : sequence of sequence of ndarray
            For each frame, the detections of each view.
        most : int
            Hypotheses kept in a frame of several views.
        likelihood : AppearanceLikelihood
            How much a detection looks like a paw.

        Returns
        -------
        list of PointHypotheses
            Those of each frame.
        """

    def learn_score(
        self,
        likelihood: AppearanceLikelihood,
        clicks: np.ndarray,
        found: Mapping[int, Sequence[np.ndarray]],
    ) -> AppearanceLikelihood:
        """Return the likelihood with what detections of clicks say, where that is of use."""
        return likelihood

    def anchors_of_paths(
        self,
        here: Mapping[int, np.ndarray],
        found: Sequence[np.ndarray],
        observations: Observations,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> dict[int, np.ndarray]:
        """Return where the detections of placed points meet, in one frame: paths go through there.

        A click in the middle of a long foot is farther from its end than paws are apart. Of the
        places that say that the point is where it was placed, its toes and its heel, the one that
        looks best is taken; without any, the point itself.

        Parameters
        ----------
        here : mapping
            Point number to position, certain.
        found : sequence of ndarray
            Detections of each view in that frame.
        observations : Observations
            What they say, of that frame alone.
        most : int
            As for :meth:`hypotheses`.
        likelihood : AppearanceLikelihood
            The same.

        Returns
        -------
        dict
            Point number to place.
        """
        places = self.hypotheses([found], most=most, likelihood=likelihood)[0]
        n_points = observations.at.shape[1]
        meet = dict(here)
        price = dict.fromkeys(here, np.inf)
        for place, cost in zip(places.at, places.cost, strict=True):
            said = self._said(np.tile(place, (1, n_points, 1)), observations)[0]
            for p, at in here.items():
                away = float(np.linalg.norm(said[p] - at)) / self.paw_width
                if away < TREADMILL.pipeline_same and cost + away < price[p]:
                    meet[p], price[p] = place, cost + away
        return meet

    def tracked_points(
        self, places: np.ndarray, observations: Observations, *, acceleration: float
    ) -> np.ndarray:
        """Return where the tracked points are of chosen places.

        Parameters
        ----------
        places : ndarray, shape (n, P, d)
            Places where detections meet, NaN where occluded.
        observations : Observations
            What every view shows.
        acceleration : float
            Standard deviation of the acceleration of a paw, length per frame squared.

        Returns
        -------
        ndarray, shape (n, P, d)
            Positions, NaN where occluded.
        """
        return self._said(places, observations)

    def _said(self, places: np.ndarray, observations: Observations) -> np.ndarray:
        """Return where the points are of places by the detections of all views."""
        return tracked_points(
            places, observations, geometry=self.projection, paw_width_px=self.paw_width_px
        )

    def observed_elsewhere(
        self,
        frame: np.ndarray,
        at: np.ndarray,
        found: Sequence[Sequence[np.ndarray]],
        *,
        tracked_in_view: np.ndarray,
        likelihood: AppearanceLikelihood,
    ) -> np.ndarray:
        """Return to what share (P, k) places are seen by other views than those of a point.

        Parameters
        ----------
        frame : ndarray of int, shape (k,)
            Frame of each place.
        at : ndarray, shape (k, d)
            The places.
        found : sequence of sequence of ndarray
            For each frame, the detections of each view.
        tracked_in_view : ndarray of bool, shape (P, V)
            Which view tracks which point.
        likelihood : AppearanceLikelihood
            How much a detection looks like a paw.

        Returns
        -------
        ndarray, shape (P, k)
            From 0 to 1; 0 where one view alone makes the places.
        """
        return np.zeros((len(tracked_in_view), len(at)))

    def appearance_cost(self, total: np.ndarray) -> np.ndarray:
        """Return what the look of tracklets counts against them, of the costs of their places."""
        return np.zeros_like(total)

    def as_high(self, at: np.ndarray, expected: np.ndarray) -> np.ndarray:
        """Return places (n, d) of paths, as high as expected ones where paths have no height."""
        return at

    def lateral_prior(
        self, chosen: np.ndarray, body: np.ndarray, *, body_scale: float
    ) -> LateralPrior | None:
        """Return where points usually are to the side, where a depth tells it.

        Parameters
        ----------
        chosen : ndarray, shape (n, P, d)
            Chosen places, NaN where occluded.
        body : ndarray, shape (n, d)
            The slowly moving middle of the body.
        body_scale : float
            Distance of front from hind paws.

        Returns
        -------
        LateralPrior or None
            The prior; None without a depth.
        """
        return None


@dataclass(frozen=True)
class SingleView(Geometry):
    """One view by itself, from the side: positions are its pixels.

    Parameters
    ----------
    up : ndarray, shape (2,)
        Unit vector in the picture.
    """

    up: np.ndarray

    @property
    def across(self) -> np.ndarray:
        """One picture from the side does not tell it."""
        return np.zeros_like(self.up)

    def misplacement(self, x: np.ndarray, since: Anchors, *, body: np.ndarray, point: int) -> float:
        """Return how high places are: clicks are on the near side, lower in the picture."""
        return float(np.nanmedian(x @ self.up))

    def axes(self, up: np.ndarray, forward: np.ndarray) -> np.ndarray:
        """Return forward and up."""
        return np.stack([forward, up])

    def hypotheses(
        self,
        found: Sequence[Sequence[np.ndarray]],
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return the detections of the view as places."""
        return [
            PointHypotheses(
                rows[0][:, :2].astype(float),
                1.5 * (1.0 - endpoint_score(rows[0], self.limb_direction[0])),
            )
            for rows in found
        ]


@dataclass(frozen=True)
class SingleViewFromBelow(SingleView):
    """One view by itself, from below: up in its picture is to one side; nothing has a height."""

    @property
    def from_below(self) -> np.ndarray:
        """The view is."""
        return np.ones(1, bool)

    @property
    def across(self) -> np.ndarray:
        """Up in the picture."""
        return self.up

    def lowest(self, height: np.ndarray) -> float:
        """Return that nothing is known."""
        return -np.inf


@dataclass(frozen=True)
class InSpace(Geometry):
    """Calibrated views.

    Parameters
    ----------
    volume : Volume
        Where paws can be.
    """

    volume: Volume

    @property
    def across(self) -> np.ndarray:
        """That of the volume."""
        return self.volume.across

    @property
    def coefs(self) -> np.ndarray:
        """DLT coefficients (11, V)."""
        return self.projection.table

    def misplacement(self, x: np.ndarray, since: Anchors, *, body: np.ndarray, point: int) -> float:
        """Return how far to the side of its clicks a point is."""
        away = lateral_offset(x, since, body=body, point=point, across=self.across)
        return float(np.abs(np.nanmedian(away)))

    def axes(self, up: np.ndarray, forward: np.ndarray) -> np.ndarray:
        """Return forward, across and up."""
        return np.stack([forward, np.cross(up, forward), up])


def lateral_offset(
    x: np.ndarray, anchors: Anchors, *, body: np.ndarray, point: int, across: np.ndarray
) -> np.ndarray:
    """Return how far to the side of where a point was clicked places are.

    The side of an animal moves with it: both are taken relative to the body.

    Parameters
    ----------
    x, body : ndarray, shape (n, d)
        Places, NaN where occluded, and the body in their frames.
    anchors : mapping
        Of the frames with clicks, each point's distance from the body there, (d,).
    point : int
        Which point.
    across : ndarray, shape (d,)
        Unit vector to the side.

    Returns
    -------
    ndarray, shape (n,)
        The distance, positive along ``across``, in the unit of space.
    """
    clicked = np.mean([here[point] @ across for here in anchors.values() if point in here])
    return np.asarray((x - body) @ across - clicked)
