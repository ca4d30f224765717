"""Pseudo-labels for self-training: frames in which appearance alone and the whole model agree."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.estimates import Estimates, estimate
from pawnb.core.paws.offline.detection.appearance import TrainingFrame
from pawnb.core.paws.offline.parameters import RUN, AppearanceParameters
from pawnb.core.paws.offline.scene.stack import BodyStack


def pseudo_labelled_frames(
    stack: BodyStack,
    annotations: Annotations,
    *,
    estimates: Mapping[int, Estimates],
    looks: Mapping[int, Float32Array],
    priors: Mapping[int, Float32Array],
    name_shares: Mapping[int, FloatArray | None],
    radius: float,
    parameters: AppearanceParameters,
) -> dict[int, TrainingFrame]:
    """Choose frames spread over the recording in which most points are agreed on.

    Parameters
    ----------
    stack : BodyStack
        The view.
    annotations : Annotations
        Clicked frames, which are not chosen.
    estimates : mapping
        Point to where the whole model puts it.
    looks : mapping
        Point to ratios of likelihoods by appearance alone.
    priors : mapping
        Point to the probability of places without evidence.
    name_shares : mapping
        Point to how surely the tracklet that was given to it is its own (n,); where that is 0
        nothing is learnt of it. None where names were not decided jointly.
    radius : float
        About half a paw, in places.
    parameters : AppearanceParameters
        The kind's parameters.

    Returns
    -------
    dict
        Row to its frame; points that are not agreed on are no background there.
    """
    n = stack.shape[0]
    points = sorted(estimates)
    good = np.zeros((n, len(points)), bool)
    for i, point in enumerate(points):
        alone = estimate(looks[point] * priors[point], radius)
        apart = np.linalg.norm(alone.place - estimates[point].place, axis=1)
        good[:, i] = (estimates[point].probability > parameters.sure) & (
            apart < RUN.agree_radii * radius
        )
        share = name_shares[point]
        if share is not None:
            good[:, i] &= share > 0.0
    count = good.sum(axis=1)
    training_frames = {}
    random = np.random.default_rng(0)
    for part in np.array_split(np.arange(n), parameters.learnt_frames):
        if not len(part):
            continue
        row = int(part[np.argmax(count[part] + random.uniform(0, 0.5, len(part)))])
        if row in annotations.places or count[row] < max(1, len(points) / 2):
            continue
        here = {p: stack.from_grid(estimates[p].place[row]) for p in points}
        training_frames[row] = TrainingFrame(
            {p: here[p] for i, p in enumerate(points) if good[row, i]},
            [here[p] for i, p in enumerate(points) if not good[row, i]],
            clicked=False,
        )
    return training_frames
