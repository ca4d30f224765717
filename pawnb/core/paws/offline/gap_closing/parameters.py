"""Parameters of the stage ``gap_closing``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class GapClosingParameters:
    """Occlusions bridged by multiple hypothesis tracking, and what is rejected.

    Parameters
    ----------
    gap_before, gap_after : int
        Certain frames that tell how a stretch begins, and how it ends. Set by hand.
    gap_closing_look : float
        Cost of a detection: so many times minus the logarithm of how much it looks like a paw. Set
        by hand.
    gap_closing_other : float
        Cost of a detection that lies where another point is. Set by hand.
    gap_closing_beside : float
        Distance, in paw widths, at which it does. Set by hand.
    gap_closing_expected : float
        Weight of a frame's distance from the arc of its swing, and from where the cycle has the
        point, as frames err alike. The latter only where nothing certain follows: the cycle of a
        paw that is occluded in every stride is no more than was made of it before, and what was
        decided too late once would be so again. Set by hand.
    gap_closing_aside : float
        Standard deviation, in paw widths, of how far aside of its arc a paw swings. Set by hand.
    farthest_off_arc : float
        Squared standard deviations beyond which a point off its arc costs no more: an arc may be of
        a stance that was estimated wrongly. Set by hand.
    gap_closing_manoeuvre : float
        Standard deviation of what lift-off changes of a speed, in that of the fastest swings.
        Measured: front paws go up at once, by up to 1.3 of it in rendered scenes.
    rising_s, swinging_s : float
        Time, s, after lift-off in which a paw is bent and dim, and in which it swings for certain.
        Set by hand.
    gap_closing_dim : float
        Largest cost of a poor look then. Set by hand.
    gap_closing_farthest : float
        Squared standard deviations beyond which a point off its cycle costs no more. Set by hand.
    limb_clutter_at : float
        A detection within so many paw widths of a point is that point's. Set by hand.
    limb_clutter_grades : tuple[float, ...]
        Detections of a limb look worse than paws: those that look alike are counted together. Set
        by hand.
    limb_clutter_reach : float
        Detections up to so many paw widths to either side of a paw may belong to its limb. Set by
        hand.
    limb_clutter_bin : float
        Side of a bin, in paw widths: about how well a detection's place is known. Set by hand.
    limb_clutter_smooth : float
        Standard deviation, in bins, by which counts are smoothed. Set by hand.
    limb_clutter_before : float
        Sightings of a paw without any limb that are assumed beforehand. Set by hand.
    rejection_least : int
        Certain stretches shorter than this are associated again too. Set by hand.
    drawn_s : float
        A path that is lost so soon, s, after its point left the place where it stood was drawn off.
        Set by hand.
    rejection_settled : int
        Frames for which a point must have stood for its path to be taken as drawn off. Set by hand.
    off_arc : float
        A place so many standard deviations off the arc of a swing is associated again. Set by hand.
    off_at_least : float
        So many paw widths at least count as one of these. Set by hand.
    followed_s : float
        Time, s, for which wrists are followed: so long a paw may be covered before it lifts off.
        Set by hand.
    wrist_clutter_vague : float
        Cost of what a wrist says of its paw, besides how the wrist looks: it turns over the paw.
        Set by hand.
    no_paw : float
        What speaks against a wrist being the paw. Set by hand.
    wrist_nearest, wrist_farthest : float
        Detections at such distances from a paw that stands, in paw widths, may be its wrist. Set by
        hand.
    wrist_same : float
        A detection is that of the frame before if it is within so many paw widths of where that was
        to be. Set by hand.
    wrist_risen : float
        What has moved so many paw widths against the ground has left it, and may be the paw itself:
        it goes up to where its wrist was. Set by hand.
    certain_sd : float
        Standard deviation of a place that is certain, in paw widths. Set by hand.
    reach : float
        A point goes no farther than so many body sizes while no tracklet is certain. Set by hand.
    least_detection_probability : float
        Detections count as likely as this at least. Set by hand.
    mht_impulse_cost : float
        Cost of a manoeuvre. Costs are minus log-probabilities. Set by hand.
    mht_good, mht_bad : float
        Standard deviation of a detection, and of one that is half occluded or blurred, in paw
        widths. Set by hand.
    mht_bad_cost : float
        Cost of a bad detection. Set by hand.
    mht_clutter : float
        Detections that are nothing, per square paw width. Set by hand.
    mht_seen, mht_seen_across : float
        Chance that a view sees the point: one that tracks it, and one from the other side. Set by
        hand.
    mht_occlusion_onset_cost, mht_occlusion_frame_cost : float
        Cost of becoming occluded to all views that track the point, and of staying so for a frame.
        Set by hand.
    mht_reappearance_cost : float
        Cost of coming out again. Set by hand.
    mht_sideways : float
        Points change their speed so much less to the side than forward and up. Set by hand.
    mht_hold, mht_slip : float
        Standard deviation of where a point stands, and of what it moves there from frame to frame,
        in that of a certain place. Set by hand.
    mht_lifting : float
        Standard deviation of how lift-off changes the speed, in that of a manoeuvre. Set by hand.
    mht_covered : float
        Cost of standing where another paw covers the point. Set by hand.
    mht_alike : float
        Hypotheses nearer to each other than so many of their standard deviations are the same. Set
        by hand.
    mht_gate : float
        Largest squared distance of a detection, in standard deviations. Set by hand.
    mht_out_of_reach_cost : float
        Cost of a frame farther from where the stretch begins than a point goes. Set by hand.
    mht_pruning_cost : float
        Hypotheses that cost so much more than the best are forgotten. Set by hand.
    mht_most, mht_most_within : int
        Hypotheses kept from frame to frame, and from view to view within a frame: a paw that comes
        out again costs much in the first view and made good by the next. Set by hand.
    region_least : int
        Certain frames from which it is learnt how far from the middle of the animal a point is. Set
        by hand.
    region_tail : float
        Share of them that may be farther ahead or behind, left or right. Set by hand.
    region_ahead, region_aside : float
        So much farther, in body sizes, it may be where it is not seen: paws are seen worst where
        they lift off, at the end of their range. Measured: with 30 % of all detections left out
        17.7 of 1000 visible labels were wrong without limits and 4.1 with these
        (``benchmarks/unseen_paws.py``, two rendered scenes in colour).
    region_sd : float
        Standard deviation of how far beyond that it is, in body sizes. Set by hand.
    region_nearest : float
        Points are not nearer to each other in space than so many paw widths. Measured: 0.95 in
        eight rendered scenes.
    region_shared : float
        Cost of a frame on the very place of another point. Set by hand.
    """

    gap_before: int = 10
    gap_after: int = 6
    gap_closing_look: float = 1.1
    gap_closing_other: float = 8.0
    gap_closing_beside: float = 0.35
    gap_closing_expected: float = 0.2
    gap_closing_aside: float = 0.7
    farthest_off_arc: float = 9.0
    gap_closing_manoeuvre: float = 0.8
    rising_s: float = 0.008
    swinging_s: float = 0.04
    gap_closing_dim: float = 0.7
    gap_closing_farthest: float = 16.0
    limb_clutter_at: float = 0.5
    limb_clutter_grades: tuple[float, ...] = (0.1, 0.3)
    limb_clutter_reach: float = 3.5
    limb_clutter_bin: float = 0.5
    limb_clutter_smooth: float = 0.7
    limb_clutter_before: float = 10.0
    rejection_least: int = 4
    drawn_s: float = 0.03
    rejection_settled: int = 6
    off_arc: float = 3.0
    off_at_least: float = 0.5
    followed_s: float = 0.03
    wrist_clutter_vague: float = 1.0
    no_paw: float = 30.0
    wrist_nearest: float = 0.8
    wrist_farthest: float = 2.5
    wrist_same: float = 0.5
    wrist_risen: float = 0.7
    certain_sd: float = 0.25
    reach: float = 1.5
    least_detection_probability: float = 0.02
    mht_impulse_cost: float = 2.0
    mht_good: float = 0.15
    mht_bad: float = 0.6
    mht_bad_cost: float = 2.0
    mht_clutter: float = 0.05
    mht_seen: float = 0.7
    mht_seen_across: float = 0.15
    mht_occlusion_onset_cost: float = 2.0
    mht_occlusion_frame_cost: float = 0.6
    mht_reappearance_cost: float = 1.0
    mht_sideways: float = 0.3
    mht_hold: float = 0.4
    mht_slip: float = 0.1
    mht_lifting: float = 0.5
    mht_covered: float = 0.6
    mht_alike: float = 0.5
    mht_gate: float = 16.0
    mht_out_of_reach_cost: float = 50.0
    mht_pruning_cost: float = 25.0
    mht_most: int = 40
    mht_most_within: int = 150
    region_least: int = 30
    region_tail: float = 0.02
    region_ahead: float = 0.25
    region_aside: float = 0.06
    region_sd: float = 0.05
    region_nearest: float = 0.9
    region_shared: float = 3.0


GAP_CLOSING = in_force("gap_closing", GapClosingParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
