"""Parameters of the stage ``smoothing``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class SmoothingParameters:
    """Positions refined with the whole recording, and how sure they are.

    Parameters
    ----------
    association_odds_apart : float
        Detections nearer to each other than so many paw widths say the same of a point. Set by
        hand.
    association_odds_most : float
        Largest separation, and that of detections that are alone in their picture. Set by hand.
    forward_backward_distance_trace : float
        Information that every frame has, in the largest, as in smoothing: what nothing tells stays
        finite. Set by hand.
    informative_frames : int
        Position, speed and acceleration are estimated from so many frames at least. Set by hand.
    refinement_near, near_open : float
        A detection may lie so many paw widths from where its point must be, farther in open frames,
        where that is known from what lies far before and after. Set by hand.
    refinement_against : float
        In open frames it may lie this much less far away for each unit of what speaks against it:
        what lies where a point is occluded is mostly a part of a limb. A paw that lifts off, dim
        and bent, looks poor as well, so what looks poor is not left out altogether. Set by hand.
    refinement_rounds : int
        Most times that positions are fitted and measurements weighed anew. Set by hand.
    refinement_bridged : int
        Rounds in which open frames keep what was chosen there; then everything is open to all. Set
        by hand.
    refinement_steps : int
        Gauss-Newton steps of each fit. Set by hand.
    refinement_sigma : float
        Standard deviation of a good detection, in paw widths. Set by hand.
    refinement_tail : float
        Residuals beyond this many standard deviations count less and less. Set by hand.
    refinement_hold : float
        Standard deviation of where a point stands that is not seen, in paw widths: it goes exactly
        as the ground does, and what is taken too freely there lets the swing begin too early. Set
        by hand.
    unsure_lift : float
        Standard deviation of how lift-off changes the speed upwards, in that change. Forward it
        does not: there a paw goes on with the ground and gains speed little by little. Set by hand.
    on_arc : float
        Variance of how much an occluded paw bends off its arc, in that of how much paws bend. Set
        by hand.
    refinement_pull, pull_between : float
        Information, in that of one expectation, that the cycle gives a frame without detections,
        and less where detections follow: the cycle of a paw that is occluded in every stride is no
        more than was made of it before. Without any, a paw that is seen no more once it lifts off
        goes on as it began. There the arc of its swing gives as much as the cycle. Set by hand.
    by_hand : float
        Standard deviation of what was placed by hand, in paw widths. Set by hand.
    by_hand_px : float
        And px, beside that. Set by hand.
    alike : float
        Standard deviation, in paw widths, of what is alike from frame to frame and does not average
        out. Set by hand.
    least_clear : float
        Standard deviations are those of a detection of this quality, at least. Set by hand.
    first_sd : float
        Standard deviation of certain places, in paw widths, in the first path through them. Set by
        hand.
    """

    association_odds_apart: float = 0.5
    association_odds_most: float = 30.0
    forward_backward_distance_trace: float = 1e-9
    informative_frames: int = 3
    refinement_near: float = 0.9
    near_open: float = 2.2
    refinement_against: float = 0.3
    refinement_rounds: int = 8
    refinement_bridged: int = 3
    refinement_steps: int = 2
    refinement_sigma: float = 0.12
    refinement_tail: float = 3.0
    refinement_hold: float = 0.05
    unsure_lift: float = 0.3
    on_arc: float = 0.1
    refinement_pull: float = 0.05
    pull_between: float = 0.01
    by_hand: float = 0.05
    by_hand_px: float = 0.3
    alike: float = 0.06
    least_clear: float = 0.3
    first_sd: float = 0.3


SMOOTHING = in_force("smoothing", SmoothingParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
