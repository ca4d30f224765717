"""Neighbouring legs that cross: perhaps each has the other's end.

Where two legs lie side by side, each can come to lie on the inner part of its own limb and on the
outer part of the other. They then cross, which legs seldom do, and neither comes back by itself:
its own end is explained by the other leg.
"""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.candidates.leg_candidates import part_near
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.weighing import legs_cross
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.layout import leg_numbers
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior


def uncrossed(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, *, prior: Prior
) -> FloatArray:
    """Return the pose in which neighbouring legs have given each other their ends back.

    Parameters
    ----------
    fitter : FrameFitter
        A fitter.
    pose : ndarray, shape (n_parameters,)
        The pose.
    image_evidence : ImageEvidence
        The frame.
    prior : Prior
        What a pose costs besides its picture.

    Returns
    -------
    ndarray, shape (n_parameters,)
        The array given where no neighbours cross, or where the picture speaks for their crossing.
    """
    for leg, neighbours in enumerate(fitter.index.neighbours):
        for other in neighbours:
            if other > leg:
                pose = _pair(fitter, pose, (leg, other), image_evidence, prior)
    return pose


def _pair(
    fitter: FrameFitter,
    pose: FloatArray,
    legs: tuple[int, int],
    image_evidence: ImageEvidence,
    prior: Prior,
) -> FloatArray:
    """Return the pose with two legs as they fit better: crossed, if they are, or not."""
    layout, places = fitter.layout, fitter.joints(pose)
    if not legs_cross(fitter, (legs[0], places[legs[0]]), (legs[1], places[legs[1]])):
        return pose
    one, other = (places[leg, : layout.n_segments[leg] + 1] for leg in legs)
    swapped = with_ends_swapped(one, other)
    trial = pose.copy()
    for leg, joints in zip(legs, swapped, strict=True):
        heading = float(pose[2])
        trial[fitter.index.numbers[leg]] = leg_numbers(layout, leg, joints, heading=heading)
    part = part_near(image_evidence, (one, other))
    active = np.concatenate([fitter.index.numbers[leg] for leg in legs])
    (_, before), (found, after) = (
        fitter.fit(which, part, prior, active=active, rounds=CANDIDATES.crossed_legs_rounds)
        for which in (pose, trial)
    )
    return found if after < before - CANDIDATES.crossed_legs_better else pose


def with_ends_swapped(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two chains that cross with what lies beyond their first crossing exchanged.

    Parameters
    ----------
    one, other : ndarray, shape (n + 1, 2)
        Joints and tips of two legs; they need not have as many.

    Returns
    -------
    one, other : ndarray
        As many places each as before, at the same shares of the new ways; the chains given where
        they do not cross.
    """
    met = _first_crossing(one, other)
    if met is None:
        return one, other
    i, j, place = met
    return (
        _laid_along(np.vstack([one[: i + 1], place, other[j + 1 :]]), one),
        _laid_along(np.vstack([other[: j + 1], place, one[i + 1 :]]), other),
    )


def _first_crossing(one: FloatArray, other: FloatArray) -> tuple[int, int, np.ndarray] | None:
    """Return which segments of two chains cross, the first of ``one`` that does, and where."""
    for i, (a, b) in enumerate(zip(one[:-1], np.diff(one, axis=0), strict=True)):
        for j, (c, d) in enumerate(zip(other[:-1], np.diff(other, axis=0), strict=True)):
            det = b[0] * d[1] - b[1] * d[0]
            away = c - a
            if abs(det) > 1e-9:
                t = (away[0] * d[1] - away[1] * d[0]) / det
                s = (away[0] * b[1] - away[1] * b[0]) / det
                if 0.0 <= t <= 1.0 and 0.0 <= s <= 1.0:
                    return i, j, a + t * b
    return None


def _laid_along(path: FloatArray, joints: FloatArray) -> FloatArray:
    """Return places at the same shares of a path as joints have of their own chain."""
    own, at = _far(joints), _far(path)
    share = own * at[-1] / max(own[-1], 1e-9)
    return np.column_stack([np.interp(share, at, path[:, i]) for i in (0, 1)])


def _far(chain: FloatArray) -> FloatArray:
    """Return how far along a chain each of its places lies."""
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(chain, axis=0).T)))
