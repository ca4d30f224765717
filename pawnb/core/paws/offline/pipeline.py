"""The pipeline on one page: evidence, association, learning from what is agreed, estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.estimates import Estimates, estimate
from pawnb.core.paws.offline.association.positional_prior import (
    prior_from_clicks,
    prior_from_tracks,
)
from pawnb.core.paws.offline.detection.appearance import (
    Lesson,
    appearance_maps,
    learn_appearance,
)
from pawnb.core.paws.offline.detection.evidence import Detections, paint
from pawnb.core.paws.offline.detection.motion import detect_by_motion
from pawnb.core.paws.offline.learning import agreed_lessons
from pawnb.core.paws.offline.parameters import OfflineParameters
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.rig import Rig


@dataclass(frozen=True)
class ViewInput:
    """What comes in for one view.

    Parameters
    ----------
    name : str
        Its name.
    size : (int, int)
        Its width and height, px.
    stack : BodyStack
        Its pictures in the body's frame.
    annotations : Annotations
        What was placed by hand.
    detections : sequence of Detections
        Of further kinds of evidence.
    """

    name: str
    size: tuple[int, int]
    stack: BodyStack
    annotations: Annotations
    detections: Sequence[Detections] = ()


def run_pipeline(
    views: Sequence[ViewInput],
    *,
    n_points: int,
    parameters: OfflineParameters,
    rig: Rig | None = None,
) -> list[dict[int, Estimates]]:
    """Return where every clicked point is in every view.

    Parameters
    ----------
    views : sequence of ViewInput
        The views.
    n_points : int
        Number of points in all.
    parameters : OfflineParameters
        Parameters of all stages.
    rig : Rig, optional
        Calibration of the views; without it each is tracked by itself.

    Returns
    -------
    list of dict
        For each view: point to its Estimates.
    """
    radius = parameters.appearance.radius / parameters.scene.spacing
    motion = [_motion(view, parameters) for view in views]
    lessons = [_clicked_lessons(view) for view in views]
    priors = [
        prior_from_clicks(v.stack, v.annotations, radius=radius, parameters=parameters)
        for v in views
    ]
    estimates: list[dict[int, Estimates]] = []
    for round_ in range(parameters.appearance.rounds):
        looks = [
            _appearance(view, own, n_points, parameters)
            for view, own in zip(views, lessons, strict=True)
        ]
        evidence = [
            ViewEvidence(
                v.stack, v.name, v.size, v.annotations,
                {p: m[p] * look[p] ** parameters.appearance.trust for p in m}, prior,
            )
            for v, m, look, prior in zip(views, motion, looks, priors, strict=True)
        ]  # fmt: skip
        posteriors = associate(evidence, radius=radius, parameters=parameters.association, rig=rig)
        estimates = [{p: estimate(m, radius) for p, m in own.items()} for own in posteriors]
        if round_ + 1 < parameters.appearance.rounds:
            lessons = [
                {**_clicked_lessons(v),
                 **agreed_lessons(v.stack, v.annotations, estimates=e, looks=look, priors=prior,
                                  radius=radius, parameters=parameters.appearance)}
                for v, e, look, prior in zip(views, estimates, looks, priors, strict=True)
            ]  # fmt: skip
            priors = [
                prior_from_tracks(own, prior, radius)
                for own, prior in zip(posteriors, priors, strict=True)
            ]
    return estimates


def _motion(view: ViewInput, parameters: OfflineParameters) -> dict[int, np.ndarray]:
    """Return ratios of likelihoods by motion and by further detections, for each point."""
    found = [detect_by_motion(view.stack, view.annotations, parameters.motion), *view.detections]
    ratios = {}
    for point in view.annotations.points:
        ratios[point] = paint(found[0], view.stack, point)
        for more in found[1:]:
            ratios[point] *= paint(more, view.stack, point)
    return ratios


def _clicked_lessons(view: ViewInput) -> dict[int, Lesson]:
    """Return what the clicks teach."""
    placed = view.annotations.moved(view.stack.to_body)
    return {row: Lesson(here) for row, here in placed.places.items()}


def _appearance(
    view: ViewInput, lessons: Mapping[int, Lesson], n_points: int, parameters: OfflineParameters
) -> dict[int, np.ndarray]:
    """Return ratios of likelihoods by appearance, for each point."""
    classify = learn_appearance(
        view.stack, lessons, n_points=n_points, parameters=parameters.appearance
    )
    return appearance_maps(
        view.stack, classify, points=view.annotations.points, parameters=parameters.appearance
    )
