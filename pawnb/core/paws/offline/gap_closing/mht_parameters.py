"""Parameters of multiple hypothesis tracking, see :mod:`.gap_closing.mht`."""

from __future__ import annotations

from typing import NamedTuple


class MHTParameters(NamedTuple):
    """Parameters of multiple hypothesis tracking; costs are minus log-probabilities.

    Parameters
    ----------
    jerk : float
        Usual standard deviation of the change of acceleration from frame to frame.
    impulse : float
        Standard deviation of the change of speed where a point is kicked.
    noise : float
        Standard deviation of a place that is certain.
    reach : float
        A point does not go farther than this while no tracklet is certain.
    impulse_cost : float
        Cost of a kick.
    good, bad : float
        Standard deviation of a detection, and of one that is half occluded or blurred, in
        paw widths of a paw.
    bad_cost : float
        Cost of a bad detection.
    clutter : float
        Detections that are nothing, per square paw width.
    seen, seen_across : float
        Chance that a view sees the point: one that tracks it, and one from the other side.
    occlusion_onset_cost, occlusion_frame_cost, reappearance_cost, one_view_cost : float
        Cost of becoming occluded to all views that track the point, of staying so, of coming
        out again, and of being seen by none but one of two.
    sideways : float
        Points change their speed so much less to the side than forward and up.
    hold, slip : float
        Standard deviation of where a point stands, and of what it moves there from frame to
        frame, in ``noise``.
    lifting : float
        Standard deviation of how lift-off changes the speed, in ``impulse``.
    covered : float
        Cost of standing where another paw covers the point.
    rising, swinging : int
        Frames after lift-off in which a paw may look poor, and in which it swings for certain.
    alike : float
        Hypotheses nearer to each other than so many of their standard deviations tell the same.
    most, most_within : int
        Hypotheses kept from frame to frame, and from view to view within a frame: a paw that
        comes out again costs much in the first view and made good by the next.
    """

    jerk: float
    impulse: float
    noise: float
    reach: float
    impulse_cost: float = 2.0
    good: float = 0.15
    bad: float = 0.6
    bad_cost: float = 2.0
    clutter: float = 0.05
    seen: float = 0.7
    seen_across: float = 0.15
    occlusion_onset_cost: float = 2.0
    occlusion_frame_cost: float = 0.6
    reappearance_cost: float = 1.0
    one_view_cost: float = 0.2
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
