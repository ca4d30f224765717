"""How far appearance is trusted beside motion: clicked frames are left out in turn."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.positional_prior import prior_from_clicks
from pawnb.core.paws.offline.detection.appearance import (
    appearance_maps,
    clicked_lessons,
    learn_appearance,
)
from pawnb.core.paws.offline.detection.evidence import paint
from pawnb.core.paws.offline.detection.motion import detect_by_motion
from pawnb.core.paws.offline.parameters import RUN, OfflineParameters
from pawnb.core.paws.offline.view_input import ViewInput


@dataclass(frozen=True)
class Weighing:
    """What leaving out clicked frames has shown.

    Parameters
    ----------
    trust : float
        Power of the ratio of likelihoods by appearance.
    found : ndarray, shape (m,)
        With that power, the probability that the model gave to within half a paw of each click
        that was left out; empty where only one frame was clicked.
    """

    trust: float
    found: np.ndarray


def weigh(views: Sequence[ViewInput], n_points: int, parameters: OfflineParameters) -> Weighing:
    """Choose how far appearance is trusted.

    Parameters
    ----------
    views : sequence of ViewInput
        The views, each by itself.
    n_points : int
        Number of points in all.
    parameters : OfflineParameters
        Parameters of all stages.

    Returns
    -------
    Weighing
        The power with the largest mean logarithm of the probability at clicks that were left
        out; the parameters' own where no frame can be left out or none is clearly better.
    """
    scores = [_left_out(view, n_points, parameters) for view in views]
    table = np.concatenate([np.empty((0, len(parameters.appearance.trusts))), *scores])
    if not len(table):
        return Weighing(parameters.appearance.trust, np.empty(0))
    score = np.log(table + RUN.weighing_chance).sum(axis=0)
    usual = parameters.appearance.trusts.index(parameters.appearance.trust)
    best = int(np.argmax(score))
    if score[best] < score[usual] + RUN.weighing_clear:
        best = usual
    return Weighing(parameters.appearance.trusts[best], table[:, best])


def _left_out(view: ViewInput, n_points: int, parameters: OfflineParameters) -> np.ndarray:
    """Return the probability at each click that was left out, for every power."""
    rows = view.annotations.rows
    if len(rows) < RUN.weighing_fewest:
        return np.empty((0, len(parameters.appearance.trusts)))
    chosen = np.unique(np.linspace(0, len(rows) - 1, parameters.appearance.folds).round())
    tables = [_one_left_out(view, rows[int(i)], n_points, parameters) for i in chosen]
    return np.concatenate(tables)


def _one_left_out(
    view: ViewInput, row: int, n_points: int, parameters: OfflineParameters
) -> np.ndarray:
    """Return the probability (points, powers) at the clicks of one frame, tracked without it."""
    stack, trusts = view.stack, parameters.appearance.trusts
    rest = view.annotations.without(row)
    points = sorted(set(view.annotations.places[row]) & set(rest.points))
    # clicks close the model: beyond the neighbouring ones nothing bears on this frame
    begin = max((r for r in rest.rows if r < row), default=0)
    end = 1 + min((r for r in rest.rows if r > row), default=stack.shape[0] - 1)
    part, placed = stack.part(begin, end), rest.part(begin, end)
    classify = learn_appearance(
        stack,
        clicked_lessons(stack, rest),
        n_points=n_points,
        parameters=parameters.appearance,
    )
    looks = appearance_maps(
        stack, classify, points=points, parameters=parameters.appearance, rows=range(begin, end)
    )
    motion = detect_by_motion(part, placed, parameters.motion)
    ratios = {point: paint(motion, part, point) for point in points}
    radius = parameters.appearance.radius / parameters.scene.spacing
    priors = prior_from_clicks(stack, rest, radius=radius, parameters=parameters)
    once = dataclasses.replace(parameters.association, iterations=1)
    table = np.zeros((len(points), len(trusts)))
    for k, trust in enumerate(trusts):
        likelihood = {point: ratios[point] * looks[point] ** trust for point in points}
        evidence = ViewEvidence(part, view.name, view.size, placed, likelihood, priors)
        posteriors = associate([evidence], radius=radius, parameters=once, compared=False)[0]
        for i, point in enumerate(points):
            mass = posteriors[point].mass[row - begin]
            x, y = stack.grid_of(view.annotations.places[row][point], row)
            v, u = np.mgrid[: mass.shape[0], : mass.shape[1]]
            table[i, k] = mass[(u - x) ** 2 + (v - y) ** 2 <= radius**2].sum()
    return table
