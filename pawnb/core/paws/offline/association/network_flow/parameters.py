"""Parameters of the stage ``network_flow``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class NetworkFlowParameters:
    """Tracklets of places in space, and their association by min-cost flow.

    Parameters
    ----------
    body_clutter_slow : float
        What is slower, in the speed of the ground, stays: paws that land or lift off do for a
        moment. Set by hand.
    body_clutter_with : float
        Speeds that differ from the ground's by less of it are those of paws that stand. Set by
        hand.
    body_clutter_passed : float
        Thicknesses by which the ground must have moved away under what stays. Set by hand.
    body_clutter_share : float
        Share of its frames in which a tracklet must stay. Set by hand.
    aside_sd : float
        Standard deviation, in spans, of how far to the side of its click a paw is later. Measured:
        it wanders by 0.02 to 0.08 itself; and detections of two views of one side that lie half a
        paw width off are as much off in depth. Set by hand above that.
    usual_farthest : float
        Squared standard deviations, along and to the side, beyond which it costs no more to be far
        from where paws of a kind usually are: that is another paw. Half of it is less than being
        occluded costs in a frame, as all that tells where a point usually is must be. Set by hand.
    same_side : float
        An unlabelled target that is within so many spans, to the side, of where the paw of its kind
        was clicked is that paw. Measured: clicks of two views of one side are 0.01 off in depth,
        and left and right paws of rendered mice are 0.2 (front) to 0.9 (hind) apart.
    far_side : float
        An unlabelled target is so many spans farther from the cameras than the clicked one of its
        kind. Set by hand.
    lateral_prior_wanders : float
        Standard deviation, in spans, of how far to the side of its usual way a paw goes. Set by
        hand.
    to_sd : float
        Standard deviation of a normal distribution over its median absolute deviation: mathematics,
        one over the 3/4 quantile of the standard normal distribution.
    positional_prior_bins : int
        Bins of the distribution of where a paw is about the body. Set by hand.
    positional_prior_most : float
        Largest cost of one frame: a rare place is not an impossible one. Set by hand.
    pruning_rounds : int
        Most steps of the bounds on the cost of an association. Set by hand.
    pruning_exact : float
        Bounds that differ by less, relative to the costs, are the same. Set by hand.
    splitting_stands, splitting_slides : float
        A paw that stands stays within so many paw widths of its place on the ground, and does not
        stand again as many farther on. Set by hand.
    splitting_between : int
        Frames before and after such a slide that belong to neither place. Set by hand.
    tracklet_association_looks : int
        Times that paths are chosen again with the habits learnt from the last choice. Set by hand.
    tracklet_association_habit : float
        Weight of where points rarely are relative to the body: neighbouring frames err alike. Set
        by hand.
    tracklet_association_expected : float
        Half a squared standard deviation from where the cycle has a point, for frames that err
        alike. Set by hand.
    tracklet_association_farthest : float
        Squared standard deviations beyond which a point off its cycle costs no more. That cost must
        be above what it costs to stay occluded: towards the end of a recording, where no later
        tracklet has to be reached, a point that is lost would else take whatever is there, however
        far from its own place. Set by hand.
    kinds_apart : float
        Clicks of front and hind paws this many spans apart tell where each usually are. Set by
        hand.
    look_below : float
        What a place looks like counts so much more from below, where nothing hides a paw. Set by
        hand.
    tracklet_association_elsewhere : float
        Cost of a place that no view of the point's own shows, in that of being occluded: an
        occluded paw is bridged, and one that follows another's is wrong. Set by hand.
    hopped : float
        Cost of a place to which no swing leads, in that of being occluded: less, so that it is kept
        where no other point wants it. Measured: of 1000 visible labels of a film in H.264 of crf 28
        (half scale, seed 33) 74 are wrong without it and 7 with 0.3; of one in grey 11 without it
        and with 0.3, 15 with 1.
    tracklet_association_good : float
        Largest cost of a place that tells about it. Set by hand.
    tracklet_association_cost_limits, tracklet_association_worse : tuple[float, ...] or float
        Tracklets are no paw if they cost more a frame; the limit is raised, at most to the second,
        to so much above what the clicked paws cost: with their toes spread they look less like
        ends. Set by hand.
    tracklet_association_meeting : float
        Distance, in paw widths, at which points meet in a picture. Set by hand.
    stood_s : float
        Time, s, for which a paw goes with the ground to be known to stand. Set by hand.
    tracklet_association_wanders : float
        Before the body is followed places to the side are known so much less well: an animal on a
        belt wanders. Only where unlabelled targets are kept to their side, too: clicked paws hold
        their own. Set by hand.
    tracklets_ends : int
        Frames at each end from which position and speed there are taken. Set by hand.
    tracklets_cost_limits, tracklets_enough : tuple[float, ...] or float
        The speed of the ground is estimated from good places; from worse ones where those make
        fewer steps than so many a frame, as where paws are dim. Set by hand.
    at_once : int
        Frames worked on together: enough to save loops, and little memory. Set by hand.
    vague : float
        Weight of the logarithm of how wide the place is that a gap allows, beside the squared
        distance from its middle; mathematics, where errors are independent, would say 0.5. Set by
        hand.
    most_worth : float
        A tracklet is worth no more than this as the next one, however long. Set by hand.
    solver_gap : float
        Relative gap of cost at which integer programming stops. Set by hand.
    solver_links : int
        Up to so many links all are solved in whole numbers, of more those that the linear programme
        uses. Measured: 41,000 of them (a dog indoors) took more than 60 s, the 600 used 0.02; seven
        rendered scenes of 1000 frames, up to 600, are whole-numbered by themselves.
    solver_nodes : int
        Integer programming stops after so many nodes. Set by hand.
    positional_prior_blur : float
        Blur, in spans, of the distribution of where a paw is about the body. Set by hand.
    positional_prior_rare : float
        Density, of the greatest, that is added everywhere before its logarithm is taken. Set by
        hand.
    click_alone : float
        In a clicked frame places nearer than so many paw widths to a click are the clicked paw's.
        Set by hand.
    linked_cost_limit : float
        Places that cost more than this are in no tracklet. Set by hand.
    single_cost_limit : float
        The largest cost of a tracklet of one place. Set by hand.
    ground_within : float
        Distance, paw widths, in which steps agree with the speed of the ground. Set by hand.
    ground_fastest : float
        The ground goes no faster than so many times the fastest paw. Set by hand.
    kinds_reach, kinds_sd : float
        Distance, in spans, from where paws of its kind usually are that costs nothing, and standard
        deviation beyond it. Set by hand.
    kinds_quantiles : tuple of float
        Quantiles of good places at which front and hind paws are, where no click tells. Set by
        hand.
    gate : float
        Squared standard deviations within which a place may follow. Set by hand.
    clear : float
        Squared standard deviations by which all others must be farther. Set by hand.
    clear_near : tuple of float
        Where the nearest is near: all others must be farther than so many times its square, and so
        many more. Set by hand.
    unlike : float
        What a place costs that looks nothing like a paw; in space for each of two views. Set by
        hand.
    support_reach : float
        Distance, in what two views may disagree by, at which a detection hardly counts. Set by
        hand.
    tolerance : float
        Distance, in paw widths, by which two views may disagree. Set by hand.
    ground_frames : int
        Frames, evenly spread, from which the speed of the ground is estimated. Set by hand.
    """

    body_clutter_slow: float = 0.35
    body_clutter_with: float = 0.4
    body_clutter_passed: float = 3.0
    body_clutter_share: float = 0.8
    aside_sd: float = 0.1
    usual_farthest: float = 6.0
    same_side: float = 0.1
    far_side: float = 0.2
    lateral_prior_wanders: float = 0.1
    to_sd: float = 1.4826
    positional_prior_bins: int = 160
    positional_prior_most: float = 4.0
    pruning_rounds: int = 400
    pruning_exact: float = 1e-7
    splitting_stands: float = 0.5
    splitting_slides: float = 0.6
    splitting_between: int = 2
    tracklet_association_looks: int = 2
    tracklet_association_habit: float = 0.5
    tracklet_association_expected: float = 0.3
    tracklet_association_farthest: float = 36.0
    kinds_apart: float = 0.5
    look_below: float = 3.0
    tracklet_association_elsewhere: float = 1.5
    hopped: float = 0.3
    tracklet_association_good: float = 0.5
    tracklet_association_cost_limits: tuple[float, ...] = (0.9, 1.2)
    tracklet_association_worse: float = 0.2
    tracklet_association_meeting: float = 3.0
    stood_s: float = 0.015
    tracklet_association_wanders: float = 2.0
    tracklets_ends: int = 6
    tracklets_cost_limits: tuple[float, ...] = (0.3, 0.6, 0.9, 1.2, 1.5)
    tracklets_enough: float = 0.3
    at_once: int = 200
    vague: float = 0.15
    most_worth: float = 30.0
    solver_gap: float = 1e-4
    solver_links: int = 5000
    solver_nodes: int = 200
    positional_prior_blur: float = 0.05
    positional_prior_rare: float = 1e-3
    click_alone: float = 1.2
    linked_cost_limit: float = 1.6
    single_cost_limit: float = 0.5
    ground_within: float = 0.3
    ground_fastest: float = 2.0
    kinds_reach: float = 0.33
    kinds_sd: float = 0.1
    kinds_quantiles: tuple[float, ...] = (0.75, 0.25)
    gate: float = 16.0
    clear: float = 5.0
    clear_near: tuple[float, float] = (4.0, 0.3)
    unlike: float = 1.5
    support_reach: float = 0.6
    tolerance: float = 0.8
    ground_frames: int = 400


NETWORK_FLOW = in_force("network_flow", NetworkFlowParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
