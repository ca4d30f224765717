"""The path through the whole recording, and candidates that only the frames after it suggest."""

from __future__ import annotations

import numpy as np

from pawnb.core.pose.fit.choices import Choices, add_candidates, fit_leg, side_energy
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.follow import Follower
from pawnb.core.pose.fit.path import Trellis

_MOST_BACK = 60
"""Frames that a leg is followed back from where it is found again."""


def look_back(follower: Follower) -> None:
    """Choose the path through all frames followed, looking back where a leg leaps.

    A leg that was lost and found again leaps: from where it was found it is followed backwards,
    the poses met on the way become candidates, and the path is chosen again. The poses of the
    path replace those in ``follower.kept``.

    Parameters
    ----------
    follower : Follower
        After its run; changed in place.
    """
    kept, settings = follower.kept, follower.fitter.settings
    if not settings.choose_path or not kept:
        return
    paths = _paths(follower)
    if _follow_back(follower, paths):
        paths = _paths(follower)
    for t, choices in enumerate(kept):
        pose = choices.pose.copy()
        for leg, which in paths[t].items():
            pose[follower.fitter.numbers[leg]] = choices.legs[leg][which]
        choices.pose = pose


def _paths(follower: Follower) -> list[dict[int, int]]:
    """Return the candidate of every leg in every frame on the best paths."""
    settings = follower.fitter.settings
    out: list[dict[int, int]] = [{} for _ in follower.kept]
    for legs in follower.sides:
        trellis = Trellis(settings.jump_px)
        for choices in follower.kept:
            energy = side_energy(choices, legs, settings.evidence_share)
            trellis.push(energy, [choices.joints[leg] for leg in legs])
        for t, state in enumerate(trellis.path()):
            out[t].update(zip(legs, state, strict=True))
    return out


def _follow_back(follower: Follower, paths: list[dict[int, int]]) -> bool:
    """Follow legs backwards from their leaps; return whether candidates were added."""
    fitter, kept = follower.fitter, follower.kept
    leap = 6 * fitter.settings.jump_px
    leaps = []
    for leg in range(len(fitter.numbers)):
        for t in range(len(kept) - 1, 0, -1):
            now = kept[t].joints[leg][paths[t][leg]]
            before = kept[t - 1].joints[leg][paths[t - 1][leg]]
            if np.nanmax(np.abs(now - before)) > leap:
                leaps.append((leg, t, kept[t].legs[leg][paths[t][leg]]))
    # candidates change places when some are added, so leaps are listed first
    added = [_trace(follower, *one) for one in leaps]
    return any(added)


def _trace(follower: Follower, leg: int, t: int, numbers: np.ndarray) -> bool:
    """Follow one leg backwards from frame t until it meets a known candidate or is lost."""
    fitter, kept = follower.fitter, follower.kept
    velocity = np.zeros_like(numbers)
    added = False
    for back in range(t - 1, max(t - 1 - _MOST_BACK, -1), -1):
        choices = kept[back]
        sight = fitter.sight(choices.image.astype(float), choices.box, choices.pose)
        found = fit_leg(
            fitter, choices.pose, leg, numbers + velocity, sight, fitter.anatomy, rounds=6
        )
        count = len(choices.legs[leg])
        add_candidates(fitter, choices, {leg: [found]}, sight, fitter.anatomy)
        if len(choices.legs[leg]) == count:
            break
        velocity = np.clip(found - numbers, -0.2, 0.2)
        numbers = found
        added = True
    return added


def chosen_poses(fitter: FrameFitter, found: list[Choices]) -> np.ndarray:
    """Return the poses of a path, shape (n, n_parameters)."""
    return np.array([c.pose for c in found]).reshape(len(found), fitter.n)
