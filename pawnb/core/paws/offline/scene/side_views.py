"""Several views from the side: places are where detections of two of them meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pawnb.core import dlt
from pawnb.core.paws.offline.association.network_flow.lateral_prior import (
    LateralPrior,
    learn_lateral_prior,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import (
    PointHypotheses,
    StereoMatcher,
)
from pawnb.core.paws.offline.detection.colour.likelihood import (
    AppearanceLikelihood,
    score_at_clicks,
)
from pawnb.core.paws.offline.scene.geometry import InSpace
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL


@dataclass(frozen=True)
class SideViews(InSpace):
    """Several views from the side: places are where detections of two of them meet."""

    points_meet: ClassVar[bool] = False

    @property
    def depth_axis(self) -> np.ndarray:
        """That of the volume."""
        return self.volume.across

    def away_from_cameras(self, middle: np.ndarray) -> float:
        """Return the sign that leads away from all cameras, seen from ``middle`` (3,)."""
        signs = set()
        for coefs in self.coefs.T:
            # a projection maps its centre, in homogeneous coordinates, to nothing
            *centre, far = np.linalg.svd(dlt.to_matrix(coefs))[2][-1]
            signs.add(float(-np.sign((centre - far * middle) @ self.across * far)))
        return signs.pop() if len(signs) == 1 else 0.0

    def is_other_side(self, offset: np.ndarray, least: float) -> np.ndarray:
        """Tell which are farther than ``least`` from the clicks."""
        return np.abs(offset) > least

    @property
    def least_observed(self) -> float:
        """Less than elsewhere: depth tells that it is on the other side."""
        return TREADMILL.least_seen_aside

    def hypotheses(
        self,
        found: Sequence[Sequence[np.ndarray]],
        *,
        most: int,
        likelihood: AppearanceLikelihood,
    ) -> list[PointHypotheses]:
        """Return where detections of two views meet."""
        return self._matcher(likelihood, most).places(found)

    def learn_score(
        self,
        likelihood: AppearanceLikelihood,
        clicks: np.ndarray,
        found: Mapping[int, Sequence[np.ndarray]],
    ) -> AppearanceLikelihood:
        """Learn it: the curves were learnt from views from the side that agree in space."""
        return replace(likelihood, score=score_at_clicks(clicks, found, likelihood))

    def observed_elsewhere(
        self,
        frame: np.ndarray,
        at: np.ndarray,
        found: Sequence[Sequence[np.ndarray]],
        *,
        tracked_in_view: np.ndarray,
        likelihood: AppearanceLikelihood,
    ) -> np.ndarray:
        """Return the share of :func:`observed_elsewhere` by what each view shows at the places."""
        seen = self._matcher(likelihood, most=0).seen(frame, at, found)
        return observed_elsewhere(seen, tracked_in_view)

    def lateral_prior(
        self, chosen: np.ndarray, body: np.ndarray, *, body_scale: float
    ) -> LateralPrior | None:
        """Learn it."""
        return learn_lateral_prior(chosen, body, self.across, body_scale=body_scale)

    def _matcher(self, likelihood: AppearanceLikelihood, most: int) -> StereoMatcher:
        """Return what makes places of detections."""
        return StereoMatcher(
            self.coefs, self.volume, tolerance_px=0.8 * self.paw_width_px,
            likelihood=likelihood, apart=self.paw_width, most=most,
        )  # fmt: skip


def observed_elsewhere(seen: np.ndarray, tracked_in_view: np.ndarray) -> np.ndarray:
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
