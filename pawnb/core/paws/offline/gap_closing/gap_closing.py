"""Which detections a point took where its path is not certain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.parallel import on_threads
from pawnb.core.paws.offline.detection.colour.observations import Observations
from pawnb.core.paws.offline.gap_closing.clutter.limb_clutter import learn_limb_clutter
from pawnb.core.paws.offline.gap_closing.clutter.wrist_clutter import follow_wrist_clutter
from pawnb.core.paws.offline.gap_closing.conflicts import ClosedGap, resolve_conflicts
from pawnb.core.paws.offline.gap_closing.gap import Gap
from pawnb.core.paws.offline.gap_closing.hypothesis_kernels import ProcessNoise
from pawnb.core.paws.offline.gap_closing.mht import process_noise_of, state_after
from pawnb.core.paws.offline.gap_closing.mht_kernels import (
    ExpectedPositions,
    GapEvidence,
    TargetModel,
    run_mht,
)
from pawnb.core.paws.offline.gap_closing.mht_parameters import MHTParameters, mht_parameters
from pawnb.core.paws.offline.gap_closing.parameters import GAP_CLOSING
from pawnb.core.paws.offline.gap_closing.rejection import frames_to_reassociate, runs
from pawnb.core.paws.offline.gap_closing.state import GapClosing, TrackingState
from pawnb.core.paws.offline.gap_closing.update_kernels import Cameras
from pawnb.core.paws.offline.gap_closing.usual_region import (
    UsualRegion,
    same_kind,
    usual_region,
)
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.scene.parameters import MOVEMENT
from pawnb.core.paws.offline.stride.stance import Stance, Substrate, covered, learn_substrate


def close_gaps(
    state: TrackingState,
    observations: Observations,
    *,
    geometry: Projection,
    paw_width_px: FloatArray,
    tracked_in_view: BoolArray,
    motion_model: MotionModel,
) -> GapClosing:
    """Choose detections for every point where its path is not certain.

    Parameters
    ----------
    state : TrackingState
        What is known so far.
    observations : Observations
        What every view shows.
    geometry : Projection
        The views.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.
    tracked_in_view : ndarray of bool, shape (P, V)
        Which view tracks which point.
    motion_model : MotionModel
        How points move.

    Returns
    -------
    GapClosing
        The choice.
    """
    is_open = frames_to_reassociate(
        state.chosen,
        state.assignment.by_hand,
        motion_model=motion_model,
        duty_factor=state.stride.duty_factor,
        swings=state.stride.swings,
    )
    sure = np.where(is_open[..., None], np.nan, state.chosen)
    substrate = learn_substrate(sure, motion_model, liftoff_velocity=state.stride.liftoff_velocity)
    stances = substrate.stances(sure)
    cost = _candidate_costs(state, is_open, observations, geometry, paw_width_px)
    wrist_clutter = follow_wrist_clutter(
        stances, observations, substrate=substrate, geometry=geometry, paw_width_px=paw_width_px
    )
    parameters = _mht_parameters(motion_model)
    closer = _GapCloser(
        state,
        sure,
        *wrist_clutter.observed(observations, cost),
        substrate,
        stances,
        geometry.project(np.where(np.isnan(sure), state.before, sure)),
        parameters,
        process_noise_of(
            parameters,
            substrate.substrate_velocity,
            across=motion_model.axes[1] if len(motion_model.axes) == 3 else None,
        ),
        geometry,
        paw_width_px,
        np.maximum(
            _appearance_cost(observations.detection_probability) - GAP_CLOSING.gap_closing_dim, 0.0
        ),
    )
    choice, held = closer.close_all(tracked_in_view, is_open, n_detections=cost.shape[-1])
    after = substrate.stances(np.where(np.isnan(held), sure, held))
    stops = [(p, one.stop) for p, mine in enumerate(after) for one in mine]
    lift_offs = [(p, stop - 1) for p, stop in stops if stop < len(is_open)]
    choice, cost = wrist_clutter.left_out(choice, cost)
    return GapClosing(is_open, choice, cost, held, lift_offs, substrate, after)


def _mht_parameters(motion_model: MotionModel) -> MHTParameters:
    """Return the parameters for points that move so."""
    fps = motion_model.fps
    return mht_parameters(
        jerk=motion_model.jerk, impulse=GAP_CLOSING.gap_closing_manoeuvre * motion_model.speed,
        noise=GAP_CLOSING.certain_sd * motion_model.paw_width,
        reach=GAP_CLOSING.reach * motion_model.body_scale,
        rising=max(1, round(GAP_CLOSING.rising_s * fps)),
        swinging=round(GAP_CLOSING.swinging_s * fps),
    )  # fmt: skip


@dataclass(frozen=True)
class _GapCloser:
    """Tells what points did where they are not certain; see :func:`close_gaps`."""

    state: TrackingState
    sure: FloatArray  # (n, P, d), certain places
    observations: Observations
    cost: FloatArray  # (n, P, V, C)
    substrate: Substrate
    stances: list[list[Stance]]
    uv: FloatArray  # (n, P, V, 2), where all points are as far as is known
    parameters: MHTParameters
    process_noise: ProcessNoise  # but for the direction of time of each stretch
    geometry: Projection
    paw_width_px: FloatArray
    excused: FloatArray  # (n, V, C), how much of a poor look a paw that lifts off is forgiven

    def close_all(
        self, tracked_in_view: BoolArray, is_open: BoolArray, *, n_detections: int
    ) -> tuple[IntArray, FloatArray]:
        """Close all stretches, each by itself, then those again in which two points took one paw.

        Returns
        -------
        choice : ndarray of int, shape (n, P, V)
            The detections taken, -1 where none.
        held : ndarray, shape (n, P, d)
            Where points stand though no path says so, NaN elsewhere.
        """
        choice = np.full((*is_open.shape, len(self.paw_width_px)), -1)
        held = np.full(self.sure.shape, np.nan)
        by_hand = self.state.assignment.by_hand
        gaps = [
            (p, Gap.of(first, stop, is_open[:, p]))
            for p in range(is_open.shape[1])
            for first, stop in runs(is_open[:, p])
            # of an unlabelled target nobody has said that it was there
            if first > 0 or by_hand[:, p].any()
        ]
        closed = resolve_conflicts(
            on_threads(lambda one: self.close(*one, tracked_in_view[one[0]]), gaps),
            lambda one, more: self.close(one.point, one.gap, tracked_in_view[one.point], more),
            n_detections,
        )
        for one in closed:
            choice[one.gap.frames, one.point] = one.taken
            held[one.gap.frames[one.stood], one.point] = one.standing
        return choice, held

    def close(
        self, point: int, gap: Gap, tracked_in_view: BoolArray, against: np.ndarray | float = 0.0
    ) -> ClosedGap:
        """Tell a stretch, given what speaks ``against`` detections (frames, V, C) besides."""
        motion_model = self.substrate.motion_model
        state, covariance = state_after(
            self.state.chosen[gap.before, point], gap.way * motion_model.substrate_velocity,
            parameters=self.parameters, speed=MOVEMENT.unknown_speed * motion_model.speed,
        )  # fmt: skip
        due = self._due(point, gap)
        edge, standing = self._standing(point, gap, is_told=due is not None)
        evidence = self._shown(point, gap, tracked_in_view, standing, due)
        choice, stood, cost = run_mht(
            state, covariance, edge,
            evidence._replace(negative_log_odds=evidence.negative_log_odds + against),
            self._expected(point, gap),
            self._region(point, gap),
            self._how(point, gap, tracked_in_view),
        )  # fmt: skip
        return ClosedGap(point, gap, choice, stood, standing[stood], cost)

    def _region(self, point: int, gap: Gap) -> UsualRegion:
        """Return where a point may be in a stretch and the frames that follow."""
        state, motion_model = self.state, self.substrate.motion_model
        alike: list[tuple[int, np.ndarray]] = []
        if len(motion_model.axes) == 3:  # one picture from the side has no sides
            alike = same_kind(
                state.assignment, state.body, point, kinds=state.kinds, across=motion_model.axes[1]
            )
        return usual_region(
            self.sure, state.body, point, frames=np.concatenate([gap.frames, gap.after]),
            motion_model=motion_model, alike=alike, are_apart=state.are_apart,
        )  # fmt: skip

    def _due(self, point: int, gap: Gap) -> FloatArray | None:
        """Return what speaks against lifting off before each frame of a stretch and after it.

        Nothing where nothing is known of it: of the swing itself, or of the rhythm.
        """
        if gap.way < 0:
            return None
        stride, stances = self.state.stride, self.stances[point]
        frames = np.concatenate([gap.frames, gap.after])
        if stride.swings is not None:
            due = stride.swings.due(point, frames, self.substrate.motion_model.fps)
            if due is not None:
                return due
        now = gap.stance(stances)
        # where nothing follows that says when it lifted off, that is left open
        if stride.duty_factor is None or now is None or gap.is_last:
            return None
        later = [one for one in stances if one.first >= now.stop]
        return stride.duty_factor.due(point, now, later[0] if later else None, frames=frames)

    def _standing(self, point: int, gap: Gap, *, is_told: bool) -> tuple[FloatArray, FloatArray]:
        """Return where a point stands where a stretch begins, and in its frames (frames, d).

        NaN where it does not stand there, and where nothing follows and it is not known when it
        is due to lift off.
        """
        substrate, stance = self.substrate, gap.stance(self.stances[point])
        if stance is None or (gap.is_last and gap.way > 0 and not is_told):
            nowhere = np.full((len(gap.frames), len(substrate.substrate_velocity)), np.nan)
            return nowhere[0], nowhere
        edge = substrate.places(stance, gap.before[-1:])[0]
        return edge, substrate.places(stance, gap.frames)

    def _how(self, point: int, gap: Gap, tracked_in_view: BoolArray) -> TargetModel:
        """Return the model of a point."""
        substrate, way = self.substrate, gap.way
        # backwards in time a paw that stands has not landed yet: how it will is not known
        liftoff_velocity = (
            substrate.liftoff_velocity[point]
            if way > 0
            else np.zeros_like(substrate.substrate_velocity)
        )
        return TargetModel(
            Cameras(self.geometry.rows, self.paw_width_px, tracked_in_view),
            self.process_noise._replace(
                substrate_velocity=way * substrate.substrate_velocity,
                liftoff_velocity=liftoff_velocity,
            ),
            substrate.kinematic_prior(point, way=way),
            self.parameters,
        )

    def _shown(
        self,
        point: int,
        gap: Gap,
        tracked_in_view: BoolArray,
        standing: FloatArray,
        due: FloatArray | None,
    ) -> GapEvidence:
        """Return what the frames of a stretch show of a point that may stand there.

        ``due`` is what speaks against lifting off before each frame.
        """
        t, observations = gap.frames, self.observations
        negative_log_odds = self.cost[t, point]
        occluded = covered(
            standing, self.uv[t], point, geometry=self.geometry, paw_width_px=self.paw_width_px
        )
        return GapEvidence(
            # those that are there come first
            observations.is_there[t].sum(axis=-1),
            observations.at[t, point],
            np.stack([negative_log_odds, negative_log_odds - self.excused[t]]),
            np.asarray(occluded[:, tracked_in_view].all(axis=1)),
            self.state.chosen[gap.after, point],
            np.zeros(len(t) + len(gap.after)) if due is None else due,
        )

    def _expected(self, point: int, gap: Gap) -> ExpectedPositions:
        """Return where a point is expected: by the cycle, and by the arc of its swing."""
        cycle, swings, motion_model = (
            self.state.stride.cycle,
            self.state.stride.swings,
            self.substrate.motion_model,
        )
        t = np.concatenate([gap.frames, gap.after])
        n, most = len(gap.frames), np.zeros(2)
        at = np.full((2, len(t), len(motion_model.axes)), np.nan)
        variance, axes = np.ones(at.shape), np.stack([motion_model.axes] * 2)
        if cycle is not None and gap.is_last:
            at[0], variance[0] = (
                cycle.mean[t, point],
                cycle.sd[t, point] ** 2 / GAP_CLOSING.gap_closing_expected,
            )
            axes[0], most[0] = (
                cycle.axes,
                0.5 * GAP_CLOSING.gap_closing_expected * GAP_CLOSING.gap_closing_farthest,
            )
        if swings is not None and gap.way > 0:
            at[1, :n], sd = swings.place[gap.frames, point], swings.sd[gap.frames, point]
            sd[:, 1:-1] = np.hypot(
                sd[:, 1:-1], GAP_CLOSING.gap_closing_aside * motion_model.paw_width
            )
            weight = GAP_CLOSING.gap_closing_expected
            variance[1, :n], most[1] = sd**2 / weight, 0.5 * weight * GAP_CLOSING.farthest_off_arc
        return ExpectedPositions(at, variance, axes, most)


def _appearance_cost(detection_probability: FloatArray) -> FloatArray:
    """Return what speaks against detections for how much they look like paws."""
    return np.asarray(
        -GAP_CLOSING.gap_closing_look
        * np.log(np.clip(detection_probability, GAP_CLOSING.least_detection_probability, 1.0))
    )


def _candidate_costs(
    state: TrackingState,
    is_open: BoolArray,
    observations: Observations,
    geometry: Projection,
    paw_width_px: FloatArray,
) -> FloatArray:
    """Return what speaks against each detection (n, P, V, C) being each point."""
    n, n_points, _ = state.chosen.shape
    x = np.where(is_open[..., None], np.nan, state.chosen)
    x = np.where(np.isfinite(x), x, state.before)
    trust = np.where(is_open, state.trust, 1.0)
    there = np.isfinite(x[..., 0])
    uv = geometry.project(np.nan_to_num(x))
    poor = _appearance_cost(observations.detection_probability)
    cost = np.repeat(poor[:, None], n_points, axis=1)
    explained = np.zeros((n, n_points, *poor.shape[1:]))
    for p in range(n_points):
        away = np.linalg.norm(observations.at[:, p] - uv[:, p, :, None], axis=-1)
        away = np.where(observations.is_there, away, np.inf)
        near = np.exp(-((away / (GAP_CLOSING.gap_closing_beside * paw_width_px[:, None])) ** 2))
        # one detection is enough to explain a point
        near[away > away.min(axis=-1, keepdims=True)] = 0.0
        explained[:, p] = np.where(there[:, p], trust[:, p], 0.0)[:, None, None] * near
    believed = np.where(there, trust, 0.0)
    limb_clutter = learn_limb_clutter(uv, believed, observations, paw_width_px=paw_width_px)
    for p in range(n_points):
        limb = limb_clutter.negative_log_odds(uv[:, p], observations, p, paw_width_px=paw_width_px)
        limb = believed[:, p, None, None] * limb
        explained[:, p] = np.maximum(GAP_CLOSING.gap_closing_other * explained[:, p], limb)
    for p in range(n_points):
        others = np.delete(explained, p, axis=1)
        if others.shape[1]:
            cost[:, p] += others.max(axis=1)
    return cost
