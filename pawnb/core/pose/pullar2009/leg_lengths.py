"""How long each leg looks in the start frame.

Seen from above a leg is shorter than it is, since it is raised. In the thesis a person adjusts the
leg span by eye, so that "a balance had to be struck between having some of the stick model legs
too long and/or short" (Pullar 2009, §5.1.2). Here each leg has its factor, chosen by the energy.
"""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.pullar2009.energy import FrameCosts, Pullar2009Energy
from pawnb.core.pose.pullar2009.inference import infer_pose
from pawnb.core.pose.pullar2009.limb_steps import shape_cost
from pawnb.core.pose.pullar2009.parameters import PULLAR2009
from pawnb.core.pose.pullar2009.sticks import Sticks, distance_map


def fit_leg_lengths(
    energy: Pullar2009Energy, frame: FrameCosts, pose: FloatArray, *, rng: np.random.Generator
) -> tuple[Pullar2009Energy, FloatArray]:
    """Find how long each leg looks.

    Parameters
    ----------
    energy : Pullar2009Energy
        The energy.
    frame : FrameCosts
        The start frame's costs.
    pose : ndarray, shape (3 + n_joints,)
        The start pose.
    rng : numpy.random.Generator
        Source of the random combinations.

    Returns
    -------
    energy : Pullar2009Energy
        That of a stick animal with those lengths.
    factors : ndarray, shape (n_legs,)
        Factor of each leg's length, of :func:`lengths_tried`. The pose and the factors are fitted
        in turn, a few times: each leg gets the factor for which the shape prior costs least, the
        labels being those of the likelihood alone (Fig. 3.6b) near the legs, which keep their
        thin ends.
    """
    whole, tried = energy.sticks, lengths_tried()
    factors = np.ones(len(whole.n_links))
    for _ in range(PULLAR2009.lengths_rounds):
        fit = infer_pose(energy, frame, pose, rng=rng)
        pose, before = fit.pose, factors.copy()
        dark = _dark_along(energy, frame, scaled(whole, np.full(len(factors), tried[-1])), pose)
        for leg in range(len(factors)):
            costs = []
            for factor in tried:
                factors[leg] = factor
                costs.append(_cost(energy, frame, scaled(whole, factors), pose, dark))
            factors[leg] = tried[int(np.argmin(costs))]
        energy = energy.with_sticks(scaled(whole, factors))
        if np.abs(factors - before).max() < PULLAR2009.lengths_settled:
            break
    return energy, factors


def lengths_tried() -> FloatArray:
    """Return the lengths that are tried, as shares of the start pose, ascending."""
    p = PULLAR2009
    # a step's fraction more, so that rounding does not leave out the last
    return np.arange(p.lengths_from, p.lengths_to + p.lengths_step / 2, p.lengths_step)


def scaled(sticks: Sticks, factors: FloatArray) -> Sticks:
    """Return the shape with each leg's lengths multiplied by its factor."""
    return dataclasses.replace(sticks, length=sticks.length * factors[:, None])


def per_segment(animal: StickAnimal, factors: FloatArray) -> FloatArray:
    """Return the factor of each segment, shape (n_segments,), from those of the legs."""
    return np.repeat(factors, [len(leg.segments) for leg in animal.legs])


def _dark_along(
    energy: Pullar2009Energy, frame: FrameCosts, sticks: Sticks, pose: np.ndarray
) -> np.ndarray:
    """Return the pixels near the shape that stand out of the background, specks left out."""
    u0, v0, u1, v1 = frame.box
    reach = PULLAR2009.lengths_reach * energy.parameters.thickness_px
    away = distance_map(
        (u0, v0), (v1 - v0, u1 - u0), pose[2], sticks.points(pose), sticks.n_links,
        sticks.parts(pose), reach,
    )  # fmt: skip
    dark = (frame.own < 0) & (away < reach)
    _, names, stats, _ = cv2.connectedComponentsWithStats(dark.astype(np.uint8), connectivity=8)
    large = stats[:, cv2.CC_STAT_AREA] >= PULLAR2009.lengths_speck_px
    large[0] = False
    return large[names]


def _cost(
    energy: Pullar2009Energy,
    frame: FrameCosts,
    sticks: Sticks,
    pose: np.ndarray,
    labels: np.ndarray,
) -> float:
    """Return the shape prior's cost for labels that stay."""
    p, margin = energy.parameters, int(PULLAR2009.lengths_margin_of_span * energy.span_px)
    # beyond the picture there is no animal either
    wide = np.pad(labels, margin)
    origin = (frame.box[0] - margin, frame.box[1] - margin)
    return float(
        shape_cost(
            wide,
            origin,
            pose[2],
            sticks.points(pose),
            sticks.n_links,
            sticks.parts(pose),
            p.thickness_px,
            p.steepness,
        )
    )
