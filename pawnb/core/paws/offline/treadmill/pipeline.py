"""Deciding over the whole recording: paths, gaps and the stride, each from the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pawnb.core.paws.layout import Layout
from pawnb.core.paws.offline.association.network_flow.contralateral import (
    lateral_axis,
    share_observed,
    with_contralateral,
)
from pawnb.core.paws.offline.association.network_flow.lateral_prior import (
    LateralPrior,
    learn_lateral_prior,
)
from pawnb.core.paws.offline.association.network_flow.tracklet_association import (
    TrackletAssociator,
    find_hypotheses,
)
from pawnb.core.paws.offline.detection.colour.label_offsets import learn_offsets
from pawnb.core.paws.offline.detection.colour.likelihood import (
    AppearanceLikelihood,
    score_at_clicks,
)
from pawnb.core.paws.offline.detection.colour.observations import (
    Observations,
    read_observations,
    tracked_points,
)
from pawnb.core.paws.offline.gap_closing.gap_closing import GapClosing, TrackingState, close_gaps
from pawnb.core.paws.offline.gap_closing.rejection import without_hops
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.scene.treadmill import Scene, unlabelled_kinds
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.smoothing.association_odds import association_log_odds
from pawnb.core.paws.offline.smoothing.forward_backward_distance import (
    forward_backward_distance,
    leave_one_out,
)
from pawnb.core.paws.offline.smoothing.refinement import (
    MeasurementModel,
    SmoothedTracks,
    deviations,
    refine,
)
from pawnb.core.paws.offline.stride.cycle import learn_cycle
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor, learn_duty_factor
from pawnb.core.paws.offline.stride.stance import learn_liftoff_velocity
from pawnb.core.paws.offline.stride.swing import Swings, learn_swings
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL


@dataclass(frozen=True)
class ReferenceAnnotations:
    """Clicks from which it is learnt where the tracked points lie on the paws.

    Parameters
    ----------
    clicks : ndarray, shape (frames, P, V, 2)
        Clicks, px, NaN where there is none, in the order of ``found``.
    found : mapping
        Clicked frame to the detections of every view.
    """

    clicks: np.ndarray
    found: Mapping[int, Sequence[np.ndarray]]


def run_pipeline(
    found: Sequence[Sequence[np.ndarray]],
    anchors: Mapping[int, Mapping[int, np.ndarray]],
    certain: np.ndarray,
    *,
    scene: Scene,
    layout: Layout,
    fps: float,
    settings: OfflineSettings,
    reference: ReferenceAnnotations | None = None,
) -> SmoothedTracks:
    """Decide where every point was in every frame.

    Where a view shows paws of the other side that nobody clicked, they are followed too, as
    unlabelled targets, lest they be taken for the points of their kind. Paths are chosen among
    certain tracklets and the gaps between them bridged; the stride is learnt from the tracks
    that this gives, and both are done again with it.

    Parameters
    ----------
    found : sequence
        Detections of every frame and view.
    anchors : mapping
        Frame to point number to position, certain.
    certain : ndarray, shape (n, P, V, 2)
        Image positions placed by hand, NaN elsewhere.
    scene : Scene
        What the clicks say.
    layout : Layout
        Which point is tracked in which view.
    fps : float
        Frames per second.
    settings : OfflineSettings
        The settings.
    reference : ReferenceAnnotations, optional
        Clicks that say where on a paw its point is; default those of ``certain``.

    Returns
    -------
    SmoothedTracks
        The tracks.
    """
    n_points = len(layout.kinds)
    if reference is None:
        clicked = sorted(np.flatnonzero(np.isfinite(certain[..., 0]).any(axis=(1, 2))).tolist())
        reference = ReferenceAnnotations(certain[clicked], {t: found[t] for t in clicked})
    extra, left_out = unlabelled_kinds(layout.kinds), True
    while left_out:
        prepared = _prepare(found, certain, reference, scene=scene, layout=layout, extra=extra)
        paths = _paths(found, anchors, prepared, scene=scene, fps=fps, settings=settings)
        first = paths.first()
        # an unlabelled target without a paw of its own would share that of its kind
        share = share_observed(first, anchors, scene, body=paths.body(first), kinds=prepared.kinds)
        least = TREADMILL.least_seen if lateral_axis(scene) is None else TREADMILL.least_seen_aside
        left_out = bool((share < least).any())
        extra = [kind for kind, seen in zip(extra, share, strict=True) if seen >= least]
    result = _iterate_until_converged(
        first, anchors, paths, prepared, scene=scene, fps=fps, settings=settings
    )
    return SmoothedTracks(
        result.x[:, :n_points],
        result.sd[:, :n_points],
        result.measured[:, :n_points],
        result.detection_probability[:, :n_points],
        result.displacement_from_first_pass[:, :n_points],
        result.association_log_odds[:, :n_points],
        result.forward_backward_distance[:, :n_points],
    )


@dataclass(frozen=True)
class _Prepared:
    """What is known before paths are chosen; unlabelled targets come after the clicked points."""

    kinds: list[str]
    certain: np.ndarray  # (n, P + S, V, 2)
    tracked_in_view: np.ndarray  # (P + S, V)
    observations: Observations
    likelihood: AppearanceLikelihood
    unsure: np.ndarray
    is_one_sided: bool  # paws of the other side were not clicked


def _prepare(
    found: Sequence[Sequence[np.ndarray]],
    certain: np.ndarray,
    reference: ReferenceAnnotations,
    *,
    scene: Scene,
    layout: Layout,
    extra: Sequence[str],
) -> _Prepared:
    """Learn from the clicks what detections say of points and of targets of the kinds ``extra``."""
    paw_width_px, facing, limb_direction = scene.paw_width_px, layout.facing, scene.limb_direction
    kinds = [*layout.kinds, *extra]
    room = ((0, 0), (0, len(extra)), (0, 0), (0, 0))
    certain = np.pad(certain, room, constant_values=np.nan)
    clicks = np.pad(reference.clicks, room, constant_values=np.nan)
    # a view from below shows middles of paws, the others their ends
    below = np.arange(len(facing)) == (-1 if scene.bottom_view is None else scene.bottom_view.view)
    kinds_of_view = [
        learn_offsets(
            np.where(alike[:, None], clicks, np.nan), reference.found, paw_width_px=paw_width_px,
            facing=facing, limb_direction=limb_direction, kinds=kinds,
        )
        for alike in (~below, below)
    ]  # fmt: skip
    offsets = [kinds_of_view[int(one)] for one in below]
    likelihood = AppearanceLikelihood(limb_direction, paw_width_px)
    if scene.geometry.coefs is not None and scene.bottom_view is None and not scene.is_learnt:
        # the curves were learnt from views from the side that agree in space
        likelihood = replace(likelihood, score=score_at_clicks(clicks, reference.found, likelihood))
    return _Prepared(
        kinds, certain, with_contralateral(layout.tracked, layout.kinds, extra),
        read_observations(found, offsets, facing=facing, likelihood=likelihood), likelihood,
        np.max([one.unsure for one in offsets], axis=0), bool(unlabelled_kinds(layout.kinds)),
    )  # fmt: skip


def _paths(
    found: Sequence[Sequence[np.ndarray]],
    anchors: Mapping[int, Mapping[int, np.ndarray]],
    prepared: _Prepared,
    *,
    scene: Scene,
    fps: float,
    settings: OfflineSettings,
) -> TrackletAssociator:
    """Return the tracklets, to be chosen from."""
    meet = anchors
    if scene.bottom_view is None:
        meet = {
            t: _meeting_detections(
                here, found[t], prepared.observations.only(t), scene=scene, settings=settings,
                likelihood=prepared.likelihood,
            )
            for t, here in anchors.items()
        }  # fmt: skip
    return TrackletAssociator(
        found,
        meet,
        scene,
        fps=fps,
        settings=settings,
        kinds=prepared.kinds,
        likelihood=prepared.likelihood,
        tracked_in_view=prepared.tracked_in_view,
    )


def _iterate_until_converged(
    first: np.ndarray,
    anchors: Mapping[int, Mapping[int, np.ndarray]],
    paths: TrackletAssociator,
    prepared: _Prepared,
    *,
    scene: Scene,
    fps: float,
    settings: OfflineSettings,
) -> SmoothedTracks:
    """Bridge the gaps of paths and learn the stride, then do all of it again with the stride."""
    measurement = MeasurementModel(
        scene.geometry,
        scene.paw_width_px,
        scene.paw_width,
        paths.motion_model.jerk,
        prepared.tracked_in_view,
        prepared.unsure,
    )
    by_hand = np.isfinite(prepared.certain[..., 0]).any(axis=-1)
    strides = (settings.shortest_stride_s * fps, settings.longest_stride_s * fps)

    def close_and_smooth(state: TrackingState) -> tuple[SmoothedTracks, GapClosing]:
        gap_closing = close_gaps(
            state, prepared.observations, geometry=scene.geometry, paw_width_px=scene.paw_width_px,
            tracked_in_view=prepared.tracked_in_view, motion_model=paths.motion_model,
        )  # fmt: skip
        smoothed = refine(
            state.chosen,
            prepared.observations,
            gap_closing,
            certain=prepared.certain,
            measurement=measurement,
            cycle=state.cycle,
            lateral_prior=_lateral_prior(state.chosen, paths, prepared),
            swings=state.swings,
        )
        return smoothed, gap_closing

    def tracked(places: np.ndarray) -> np.ndarray:
        return _tracked(places, anchors, prepared.observations, paths.motion_model, scene)

    def liftoff_velocity() -> np.ndarray | None:
        if gap_closing.substrate is None:
            return None
        return learn_liftoff_velocity(
            gap_closing.substrate, result.x, np.isfinite(result.measured[..., 0]).any(axis=-1),
            lift_offs=gap_closing.lift_offs, frames=max(1, round(TREADMILL.rising_s * fps)),
        )  # fmt: skip

    def body(places: np.ndarray) -> np.ndarray | None:
        # a learnt look shows too little of swings to say how far points go
        return None if scene.is_learnt else paths.body(places)

    places = tracked(first)
    result, gap_closing = close_and_smooth(TrackingState(places, by_hand, body=body(places)))
    unaided = before = result.x
    for iteration in range(settings.n_iterations + TREADMILL.one_more):
        if iteration >= settings.n_iterations and not _changed(result.x, before, scene.paw_width):
            break
        before = result.x
        sd = result.sd.mean(axis=-1) / scene.paw_width
        duty_factor = learn_duty_factor(gap_closing.stances, prepared.kinds)
        stances, lost = without_hops(gap_closing.stances, gap_closing.is_open, duty_factor)
        gap_closing = replace(gap_closing, stances=stances)
        cycle = learn_cycle(
            result.x, paths.body(result.x), axes=paths.motion_model.axes, frames=strides,
            noise=0.25 * scene.paw_width,
            trust=np.where(lost, 0.0, 1.0 / (1.0 + (sd / TREADMILL.learnt_from) ** 2)),
        )  # fmt: skip
        swings = _swings(result, gap_closing, duty_factor, prepared, lost, scene.paw_width, fps=fps)
        # a recording of two strides tells a rhythm, but no cycle
        if cycle is None and swings is None:
            break
        trust = 1.0 / (1.0 + (sd / TREADMILL.pipeline_believed) ** 2)
        if lost.any():
            paths.doubt(lost)
            first = paths.first()
        places = tracked(first if cycle is None else paths.again(cycle))
        state = TrackingState(
            places,
            by_hand,
            result.x,
            trust,
            cycle,
            liftoff_velocity(),
            duty_factor,
            swings,
            body(places),
        )
        result, gap_closing = close_and_smooth(state)
        result.displacement_from_first_pass = np.linalg.norm(result.x - unaided, axis=-1)
    result.sd = _stated(result.sd, gap_closing.is_open, is_one_sided=prepared.is_one_sided)
    if result.equations is not None:
        result.forward_backward_distance = forward_backward_distance(result.equations)
        result.association_log_odds = association_log_odds(
            result.measured,
            leave_one_out(result.x, result.equations),
            prepared.observations,
            negative_log_odds=gap_closing.negative_log_odds,
            sigma=deviations(prepared.observations.detection_probability, measurement),
            geometry=scene.geometry,
            paw_width_px=scene.paw_width_px,
        )
    return result


def _changed(x: np.ndarray, before: np.ndarray, paw_width: float) -> bool:
    """Tell whether tracks (n, P, d) go elsewhere than in the look before."""
    far = np.linalg.norm(x - before, axis=-1) > TREADMILL.pipeline_changes * paw_width
    return bool((far.sum(axis=0) >= TREADMILL.changed_frames).any())


def _swings(
    result: SmoothedTracks,
    gap_closing: GapClosing,
    duty_factor: DutyFactor | None,
    prepared: _Prepared,
    lost: np.ndarray,
    paw_width: float,
    *,
    fps: float,
) -> Swings | None:
    """Return where points swing; None without a rhythm, or where no view shows heights.

    Frames (n, P) in which points were ``lost`` tell nothing.
    """
    if (
        duty_factor is None
        or gap_closing.substrate is None
        or np.isnan(gap_closing.substrate.height).all()
    ):
        return None
    seen = (np.isfinite(result.measured[..., 0]) & prepared.tracked_in_view).any(axis=-1) & ~lost
    # arcs go forward and up: that a single view tells no depth takes nothing from them
    ahead = gap_closing.substrate.motion_model.axes[[0, -1]]
    sd = np.sqrt(result.sd**2 @ (ahead**2).T).mean(axis=-1) / paw_width
    return learn_swings(
        result.x,
        seen / (1.0 + (sd / TREADMILL.learnt_from) ** 2),
        gap_closing.stances,
        certain=~gap_closing.is_open,
        substrate=gap_closing.substrate,
        duty_factor=duty_factor,
        kinds=prepared.kinds,
        fps=fps,
    )


def _stated(sd: np.ndarray, is_open: np.ndarray, *, is_one_sided: bool) -> np.ndarray:
    """Return the standard deviations (n, P, d) that are stated, given where places are certain."""
    certain = np.zeros_like(is_open) if is_one_sided else ~is_open
    return np.where(certain[..., None], TREADMILL.pipeline_stated * sd, sd)


def _lateral_prior(
    chosen: np.ndarray, paths: TrackletAssociator, prepared: _Prepared
) -> LateralPrior | None:
    """Return where points usually are to the side, if only one side of the animal was clicked."""
    across = lateral_axis(paths.scene) if prepared.is_one_sided else None
    if across is None:
        return None
    return learn_lateral_prior(
        chosen, paths.body(chosen), across, body_scale=paths.scene.body_scale
    )


def _tracked(
    places: np.ndarray,
    anchors: Mapping[int, Mapping[int, np.ndarray]],
    observations: Observations,
    motion_model: MotionModel,
    scene: Scene,
) -> np.ndarray:
    """Return where the tracked points are of chosen places (n, P, d)."""
    view = None
    if scene.bottom_view is not None:
        places = scene.bottom_view.to_space(places, observations, motion_model.acceleration)
        view = scene.bottom_view.view
    moved = tracked_points(
        places, observations, geometry=scene.geometry, paw_width_px=scene.paw_width_px, view=view
    )
    for t, here in anchors.items():
        for p, at in here.items():
            moved[t, p] = at
    return moved


def _meeting_detections(
    here: Mapping[int, np.ndarray],
    found: Sequence[np.ndarray],
    observations: Observations,
    *,
    scene: Scene,
    settings: OfflineSettings,
    likelihood: AppearanceLikelihood,
) -> dict[int, np.ndarray]:
    """Return where the detections of placed points meet, in one frame: paths go through there.

    A click in the middle of a long foot is farther from its end than paws are apart. Of the
    places that say that the point is where it was placed, its toes and its heel, the one that
    looks best is taken; without any, the point itself.
    """
    places = find_hypotheses([found], scene, settings, likelihood=likelihood)[0]
    n_points = observations.at.shape[1]
    meet = dict(here)
    price = dict.fromkeys(here, np.inf)
    for place, cost in zip(places.at, places.cost, strict=True):
        said = tracked_points(
            np.tile(place, (1, n_points, 1)), observations, geometry=scene.geometry,
            paw_width_px=scene.paw_width_px,
        )[0]  # fmt: skip
        for p, at in here.items():
            away = float(np.linalg.norm(said[p] - at)) / scene.paw_width
            if away < TREADMILL.pipeline_same and cost + away < price[p]:
                meet[p], price[p] = place, cost + away
    return meet
