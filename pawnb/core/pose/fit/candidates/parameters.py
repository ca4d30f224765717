"""Parameters of the stage ``candidates``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class CandidateParameters:
    """Poses of single legs, and the path through them.

    Parameters
    ----------
    crossed_legs_rounds : int
        Most steps of the fit of two legs whose ends are exchanged. Set by hand.
    crossed_legs_better : float
        What the cost falls by, at least, where ends are given back: that of one standard deviation.
        Set by hand.
    leg_candidates_beam : int
        Part poses of a leg that are kept while it is built from the body outwards. Set by hand.
    limb_turns : int
        Turns of a link that are tried, evenly over its range. Set by hand.
    limb_shorter : tuple of float
        Logarithms of a link's foreshortening that are tried. Set by hand.
    limb_shorter_cost : float
        Cost of a link's squared logarithmic foreshortening, px: little, as whole legs are raised.
        Set by hand.
    limb_hidden : float
        What counts as seen of a leg where nothing can be seen, as a share of its darkness: a little
        less than half, so that no leg is hidden that could as well be seen. Set by hand.
    limb_step_px : float
        Distance of the places along a link that are looked at, working px. Set by hand.
    limb_least_dark : float
        Least darkness that is expected of a link. Set by hand.
    limb_direction_rad : float
        Chains that end at the same place count as others where they come from directions further
        apart, rad. Set by hand.
    same_px : float
        Poses of a leg that are nowhere further apart are one and the same, working px. Set by hand.
    least_shown : float
        Darkness by which a leg must be darker than the body under it for a pixel to show it. Set by
        hand.
    fastest_back : float
        Most that an angle, rad, or the logarithm of a length may change from frame to frame on the
        way back. Set by hand.
    leg_candidates_neutral : float
        What a leg sees under others, as a share of its darkness: a little less than half, so that
        no leg is laid across the body where it could as well lie beside it. Set by hand.
    beside_px : float
        Legs whose joints are no further apart may share pixels, working px. Set by hand.
    leg_candidates_crossed : float
        Cost of neighbouring legs that cross, in a frame: they seldom do. Set by hand.
    room_px : float
        Room about legs that are fitted alone, working px. Set by hand.
    leg_candidates_worthless, few_pixels : float
        A candidate that explains less, for each pixel it shows and so many more, than this share of
        what the best one does is dropped. Of a leg whose most is hidden, the rest may be all there
        is to see. Set by hand.
    most_step : float
        Cost of a leap from anywhere to anywhere. Set by hand.
    viterbi_keep_velocity : float
        Share of a step that is expected again along the path. Set by hand.
    viterbi_path_keep_velocity : float
        Share of a step that is expected again on the way back. Set by hand.
    most_back : int
        Frames that a leg is followed back from where it is found again. Set by hand.
    leap_sds : float
        Joints that move by so many standard deviations of how far legs stray leap: they do not go
        on as they moved, and are followed backwards from there. Set by hand.
    rounds_leg : int
        Steps at most of the fit of a leg alone. Set by hand.
    rounds_back : int
        Steps at most of one that is followed backwards. Set by hand.
    """

    crossed_legs_rounds: int = 12
    crossed_legs_better: float = 0.5
    leg_candidates_beam: int = 24
    limb_turns: int = 17
    limb_shorter: tuple[float, ...] = (-0.4, -0.2, 0.0, 0.2, 0.4)
    limb_shorter_cost: float = 6.0
    limb_hidden: float = 0.4
    limb_step_px: float = 1.5
    limb_least_dark: float = 0.1
    limb_direction_rad: float = 0.35
    same_px: float = 2.5
    least_shown: float = 0.02
    fastest_back: float = 0.2
    leg_candidates_neutral: float = 0.4
    beside_px: float = 4.0
    leg_candidates_crossed: float = 4.0
    room_px: float = 14.0
    leg_candidates_worthless: float = 0.35
    few_pixels: float = 30.0
    most_step: float = 60.0
    viterbi_keep_velocity: float = 0.85
    viterbi_path_keep_velocity: float = 0.9
    most_back: int = 60
    leap_sds: float = 6.0
    rounds_leg: int = 4
    rounds_back: int = 6


CANDIDATES = in_force("candidates", CandidateParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
