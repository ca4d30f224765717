"""How the views stand about the animal, and all that this alone decides.

Views are one picture by itself (:class:`.views.SingleView`, :class:`.views.SingleViewFromBelow`),
several from the side (:class:`.views.SideViews`) or several of which one from below leads
(:class:`.bottom_view.BottomView`). What differs between them is a method here: the other stages
ask the geometry and need not know which one it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.association.network_flow.priors.lateral_prior import LateralPrior
from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses
from pawnb.core.paws.offline.detection.colour.detections import InFrames, InViews
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.projection import Projection

Anchors = Mapping[int, Mapping[int, np.ndarray]]
"""Frame to point number to position, certain."""


class Geometry(Protocol):
    """The views and the size of a paw in them."""

    @property
    def projection(self) -> Projection:
        """From positions to pictures."""
        ...

    @property
    def paw_width(self) -> float:
        """Width of a paw, in the unit of positions."""
        ...

    @property
    def paw_width_px(self) -> FloatArray:
        """The same in each view (V,), px."""
        ...

    @property
    def limb_direction(self) -> Sequence[tuple[float, float]]:
        """Direction in each picture in which limbs tend to end."""
        ...

    @property
    def points_meet(self) -> bool:
        """Whether points meet on their paths that do not meet in space."""
        ...

    @property
    def from_below(self) -> BoolArray:
        """Which views (V,) are from below: they show middles of paws, the others ends of limbs."""
        ...

    @property
    def across(self) -> FloatArray:
        """Unit vector (d,) to the side of the animal; 0 where positions do not tell it."""
        ...

    @property
    def depth_axis(self) -> FloatArray:
        """Unit vector (d,) to the side where places have a depth; 0 where they have none."""
        ...

    @property
    def least_observed(self) -> float:
        """Share of frames in which an unlabelled target must be seen as a paw of its own."""
        ...

    def away_from_cameras(self, middle: FloatArray) -> float:
        """Return the sign of ``depth_axis`` that leads away from all cameras; 0 if none does."""
        ...

    def is_other_side(self, offset: FloatArray, least: float) -> BoolArray:
        """Tell which offsets (n,) along ``depth_axis`` are at another side than the clicks.

        Without a depth nothing speaks against it.
        """
        ...

    def misplacement(self, x: FloatArray, since: Anchors, *, body: FloatArray, point: int) -> float:
        """Return how far places are from being on the side where a point was clicked.

        Parameters
        ----------
        x, body : ndarray, shape (n, d)
            Places, NaN where occluded, and the middle of the body.
        since : mapping
            Of the frames with clicks, each point's distance from the body there, (d,).
        point : int
            Which point.

        Returns
        -------
        float
            The less the better; of places of two points it tells which is the clicked one.
        """
        ...

    def axes(self, up: FloatArray, forward: FloatArray) -> FloatArray:
        """Return the axes (d, d) of movement: forward, across (in space only) and up."""
        ...

    def lowest(self, height: FloatArray) -> float:
        """Return the height of what paws stand on, of heights of clicks."""
        ...

    def hypotheses(
        self,
        found: InFrames,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return where paws may be in every frame, from the detections of its views.

        Parameters
        ----------
        found : sequence of sequence of Detections
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
        ...

    def learn_score(
        self,
        likelihood: AppearanceLikelihood,
        clicks: FloatArray,
        found: Mapping[int, InViews],
    ) -> AppearanceLikelihood:
        """Learn what score detections of clicks have, where that is of use.

        Parameters
        ----------
        likelihood : AppearanceLikelihood
            How much a detection looks like a paw, by the plain rule.
        clicks : ndarray, shape (frames, P, V, 2)
            Clicks, NaN where there is none, in the order of ``found``.
        found : mapping
            Clicked frame to the detections of every view.

        Returns
        -------
        AppearanceLikelihood
            With the score, or as it was.
        """
        ...

    def anchors_of_paths(
        self,
        here: Mapping[int, AnyArray],
        found: InViews,
        observations: Observations,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> dict[int, AnyArray]:
        """Return where paths of placed points pass in one frame.

        Parameters
        ----------
        here : mapping
            Point number to position, certain.
        found : sequence of Detections
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
        ...

    def tracked_points(
        self, places: AnyArray, observations: Observations, *, acceleration: float
    ) -> AnyArray:
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
        ...

    def observed_elsewhere(
        self,
        frame: IntArray,
        at: FloatArray,
        found: InFrames,
        *,
        tracked_in_view: BoolArray,
        likelihood: AppearanceLikelihood,
    ) -> FloatArray:
        """Return to what share places are seen by other views than those of a point.

        Parameters
        ----------
        frame : ndarray of int, shape (k,)
            Frame of each place.
        at : ndarray, shape (k, d)
            The places.
        found : sequence of sequence of Detections
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
        ...

    def appearance_cost(self, total: AnyArray) -> AnyArray:
        """Return what appearance counts against tracklets, of the costs of their places."""
        ...

    def as_high(self, at: FloatArray, expected: FloatArray) -> FloatArray:
        """Return places (n, d) of paths, as high as expected ones where paths have no height."""
        ...

    def lateral_prior(
        self, chosen: FloatArray, body: FloatArray, *, body_scale: float
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
        ...


def lateral_offset(
    x: FloatArray, anchors: Anchors, *, body: FloatArray, point: int, across: FloatArray
) -> FloatArray:
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
