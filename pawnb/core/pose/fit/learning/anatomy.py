"""What is known of a pose before its frame is seen: anatomy, and where it was before."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import N_BODY, links_of
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import Prior

_UNBOUNDED = 1e9
"""Guard: a bound that is none."""


def parameter_kinds(animal: StickAnimal) -> tuple[IntArray, IntArray]:
    """Return where the angles and the foreshortenings are in the pose vector."""
    angles: list[int] = []
    lengths: list[int] = []
    at = N_BODY
    for leg in animal.legs:
        n = int(links_of(leg)[0][-1]) + 1
        angles += range(at, at + n)
        lengths += range(at + n, at + 2 * n)
        at += 2 * n
    return np.array(angles), np.array(lengths)


def anatomy(animal: StickAnimal, start: FloatArray, *, foreshortening_sd: float) -> Prior:
    """Return the prior of anatomy.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    start : ndarray, shape (n_parameters,)
        The start pose; limits are wide enough for it.
    foreshortening_sd : float
        Standard deviation of the logarithm of projected lengths.

    Returns
    -------
    Prior
        Nothing is known of the body's place.
    """
    angles, lengths = parameter_kinds(animal)
    n = len(start)
    middle, precision = np.zeros(n), np.zeros(n)
    low, high, wall = np.full(n, -_UNBOUNDED), np.full(n, _UNBOUNDED), np.zeros(n)
    natural, half = np.radians(animal.natural_deg), np.radians(animal.range_deg / 2)
    reach = LEARNING.range_more * half + np.radians(LEARNING.range_more_deg)
    more = np.radians(LEARNING.start_more_deg)
    middle[angles] = natural
    precision[angles] = 1.0 / (LEARNING.range_sd * half + np.radians(LEARNING.range_sd_deg)) ** 2
    low[angles] = np.minimum(natural - reach, start[angles] - more)
    high[angles] = np.maximum(natural + reach, start[angles] + more)
    wall[angles] = 1.0 / np.radians(LEARNING.wall_deg) ** 2
    precision[lengths] = 1.0 / foreshortening_sd**2
    low[lengths], high[lengths] = np.log(LEARNING.anatomy_foreshortened)
    wall[lengths] = 1.0 / LEARNING.wall_length**2
    group, at = np.full(n, -1), 0
    for i, leg in enumerate(animal.legs):
        links = int(links_of(leg)[0][-1]) + 1
        group[lengths[at : at + links]] = i
        at += links
    return Prior(
        middle, precision, low, high, wall, group, np.array([LEARNING.anatomy_together]),
        np.zeros(n), np.zeros((0, 0)),
    )  # fmt: skip


def about(prior: Prior, pose: FloatArray, sd: FloatArray) -> Prior:
    """Return the prior with a second source of knowledge: ``pose`` with standard deviations.

    Parameters
    ----------
    prior : Prior
        What is known already.
    pose, sd : ndarray, shape (n_parameters,)
        Expected pose and its standard deviations; infinite where nothing is expected.

    Returns
    -------
    Prior
        The product of both.
    """
    more = 1.0 / sd**2
    precision = prior.precision + more
    weighted = prior.precision * prior.middle + more * pose
    middle = np.divide(weighted, precision, out=pose.copy(), where=precision > 0)
    return prior._replace(middle=middle, precision=precision)
