"""The pose tracker ``pawnb``: a painted stick animal, and the smoothest path through a recording.

Every frame is fitted with sub-pixel precision on a crop that follows the animal
(:mod:`.rendering.gauss_newton_kernels`); where a leg may be elsewhere, its other places are kept
(:mod:`.candidates.leg_candidates`), and in the end the path is chosen that is smoothest over the
whole recording and explains most of the picture (:mod:`.candidates.viterbi`). Then all frames are
fitted together, with how evenly this animal's legs move (:mod:`.sequence.final_fit`). The steps
are in :mod:`.pipeline`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import poses_of_vectors
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.pipeline import run_pipeline
from pawnb.core.pose.fit.reading import WaysReader
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture
from pawnb.core.pose.fit.sequence.between_annotations import Ways
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.state import PoseFitState, PoseRecording
from pawnb.core.pose.fit.steps import Steps
from pawnb.core.pose.poses import Poses, joint_positions, start_within
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.video.views import ViewReader
from pawnb.schema import ORIGIN_CODE


def track_pose(
    reader: ViewReader,
    start: Poses,
    *,
    animal: StickAnimal,
    background: BackgroundPicture,
    settings: PoseSettings | None = None,
    frames: tuple[int, int],
    reference: Poses | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] | None = None,
    kept: KeptFrames | None = None,
) -> PoseTrack:
    """Track a jointed animal through a recording, both ways from each start frame.

    Parameters
    ----------
    reader : ViewReader
        The view.
    start : Poses
        The animal's pose in one frame or more, roughly; those outside ``frames`` are left out.
    animal : StickAnimal
        The animal.
    background : Background
        The empty scene: ``mean`` and ``sd``, grey values, shape (H, W).
    settings : PoseSettings, optional
        Settings; see there.
    frames : tuple of int
        First frame and one past the last.
    reference : Poses, optional
        One frame, also outside ``frames``, from which appearance is learnt; default the first
        start pose.
    progress : callable, optional
        Called with frames done and frames in all.
    stop : callable, optional
        Tracking ends early, with what it has, when this returns True.
    kept : KeptFrames, optional
        What an interrupted run has found frame by frame, and what this one finds. The fit of all
        frames together is done anew.

    Returns
    -------
    PoseTrack
        One row for every frame of ``frames``: NaN and origin missing where the animal is not
        there. ``estimated`` says how many pixels of the view make a working pixel, and how
        blurred the animal's edge is, px of the view.

    Raises
    ------
    InputError
        If no start pose lies within ``frames``, or none of the body is where it says.
    """
    start = start_within(start, frames)
    # frames are followed and then fitted together; those between start poses are followed twice
    between = int(start.frames.max() - start.frames.min())
    steps = Steps(2 * (frames[1] - frames[0]) + between, progress, stop)
    state = run_pipeline(
        PoseRecording(
            frame=reader.frame,
            ways=Ways(WaysReader(reader, steps).read, steps, kept or KeptFrames()),
            frames=frames,
            start=start,
            reference=start.take([0]) if reference is None else reference,
            animal=animal,
            background=background,
            settings=settings or PoseSettings(),
        )
    )
    steps.end()
    return _result(state)


def _result(state: PoseFitState) -> PoseTrack:
    """Return what was found in px of the view, one row a frame."""
    fitter, animal = state.fitter, state.recording.animal
    numbers = np.arange(*state.recording.frames)
    n, n_legs = len(numbers), len(animal.legs)
    factor = fitter.evidence.factor
    rows = np.array([one.frame for one in state.frames], dtype=int) - int(numbers[0])
    vectors, sds = np.full((n, fitter.index.n), np.nan), np.full((n, fitter.index.n), np.nan)
    places = np.full((n, *fitter.layout.radius.shape, 2), np.nan)
    support = np.full((n, n_legs), np.nan)
    for row, one in zip(rows, state.final_fits, strict=True):
        vectors[row], sds[row] = one.pose, one.sd
        places[row] = one.places_sd * factor
        support[row] = np.fmin(one.support[:, 0], one.support[:, 1])
    scale = float(state.recording.reference.scale[0])
    poses = poses_of_vectors(animal, vectors, frames=numbers, scale=scale, factor=factor)
    poses.scale[np.isnan(vectors[:, 0])] = np.nan
    confidence = np.clip(
        (np.nan_to_num(support) - FITTING.tracker_doubtful)
        / (FITTING.tracker_sure - FITTING.tracker_doubtful),
        0.0,
        1.0,
    )
    origin = np.where(confidence > 0, ORIGIN_CODE["measured"], ORIGIN_CODE["predicted"])
    origin[np.isnan(vectors[:, 0])] = ORIGIN_CODE["missing"]
    assert places.shape[1:3] == joint_positions(animal, poses).shape[1:3]  # noqa: S101
    return PoseTrack(
        poses=poses,
        xy_sd_px=sds[:, :2] * factor,
        heading_sd_deg=np.degrees(sds[:, 2]),
        angles_sd_deg=np.degrees(sds[:, fitter.index.angles]),
        places_sd_px=places,
        confidence=confidence,
        origin=origin.astype(np.int8),
        estimated={"working_px": factor, "blur_px": float(fitter.blur * factor)},
    )
