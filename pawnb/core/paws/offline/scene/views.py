"""One view by itself, from the side or from below, and several views from the side."""

# ruff: noqa: ARG002  (geometries are asked alike, and not each needs all that it is told)

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core import dlt
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.priors.lateral_prior import (
    LateralPrior,
    learn_lateral_prior,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import (
    PointHypotheses,
    StereoMatcher,
    Volume,
)
from pawnb.core.paws.offline.detection.colour.detections import InFrames, InViews
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour.likelihood import (
    AppearanceLikelihood,
    score_at_clicks,
)
from pawnb.core.paws.offline.detection.colour.observations import Observations, tracked_points
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.geometry import Anchors, lateral_offset
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL


@dataclass(frozen=True)
class _Views(ABC):
    """What geometries have in common, and do where their views tell no depth.

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

    @property
    def from_below(self) -> BoolArray:
        """None is."""
        return np.zeros(len(self.paw_width_px), bool)

    @property
    @abstractmethod
    def across(self) -> np.ndarray:
        """Unit vector to the side."""

    @property
    def depth_axis(self) -> FloatArray:
        """There is none."""
        return np.zeros_like(self.across)

    @property
    def least_observed(self) -> float:
        """Nothing but how often it is seen tells an unlabelled target."""
        return TREADMILL.least_seen

    def away_from_cameras(self, middle: FloatArray) -> float:
        """Return that no side does."""
        return 0.0

    def is_other_side(self, offset: FloatArray, least: float) -> BoolArray:
        """Tell that all may be."""
        return np.ones(offset.shape, bool)

    @abstractmethod
    def hypotheses(
        self,
        found: InFrames,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return where paws may be."""

    def lowest(self, height: FloatArray) -> float:
        """Return the height of the lowest click."""
        return float(height.min())

    def learn_score(
        self,
        likelihood: AppearanceLikelihood,
        clicks: FloatArray,
        found: Mapping[int, InViews],
    ) -> AppearanceLikelihood:
        """Return it as it was: the curves were learnt from views that agree in space."""
        return likelihood

    def anchors_of_paths(
        self,
        here: Mapping[int, FloatArray],
        found: InViews,
        observations: Observations,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> dict[int, FloatArray]:
        """Return where the detections of placed points meet.

        A click in the middle of a long foot is farther from its end than paws are apart. Of the
        places that say that the point is where it was placed, its toes and its heel, the one that
        looks best is taken; without any, the point itself.
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
        self, places: FloatArray, observations: Observations, *, acceleration: float
    ) -> FloatArray:
        """Return where the detections of all views have the points."""
        return self._said(places, observations)

    def _said(self, places: FloatArray, observations: Observations) -> FloatArray:
        """Return where the points are of places by the detections of all views."""
        return tracked_points(
            places, observations, geometry=self.projection, paw_width_px=self.paw_width_px
        )

    def observed_elsewhere(
        self,
        frame: IntArray,
        at: FloatArray,
        found: InFrames,
        *,
        tracked_in_view: BoolArray,
        likelihood: AppearanceLikelihood,
    ) -> FloatArray:
        """Return that none are: one view alone makes the places."""
        return np.zeros((len(tracked_in_view), len(at)))

    def appearance_cost(self, total: FloatArray) -> FloatArray:
        """Return that the appearance of places counts as they are linked, and not once more."""
        return np.zeros_like(total)

    def as_high(self, at: FloatArray, expected: FloatArray) -> FloatArray:
        """Return them as they are."""
        return at

    def lateral_prior(
        self, chosen: FloatArray, body: FloatArray, *, body_scale: float
    ) -> LateralPrior | None:
        """Return that nothing is known to the side."""
        return None


@dataclass(frozen=True)
class SingleView(_Views):
    """One view by itself, from the side: positions are its pixels.

    Parameters
    ----------
    up : ndarray, shape (2,)
        Unit vector in the picture.
    """

    up: FloatArray

    @property
    def across(self) -> FloatArray:
        """One picture from the side does not tell it."""
        return np.zeros_like(self.up)

    def misplacement(self, x: FloatArray, since: Anchors, *, body: FloatArray, point: int) -> float:
        """Return how high places are: clicks are on the near side, lower in the picture."""
        return float(np.nanmedian(x @ self.up))

    def axes(self, up: FloatArray, forward: FloatArray) -> FloatArray:
        """Return forward and up."""
        return np.stack([forward, up])

    def hypotheses(
        self,
        found: InFrames,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return the detections of the view as places."""
        return [
            PointHypotheses(
                here.uv.astype(float),
                NETWORK_FLOW.unlike * (1.0 - endpoint_score(here, self.limb_direction[0])),
            )
            for (here,) in found
        ]


@dataclass(frozen=True)
class SingleViewFromBelow(SingleView):
    """One view by itself, from below: up in its picture is to one side; nothing has a height."""

    @property
    def from_below(self) -> BoolArray:
        """The view is."""
        return np.ones(1, bool)

    @property
    def across(self) -> FloatArray:
        """Up in the picture."""
        return self.up

    def lowest(self, height: FloatArray) -> float:
        """Return that nothing is known."""
        return -np.inf


@dataclass(frozen=True)
class InSpace(_Views):
    """Calibrated views.

    Parameters
    ----------
    volume : Volume
        Where paws can be.
    """

    volume: Volume

    @property
    def across(self) -> FloatArray:
        """That of the volume."""
        return self.volume.across

    @property
    def coefs(self) -> FloatArray:
        """DLT coefficients (11, V)."""
        return self.projection.table

    def misplacement(self, x: FloatArray, since: Anchors, *, body: FloatArray, point: int) -> float:
        """Return how far to the side of its clicks a point is."""
        away = lateral_offset(x, since, body=body, point=point, across=self.across)
        return float(np.abs(np.nanmedian(away)))

    def axes(self, up: FloatArray, forward: FloatArray) -> FloatArray:
        """Return forward, across and up."""
        return np.stack([forward, np.cross(up, forward), up])


@dataclass(frozen=True)
class SideViews(InSpace):
    """Several views from the side: places are where detections of two of them meet."""

    points_meet: ClassVar[bool] = False

    @property
    def depth_axis(self) -> FloatArray:
        """That of the volume."""
        return self.volume.across

    def away_from_cameras(self, middle: FloatArray) -> float:
        """Return the sign that leads away from all cameras, seen from ``middle`` (3,)."""
        signs = set()
        for coefs in self.coefs.T:
            # a projection maps its centre, in homogeneous coordinates, to nothing
            *centre, far = np.linalg.svd(dlt.to_matrix(coefs))[2][-1]
            signs.add(float(-np.sign((centre - far * middle) @ self.across * far)))
        return signs.pop() if len(signs) == 1 else 0.0

    def is_other_side(self, offset: FloatArray, least: float) -> BoolArray:
        """Tell which are farther than ``least`` from the clicks."""
        return np.abs(offset) > least

    @property
    def least_observed(self) -> float:
        """Less than elsewhere: depth tells that it is on the other side."""
        return TREADMILL.least_seen_aside

    def hypotheses(
        self,
        found: InFrames,
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return where detections of two views meet."""
        return self._matcher(likelihood, most).places(found)

    def learn_score(
        self,
        likelihood: AppearanceLikelihood,
        clicks: FloatArray,
        found: Mapping[int, InViews],
    ) -> AppearanceLikelihood:
        """Learn it: the curves were learnt from views from the side that agree in space."""
        return replace(likelihood, score=score_at_clicks(clicks, found, likelihood))

    def observed_elsewhere(
        self,
        frame: IntArray,
        at: FloatArray,
        found: InFrames,
        *,
        tracked_in_view: BoolArray,
        likelihood: AppearanceLikelihood,
    ) -> FloatArray:
        """Return the share of :func:`observed_elsewhere` by what each view shows at the places."""
        seen = self._matcher(likelihood, most=0).seen(frame, at, found)
        return observed_elsewhere(seen, tracked_in_view)

    def lateral_prior(
        self, chosen: FloatArray, body: FloatArray, *, body_scale: float
    ) -> LateralPrior | None:
        """Learn it."""
        return learn_lateral_prior(chosen, body, self.across, body_scale=body_scale)

    def _matcher(self, likelihood: AppearanceLikelihood, most: int) -> StereoMatcher:
        """Return what makes places of detections."""
        return StereoMatcher(
            self.coefs, self.volume, tolerance_px=NETWORK_FLOW.tolerance * self.paw_width_px,
            likelihood=likelihood, apart=self.paw_width, most=most,
        )  # fmt: skip


def observed_elsewhere(seen: FloatArray, tracked_in_view: BoolArray) -> FloatArray:
    """Return to what share places are seen by other views than those that track a point.

    Two views make a place, and any two do. But where a view that tracks the point shows
    nothing, and one that tracks others does, it is likelier one of those: a paw that is occluded
    leaves its point free to follow the paw of the other side.

    Parameters
    ----------
    seen : ndarray, shape (k, V)
        How much each view shows a paw there, 0 to 1.
    tracked_in_view : ndarray of bool, shape (P, V)
        Which view tracks which point.

    Returns
    -------
    ndarray, shape (P, k)
        From 0, seen as well by its own views as by all, to 1, by others alone. Two views are
        enough; where one tracks the point, that one.
    """
    most = np.minimum(tracked_in_view.sum(axis=1), 2.0)[:, None]
    missed = np.maximum(most - tracked_in_view @ seen.T, 0.0)
    missed = missed - np.maximum(most - seen.sum(axis=1), 0.0)
    return np.asarray(missed / np.maximum(most, 1.0))
