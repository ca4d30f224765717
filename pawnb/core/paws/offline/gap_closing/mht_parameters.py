"""How stories of a point are told: the numbers of :mod:`.gap_closing.mht`."""

from __future__ import annotations

from typing import NamedTuple


class Telling(NamedTuple):
    """How stories are told; costs are minus log-probabilities.

    Parameters
    ----------
    jerk : float
        Usual standard deviation of the change of acceleration from frame to frame.
    kick : float
        Standard deviation of the change of speed where a point is kicked.
    noise : float
        Standard deviation of a place that is certain.
    reach : float
        A point does not go farther than this while no piece is certain.
    kick_cost : float
        Cost of a kick.
    good, bad : float
        Standard deviation of a candidate, and of one that is half hidden or blurred, in
        thicknesses of a paw.
    bad_cost : float
        Cost of a bad candidate.
    clutter : float
        Candidates that are nothing, per square thickness.
    seen, seen_across : float
        Chance that a view sees the point: one that tracks it, and one from the other side.
    hide, stay, show, half : float
        Cost of becoming hidden to all views that track the point, of staying so, of coming
        out again, and of being seen by none but one of two.
    sideways : float
        Points change their speed so much less to the side than forward and up.
    hold, slip : float
        Standard deviation of where a point stands, and of what it moves there from frame to
        frame, in ``noise``.
    lifting : float
        Standard deviation of how lift-off changes the speed, in ``kick``.
    covered : float
        Cost of standing where another paw covers the point.
    rising, swinging : int
        Frames after lift-off in which a paw may look poor, and in which it swings for certain.
    alike : float
        Stories nearer to each other than so many of their standard deviations tell the same.
    most, most_within : int
        Stories kept from frame to frame, and from view to view within a frame: a paw that
        comes out again is told dearly by the first view and made good by the next.
    """

    jerk: float
    kick: float
    noise: float
    reach: float
    kick_cost: float = 2.0
    good: float = 0.15
    bad: float = 0.6
    bad_cost: float = 2.0
    clutter: float = 0.05
    seen: float = 0.7
    seen_across: float = 0.15
    hide: float = 2.0
    stay: float = 0.6
    show: float = 1.0
    half: float = 0.2
    sideways: float = 0.3
    hold: float = 0.4
    slip: float = 0.1
    lifting: float = 0.5
    covered: float = 0.6
    rising: int = 0
    swinging: int = 0
    alike: float = 0.5
    most: int = 40
    most_within: int = 150
