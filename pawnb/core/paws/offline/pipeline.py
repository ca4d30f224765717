"""The pipeline on one page: evidence, association, learning from what is agreed, estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.agreement import trust_by_agreement
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.estimates import Estimates, estimate
from pawnb.core.paws.offline.association.positional_prior import (
    prior_from_clicks,
    prior_from_tracks,
)
from pawnb.core.paws.offline.detection.appearance import (
    Lesson,
    appearance_maps,
    clicked_lessons,
    learn_appearance,
)
from pawnb.core.paws.offline.detection.correlation import detect_by_correlation
from pawnb.core.paws.offline.detection.evidence import Detections, paint
from pawnb.core.paws.offline.detection.motion import detect_by_motion
from pawnb.core.paws.offline.learning import agreed_lessons
from pawnb.core.paws.offline.parameters import OfflineParameters
from pawnb.core.paws.offline.quality.calibration import probability_right, standard_deviation
from pawnb.core.paws.offline.quality.signs import Signs, read_signs, usual_look
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.paws.offline.view_input import ViewInput
from pawnb.core.paws.offline.weighing import Weighing, weigh
from pawnb.core.rig import Rig


@dataclass(frozen=True)
class PointTrack:
    """Where one point is in one view, and what tells whether that is right; n frames.

    Parameters
    ----------
    found : Estimates
        Where it is.
    signs : Signs
        What tells whether that is right.
    named : ndarray of bool, shape (n,), optional
        Whether one tracklet was given to it, jointly with those of all other points; where not,
        it was hidden or could not be distinguished. None where a point is alone.
    """

    found: Estimates
    signs: Signs
    named: np.ndarray | None = None


@dataclass(frozen=True)
class ViewTrack:
    """Where the points are in one view; n frames, P points, NaN where nothing was estimated.

    Parameters
    ----------
    uv : ndarray, shape (n, P, 2)
        Positions, px of the view.
    probability : ndarray, shape (n, P)
        Probability of being within about half a paw of it (:mod:`.calibration`).
    sd_px : ndarray, shape (n, P)
        Standard deviation, px.
    """

    uv: np.ndarray
    probability: np.ndarray
    sd_px: np.ndarray


def no_track(n: int, n_points: int) -> ViewTrack:
    """Return a track of n frames in which nothing was found."""
    nothing = np.full((n, n_points), np.nan)
    return ViewTrack(np.full((n, n_points, 2), np.nan), nothing, nothing.copy())


def view_track(
    stack: BodyStack,
    tracks: Mapping[int, PointTrack],
    n_points: int,
    *,
    chance: np.ndarray | None = None,
) -> ViewTrack:
    """Return estimates on the grid as positions in the view.

    Parameters
    ----------
    stack : BodyStack
        The view.
    tracks : mapping
        Point to its track.
    n_points : int
        Number of points in all.
    chance : ndarray, shape (n_points,), optional
        How likely what each point was tracked from is right; without it, it surely is.

    Returns
    -------
    ViewTrack
        Positions in the view, px.
    """
    n = stack.shape[0]
    track = no_track(n, n_points)
    rows = np.arange(n)
    for point, own in tracks.items():
        track.uv[:, point] = stack.picture_of(own.found.place, rows)
        right = probability_right(own.signs) * (1.0 if chance is None else chance[point])
        track.probability[:, point] = right
        sd_px = own.found.sd * stack.spacing / stack.scale
        track.sd_px[:, point] = standard_deviation(sd_px, right, stack.extent_px)
    return track


def run_pipeline(
    views: Sequence[ViewInput],
    *,
    n_points: int,
    parameters: OfflineParameters,
    rig: Rig | None = None,
    rows: tuple[int, int] | None = None,
    weighing: Weighing | None = None,
) -> list[dict[int, PointTrack]]:
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
    rows : tuple of int, optional
        First row and one past the last that are tracked; all views teach with all of theirs.
    weighing : Weighing, optional
        How far appearance is trusted; default what leaving out clicked frames says.

    Returns
    -------
    list of dict
        For each view: point to its track.
    """
    radius = parameters.appearance.radius / parameters.scene.spacing
    weighing = weighing or weigh(views, n_points, parameters)
    wholes, clicked = views, [clicked_lessons(v.stack, v.annotations) for v in views]
    priors = [
        prior_from_clicks(v.stack, v.annotations, radius=radius, parameters=parameters)
        for v in views
    ]
    begin, end = rows or (0, views[0].stack.shape[0])
    views = [view.part(begin, end) for view in views]
    followed = [detect_by_motion(v.stack, v.annotations, parameters.motion) for v in views]
    motion = [
        _motion(view, own, whole.annotations.points)
        for view, own, whole in zip(views, followed, wholes, strict=True)
    ]
    lessons = clicked
    others = motion
    estimates: list[dict[int, Estimates]] = []
    for round_ in range(parameters.appearance.rounds):
        looks = [
            _appearance(view, own, n_points, parameters, rows=range(begin, end))
            for view, own in zip(wholes, lessons, strict=True)
        ]
        evidence = [
            ViewEvidence(
                v.stack, v.name, v.size, v.annotations,
                {p: m[p] * look[p] ** weighing.trust for p in m}, prior, look, m,
                weighing.trust,
            )
            for v, m, look, prior in zip(views, others, looks, priors, strict=True)
        ]  # fmt: skip
        posteriors = associate(
            evidence, radius=radius, parameters=parameters.association, rig=rig,
            identity=parameters.identity, compared=round_ + 1 == parameters.appearance.rounds,
        )  # fmt: skip
        estimates = [{p: estimate(q.mass, radius) for p, q in own.items()} for own in posteriors]
        if round_ + 1 < parameters.appearance.rounds:
            others = [
                _with_correlation(view, own, m, e, parameters=parameters)
                for view, own, m, e in zip(views, followed, motion, estimates, strict=True)
            ]
            lessons = [
                own
                | _moved_on(
                    begin,
                    agreed_lessons(
                        v.stack,
                        v.annotations,
                        estimates=e,
                        looks=look,
                        priors=prior,
                        named={p: q.named for p, q in told.items()},
                        radius=radius,
                        parameters=parameters.appearance,
                    ),
                )
                for v, own, e, look, prior, told in zip(
                    views, clicked, estimates, looks, priors, posteriors, strict=True
                )
            ]
            priors = [
                prior_from_tracks({p: q.mass for p, q in own.items()}, prior, radius)
                for own, prior in zip(posteriors, priors, strict=True)
            ]
    usual = [usual_look(found, look) for found, look in zip(estimates, looks, strict=True)]
    return [
        {
            p: PointTrack(
                found[p],
                read_signs(
                    found[p],
                    motion=m[p],
                    look=look[p],
                    agreement=own[p].agreement,
                    clicked=v.annotations.rows_of(p),
                    usual_look=mean,
                ),
                own[p].named,
            )
            for p in found
        }
        for v, found, m, look, own, mean in zip(
            views, estimates, motion, looks, posteriors, usual, strict=True
        )
    ]


def _motion(view: ViewInput, followed: Detections, points: Sequence[int]) -> dict[int, np.ndarray]:
    """Return ratios of likelihoods by motion and by further detections, for each point."""
    ratios = {}
    for point in points:
        ratios[point] = paint(followed, view.stack, point)
        for more in view.detections:
            ratios[point] *= paint(more, view.stack, point)
    return ratios


def _with_correlation(
    view: ViewInput,
    followed: Detections,
    ratios: Mapping[int, np.ndarray],
    estimates: Mapping[int, Estimates],
    *,
    parameters: OfflineParameters,
) -> dict[int, np.ndarray]:
    """Return ratios with those by correlation, as far as it agrees with what others have found."""
    radius_px = parameters.appearance.radius
    found = detect_by_correlation(
        view.stack, view.annotations, parameters.correlation, radius_px=radius_px,
        followed=followed,
    )  # fmt: skip
    radius = radius_px / view.stack.spacing
    found = trust_by_agreement(found, view.stack, estimates, radius=radius)
    return {point: own * paint(found, view.stack, point) for point, own in ratios.items()}


def _moved_on(begin: int, lessons: Mapping[int, Lesson]) -> dict[int, Lesson]:
    """Return lessons of a part by the rows of the whole."""
    return {begin + row: lesson for row, lesson in lessons.items()}


def _appearance(
    view: ViewInput,
    lessons: Mapping[int, Lesson],
    n_points: int,
    parameters: OfflineParameters,
    *,
    rows: Sequence[int],
) -> dict[int, np.ndarray]:
    """Return ratios of likelihoods by appearance, for each point."""
    classify = learn_appearance(
        view.stack, lessons, n_points=n_points, parameters=parameters.appearance
    )
    return appearance_maps(
        view.stack, classify, points=view.annotations.points, parameters=parameters.appearance,
        rows=rows,
    )  # fmt: skip
