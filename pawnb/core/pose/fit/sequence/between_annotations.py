"""Several known frames: between two of them the animal is followed from both, and the path joins.

A leg that follows its neighbour from one side may be right from the other: what either way finds
becomes a candidate, and the path goes from the one known pose to the other.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates, only_candidate
from pawnb.core.pose.fit.candidates.leg_candidates import with_candidates
from pawnb.core.pose.fit.candidates.viterbi_path import improve_viterbi_path
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.observation import evidence_of, observe
from pawnb.core.pose.fit.rendering.blur import blurred
from pawnb.core.pose.fit.sequence.first_frame import start_prior
from pawnb.core.pose.fit.sequence.one_direction import follow
from pawnb.core.pose.fit.sequence.parallel import side_by_side
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.sequence.state import Followed
from pawnb.core.pose.fit.steps import Steps
from pawnb.core.pose.fit.support import body_support
from pawnb.core.video.views import Frame

HEADING = 2
"""Layout: where a pose vector has the heading."""


Read = Callable[[range], Iterable[Frame]]
"""Yields the frames of a range, in its order."""


def fit_known(fitter: FrameFitter, frame: Frame, pose: FloatArray) -> tuple[FloatArray, float]:
    """Fit a further known frame, once the start frame has shown the animal's appearance.

    Parameters
    ----------
    fitter : FrameFitter
        Knows the animal's appearance.
    frame : Frame
        The frame.
    pose : ndarray, shape (n_parameters,)
        The person's pose, working pixels.

    Returns
    -------
    pose : ndarray
        The fitted pose.
    support : float
        How dark the body's place is relative to what is expected, 0 to 1.
    """
    prior = start_prior(fitter, pose)
    image_evidence, _, _ = observe(fitter, frame, pose)
    for blur in SEQUENCE.between_annotations_coarse_blurs:
        soft = blurred(image_evidence, blur)
        pose, _ = fitter.fit(
            pose, soft, prior, blur=fitter.blur + blur, rounds=SEQUENCE.rounds_blurred
        )
    image_evidence, _, _ = observe(fitter, frame, pose)
    pose, _ = fitter.fit(pose, image_evidence, prior, rounds=SEQUENCE.rounds_whole)
    return pose, body_support(fitter, pose, image_evidence)


@dataclass(frozen=True)
class Ways:
    """What is the same for all ways through a recording.

    Parameters
    ----------
    read : callable
        Yields the frames of a range; also of two at the same time.
    steps : Steps
        Counts the frames that are followed.
    kept : KeptFrames
        What an interrupted run has found, and what this one finds.
    turn : str
        Begins the names of the ways, so that a second turn is kept apart from the first.
    """

    read: Read
    steps: Steps
    kept: KeptFrames
    turn: str = ""

    def follow(
        self, fitter: FrameFitter, pose: FloatArray, numbers: range, *, way: str
    ) -> Followed:
        """Return what is found from a pose through frames.

        Parameters
        ----------
        fitter : FrameFitter
            What poses are fitted with.
        pose : ndarray, shape (n_parameters,)
            The pose in the frame before the first.
        numbers : range
            The frames.
        way : str
            Which way it is.

        Returns
        -------
        Followed
            What was found.
        """
        return follow(
            fitter, pose, self.read(numbers), done=self.steps.one, kept=self.kept,
            way=f"{self.turn}{way}",
        )  # fmt: skip


def follow_all(
    fitter: FrameFitter, known: Mapping[int, FloatArray], frames: tuple[int, int], *, ways: Ways
) -> tuple[LegCandidates, ...]:
    """Follow the animal both ways from every known frame.

    Parameters
    ----------
    fitter : FrameFitter
        Knows the animal's appearance.
    known : mapping of int to ndarray, shape (n_parameters,)
        Frame to pose, working pixels; one or more, within ``frames``. Of one alone the pose is
        where following begins; of several, each is kept as it is.
    frames : tuple of int
        First frame and one past the last.
    ways : Ways
        How frames are read, counted and kept.

    Returns
    -------
    tuple of LegCandidates
        What every frame leaves open, frames ascending.
    """
    numbers = sorted(known)
    first, last = numbers[0], numbers[-1]

    def back() -> list[LegCandidates]:
        before = range(first - 1, frames[0] - 1, -1)
        followed = ways.follow(fitter, known[first], before, way=f"from {first} back")
        return list(improve_viterbi_path(followed).frames[::-1])

    def onwards() -> list[LegCandidates]:
        found: list[LegCandidates] = []
        for ends in itertools.pairwise(numbers):
            found += _between(fitter, known, ends, ways)
        after = range(last, frames[1])
        followed = ways.follow(fitter, known[last], after, way=f"from {last}")
        if len(known) > 1:
            followed = followed.with_frames(_pinned(fitter, followed.frames, known))
        return [*found, *improve_viterbi_path(followed).frames]

    earlier, later = side_by_side(back, onwards, ways.steps)
    return tuple(_unwrapped(earlier + later))


def _between(
    fitter: FrameFitter, known: Mapping[int, FloatArray], ends: tuple[int, int], ways: Ways
) -> list[LegCandidates]:
    """Return what frames leave open from one known frame to before the next."""
    first, last = ends
    backward = ways.follow(
        fitter, known[last], range(last, first, -1), way=f"from {last} back"
    ).frames
    forward = ways.follow(fitter, known[first], range(first, last), way=f"from {first}")
    there, back = (
        {candidates.frame: candidates for candidates in found}
        for found in (forward.frames, backward)
    )
    found = [
        _with_pose_of(fitter, candidates, back[number]) if number in back else candidates
        for number, candidates in there.items()
    ]
    found += [back[number] for number in sorted(back) if number not in there]
    found = _unwrapped(_pinned(fitter, found, known))
    improved = improve_viterbi_path(forward.with_frames(found))
    return [candidates for candidates in improved.frames if candidates.frame != last]


def _with_pose_of(
    fitter: FrameFitter, candidates: LegCandidates, other: LegCandidates
) -> LegCandidates:
    """Return a frame to which each leg of another pose is a candidate."""
    image_evidence = evidence_of(fitter, candidates.pose, image=candidates.grey, box=candidates.box)
    extra = {leg: [other.pose[numbers]] for leg, numbers in enumerate(fitter.index.numbers)}
    return with_candidates(
        fitter, candidates, extra, image_evidence=image_evidence, prior=fitter.anatomy
    )


def _pinned(
    fitter: FrameFitter, found: Sequence[LegCandidates], known: Mapping[int, FloatArray]
) -> list[LegCandidates]:
    """Return frames that leave nothing open where the pose is known."""

    def pinned(candidates: LegCandidates) -> LegCandidates:
        if candidates.frame not in known:
            return candidates
        pose, grey = known[candidates.frame], candidates.grey
        only = only_candidate(fitter, candidates.frame, pose, image=grey, box=candidates.box)
        return only.with_alternatives({})

    return [pinned(candidates) for candidates in found]


def _unwrapped(found: Sequence[LegCandidates]) -> list[LegCandidates]:
    """Give headings no leaps of a whole turn: each known pose has its own."""
    out = []
    turns = np.unwrap([candidates.pose[HEADING] for candidates in found])
    for candidates, turn in zip(found, turns, strict=True):
        pose = candidates.pose.copy()
        pose[HEADING] = turn
        out.append(candidates.with_pose(pose))
    return out
