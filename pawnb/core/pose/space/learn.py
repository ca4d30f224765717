"""Appearance and proportions of the animal, learnt from frames whose joints are known in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.learning.appearance import learn_legs
from pawnb.core.pose.fit.learning.appearance_kernels import look_equations
from pawnb.core.pose.fit.pose_index import partners
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import picture_cost
from pawnb.core.pose.space.fitter import SpaceFitter
from pawnb.core.pose.space.frame import SpaceFrame
from pawnb.core.pose.space.model import SpaceModel
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.picture_kernels import paint_parts, paint_space

Sample = tuple[SpaceFrame, ImageEvidence, np.ndarray]
"""A frame, its second picture and its unknowns."""


def learn_model(fitter: SpaceFitter, samples: Sequence[Sample], first: PoseLayout) -> SpaceModel:
    """Return the model with body, legs' appearance and lengths as the pictures have them.

    Parameters
    ----------
    fitter : SpaceFitter
        With the model as known so far.
    samples : sequence of Sample
        Fitted frames.
    first : PoseLayout
        Thickness and darkness as the species file has them.

    Returns
    -------
    SpaceModel
        The changed model.
    """
    model = _learn_body(fitter, samples[::2])
    layout = _learn_legs(fitter.with_model(model), samples, first)
    return model.changed(layout=layout, lengths=_learn_lengths(model, samples))


def _learn_body(fitter: SpaceFitter, samples: Sequence[Sample]) -> SpaceModel:
    """Return the model with the body as thick and as pitched as the second view has it."""
    model = fitter.model
    no_body = np.zeros((0, 10))
    pictures = []
    for _, image_evidence, x in samples:
        value, owner, along, joints = fitter.canvas(image_evidence)
        paint_space(
            model.layout,
            x,
            model.coefs,
            no_body,
            fitter.shown,
            fitter.blur,
            image_evidence.box,
            value,
            owner,
            along,
            joints,
        )
        pictures.append((value, owner))
    front = model.size * np.array([part.centre[0] for part in model.animal.body])
    for _ in range(IN_SPACE.body_rounds):
        trials = []
        for slope in np.linspace(*IN_SPACE.pitches):
            trial = model.changed(lift=slope * front)
            trials.append((trial, 0.5 * len(samples) * (slope / IN_SPACE.pitch_sd) ** 2))
        model = _cheapest(trials, fitter.blur, samples, pictures)
        for part in range(len(front)):
            trials = []
            for thick in np.linspace(*IN_SPACE.thickness):
                thickness = model.thickness.copy()
                thickness[part] = thick
                trials.append((model.changed(thickness=thickness), 0.0))
            model = _cheapest(trials, fitter.blur, samples, pictures)
    return model


def _cheapest(
    trials: Sequence[tuple[SpaceModel, float]],
    blur: float,
    samples: Sequence[Sample],
    pictures: Sequence[tuple[np.ndarray, ...]],
) -> SpaceModel:
    """Return the model that explains the samples best; each has a cost of its own."""
    costs = [own + _picture_costs(model, blur, samples, pictures) for model, own in trials]
    return trials[int(np.argmin(costs))][0]


def _picture_costs(
    model: SpaceModel,
    blur: float,
    samples: Sequence[Sample],
    pictures: Sequence[tuple[np.ndarray, ...]],
) -> float:
    """Return the cost of all samples with this body painted on their legs."""
    total = 0.0
    for (one, image_evidence, x), (value, owner) in zip(samples, pictures, strict=True):
        value, owner = value.copy(), owner.copy()
        parts = model.body_parts(one.xy, one.heading_deg, float(x[0]))
        paint_parts(parts, float(x[0]), blur, image_evidence.box, value, owner)
        total += picture_cost(
            value, owner, image_evidence.seen, image_evidence.weight, model.settings.soft_error
        )
    return total


def _learn_legs(fitter: SpaceFitter, samples: Sequence[Sample], first: PoseLayout) -> PoseLayout:
    """Return the layout with legs as thick and dark, and the body as dark, as they are seen."""
    model = fitter.model
    layout = model.layout
    partner = partners(model.animal)
    for _ in range(IN_SPACE.leg_rounds):
        legs, nodes = layout.radius.shape
        matrix, vector = np.zeros((legs, 2 * nodes, 2 * nodes)), np.zeros((legs, 2 * nodes))
        own = fitter.with_model(model.changed(layout=layout))
        body_dark = []
        for one, image_evidence, x in samples:
            value, owner, along, joints = own.painted(one, image_evidence, x)
            look_equations(
                layout, fitter.blur, image_evidence.box, value, owner, along, joints,
                image_evidence.seen, image_evidence.weight, model.settings.soft_error, matrix,
                vector,
            )  # fmt: skip
            body_dark.append(
                np.median(image_evidence.seen[owner < -1]) if (owner < -1).any() else np.nan
            )
        layout = learn_legs(
            layout, first, partner, equations=(matrix, vector), n_frames=len(samples)
        )
        ellipse = layout.ellipse.copy()
        if np.isfinite(body_dark).any():
            ellipse[:, 4] = np.nanmedian(body_dark)
        layout = layout._replace(ellipse=ellipse)
    return layout


def _learn_lengths(model: SpaceModel, samples: Sequence[Sample]) -> np.ndarray:
    """Return the lengths of segments, each leg longer or shorter as a whole."""
    lengths = model.lengths.copy()
    seen = np.array([_sizes(model, x) for _, _, x in samples])
    for i, n in enumerate(model.layout.n_segments):
        factor = np.median(seen[:, i, :n].sum(axis=1)) / lengths[i, :n].sum()
        trust = IN_SPACE.same_length**2 / (IN_SPACE.same_length**2 + IN_SPACE.length_seen**2)
        lengths[i, :n] *= 1.0 + trust * (factor - 1.0)
    return lengths


def _sizes(model: SpaceModel, x: np.ndarray) -> np.ndarray:
    """Return the lengths (legs, segments) of segments of one frame's unknowns."""
    joints = x[1:].reshape(len(model.animal.legs), -1, 3)
    return np.asarray(np.linalg.norm(np.diff(joints, axis=1), axis=-1))
