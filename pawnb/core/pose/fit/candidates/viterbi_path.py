"""The path through the whole recording, and candidates that only the frames after it suggest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.leg_candidates import fit_leg, with_candidates
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi import ViterbiTrellis, extend_trellis
from pawnb.core.pose.fit.candidates.weighing import side_energy
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.observation import evidence_of
from pawnb.core.pose.fit.sequence.expectation import expectation, fit_expected, usual_anatomy
from pawnb.core.pose.fit.sequence.state import Followed

_Path = list[dict[int, int]]
"""Of every frame, the candidate of each leg."""


def improve_viterbi_path(followed: Followed) -> Followed:
    """Choose the path through all frames followed, after a second pass backwards.

    Where a frame left more than one candidate open, the animal is followed again from the sure
    frames after it, backwards in time, and what that finds becomes candidates too. A leg that
    still leaps, because it was lost and found again, is followed back on its own from where it
    was found.

    Parameters
    ----------
    followed : Followed
        What one direction has found.

    Returns
    -------
    Followed
        With the poses of the path, and the candidates that were found.
    """
    if not followed.fitter.settings.choose_path or not any(c.is_open for c in followed.frames):
        return followed
    followed = _adopted(followed, _paths(followed))
    followed = _followed_backwards(followed)
    paths = _paths(followed)
    leaps = _leaps(followed, paths)
    if leaps:
        followed = _traced(followed, leaps)
        paths = _paths(followed)
    return _adopted(followed, paths)


def _adopted(followed: Followed, paths: _Path) -> Followed:
    """Return frames with the poses of the path; candidates stay as they are."""
    numbers, frames = followed.fitter.index.numbers, []
    for candidates, chosen in zip(followed.frames, paths, strict=True):
        pose = candidates.pose.copy()
        for leg, which in chosen.items():
            pose[numbers[leg]] = candidates.legs[leg][which]
        frames.append(candidates.with_pose(pose))
    return followed.with_frames(frames)


def _followed_backwards(followed: Followed) -> Followed:
    """Return frames with what following backwards finds in the doubtful ones, in two halves."""
    doubtful = [t for t, candidates in enumerate(followed.frames) if candidates.is_doubtful]
    half = len(doubtful) // 2
    parts = (doubtful[:half], doubtful[half:])
    earlier, later = on_threads(lambda part: _second_pass(followed, part), parts)
    found = earlier | later
    return followed.with_frames(found.get(t, one) for t, one in enumerate(followed.frames))


def _second_pass(followed: Followed, frames: Sequence[int]) -> dict[int, LegCandidates]:
    """Follow the animal backwards through doubtful frames; return them with what is found."""
    fitter, kept, last = followed.fitter, followed.frames, len(followed.frames) - 1
    anatomy, lengths = usual_anatomy(fitter, followed.middle), fitter.index.lengths
    out, before = {}, -1
    for t in reversed(frames):
        candidates = kept[t]
        if before != t + 1:  # not followed to here: the sure frames after it say how it moves
            after = min(t + 1, last)
            pose = kept[after].pose
            velocity = pose - kept[min(t + 2, last)].pose
            velocity[lengths] = 0.0
        before = t
        expected = pose + CANDIDATES.viterbi_path_keep_velocity * velocity
        image_evidence = evidence_of(
            fitter, candidates.pose, image=candidates.grey, box=candidates.box
        )
        prior = expectation(fitter, anatomy, expected)
        found = fit_expected(fitter, expected, image_evidence=image_evidence, prior=prior)
        extra = {leg: [found[numbers]] for leg, numbers in enumerate(fitter.index.numbers)}
        out[t] = with_candidates(
            fitter, candidates, extra, image_evidence=image_evidence, prior=anatomy
        )
        velocity = found - pose
        velocity[lengths] = 0.0
        pose = found
    return out


def _paths(followed: Followed) -> _Path:
    """Return the candidate of every leg in every frame on the best paths.

    Each side's path is chosen twice, the second time by what that of the other side explains.
    """
    share = followed.fitter.settings.evidence_share
    out: _Path = [{} for _ in followed.frames]
    for legs in 2 * followed.fitter.index.sides:
        trellis: ViterbiTrellis | None = None
        for candidates, chosen in zip(followed.frames, out, strict=True):
            others = {leg: k for leg, k in chosen.items() if leg not in legs}
            energy = side_energy(candidates, legs, share, others=others)
            joints = tuple(candidates.joints[leg] for leg in legs)
            trellis = extend_trellis(trellis, energy, joints, jump_px=followed.jump_px)
        states = [] if trellis is None else trellis.path()
        for chosen, state in zip(out, states, strict=True):
            chosen.update(zip(legs, state, strict=True))
    return out


def _leaps(followed: Followed, paths: _Path) -> list[tuple[int, int, FloatArray]]:
    """Return where legs leap on the path: leg, frame, and its part of the pose vector there."""
    kept, leaps = followed.frames, []
    for leg in range(len(followed.fitter.index.numbers)):
        for t in range(len(kept) - 1, 0, -1):
            now = kept[t].joints[leg][paths[t][leg]]
            before = kept[t - 1].joints[leg][paths[t - 1][leg]]
            if np.nanmax(np.abs(now - before)) > CANDIDATES.leap_sds * followed.jump_px:
                leaps.append((leg, t, kept[t].legs[leg][paths[t][leg]]))
    return leaps


def _traced(followed: Followed, leaps: Sequence[tuple[int, int, FloatArray]]) -> Followed:
    """Return frames with what following legs backwards from their leaps finds."""
    frames = list(followed.frames)
    for leg, t, numbers in leaps:
        for back, candidates in _trace(followed.fitter, frames[:t], leg, numbers).items():
            frames[back] = candidates
    return followed.with_frames(frames)


def _trace(
    fitter: FrameFitter, frames: Sequence[LegCandidates], leg: int, numbers: FloatArray
) -> dict[int, LegCandidates]:
    """Follow one leg backwards from after the frames until it meets a candidate or is lost.

    Returned are the frames, by their place, with what was found.
    """
    velocity, out = np.zeros_like(numbers), {}
    last = len(frames) - 1
    for back in range(last, max(last - CANDIDATES.most_back, -1), -1):
        candidates = frames[back]
        image_evidence = evidence_of(
            fitter, candidates.pose, image=candidates.grey, box=candidates.box
        )
        found = fit_leg(
            fitter, candidates.pose, leg, guess=numbers + velocity, image_evidence=image_evidence,
            prior=fitter.anatomy, rounds=CANDIDATES.rounds_back,
        )  # fmt: skip
        out[back] = with_candidates(
            fitter, candidates, {leg: [found]}, image_evidence=image_evidence, prior=fitter.anatomy
        )
        if len(out[back].legs[leg]) == len(candidates.legs[leg]):
            break
        velocity = np.clip(found - numbers, -CANDIDATES.fastest_back, CANDIDATES.fastest_back)
        numbers = found
    return out


def chosen_poses(fitter: FrameFitter, found: Sequence[LegCandidates]) -> FloatArray:
    """Return the poses of a path, shape (n, n_parameters)."""
    return np.array([c.pose for c in found]).reshape(len(found), fitter.index.n)
