"""The pipeline on one page: evidence, association, learning from what is agreed, estimates."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.estimates import Estimates, estimate
from pawnb.core.paws.offline.association.forward_backward import Posterior
from pawnb.core.paws.offline.association.positional_prior import (
    prior_from_clicks,
    prior_from_tracks,
)
from pawnb.core.paws.offline.detection.appearance import (
    appearance_maps,
    clicked_training_frames,
    learn_appearance,
)
from pawnb.core.paws.offline.detection.classifier import Classifier
from pawnb.core.paws.offline.detection.correlation import detect_by_correlation
from pawnb.core.paws.offline.detection.evidence import Detections, paint
from pawnb.core.paws.offline.detection.motion import detect_by_motion
from pawnb.core.paws.offline.parameters import OfflineParameters
from pawnb.core.paws.offline.quality.calibration import probability_right, standard_deviation
from pawnb.core.paws.offline.quality.signs import Signs, read_signs
from pawnb.core.paws.offline.reuse.point_evidence import PointEvidence
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.paws.offline.self_training.agreement import agreeing_share, trust_by_agreement
from pawnb.core.paws.offline.self_training.learnt import Learnt
from pawnb.core.paws.offline.self_training.pseudo_labels import pseudo_labelled_frames
from pawnb.core.paws.offline.self_training.weighing import Weighing, weigh
from pawnb.core.paws.offline.view_input import ViewInput
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
    """

    found: Estimates
    signs: Signs


@dataclass(frozen=True)
class ViewResult:
    """What the pipeline found in one view.

    Parameters
    ----------
    points : mapping
        Point to its track.
    learnt : Learnt
        What was learnt beside the clicks, by rows of the whole view.
    evidence : PointEvidence
        What the points were found by, for corrections of others.
    """

    points: Mapping[int, PointTrack]
    learnt: Learnt
    evidence: PointEvidence


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

    uv: FloatArray
    probability: np.ndarray
    sd_px: FloatArray


def no_track(n: int, n_points: int) -> ViewTrack:
    """Return a track of n frames in which nothing was found."""
    nothing = np.full((n, n_points), np.nan)
    return ViewTrack(np.full((n, n_points, 2), np.nan), nothing, nothing.copy())


def view_track(
    stack: BodyStack,
    tracks: Mapping[int, PointTrack],
    n_points: int,
    *,
    chance: FloatArray | None = None,
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
) -> list[ViewResult]:
    """Return where every clicked point is in every view.

    A first run learns twice: from the clicks, then from frames as well in which appearance and
    the whole model agree. Where an earlier run on every view is known, its frames are taken, and
    points are learnt and associated once.

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
        First row and one past the last that are tracked; all views are trained on all of theirs.
    weighing : Weighing, optional
        How far kinds are trusted; default what leaving out clicked frames says.

    Returns
    -------
    list of ViewResult
        For each view the tracks of its points, and what was learnt of it.
    """
    radius = parameters.appearance.radius / parameters.scene.spacing
    weighing = weighing or weigh(views, n_points, parameters)
    begin, end = rows or (0, views[0].stack.shape[0])
    again = all(view.earlier is not None for view in views)
    if not again:  # learnt from the beginning
        views = [dataclasses.replace(view, kept=None) for view in views]
    parameters = parameters.again() if again else parameters
    learning, powers = parameters.appearance, weighing.powers
    works = on_threads(lambda view: _Work(view, begin, end, parameters, weighing), views)
    meanwhile: list[Callable[[], None]] = []
    for work in works if again else []:
        work.take_earlier()
        meanwhile.append(work.correlate_earlier)
    for round_ in range(learning.rounds):
        # a view learns on one thread: the others learn, or are correlated, meanwhile
        meanwhile[:0] = [functools.partial(work.learn, n_points) for work in works]
        on_threads(lambda part: part(), meanwhile)
        meanwhile.clear()
        for work in works:
            work.look()
        last = round_ + 1 == learning.rounds
        posteriors = associate(
            [work.evidence(powers.appearance) for work in works], radius=radius,
            parameters=parameters.association, rig=rig, identity=parameters.identity,
            compared=last,
        )  # fmt: skip
        for work, own in zip(works, posteriors, strict=True):
            work.take_in(own, learn=not last)
    return [work.result() for work in works]


class _Work:
    """One view while it is tracked, round by round.

    Attributes
    ----------
    training_frames : mapping
        Row of the whole view to what is learnt from it.
    fresh : list of int
        Points that are looked for; of the others an earlier run has found the evidence.
    priors, others, looks : mapping
        Point to the probability of places, and to ratios of likelihoods by all kinds but
        appearance, and by appearance.
    """

    def __init__(
        self,
        whole: ViewInput,
        begin: int,
        end: int,
        parameters: OfflineParameters,
        weighing: Weighing,
    ) -> None:
        self.left_out = weighing.offsets
        self.whole, self.begin, self.end, self.parameters = whole, begin, end, parameters
        self.radius = parameters.appearance.radius / parameters.scene.spacing
        self.clicked = clicked_training_frames(whole.stack, whole.annotations)
        self.priors = prior_from_clicks(
            whole.stack, whole.annotations, radius=self.radius, parameters=parameters
        )
        self.view = view = whole.part(begin, end)
        kept = whole.kept
        self.fresh = [p for p in whole.annotations.points if kept is None or p not in kept.looks]
        self.followed = detect_by_motion(
            view.stack, view.annotations.of(self.fresh), parameters.motion
        )
        if kept is not None:
            self.followed = self.followed.joined(kept.followed)
        self.correlated: Detections
        self.motion = _motion(
            view, self.followed, whole.annotations.points, power=weighing.powers.motion
        )
        self.training_frames, self.others = dict(self.clicked), self.motion
        self.learnt = Learnt()
        self.classify: Classifier
        self.looks: dict[int, np.ndarray] = {}
        self.posteriors: dict[int, Posterior] = {}
        self.estimates: dict[int, Estimates] = {}

    def take_earlier(self) -> None:
        """Take what an earlier run has learnt."""
        earlier, stack = self.whole.earlier, self.whole.stack
        assert earlier is not None  # noqa: S101 (asked before)
        self.learnt = earlier.learnt
        self.training_frames = {**earlier.learnt.working(stack), **self.clicked}
        masses = {p: earlier.mean_mass(stack, p, prior) for p, prior in self.priors.items()}
        self.priors = prior_from_tracks(masses, self.priors, self.radius)

    def correlate_earlier(self) -> None:
        """Take in correlation, as far as it agreed with what an earlier run has found."""
        self._correlate()
        self._add_correlation(self.learnt.agreement)

    def learn(self, n_points: int) -> None:
        """Learn what points look like, where any is looked for."""
        if not self.fresh:
            return
        self.classify = learn_appearance(
            self.whole.stack,
            self.training_frames,
            n_points=n_points,
            parameters=self.parameters.appearance,
        )

    def look(self) -> None:
        """Look for points by their appearance."""
        kept = self.whole.kept
        self.looks = {} if kept is None else dict(kept.looks)
        if self.fresh:
            self.looks |= appearance_maps(
                self.whole.stack, self.classify, points=self.fresh,
                parameters=self.parameters.appearance, rows=range(self.begin, self.end),
            )  # fmt: skip

    def evidence(self, trust: float) -> ViewEvidence:
        """Return what is known before points and views are compared."""
        v, looks, others = self.view, self.looks, self.others
        likelihood = {p: m * looks[p] ** trust for p, m in others.items()}
        return ViewEvidence(
            v.stack, v.name, v.size, v.annotations, likelihood, self.priors, looks, others, trust
        )

    def take_in(self, posteriors: dict[int, Posterior], *, learn: bool) -> None:
        """Take in what was associated; learn from it for a further round."""
        self.posteriors = posteriors
        self.estimates = {p: estimate(q.mass, self.radius) for p, q in posteriors.items()}
        if not learn:
            return
        stack = self.view.stack
        self._correlate()
        shares = agreeing_share(self.correlated, stack, self.estimates, radius=self.radius)
        self._add_correlation(shares)
        agreed = pseudo_labelled_frames(
            stack, self.view.annotations, estimates=self.estimates, looks=self.looks,
            priors=self.priors, name_shares={p: q.name_share for p, q in posteriors.items()},
            radius=self.radius, parameters=self.parameters.appearance,
        )  # fmt: skip
        moved_on = {self.begin + row: own for row, own in agreed.items()}
        self.training_frames = {**self.clicked, **moved_on}
        self.learnt = Learnt.of_working(moved_on, shares, self.whole.stack)
        masses = {p: q.mass.mean(axis=0) for p, q in posteriors.items()}
        self.priors = prior_from_tracks(masses, self.priors, self.radius)

    def result(self) -> ViewResult:
        """Return the tracks of the points, and what was learnt."""
        signs = read_signs(
            self.estimates, self.posteriors, motion=self.others, looks=self.looks,
            clicked=self.view.annotations, left_out=self.left_out,
        )  # fmt: skip
        points = {p: PointTrack(found, signs[p]) for p, found in self.estimates.items()}
        evidence = PointEvidence(
            self.begin, self.end, self.whole.annotations, self.followed, self.correlated,
            self.looks, dict.fromkeys(self.looks, (self.begin, self.end)),
        )  # fmt: skip
        return ViewResult(points, self.learnt, evidence)

    def _correlate(self) -> None:
        """Find patches about clicks again."""
        found = detect_by_correlation(
            self.view.stack, self.view.annotations.of(self.fresh), self.parameters.correlation,
            radius_px=self.parameters.appearance.radius, followed=self.followed,
        )  # fmt: skip
        kept = self.whole.kept
        self.correlated = found if kept is None else found.joined(kept.correlated)

    def _add_correlation(self, shares: Mapping[int, float]) -> None:
        """Add ratios by correlation, as far as it agrees with what others have found."""
        trusted = trust_by_agreement(self.correlated, shares)
        self.others = {
            p: own * paint(trusted, self.view.stack, p) for p, own in self.motion.items()
        }


def _motion(
    view: ViewInput, followed: Detections, points: Sequence[int], *, power: float
) -> dict[int, Float32Array]:
    """Return ratios of likelihoods by motion and by further detections, for each point."""
    ratios = {}
    for point in points:
        ratios[point] = paint(followed, view.stack, point) ** power
        for more in view.detections:
            ratios[point] *= paint(more, view.stack, point)
    return ratios
