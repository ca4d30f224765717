"""Deciding over the whole recording: paths, gaps and the stride, each from the others.

Every step takes what is known and returns what is known after it; none changes what it is given.
Paths are chosen among certain tracklets, the gaps between them are closed, and the tracks are
smoothed; the stride is learnt from these, and all is done again with it until nothing changes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pawnb.core.paws.offline.association.network_flow.assignment import Assignment
from pawnb.core.paws.offline.gap_closing.gap_closing import close_gaps
from pawnb.core.paws.offline.smoothing.diagnostics import with_diagnostics
from pawnb.core.paws.offline.smoothing.refinement import refine
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.paws.offline.stride.learn import learn_stride
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL
from pawnb.core.paws.offline.treadmill.recording import Recording
from pawnb.core.paws.offline.treadmill.state import PipelineState
from pawnb.core.paws.offline.treadmill.targets import choose_targets


def run_pipeline(recording: Recording) -> SmoothedTracks:
    """Decide where every point was in every frame.

    Parameters
    ----------
    recording : Recording
        What is given.

    Returns
    -------
    SmoothedTracks
        The tracks of the clicked points.
    """
    state = track_once(PipelineState.begin(recording, *choose_targets(recording)))
    state = replace(state, unaided=state.smoothed.x)
    while not is_settled(state):
        learnt = learn(state)
        # without a stride, too, where the others are is known once they were tracked
        if not learnt.stride.is_known and state.passes > 1:
            break
        state = track_once(learnt)
    return diagnose(state).smoothed.points(slice(len(recording.layout.kinds)))


def track_once(state: PipelineState) -> PipelineState:
    """Associate, close the gaps and smooth, by what is known of strides."""
    return smooth(close(associate(state)))


def associate(state: PipelineState) -> PipelineState:
    """Choose each point's path: by the cycle, or without one by the clicks alone."""
    cycle, recording = state.stride.cycle, state.recording
    at = recording.scene.geometry.tracked_points(
        state.first if cycle is None else state.paths.again(cycle),
        state.targets.observations,
        acceleration=state.paths.motion_model.acceleration,
    )
    for t, here in recording.anchors.items():
        for p, placed in here.items():
            at[t, p] = placed
    return replace(state, assignment=Assignment(at, state.assignment.by_hand))


def close(state: PipelineState) -> PipelineState:
    """Choose detections where paths are not certain."""
    scene = state.recording.scene
    gap_closing = close_gaps(
        state.known, state.targets.observations, geometry=scene.projection,
        paw_width_px=scene.paw_width_px, tracked_in_view=state.targets.tracked_in_view,
        motion_model=state.paths.motion_model,
    )  # fmt: skip
    return replace(state, gap_closing=gap_closing)


def smooth(state: PipelineState) -> PipelineState:
    """Smooth the tracks through the detections of all views."""
    at, targets = state.assignment.at, state.targets
    scene, lateral_prior = state.recording.scene, None
    if targets.is_one_sided:
        body = state.paths.body(at)
        lateral_prior = scene.geometry.lateral_prior(at, body, body_scale=scene.body_scale)
    smoothed = refine(
        at, targets.observations, state.gap_closing, certain=targets.certain,
        measurement=state.measurement, cycle=state.stride.cycle, lateral_prior=lateral_prior,
        swings=state.stride.swings,
    )  # fmt: skip
    moved = np.linalg.norm(smoothed.x - state.unaided, axis=-1)
    return replace(
        state,
        smoothed=replace(smoothed, displacement_from_first_pass=moved),
        before=state.smoothed.x,
        passes=state.passes + 1,
    )


def learn(state: PipelineState) -> PipelineState:
    """Learn the stride from the tracks; paths to which no swing led are doubted from then on."""
    body = state.paths.body(state.smoothed.x)
    stride = learn_stride(state.smoothed, state.gap_closing, body, gait=state.gait)
    if stride.hopped is None or not stride.hopped.any():
        return replace(state, stride=stride)
    paths = state.paths.doubting(stride.hopped)
    return replace(state, stride=stride, paths=paths, first=paths.first())


def is_settled(state: PipelineState) -> bool:
    """Tell whether no further pass is needed: the tracks go where they went in the one before."""
    aided, wanted = state.passes - 1, state.recording.settings.n_iterations
    if aided < wanted or aided >= wanted + TREADMILL.one_more:
        return aided >= wanted
    least = TREADMILL.pipeline_changes * state.recording.scene.paw_width
    far = np.linalg.norm(state.smoothed.x - state.before, axis=-1) > least
    return not (far.sum(axis=0) >= TREADMILL.changed_frames).any()


def diagnose(state: PipelineState) -> PipelineState:
    """State how sure the tracks are."""
    smoothed = with_diagnostics(
        state.smoothed, state.targets.observations, state.gap_closing,
        measurement=state.measurement, is_one_sided=state.targets.is_one_sided,
    )  # fmt: skip
    return replace(state, smoothed=smoothed)
