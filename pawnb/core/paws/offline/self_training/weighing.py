"""How far kinds of evidence are trusted, and labels: clicked frames are left out in turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.estimates import estimate
from pawnb.core.paws.offline.association.positional_prior import prior_from_clicks
from pawnb.core.paws.offline.detection.appearance import (
    appearance_maps,
    clicked_training_frames,
    learn_appearance,
)
from pawnb.core.paws.offline.detection.evidence import paint
from pawnb.core.paws.offline.detection.motion import detect_by_motion
from pawnb.core.paws.offline.parameters import RUN, OfflineParameters
from pawnb.core.paws.offline.quality.left_out import LeftOutClick, offsets
from pawnb.core.paws.offline.quality.signs import read_signs
from pawnb.core.paws.offline.view_input import ViewInput


@dataclass(frozen=True)
class Powers:
    """Powers of the ratios of likelihoods by kind.

    Parameters
    ----------
    appearance, motion : float
        0 leaves a kind out.
    """

    appearance: float
    motion: float = 1.0


@dataclass(frozen=True)
class Weighing:
    """What leaving out clicked frames has shown.

    Parameters
    ----------
    powers : Powers
        How far kinds of evidence are trusted.
    offsets : mapping
        Point to how much the log-odds of its labels differ from what their signs say
        (:func:`.quality.left_out.offsets`); without points that were clicked in one frame only.
    left_out : tuple of LeftOutClick
        The clicks that were left out, and what was found of them by these powers.
    """

    powers: Powers
    offsets: Mapping[int, float] = field(default_factory=dict)
    left_out: tuple[LeftOutClick, ...] = ()


def usual_powers(parameters: OfflineParameters) -> Powers:
    """Return the powers that are taken where the recording itself does not say."""
    return Powers(parameters.appearance.trust)


def weigh(views: Sequence[ViewInput], n_points: int, parameters: OfflineParameters) -> Weighing:
    """Leave out clicked frames in turn, to learn how far kinds of evidence and labels are trusted.

    Each is tracked without its clicks as the recording will be, with names decided jointly. Powers
    are chosen by frames with clicks on both sides: from one side tracking is another task, and what
    does it best does not do best between two (none of eight clicks of the horse was found so, and
    95 % of its marks were right). Tried are, beside the usual powers, others of appearance and each
    kind alone, so that no single kind is clearly better on what was left out. Where the usual ones
    find so much that nothing can be clearly better, nothing is tried.

    Correlation is trusted by its agreement with these (:mod:`.agreement`), other programs'
    predictions by how they fit all clicks (:mod:`.detection.prediction_reliability`).

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
        The powers by which the clicks are likeliest, the usual ones where no frame can be left
        out or none is clearly better; and what was found by them.
    """
    usual = usual_powers(parameters)
    frames = [
        _LeftOut(view, row, n_points, parameters)
        for view in views
        for row in _left_out_rows(view, parameters)
    ]
    if not frames:
        return Weighing(usual)
    by_powers = {usual: [one.outcome(usual) for one in frames]}
    between = [i for i, one in enumerate(frames) if one.between]

    def score(powers: Powers) -> float:
        return _score([click.found for i in between for click in by_powers[powers][i]])

    best, least = usual, score(usual) + RUN.weighing_clear
    highest = _score([1.0 for i in between for _ in by_powers[usual][i]])
    for powers in _others(usual, parameters):
        if least >= highest:
            break
        by_powers[powers] = [one.outcome(powers) if one.between else [] for one in frames]
        if score(powers) > least:
            best, least = powers, score(powers)
    outcomes = [by_powers[best][i] or one.outcome(best) for i, one in enumerate(frames)]
    left_out = tuple(click for clicks in outcomes for click in clicks)
    return Weighing(best, offsets(left_out), left_out)


def _left_out_rows(view: ViewInput, parameters: OfflineParameters) -> list[int]:
    """Return the clicked rows of a view that are left out, spread evenly; none of one."""
    rows = view.annotations.rows
    if len(rows) < 2:  # of one nothing is left to find it from
        return []
    chosen = np.unique(np.linspace(0, len(rows) - 1, parameters.appearance.folds).round())
    return [rows[int(i)] for i in chosen]


def _others(usual: Powers, parameters: OfflineParameters) -> list[Powers]:
    """Return the powers that are tried beside the usual ones."""
    appearance = [Powers(trust) for trust in parameters.appearance.trusts]
    return [one for one in [*appearance, Powers(usual.appearance, motion=0.0)] if one != usual]


def _score(found: Sequence[float]) -> float:
    """Return the logarithm of the probability of all clicks."""
    return float(np.log(np.array(found, float) + RUN.weighing_chance).sum())


class _LeftOut:
    """A clicked frame that is tracked without its clicks."""

    def __init__(
        self, view: ViewInput, row: int, n_points: int, parameters: OfflineParameters
    ) -> None:
        self.view, self.parameters = view, parameters
        stack, self.rest = view.stack, view.annotations.without(row)
        points = self.rest.points
        self.clicked = {
            point: stack.grid_of(uv, row)
            for point, uv in sorted(view.annotations.places[row].items())
            if point in points
        }
        # clicks close the model: beyond the neighbouring ones nothing bears on this frame
        begin = max((r for r in self.rest.rows if r < row), default=0)
        end = 1 + min((r for r in self.rest.rows if r > row), default=stack.shape[0] - 1)
        self.between = self.rest.rows[0] < row < self.rest.rows[-1]
        self.whole_row = row
        self.row, self.part = row - begin, stack.part(begin, end)
        self.placed = self.rest.part(begin, end)
        classify = learn_appearance(
            stack, clicked_training_frames(stack, self.rest), n_points=n_points,
            parameters=parameters.appearance,
        )  # fmt: skip
        self.looks = appearance_maps(
            stack, classify, points=points, parameters=parameters.appearance,
            rows=range(begin, end),
        )  # fmt: skip
        followed = detect_by_motion(self.part, self.placed, parameters.motion)
        self.motion = {point: paint(followed, self.part, point) for point in points}
        self.radius = parameters.appearance.radius / parameters.scene.spacing
        self.priors = prior_from_clicks(stack, self.rest, radius=self.radius, parameters=parameters)

    def outcome(self, powers: Powers) -> list[LeftOutClick]:
        """Return what is found of each point that was clicked."""
        motion = {p: own**powers.motion for p, own in self.motion.items()}
        likelihood = {p: own * self.looks[p] ** powers.appearance for p, own in motion.items()}
        evidence = ViewEvidence(
            self.part, self.view.name, self.view.size, self.placed, likelihood, self.priors,
            self.looks, motion, powers.appearance,
        )  # fmt: skip
        posteriors = associate(
            [evidence], radius=self.radius, parameters=self.parameters.association,
            identity=self.parameters.identity,
        )[0]  # fmt: skip
        estimates = {p: estimate(own.mass, self.radius) for p, own in posteriors.items()}
        signs = read_signs(
            estimates, posteriors, motion=motion, looks=self.looks, clicked=self.placed
        )
        outcomes = []
        for p, place in self.clicked.items():
            there = estimates[p].place[self.row]
            off = float(np.linalg.norm(there - place))
            mass = posteriors[p].mass[self.row]
            others = {q: at for q, at in self.clicked.items() if q != p}
            near = [q for q, at in others.items() if np.linalg.norm(there - at) <= self.radius]
            outcomes.append(
                LeftOutClick(
                    p, _within(mass, place, self.radius),
                    right=off <= RUN.weighing_near * self.radius,
                    signs=signs[p].columns()[self.row],
                    view=self.view.name, row=self.whole_row, off=off / self.radius,
                    taken=near[0] if near else None,
                    on_others=max((_within(mass, at, self.radius) for at in others.values()),
                                  default=0.0),
                )
            )  # fmt: skip
        return outcomes


def _within(mass: Float32Array, place: FloatArray, radius: float) -> float:
    """Return the probability within a radius of a place (x, y)."""
    v, u = np.mgrid[: mass.shape[0], : mass.shape[1]]
    return float(mass[(u - place[0]) ** 2 + (v - place[1]) ** 2 <= radius**2].sum())
