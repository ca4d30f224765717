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
        Weight of a frame's distance from where the cycle has the point, as frames err alike. Only
        where nothing certain follows: the cycle of a paw that is occluded in every stride is no
        more than was made of it before, and what was decided too late once would be so again. Set
        by hand.
    on_arc, gap_closing_last : float
        Weight of a frame's distance from the arc of its swing, and so much more where nothing
        certain follows. Set by hand.
    gap_closing_aside : float
        Standard deviation, in paw widths, of how far aside of its arc a paw swings. Set by hand.
    farthest_off_arc : float
        Squared standard deviations beyond which a point off its arc costs no more: an arc may be of
        a stance that was estimated wrongly. Set by hand.
    gap_closing_kick : float
        Standard deviation of what lift-off changes of a speed, in that of the fastest swings: front
        paws go up at once, by up to 1.3 of it in rendered scenes.
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
        Detections of a limb look worse than paws: those that look alike are counted together.
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
        A place so many standard deviations off the arc of a swing is associated again, and
    off_at_least : float
        at least so many paw widths count as one of them. Set by hand.
    followed_s : float
        Time, s, for which wrists are followed: so long a paw may be covered before it lifts off.
        Set by hand.
    wrist_decoys_vague : float
        Cost of what a wrist says of its paw, besides how the wrist looks: it turns over the paw.
        Set by hand.
    no_paw : float
        What speaks against a wrist being the paw. Set by hand.
    region_least : int
        Certain frames from which it is learnt how far from the middle of the animal a point is. Set
        by hand.
    region_tail : float
        Share of them that may be farther ahead or behind, left or right. Set by hand.
    region_ahead, region_aside : float
        So much farther, in body sizes, it may be where it is not seen: paws are seen worst where
        they lift off, at the end of their range. With 30 % of all detections left out 17.7 of 1000
        visible labels were wrong without limits and 4.1 with these (``benchmarks/unseen_paws.py``,
        two rendered scenes in colour).
    region_sd : float
        Standard deviation of how far beyond that it is, in body sizes. Set by hand.
    region_nearest : float
        Points are not nearer to each other in space than so many paw widths: 0.95 in eight
        rendered scenes.
    region_shared : float
        Cost of a frame on the very place of another point. Set by hand.
    """

    gap_before: int = 10
    gap_after: int = 6
    gap_closing_look: float = 1.1
    gap_closing_other: float = 8.0
    gap_closing_beside: float = 0.35
    gap_closing_expected: float = 0.2
    on_arc: float = 0.2
    gap_closing_last: float = 2.0
    gap_closing_aside: float = 0.7
    farthest_off_arc: float = 9.0
    gap_closing_kick: float = 0.8
    rising_s: float = 0.008
    swinging_s: float = 0.04
    gap_closing_dim: float = 0.7
    gap_closing_farthest: float = 16.0
    limb_clutter_at: float = 0.5
    limb_clutter_grades: tuple[float, ...] = (0.1, 0.3)
    limb_clutter_smooth: float = 0.7
    limb_clutter_before: float = 10.0
    rejection_least: int = 4
    drawn_s: float = 0.03
    rejection_settled: int = 6
    off_arc: float = 3.0
    off_at_least: float = 0.5
    followed_s: float = 0.03
    wrist_decoys_vague: float = 1.0
    no_paw: float = 30.0
    region_least: int = 30
    region_tail: float = 0.02
    region_ahead: float = 0.25
    region_aside: float = 0.06
    region_sd: float = 0.05
    region_nearest: float = 0.9
    region_shared: float = 3.0


GAP_CLOSING = in_force("gap_closing", GapClosingParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
