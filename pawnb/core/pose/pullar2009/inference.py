"""The pose of least energy in one frame, from a guess.

Pullar 2009, §3.4.2 and Fig. 3.8: the position by steps to the four neighbours; the angles limb by
limb for the labels found, by random combinations of -1, 0 and 1 times a multiplier that falls to
1; then the labels anew, until the energy is no longer lowered.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.pose.pullar2009.energy import Cut, FrameCosts, Pullar2009Energy
from pawnb.core.pose.pullar2009.limb_steps import (
    FLAT_EXPONENT,
    part_distances,
    shape_cost,
    turn_leg,
)
from pawnb.core.pose.pullar2009.sticks import distance_map

_LOWERED = 1e-7
"""Numerics: an energy is lower only by more than this share: costs are rounded before the cut."""
_FOUR_STEPS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Definition: the four neighbouring positions of §3.4.2, px."""


@dataclass(frozen=True, eq=False)
class FramePose:
    """The pose found in a frame.

    Parameters
    ----------
    pose : ndarray, shape (3 + n_joints,)
        u, v, heading and angles, px and degrees.
    cut : Cut
        Labels and energy for it.
    rounds : int
        Rounds of position, angles and min-cut.
    """

    pose: FloatArray
    cut: Cut
    rounds: int


def infer_pose(
    energy: Pullar2009Energy, frame: FrameCosts, guess: FloatArray, *, rng: np.random.Generator
) -> FramePose:
    """Return the pose of least energy that the 2009 search finds from a guess.

    Parameters
    ----------
    energy : Pullar2009Energy
        The energy.
    frame : FrameCosts
        The frame's costs.
    guess : ndarray, shape (3 + n_joints,)
        Where to begin.
    rng : numpy.random.Generator
        Source of the random combinations.

    Returns
    -------
    FramePose
        The pose, its labels and energy.

    Notes
    -----
    Positions are compared by their energies with the labels that are best for each; angles
    for labels that stay, as in the thesis. Since a turn that is kept lowers the energy for
    the labels at hand, and the labels found after it lower it further, no step raises it. The
    heading is turned with the legs and also beneath them: turning it with legs that already fit
    would never pay.
    """
    pose, cut = guess.copy(), energy.cut(frame, guess)
    rounds, before = 0, np.inf
    while rounds < energy.settings.max_rounds and _lower(cut.energy, before):
        rounds += 1
        before = cut.energy
        pose, cut = _move(energy, frame, pose, cut)
        turned = _turn(energy, frame, pose, cut, rng)
        if turned is not None:
            new = energy.cut(frame, turned)
            if _lower(new.energy, cut.energy):
                pose, cut = turned, new
    return FramePose(pose, cut, rounds)


def _lower(energy: float, than: float) -> bool:
    """Say whether an energy is lower, beyond rounding."""
    return np.isinf(than) or energy < than - _LOWERED * abs(than)


def _move(
    energy: Pullar2009Energy, frame: FrameCosts, pose: np.ndarray, cut: Cut
) -> tuple[np.ndarray, Cut]:
    """Step to the best of the four neighbouring positions while that lowers the energy."""
    back = None
    while True:
        steps = [step for step in _FOUR_STEPS if step != back]
        tries = []
        for step in steps:
            moved = pose.copy()
            moved[:2] += step
            tries.append((moved, energy.cut(frame, moved)))
        best = min(range(len(tries)), key=lambda i: tries[i][1].energy)
        if not _lower(tries[best][1].energy, cut.energy):
            return pose, cut
        pose, cut = tries[best]
        back = (-steps[best][0], -steps[best][1])


def _turn(
    energy: Pullar2009Energy,
    frame: FrameCosts,
    pose: np.ndarray,
    cut: Cut,
    rng: np.random.Generator,
) -> np.ndarray | None:
    """Turn body and limbs for the labels at hand; None where nothing lowers the energy."""
    v, u = np.nonzero(cut.labels)
    if not len(u):
        return None
    pixels = np.stack([u + frame.box[0], v + frame.box[1]], axis=1).astype(float)
    turned = _turn_body(energy, frame, pose, cut.labels)
    turned = _turn_limbs(energy, frame, turned, cut.labels, pixels, rng)
    return turned if (turned != pose).any() else None


def _turn_body(
    energy: Pullar2009Energy, frame: FrameCosts, pose: np.ndarray, labels: np.ndarray
) -> np.ndarray:
    """Turn the whole animal about its origin, or its body alone while the legs keep their lie."""
    sticks, p = energy.sticks, energy.parameters
    first = 3 + sticks.first[:-1]

    def cost(trial: np.ndarray) -> float:
        return energy.limits(trial) + shape_cost(
            labels, frame.box[:2], trial[2], sticks.points(trial), sticks.n_links,
            sticks.parts(trial), p.thickness_px, p.steepness,
        )  # fmt: skip

    lowest = cost(pose)
    for multiplier in range(energy.settings.first_multiplier, 0, -1):
        for turn, alone in itertools.product((multiplier, -multiplier), (False, True)):
            trial = pose.copy()
            trial[2] += turn
            if alone:
                trial[first] += sticks.side * turn
            found = cost(trial)
            if found < lowest:
                pose, lowest = trial, found
    return pose


def _turn_limbs(
    energy: Pullar2009Energy,
    frame: FrameCosts,
    pose: np.ndarray,
    labels: np.ndarray,
    pixels: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """Turn the joints of one limb after the other."""
    sticks, p = energy.sticks, energy.parameters
    pose = pose.copy()
    parts = sticks.parts(pose)
    away = part_distances(pixels, pose[2], sticks.points(pose), sticks.n_links, parts)
    most = p.thickness_px + FLAT_EXPONENT / p.steepness
    # pixels with no cost from other parts have none from this limb either
    free = p.thickness_px - FLAT_EXPONENT / p.steepness
    for i in range(len(sticks.n_links)):
        own = slice(sticks.first[i], sticks.first[i + 1])
        others = np.delete(away, 1 + i, axis=0).min(axis=0)
        rest = np.arange(len(sticks.n_links)) != i
        near = distance_map(
            frame.box[:2], labels.shape, pose[2], sticks.points(pose)[rest],
            sticks.n_links[rest], parts, most,
        )  # fmt: skip
        used = others > free
        trials = draw_turns(
            own.stop - own.start,
            first_multiplier=energy.settings.first_multiplier,
            combinations=energy.settings.combinations,
            rng=rng,
        )
        angles = pose[3:][own].copy()
        n = sticks.n_links[i]
        lowered = turn_leg(
            pose[:3], angles, trials, sticks.length[i, :n], sticks.joint[i, :n],
            sticks.fixed_deg[i, :n], n, sticks.attach[i], sticks.side[i],
            energy.middle_deg[own], energy.half_deg[own], energy.stiffness, pixels[used],
            others[used], near, labels, frame.box[:2], p.thickness_px, p.steepness,
        )  # fmt: skip
        if lowered > 0:
            pose[3:][own] = angles
            points = sticks.points(pose)[i : i + 1]
            away[1 + i] = part_distances(pixels, pose[2], points, sticks.n_links[i : i + 1], parts)[
                1
            ]
    return pose


def draw_turns(
    n_joints: int, *, first_multiplier: int, combinations: int, rng: np.random.Generator
) -> AnyArray:
    """Draw the turns that are tried for a limb, in their order.

    Parameters
    ----------
    n_joints : int
        Free joints of the limb.
    first_multiplier : int
        Degrees of the first steps; the last are of one degree.
    combinations : int
        Turns for each multiplier.
    rng : numpy.random.Generator
        Source of the random combinations.

    Returns
    -------
    ndarray, shape (first_multiplier * about combinations, n_joints)
        Combinations of -1, 0 and 1 times the multiplier, degrees. For each multiplier, those
        that turn the first joint come first, then those that leave it and turn the second, and
        so on outwards; each kind has an equal share, never fewer than its two simplest.
    """
    each = max(2, combinations // n_joints)
    out = []
    for multiplier in range(first_multiplier, 0, -1):
        for joint in range(n_joints):
            turn = rng.integers(-1, 2, (each, n_joints))
            turn[:, :joint] = 0
            turn[:, joint] = np.where(rng.random(each) < 0.5, -1, 1)
            out.append(multiplier * turn)
    return np.concatenate(out).astype(float)
