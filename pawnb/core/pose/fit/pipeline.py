"""The pose tracker as steps: each takes what is known and returns what is known after it.

The start frame shows the animal's appearance, with which it is followed both ways. Where wings or
the like turn out to hide legs, it is followed a second time, with what the first has shown of them
and of how its legs are held. Then its appearance is learnt once more, from sure frames of the whole
recording, and all frames are fitted together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pawnb.core.pose.fit.candidates.viterbi_path import chosen_poses
from pawnb.core.pose.fit.layout import pose_vectors
from pawnb.core.pose.fit.learning.attached_clutter import find_attached_clutter
from pawnb.core.pose.fit.learning.pose_prior import learn_pose_prior
from pawnb.core.pose.fit.learning.relearn import learn_again
from pawnb.core.pose.fit.prepare import check_on_animal, prepare_fitter
from pawnb.core.pose.fit.sequence.between_annotations import fit_known, follow_all
from pawnb.core.pose.fit.sequence.final_fit import fit_all_frames
from pawnb.core.pose.fit.sequence.first_frame import fit_start
from pawnb.core.pose.fit.state import PoseFitState, PoseRecording


def run_pipeline(recording: PoseRecording) -> PoseFitState:
    """Find the pose of the animal in every frame.

    Parameters
    ----------
    recording : PoseRecording
        What is given.

    Returns
    -------
    PoseFitState
        With the last fits of all frames in which the animal is.

    Raises
    ------
    InputError
        If none of the body is where a start pose says.
    """
    state = follow(fit_starts(begin(recording)))
    if not recording.ways.steps.stopped():
        learnt = learn_what_hides(state)
        if learnt.fitter.clutter.attached is not None:
            recording.ways.steps.expect(steps_of_a_pass(state))
            state = follow(fit_starts_again(learnt))
    return fit_together(learn_appearance(state))


def begin(recording: PoseRecording) -> PoseFitState:
    """Learn the animal's appearance from one frame; its pose is fitted."""
    frame = recording.frame(int(recording.reference.frames[0]))
    fitter, pose = prepare_fitter(
        frame, recording.reference, animal=recording.animal, background=recording.background,
        settings=recording.settings,
    )  # fmt: skip
    fitter, pose, support = fit_start(fitter, frame, pose)
    check_on_animal(support, frame=frame.index)
    return PoseFitState(
        recording=recording,
        fitter=fitter,
        known={frame.index: pose},
        frames=(),
        poses=np.empty((0, fitter.index.n)),
    )


def fit_starts(state: PoseFitState) -> PoseFitState:
    """Fit the start poses; the frame that the appearance was learnt from may be none of them."""
    recording, fitter, start = state.recording, state.fitter, state.recording.start
    # one animal has one size: where another start pose is larger, its legs are longer
    scale = np.full(len(start), float(recording.reference.scale[0]))
    vectors = pose_vectors(
        recording.animal, replace(start, scale=scale), factor=fitter.evidence.factor
    )
    known = {}
    for number, vector in zip(start.frames.tolist(), vectors, strict=True):
        if number in state.known:
            known[number] = state.known[number]
            continue
        known[number], support = fit_known(fitter, recording.frame(number), vector)
        check_on_animal(support, frame=number)
    return replace(state, known=known)


def follow(state: PoseFitState) -> PoseFitState:
    """Follow the animal from the start frames, and choose the smoothest path."""
    recording, turn = state.recording, "again " if state.passes else ""
    ways = replace(recording.ways, turn=turn)
    frames = follow_all(state.fitter, state.known, recording.frames, ways=ways)
    poses = chosen_poses(state.fitter, frames)
    return replace(state, frames=frames, poses=poses, passes=state.passes + 1)


def learn_what_hides(state: PoseFitState) -> PoseFitState:
    """Learn what is fixed to the body and hides legs, and then how legs are held."""
    attached = find_attached_clutter(state.fitter, state.frames, state.poses)
    if attached is None:
        return state
    fitter = state.fitter.with_clutter(replace(state.fitter.clutter, attached=attached))
    return replace(state, fitter=learn_pose_prior(fitter, state.frames, state.poses))


def fit_starts_again(state: PoseFitState) -> PoseFitState:
    """Fit the start poses with what was learnt since."""
    frame = state.recording.frame
    known = {i: fit_known(state.fitter, frame(i), pose)[0] for i, pose in state.known.items()}
    return replace(state, known=known)


def learn_appearance(state: PoseFitState) -> PoseFitState:
    """Learn the animal's appearance from sure frames of the whole recording."""
    fitter, poses = learn_again(state.fitter, state.frames, state.poses)
    return replace(state, fitter=fitter, poses=poses)


def fit_together(state: PoseFitState) -> PoseFitState:
    """Fit all frames together."""
    final_fits = fit_all_frames(state.fitter, state.frames, state.poses)
    for _ in final_fits:
        state.recording.ways.steps.one()
    return replace(state, final_fits=tuple(final_fits))


def steps_of_a_pass(state: PoseFitState) -> int:
    """Return how many frames are followed once; those between two start frames count twice."""
    first, end = state.recording.frames
    return end - first + max(state.known) - min(state.known)
