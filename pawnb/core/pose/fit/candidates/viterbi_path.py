"""The path through the whole recording, and candidates that only the frames after it suggest."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.parallel import Threads
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates
from pawnb.core.pose.fit.candidates.leg_candidates import add_candidates, fit_leg, side_energy
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi import ViterbiTrellis
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.observation import evidence_of
from pawnb.core.pose.fit.sequence.one_direction import Follower


def improve_viterbi_path(follower: Follower) -> None:
    """Choose the path through all frames followed, after a second pass backwards.

    Where a frame left more than one candidate open, the animal is followed again from the sure
    frames after it, backwards in time, and what that finds becomes candidates too. A leg that
    still leaps, because it was lost and found again, is followed back on its own from where it
    was found. The poses of the path replace those in ``follower.kept``.

    Parameters
    ----------
    follower : Follower
        After its run; changed in place.
    """
    kept, settings = follower.kept, follower.fitter.settings
    if not settings.choose_path or not any(c.is_open for c in kept):
        return
    _adopt(follower, _paths(follower))
    doubtful = [t for t, choices in enumerate(kept) if choices.is_doubtful]
    _on_two_threads(doubtful, lambda part: _second_pass(follower, part))
    paths = _paths(follower)
    if _follow_back(follower, paths):
        paths = _paths(follower)
    _adopt(follower, paths)


def _adopt(follower: Follower, paths: list[dict[int, int]]) -> None:
    """Make the poses of the path those of the frames; candidates stay as they are."""
    for t, choices in enumerate(follower.kept):
        pose = choices.pose.copy()
        for leg, which in paths[t].items():
            pose[follower.fitter.index.numbers[leg]] = choices.legs[leg][which]
        choices.pose = pose


def _on_two_threads(frames: list[int], work: Callable[[list[int]], None]) -> None:
    """Work through frames in two halves."""
    half = len(frames) // 2
    with Threads(2, thread_name_prefix="pawnb-back") as pool:
        list(pool.map(work, [frames[:half], frames[half:]]))


def _second_pass(follower: Follower, frames: list[int]) -> None:
    """Follow the animal backwards through doubtful frames, adding what is found."""
    kept, last, fitter = follower.kept, len(follower.kept) - 1, follower.fitter
    before = -1
    for t in reversed(frames):
        choices = kept[t]
        if before != t + 1:  # not followed to here: the sure frames after it say how it moves
            after = min(t + 1, last)
            pose = kept[after].pose
            velocity = pose - kept[min(t + 2, last)].pose
            velocity[fitter.index.lengths] = 0.0
        before = t
        expected = pose + CANDIDATES.viterbi_path_keep_velocity * velocity
        image_evidence = evidence_of(fitter, choices.grey, choices.box, choices.pose)
        anatomy, _ = follower.priors(expected)
        found = follower.fit_from(expected, image_evidence)
        extra = {leg: [found[numbers]] for leg, numbers in enumerate(fitter.index.numbers)}
        add_candidates(fitter, choices, extra, image_evidence=image_evidence, prior=anatomy)
        velocity = found - pose
        velocity[fitter.index.lengths] = 0.0
        pose = found


def _paths(follower: Follower) -> list[dict[int, int]]:
    """Return the candidate of every leg in every frame on the best paths.

    Each side's path is chosen twice, the second time by what that of the other side explains.
    """
    settings = follower.fitter.settings
    out: list[dict[int, int]] = [{} for _ in follower.kept]
    for legs in 2 * follower.sides:
        viterbi_trellis = ViterbiTrellis(follower.jump_px)
        for choices, chosen in zip(follower.kept, out, strict=True):
            others = {leg: k for leg, k in chosen.items() if leg not in legs}
            energy = side_energy(choices, legs, settings.evidence_share, others=others)
            viterbi_trellis.push(energy, [choices.joints[leg] for leg in legs])
        for chosen, state in zip(out, viterbi_trellis.path(), strict=True):
            chosen.update(zip(legs, state, strict=True))
    return out


def _follow_back(follower: Follower, paths: list[dict[int, int]]) -> bool:
    """Follow legs backwards from their leaps; return whether candidates may have changed."""
    fitter, kept = follower.fitter, follower.kept
    leap = 6 * follower.jump_px
    leaps = []
    for leg in range(len(fitter.index.numbers)):
        for t in range(len(kept) - 1, 0, -1):
            now = kept[t].joints[leg][paths[t][leg]]
            before = kept[t - 1].joints[leg][paths[t - 1][leg]]
            if np.nanmax(np.abs(now - before)) > leap:
                leaps.append((leg, t, kept[t].legs[leg][paths[t][leg]]))
    # candidates change places when some are added, so leaps are listed first
    for one in leaps:
        _trace(follower, *one)
    return bool(leaps)


def _trace(follower: Follower, leg: int, t: int, numbers: FloatArray) -> None:
    """Follow one leg backwards from frame t until it meets a known candidate or is lost."""
    fitter, kept = follower.fitter, follower.kept
    velocity = np.zeros_like(numbers)
    for back in range(t - 1, max(t - 1 - CANDIDATES.most_back, -1), -1):
        choices = kept[back]
        image_evidence = evidence_of(fitter, choices.grey, choices.box, choices.pose)
        found = fit_leg(
            fitter,
            choices.pose,
            leg,
            guess=numbers + velocity,
            image_evidence=image_evidence,
            prior=fitter.anatomy,
            rounds=6,
        )
        count = len(choices.legs[leg])
        add_candidates(
            fitter, choices, {leg: [found]}, image_evidence=image_evidence, prior=fitter.anatomy
        )
        if len(choices.legs[leg]) == count:
            break
        velocity = np.clip(found - numbers, -CANDIDATES.fastest_back, CANDIDATES.fastest_back)
        numbers = found


def chosen_poses(fitter: FrameFitter, found: list[LegCandidates]) -> FloatArray:
    """Return the poses of a path, shape (n, n_parameters)."""
    return np.array([c.pose for c in found]).reshape(len(found), fitter.index.n)
