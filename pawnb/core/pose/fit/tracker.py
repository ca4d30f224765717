"""The pose tracker ``pawnb``: a painted stick animal, and the smoothest path through a recording.

Every frame is fitted with sub-pixel precision on a crop that follows the animal
(:mod:`.rendering.gauss_newton_kernels`); where a leg may be elsewhere, its other places are kept
(:mod:`.candidates.leg_candidates`), and in the end the path is chosen that is smoothest over the
whole recording and explains most of the picture (:mod:`.candidates.viterbi`). Then all frames are
fitted together, with how evenly this animal's legs move (:mod:`.sequence.final_fit`).

Where wings or the like turn out to hide legs, the animal is followed a second time, with what the
first has shown of them (:mod:`.learning.attached_clutter`) and of how its legs are held
(:mod:`.learning.pose_prior`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.parallel import Threads
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.viterbi_path import chosen_poses
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.layout import pose_vectors, poses_of_vectors
from pawnb.core.pose.fit.learning.attached_clutter import find_attached_clutter
from pawnb.core.pose.fit.learning.pose_prior import learn_pose_prior
from pawnb.core.pose.fit.learning.relearn import learn_again
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.prepare import check_on_animal, prepare_fitter
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture
from pawnb.core.pose.fit.sequence.between_annotations import fit_known, follow_all
from pawnb.core.pose.fit.sequence.final_fit import Settled, settle_all
from pawnb.core.pose.fit.sequence.first_frame import fit_start
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.fit.steps import Steps
from pawnb.core.pose.poses import Poses, joint_positions, start_within
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.video.views import Frame, ViewReader
from pawnb.schema import ORIGIN_CODE


def track_pose(
    reader: ViewReader,
    start: Poses,
    *,
    animal: StickAnimal,
    background: BackgroundPicture,
    settings: PoseSettings | None = None,
    frames: tuple[int, int],
    look: Poses | None = None,
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
    look : Poses, optional
        One frame, also outside ``frames``, from which the animal's look is learnt; default the
        first start pose.
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
    settings = settings or PoseSettings()
    numbers = np.arange(*frames)
    start = start_within(start, frames)
    look = start.take([0]) if look is None else look
    fitter, known = _begin(reader, (start, look), animal, background, settings)
    # frames between two known ones are followed twice
    between = max(known) - min(known)
    steps = Steps(2 * len(numbers) + between, progress, stop)
    follow = partial(
        follow_all,
        frames=frames,
        read=_Ways(reader, steps).read,
        steps=steps,
        kept=kept or KeptFrames(),
    )
    found = follow(fitter, known)
    poses = chosen_poses(fitter, found)
    attached = None if steps.stopped() else find_attached_clutter(fitter, found, poses)
    if attached is not None:
        fitter = fitter.with_clutter(dataclasses.replace(fitter.clutter, attached=attached))
        fitter = learn_pose_prior(fitter, found, poses)
        steps.total += len(numbers) + between
        known = {i: fit_known(fitter, reader.frame(i), pose)[0] for i, pose in known.items()}
        found = follow(fitter, known, turn="again ")
        poses = chosen_poses(fitter, found)
    fitter, poses = learn_again(fitter, found, poses)
    settled = _finish(fitter, found, poses, steps)
    steps.end()
    return _result(animal, look, fitter, numbers, found, settled)


def _begin(
    reader: ViewReader,
    poses: tuple[Poses, Poses],
    animal: StickAnimal,
    background: BackgroundPicture,
    settings: PoseSettings,
) -> tuple[FrameFitter, dict[int, np.ndarray]]:
    """Return a fitter that knows the animal's look, and the fitted start poses by frame.

    Of ``poses``, the first are to start from, the second is the one to learn the look from.
    """
    start, look = poses
    frame = reader.frame(int(look.frames[0]))
    fitter, first = prepare_fitter(
        frame, look, animal=animal, background=background, settings=settings
    )
    # one animal has one size: where another start pose is larger, its legs are longer
    start = dataclasses.replace(start, scale=np.full(len(start), float(look.scale[0])))
    vectors = pose_vectors(animal, start, factor=fitter.evidence.factor)
    fitter, pose, support = fit_start(fitter, frame, first)
    known = {frame.index: _checked(pose, support, frame=frame.index)}
    for number, vector in zip(start.frames.tolist(), vectors, strict=True):
        if number not in known:
            fitted = fit_known(fitter, reader.frame(number), vector)
            known[number] = _checked(*fitted, frame=number)
    return fitter, {number: known[number] for number in start.frames.tolist()}


def _checked(pose: FloatArray, support: float, *, frame: int) -> FloatArray:
    """Return a fitted start pose, if it is on the animal."""
    check_on_animal(support, frame=frame)
    return pose


class _Ways:
    """Readers of one view for ways through it that are followed at the same time.

    A reader goes through the file; two that took turns in it would seek before every frame.
    """

    def __init__(self, reader: ViewReader, steps: Steps) -> None:
        self._free, self._steps = [reader], steps
        self._first = reader

    def read(self, numbers: range) -> Iterator[Frame]:
        """Yield frames, decoded in a thread of their own a few ahead."""
        try:
            reader = self._free.pop()  # of two threads, one gets it
        except IndexError:
            reader = self._first.again()
        try:
            yield from _read_ahead(reader, numbers, self._steps)
        finally:
            if reader is self._first:
                self._free.append(reader)
            else:
                reader.close()


def _read_ahead(reader: ViewReader, numbers: range, steps: Steps) -> Iterator[Frame]:
    """Yield frames, decoded in a thread of their own a few ahead."""
    with Threads(1, thread_name_prefix="pawnb-pose") as pool:
        waiting = []
        for i in numbers:
            waiting.append(pool.submit(reader.frame, i))
            if len(waiting) > 4:
                yield waiting.pop(0).result()
            if steps.stopped():
                break
        for future in waiting:
            if steps.stopped():
                future.cancel()
            else:
                yield future.result()


def _finish(
    fitter: FrameFitter, found: list[LegCandidates], poses: FloatArray, steps: Steps
) -> list[Settled]:
    """Return the last fit of every frame."""
    settled = settle_all(fitter, found, poses)
    for _ in found:
        steps.one()
    return settled


def _result(
    animal: StickAnimal,
    look: Poses,
    fitter: FrameFitter,
    numbers: IntArray,
    found: list[LegCandidates],
    settled: list[Settled],
) -> PoseTrack:
    """Return what was found in px of the view, one row a frame."""
    n, n_legs = len(numbers), len(animal.legs)
    factor = fitter.evidence.factor
    rows = np.array([c.frame for c in found], dtype=int) - int(numbers[0])
    vectors, sds = np.full((n, fitter.index.n), np.nan), np.full((n, fitter.index.n), np.nan)
    places = np.full((n, *fitter.layout.radius.shape, 2), np.nan)
    support = np.full((n, n_legs), np.nan)
    for row, one in zip(rows, settled, strict=True):
        vectors[row], sds[row] = one.pose, one.sd
        places[row] = one.places_sd * factor
        support[row] = np.fmin(one.support[:, 0], one.support[:, 1])
    scale = float(look.scale[0])
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
