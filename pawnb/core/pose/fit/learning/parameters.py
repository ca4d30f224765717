"""Parameters of the stage ``learning``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class LearningParameters:
    """What is learnt of the animal in its own recording.

    Parameters
    ----------
    range_more : float
        Factor by which ranges of joints are wider than the species file says. Set by hand.
    range_more_deg : float
        Ranges are so much wider besides, degrees: limits are soft. After Pullar's own Table 4.6,
        which goes beyond the ranges of Table 3.2. Set by hand.
    range_sd, range_sd_deg : float
        Standard deviation of an angle about its natural orientation: share of half its range, more.
        Set by hand.
    start_more_deg : float
        A joint that a person posed beyond its range may stay so, and this much more. Set by hand.
    wall_deg : float
        Standard deviation of an angle beyond its end. Set by hand.
    anatomy_foreshortened : tuple[float, ...]
        Least and greatest length of a segment in the picture, as a share of its own. Set by hand.
    wall_length : float
        Standard deviation of the logarithm of a length beyond these. Set by hand.
    anatomy_together : float
        A leg that is raised is shorter as a whole: this takes most of the cost of that. Set by
        hand.
    radius_sd, radius_step_sd : float
        Standard deviations of the logarithm of a leg's thickness about the species file's, and of
        its change from place to place. Set by hand.
    dark_sd, dark_step_sd : float
        The same of the logarithm of a leg's darkness. Set by hand.
    least_of_darkest : float
        A leg's palest place, as a share of its darkest: an end laid on the background would be
        learnt as transparent, and stay there. Set by hand.
    least_dark, most_dark : float
        Least and most darkness of a part of the animal, in that of what is wholly dark. Set by
        hand.
    most_change : float
        Most by which one step changes a leg's darkness or the logarithm of its thickness. Set by
        hand.
    least_radius_px : float
        Least half thickness of a leg, working px. Set by hand.
    appearance_shares : tuple[float, ...]
        Shares of a step that are tried until one makes the cost less. Set by hand.
    most_radius : float
        A leg's thickness as a share of the species file's: one that lay on a wing would grow to it.
        Set by hand.
    attached_clutter_frames : int
        So many frames of a recording are looked at, evenly spread. Set by hand.
    attached_clutter_few : int
        Of fewer frames nothing is learnt: no leg takes several steps in them. Set by hand.
    attached_clutter_dark : float
        Darkness from which on something is there; unevenness of the background is a few hundredths.
        Set by hand.
    edge_px : int
        The edge of a wide thing is so far from where a disc fits into it: corners are round then.
        Set by hand.
    least_legs : float
        Fixtures smaller than so many legs are left alone: a body is no perfect egg. Set by hand.
    body_clutter_few : int
        Of fewer frames nothing is learnt: noise and what passes by are not distinguished from the
        body. Set by hand.
    body_clutter_odd : float
        Difference, of the body's darkness, from which on a place is odd: an outline that is wrong
        by a third of a pixel errs by as much. Set by hand.
    body_clutter_most : float
        Nothing is left out where a larger share of the body is odd: it is no animal of eggs then,
        and too little of its outline would be left to tell its heading. Set by hand.
    beyond_px : float
        So far beyond the body it is looked for what belongs to it, working px. Set by hand.
    grows_px : int
        The blur spreads what is odd so far. Set by hand.
    body_clutter_leg : float
        Share of a leg in a place from which on it says nothing about the body. Set by hand.
    body_sd : tuple[float, ...]
        Standard deviations of a part of the body about the species file: logarithms of length and
        width, darkness, egg, by how much its middle is darker. Set by hand.
    waist_sd : tuple[float, ...]
        The same of the waist between two parts. Set by hand.
    overlap_sd : float
        Of a part of the body: logarithms of length and width, darkness, egg, by how much its middle
        is darker than its rim; of its half length, by how much parts that meet reach into each
        other. Set by hand.
    least_precision : float
        Of what neither picture nor prior says anything. Set by hand.
    most_egg : float
        Most by which a part of the body is an egg and no ellipse. Set by hand.
    most_step : float
        Most by which one step changes any of these. Set by hand.
    leg_clutter_few : int
        Of fewer frames nothing is learnt: noise and what passes by are not distinguished from
        hairs. Set by hand.
    leg_clutter_along : int
        Cells along a segment: a hair is about as long. Set by hand.
    leg_clutter_in_px : int
        Cells across a leg in a working pixel. Set by hand.
    leg_clutter_hairy : float
        Darkness by which the median of the frames is darker than painted where a hair is, and than
        the place that mirrors it: the rings of a leg are on both sides, and tell where it is. Set
        by hand.
    pose_prior_seen : float
        Support of a leg and of its outer third from which on it is well seen. Set by hand.
    pose_prior_few : int
        Of fewer poses of a leg and its partner nothing is learnt. Set by hand.
    pose_prior_wider : float
        A leg that is hidden is held a little differently from those that are seen. Set by hand.
    least_sd_deg, least_sd : float
        Least standard deviation of an angle, degrees, and of the logarithm of a length: what never
        changed may change a little. Set by hand.
    pose_prior_odd : float
        Poses with a number so many standard deviations from the middle are not usual ones. Set by
        hand.
    pose_prior_poses : int
        Usual poses of a leg that are kept. Set by hand.
    relearn_frames : int
        Frames that appearance is learnt from, spread over the recording. Set by hand.
    relearn_rounds : int
        Turns of learning and fitting. Set by hand.
    look_rounds : int
        Steps of finding thickness and darkness. Set by hand.
    """

    range_more: float = 1.3
    range_more_deg: float = 8.0
    range_sd: float = 0.6
    range_sd_deg: float = 6.0
    start_more_deg: float = 25.0
    wall_deg: float = 4.0
    anatomy_foreshortened: tuple[float, ...] = (0.3, 1.06)
    wall_length: float = 0.03
    anatomy_together: float = 0.95
    radius_sd: float = 0.4
    radius_step_sd: float = 0.1
    dark_sd: float = 0.3
    dark_step_sd: float = 0.1
    least_of_darkest: float = 0.5
    least_dark: float = 0.08
    most_dark: float = 1.1
    most_change: float = 0.4
    least_radius_px: float = 0.25
    appearance_shares: tuple[float, ...] = (1.0, 0.5, 0.25, 0.125, 0.06)
    most_radius: float = 1.2
    attached_clutter_frames: int = 80
    attached_clutter_few: int = 20
    attached_clutter_dark: float = 0.08
    edge_px: int = 3
    least_legs: float = 1.0
    body_clutter_few: int = 6
    body_clutter_odd: float = 0.25
    body_clutter_most: float = 0.1
    beyond_px: float = 8.0
    grows_px: int = 2
    body_clutter_leg: float = 0.01
    body_sd: tuple[float, ...] = (0.15, 0.15, 0.5, 0.15, 0.5)
    waist_sd: tuple[float, ...] = (1e-3, 0.5, 0.5, 1e-3, 1e-3)
    overlap_sd: float = 0.04
    least_precision: float = 1e-6
    most_egg: float = 0.4
    most_step: float = 0.2
    leg_clutter_few: int = 6
    leg_clutter_along: int = 8
    leg_clutter_in_px: int = 2
    leg_clutter_hairy: float = 0.12
    pose_prior_seen: float = 0.7
    pose_prior_few: int = 20
    pose_prior_wider: float = 1.5
    least_sd_deg: float = 8.0
    least_sd: float = 0.1
    pose_prior_odd: float = 3.0
    pose_prior_poses: int = 10
    relearn_frames: int = 12
    relearn_rounds: int = 2
    look_rounds: int = 4


LEARNING = in_force("learning", LearningParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
