"""Which tracklets each point took: the choice over the whole recording."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.association.network_flow.body_clutter import without_body_clutter
from pawnb.core.paws.offline.association.network_flow.contralateral import (
    assign_near_side,
    near_side_cost,
    side_cost,
)
from pawnb.core.paws.offline.association.network_flow.links import FlowCosts
from pawnb.core.paws.offline.association.network_flow.min_cost_flow import MinCostFlow
from pawnb.core.paws.offline.association.network_flow.parameters import NETWORK_FLOW
from pawnb.core.paws.offline.association.network_flow.priors.positional_prior import (
    first_positional_cost,
    follow_body,
    learn_positional_prior,
    positional_cost,
    where_kinds_are,
)
from pawnb.core.paws.offline.association.network_flow.splitting import (
    split_at_crossings,
    split_sliding,
)
from pawnb.core.paws.offline.association.network_flow.tracklets import (
    LinkingModel,
    Tracklet,
    build_tracklets,
    estimate_substrate_velocity,
    joined,
    total_costs,
)
from pawnb.core.paws.offline.association.network_flow.triangulation import PointHypotheses
from pawnb.core.paws.offline.detection.colour.detections import InFrames
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.scene.geometry import Anchors
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.scene.parameters import MOVEMENT
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.stride.cycle import Cycle


class TrackletAssociator:
    """The tracklets of a recording and the choice among them.

    Where a view leads, places lie on its plane and have no heights.

    Parameters
    ----------
    found : sequence
        Detections of every frame and view.
    anchors : mapping
        Frame to point number to position, certain.
    scene : Scene
        What the clicks say.
    fps : float
        Frames per second.
    settings : OfflineSettings
        The settings.
    kinds : sequence of str
        Kind of each point: "front", "hind" or "other". Points after the last that was
        clicked are unlabelled targets: nobody said where they are.
    likelihood : AppearanceLikelihood
        Tells how much detections look like paws.
    tracked_in_view : ndarray of bool, shape (P, V)
        Which view tracks which point.

    Attributes
    ----------
    motion_model : MotionModel
        How points move.
    body_frames : int
        Frames over which the body is followed: about two strides.
    """

    def __init__(
        self,
        found: InFrames,
        anchors: Anchors,
        scene: Scene,
        *,
        fps: float,
        settings: OfflineSettings,
        kinds: Sequence[str],
        likelihood: AppearanceLikelihood,
        tracked_in_view: BoolArray,
    ) -> None:
        self.scene, self.kinds = scene, kinds
        self.anchors = anchors
        self.shape = (len(found), len(kinds), scene.projection.n_coordinates)
        self.body_frames = max(3, round(settings.body_s * fps))
        geometry = scene.geometry
        places = geometry.hypotheses(found, most=settings.max_hypotheses, likelihood=likelihood)
        cost_limit = _take_out_anchors(places, anchors, scene.paw_width)
        self._usual = where_kinds_are(places, anchors, scene, kinds=kinds, frames=self.body_frames)
        self.motion_model = _motion_model(places, scene, fps, settings)
        noise, speed = (
            settings.noise * scene.paw_width,
            MOVEMENT.unknown_speed * self.motion_model.speed,
        )
        substrate_velocity = self.motion_model.substrate_velocity
        linking = LinkingModel(
            self.motion_model.acceleration,
            noise,
            speed,
            substrate_velocity,
            NETWORK_FLOW.linked_cost_limit,
        )
        tracklets = build_tracklets(places, linking)
        self._clicked = 1 + max(p for here in anchors.values() for p in here)
        contralateral = len(kinds) - self._clicked
        self.tracklets = self._cut(_below_cost_limit(tracklets, cost_limit), fps)
        occlusion_frame_cost = settings.occlusion_rate_cost / fps
        costs = FlowCosts(
            self.motion_model.acceleration,
            noise,
            speed,
            substrate_velocity,
            settings.occlusion_onset_cost,
            occlusion_frame_cost,
            max(4, round(settings.max_occlusion_s * fps)),
            settings.max_successors,
        )
        self._occlusion_frame_cost = occlusion_frame_cost
        self._elsewhere = np.zeros((len(kinds), len(self.tracklets)))
        if self.tracklets:
            frame, at, begins = joined(self.tracklets)
            elsewhere = geometry.observed_elsewhere(
                frame, at, found, tracked_in_view=tracked_in_view, likelihood=likelihood
            )
            cost = NETWORK_FLOW.tracklet_association_elsewhere * occlusion_frame_cost * elsewhere
            self._elsewhere = np.add.reduceat(cost, begins, axis=1)
        self._flow = MinCostFlow(
            self.tracklets, anchors, len(found), costs, contralateral=contralateral
        )

    def _cut(self, tracklets: list[Tracklet], fps: float) -> list[Tracklet]:
        """Return tracklets that lead through no meeting, without those that belong to the body."""
        paw_width, substrate_velocity = self.scene.paw_width, self.motion_model.substrate_velocity
        if self.scene.geometry.points_meet or self._clicked < len(self.kinds):
            # in one picture points meet that do not meet in space
            tracklets = split_at_crossings(
                tracklets, NETWORK_FLOW.tracklet_association_meeting * paw_width
            )
        tracklets = split_sliding(
            tracklets,
            substrate_velocity=substrate_velocity,
            axes=self.motion_model.axes[[0, -1]],
            paw_width=paw_width,
            frames=max(3, round(NETWORK_FLOW.stood_s * fps)),
        )
        return without_body_clutter(tracklets, substrate_velocity, paw_width=paw_width)

    def doubting(self, hopped: BoolArray) -> TrackletAssociator:
        """Return a choice in which points pay for where a choice before put them by mistake.

        Parameters
        ----------
        hopped : ndarray of bool, shape (n, P)
            Frames in which each point was where no swing leads.

        Returns
        -------
        TrackletAssociator
            Of the same tracklets.
        """
        other = copy.copy(self)
        if self.tracklets:
            frame, _, begins = joined(self.tracklets)
            cost = NETWORK_FLOW.hopped * self._occlusion_frame_cost * hopped[frame].T
            other._elsewhere = self._elsewhere + np.add.reduceat(cost, begins, axis=1)
        return other

    def first(self) -> FloatArray:
        """Choose by the clicks, then by where points usually are.

        Returns
        -------
        ndarray, shape (n, P, d)
            The chosen places, NaN where occluded.
        """
        start = first_positional_cost(self.tracklets, self._usual, self.anchors, scene=self.scene)
        nowhere = np.zeros((self.shape[0], self.shape[2]))
        start += near_side_cost(
            self.tracklets, self.anchors, self.scene, body=nowhere, kinds=self.kinds
        )
        x = self._choose(start)
        axes = list(self.motion_model.axes[:2])
        groups = [self.kinds, [str(p) for p in range(self.shape[1])]][: len(axes)]
        for _ in range(NETWORK_FLOW.tracklet_association_looks):
            body, body_scale = self.body(x), self.scene.body_scale
            positional_prior = learn_positional_prior(
                x, body, axes=axes, groups=groups, body_scale=body_scale
            )
            prior = positional_cost(
                self.tracklets,
                body,
                axes=axes,
                positional_prior=positional_prior,
                body_scale=body_scale,
            )
            # a prior learnt while near and far paws changed places would keep them so
            side = side_cost(self.tracklets, self.anchors, self.scene, body=body, kinds=self.kinds)
            x = self._choose(NETWORK_FLOW.tracklet_association_habit * prior + side)
        if self._clicked == len(self.kinds):
            return x
        return assign_near_side(
            x, self.anchors, self.scene, body=self.body(x), kinds=self.kinds, clicked=self._clicked
        )

    def again(self, cycle: Cycle) -> FloatArray:
        """Choose by where each point is expected at each moment of the stride.

        Returns
        -------
        ndarray, shape (n, P, d)
            The chosen places, NaN where occluded.
        """
        if not self.tracklets:
            return self._choose(None)
        frame, at, first = joined(self.tracklets)
        as_high = self.scene.geometry.as_high
        square = np.stack(
            [cycle.square(frame, p, as_high(at, cycle.mean[frame, p]))
             for p in range(self.shape[1])]
        )  # fmt: skip
        cost = NETWORK_FLOW.tracklet_association_expected * np.minimum(
            square, NETWORK_FLOW.tracklet_association_farthest
        )
        return self._choose(np.add.reduceat(cost, first, axis=1))

    def body(self, x: FloatArray) -> FloatArray:
        """Return the slowly moving middle (n, d) of tracks (n, P, d) with NaN where occluded."""
        return follow_body(x, self.body_frames)

    def _choose(self, prior: FloatArray | None) -> FloatArray:
        """Return where the cheapest chains of tracklets go."""
        x = np.full(self.shape, np.nan)
        look = self.scene.geometry.appearance_cost(total_costs(self.tracklets))
        total = look + (0.0 if prior is None else prior) + self._elsewhere
        for p, chain in enumerate(self._flow.assign(total)):
            for i in chain:
                x[self.tracklets[i].first : self.tracklets[i].last + 1, p] = self.tracklets[i].at
        for t, here in self.anchors.items():
            for p, at in here.items():
                x[t, p] = at
        return x


def _take_out_anchors(places: list[PointHypotheses], anchors: Anchors, paw_width: float) -> float:
    """Take out of ``places`` what is where points were placed; return what a place may cost."""
    cost_limit = NETWORK_FLOW.tracklet_association_cost_limits[0]
    for t, here in anchors.items():
        cost_limit = max(
            cost_limit,
            _highest_click_cost(places[t], here, paw_width)
            + NETWORK_FLOW.tracklet_association_worse,
        )
        away = places[t].distance(np.stack(list(here.values())))
        free = away > NETWORK_FLOW.click_alone * paw_width
        if t == 0:
            free[:] = False
        places[t] = places[t].take(free)
    return cost_limit


def _below_cost_limit(tracklets: Sequence[Tracklet], cost_limit: float) -> list[Tracklet]:
    """Return the tracklets whose places cost less than they may on average."""
    most = min(cost_limit, NETWORK_FLOW.tracklet_association_cost_limits[1])
    return [
        tracklet
        for tracklet, cost in zip(tracklets, total_costs(tracklets), strict=True)
        if cost / len(tracklet.detection_indices)
        < (most if len(tracklet.detection_indices) > 1 else NETWORK_FLOW.single_cost_limit)
    ]


def _highest_click_cost(
    places: PointHypotheses, here: Mapping[int, FloatArray], paw_width: float
) -> float:
    """Return the largest cost of the places where points were put by hand, 0 without any."""
    away = np.linalg.norm(places.at[:, None] - np.stack(list(here.values())), axis=-1)
    if not len(away):
        return 0.0
    cost = places.cost[away.argmin(axis=0)]
    return float(cost[away.min(axis=0) < 0.5 * paw_width].max(initial=0.0))


def _motion_model(
    places: Sequence[PointHypotheses], scene: Scene, fps: float, settings: OfflineSettings
) -> MotionModel:
    """Return how points move."""
    speed = MOVEMENT.fastest * scene.body_scale / fps
    substrate_velocity = estimate_substrate_velocity(
        places,
        within=NETWORK_FLOW.ground_within * scene.paw_width,
        longest=NETWORK_FLOW.ground_fastest * speed,
        lag=max(1, round(NETWORK_FLOW.stood_s * fps)),
    )
    clicks = np.stack([x for here in scene.anchors.values() for x in here.values()])
    return MotionModel(
        settings.acceleration * scene.body_scale / fps**2,
        settings.jerk * scene.body_scale / fps**3,
        speed,
        substrate_velocity,
        scene.geometry.axes(scene.up, scene.forward),
        scene.geometry.lowest(clicks @ scene.up),
        scene.body_scale,
        scene.paw_width,
    )
