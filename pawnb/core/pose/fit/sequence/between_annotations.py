"""Several known frames: between two of them the animal is followed from both, and the path joins.

A leg that follows its neighbour from one side may be right from the other: what either way finds
becomes a candidate, and the path goes from the one known pose to the other.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable

import numpy as np

from pawnb.core.frame_checkpoint import KeptFrames
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates, only_choice
from pawnb.core.pose.fit.candidates.leg_candidates import add_candidates
from pawnb.core.pose.fit.candidates.viterbi_path import improve_viterbi_path
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.observation import evidence_of, observe
from pawnb.core.pose.fit.parallel import side_by_side
from pawnb.core.pose.fit.rendering.blur import blurred
from pawnb.core.pose.fit.sequence.first_frame import start_prior
from pawnb.core.pose.fit.sequence.one_direction import Follower
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.steps import Steps
from pawnb.core.pose.fit.support import body_support
from pawnb.core.video.views import Frame

HEADING = 2
"""Where a pose vector has the heading."""


Read = Callable[[range], Iterable[Frame]]
"""Yields the frames of a range, in its order."""


def fit_known(fitter: FrameFitter, frame: Frame, pose: np.ndarray) -> tuple[np.ndarray, float]:
    """Fit a further known frame, once the start frame has shown how the animal looks.

    Parameters
    ----------
    fitter : FrameFitter
        Knows the animal's look.
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
        pose, _ = fitter.fit(pose, soft, prior, blur=fitter.blur + blur, rounds=8)
    image_evidence, _, _ = observe(fitter, frame, pose)
    pose, _ = fitter.fit(pose, image_evidence, prior, rounds=20)
    return pose, body_support(fitter, pose, image_evidence)


def follow_all(
    fitter: FrameFitter,
    known: dict[int, np.ndarray],
    frames: tuple[int, int],
    *,
    read: Read,
    steps: Steps,
    kept: KeptFrames,
    turn: str = "",
) -> list[LegCandidates]:
    """Follow the animal both ways from every known frame.

    Parameters
    ----------
    fitter : FrameFitter
        Knows the animal's look.
    known : dict of int to ndarray, shape (n_parameters,)
        Frame to pose, working pixels; one or more, within ``frames``. Of one alone the pose is
        where following begins; of several, each is kept as it is.
    frames : tuple of int
        First frame and one past the last.
    read : callable
        Yields the frames of a range; also of two at the same time.
    steps : Steps
        Counts the frames that are followed.
    kept : KeptFrames
        What an interrupted run has found, and what this one finds.
    turn : str
        Begins the names of the ways, so that a second turn is kept apart from the first.

    Returns
    -------
    list of Choices
        What every frame leaves open, frames ascending.
    """
    numbers = sorted(known)
    first, last = numbers[0], numbers[-1]
    before, after = range(first - 1, frames[0] - 1, -1), range(last, frames[1])

    def back() -> list[LegCandidates]:
        follower = Follower(fitter, known[first])
        found = follower.run(
            read(before), done=steps.one, kept=kept, way=f"{turn}from {first} back"
        )
        improve_viterbi_path(follower)
        return found[::-1]

    def onwards() -> list[LegCandidates]:
        found = []
        for ends in itertools.pairwise(numbers):
            found += _between(fitter, ends, known, read, steps, kept, turn)
        follower = Follower(fitter, known[last])
        part = follower.run(read(after), done=steps.one, kept=kept, way=f"{turn}from {last}")
        if len(known) > 1:
            _pin(fitter, part, known)
        improve_viterbi_path(follower)
        return found + part

    earlier, later = side_by_side(back, onwards, steps)
    return _unwrapped(earlier + later)


def _between(
    fitter: FrameFitter,
    ends: tuple[int, int],
    known: dict[int, np.ndarray],
    read: Read,
    steps: Steps,
    kept: KeptFrames,
    turn: str,
) -> list[LegCandidates]:
    """Return what frames leave open from one known frame to before the next."""
    first, last = ends
    backward = Follower(fitter, known[last])
    frames = read(range(last, first, -1))
    found = backward.run(frames, done=steps.one, kept=kept, way=f"{turn}from {last} back")
    back = {choices.frame: choices for choices in found}
    forward = Follower(fitter, known[first])
    found = forward.run(
        read(range(first, last)), done=steps.one, kept=kept, way=f"{turn}from {first}"
    )
    for choices in found:
        if (other := back.pop(choices.frame, None)) is not None:
            _add(fitter, choices, other.pose)
    found += [back[number] for number in sorted(back)]
    _pin(fitter, found, known)
    _unwrapped(found)
    improve_viterbi_path(forward)
    return [choices for choices in found if choices.frame != last]


def _add(fitter: FrameFitter, choices: LegCandidates, pose: np.ndarray) -> None:
    """Make each leg of another pose a candidate."""
    image_evidence = evidence_of(fitter, choices.grey, choices.box, choices.pose)
    extra = {leg: [pose[numbers]] for leg, numbers in enumerate(fitter.index.numbers)}
    add_candidates(fitter, choices, extra, image_evidence=image_evidence, prior=fitter.anatomy)


def _pin(fitter: FrameFitter, kept: list[LegCandidates], known: dict[int, np.ndarray]) -> None:
    """Leave nothing open in known frames."""
    for i, choices in enumerate(kept):
        pose = known.get(choices.frame)
        if pose is not None:
            image = choices.grey
            kept[i] = only_choice(fitter, choices.frame, pose, image=image, box=choices.box)
            kept[i].alternatives = [c[:0] for c in kept[i].legs]


def _unwrapped(kept: list[LegCandidates]) -> list[LegCandidates]:
    """Give headings no leaps of a whole turn: each known pose has its own."""
    turns = np.unwrap([choices.pose[HEADING] for choices in kept])
    for choices, turn in zip(kept, turns, strict=True):
        choices.pose = choices.pose.copy()
        choices.pose[HEADING] = turn
    return kept
