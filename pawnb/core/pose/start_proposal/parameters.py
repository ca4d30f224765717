"""Parameters of the stage ``pose_proposal``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class PoseProposalParameters:
    """A pose found without a click: outline, body, limbs and legs.

    :func:`pawnb.propose_start` reads them, and a check of a start pose those of the outline; a run
    of a tracker takes its start as it is. Lengths in grid px are px of the picture where the
    animal is at most ``largest_px`` long.

    Parameters
    ----------
    noise_sds : float
        A pixel further than this from the background, in SD of it, may be animal. Set by hand.
    noise_least : float
        Least SD of the background, grey values. Set by hand.
    blur_px : float
        Standard deviation of the smoothing of the difference from the background, px. Set by hand.
    blur_noise : float
        What that smoothing leaves of the noise. Set by hand: about half, as white noise would
        have it at this width.
    surely_animal : float
        Pixels this many times beyond that threshold tell how dark the animal is. Set by hand.
    pixels_least : int
        Fewer of them show no animal. Set by hand.
    contrast_percentile : float
        Percentile of their difference that is the contrast of the animal's body. Set by hand.
    pale, dark : float
        What differs by at least the first share of that contrast may be animal, by the second
        surely is. Set by hand.
    unlit_grey : float
        Background pixels darker than this grey value tell nothing of the light. Set by hand.
    light_blocks : int
        Blocks along the shorter side of the picture in which the light is compared. Set by hand:
        larger than the animal's parts.
    light_block_px : int
        Least side of such a block, px. Set by hand.
    light_known : float
        Share of a block's pixels that tell its light at least. Set by hand.
    closing_px : int
        Gaps of the outline narrower than this are closed, px. Set by hand.
    largest_px : int
        Longest side of the animal's box that is looked at without reducing it, px. Set by hand.
    margin_px : int
        Room about the animal in the grid, grid px. Set by hand.
    grid_share : float
        A pixel of a reduced grid is animal if more than this share of it is. Set by hand.
    sharp_around : float
        Radius, in the animal's greatest depth, in which the darkest pixel is looked for. Set by
        hand.
    sharp_share : float
        Where the outline is sharp pixels differ by more than this share of it. Set by hand.
    core_share : float
        The body is what a disc reaches whose radius is this share of the widest disc inside. Set
        by hand.
    gap_cost : float
        Walking through a pixel outside the outline costs so much more than through one inside.
        Set by hand.
    edge_cost : float
        Further cost of a pixel at a limb's edge, in one in its middle. Set by hand.
    body_cost : float
        Cost of a pixel of the body, in the same: a limb's way may begin anywhere on it. Set by
        hand.
    limb_window_px : int
        Window in which a limb's middle is the deepest pixel, grid px. Set by hand.
    limb_width, limb_width_px : float
        Pixels within so many median depths of a limb's way, and so many grid px, belong to it. Set
        by hand.
    limbs_more : int
        Limbs that are traced beyond the animal's legs. Set by hand.
    limb_shortest : float
        A limb's own part is at least this share of a leg's length. Set by hand.
    body_points : int
        Points about the body's outline that are compared with the silhouette's. Set by hand.
    body_rim : float
        Pixels of the body this near to its edge are compared with the ellipses, grid px. Set by
        hand.
    body_far : float
        Distances from the ellipses beyond this count as this, grid px. Set by hand.
    body_scale_weight : float
        Weight of the scale where it is known, in grid px for a factor of e. Set by hand.
    body_soft : float
        Distances beyond this count less and less (Cauchy), grid px. Set by hand.
    body_misfit : float
        Cost of a body whose outline is off by its whole length. Set by hand.
    area_range : tuple of float
        Outlines that are smaller or larger than so many times the usual one show half an animal,
        or something else. Set by hand.
    unmatched : float
        Cost of a leg without a limb; a limb that fits worse than this is nobody's. Set by hand.
    unmatched_most, unmatched_other : float
        Highest cost of a limb, and cost of a leg that takes another leg's having none, in
        ``unmatched``. Set by hand.
    left_over : float
        Cost of a long limb that is nobody's, in ``unmatched``. Set by hand.
    direction_sd_deg : float
        Standard deviation of a leg's direction from its natural one. Set by hand.
    root_sd_deg, root_sd : float
        Standard deviation of where a limb leaves the body: half the first in degrees about the
        leg's root, and the second beyond its first two segments, in their length. Set by hand.
    length_sd_first, length_sd : float
        Standard deviation of the logarithm of a limb's length, before and after it is known how
        much longer all are than the species file says. Set by hand.
    length_short : float
        What a limb that is too short counts, in one that is too long. Set by hand: a raised leg
        is shorter in the picture.
    longer_most : float
        Most that all legs are longer or shorter than the species file says, as a logarithm. Set by
        hand.
    swap_cost : float
        Cost difference of two assignments at which one is clearly better. Set by hand.
    two_legs : float
        A limb this much thicker than usual may be two legs side by side. Set by hand.
    two_legs_share : float
        Share of such a limb that a second leg takes at least. Set by hand.
    leg_samples : tuple of float
        Where along a segment it is compared with its limb. Set by hand.
    leg_arc : float
        Length of a leg in its limb's way, which is crooked by its pixels. Set by hand.
    leg_factor : tuple of float
        Least and greatest length of a leg in the species file's. Set by hand.
    leg_tip, leg_middle, leg_along : float
        Weights of the distance of a leg's tip from its limb's, of its samples from the middle
        line, and from where they were along the limb, a grid px. Set by hand.
    leg_far : float
        Distances from the middle line beyond this count as this, grid px. Set by hand.
    leg_natural, leg_beyond : float
        Weights of a joint's turn in half its range, and of what is beyond it. Set by hand.
    leg_length_weight : float
        Weight of the leg's length, of a factor of e. Set by hand.
    leg_close : float
        A leg this far from its limb, in its length, is doubted. Set by hand.
    leg_own : float
        A leg is wholly sure where this times its limb's own part is the limb. Set by hand.
    frames_most : int
        Frames that are looked through, spread evenly, where none are named. Set by hand.
    doubtful : float
        Where a leg is less sure in the best of these frames, as many more are looked through. Set
        by hand.
    frames_fitted : int
        So many of the best frames are fitted whole. Set by hand.
    travel : float
        Cost of a body that runs backwards by ``travel_of_body`` between two frames looked at. Set
        by hand.
    travel_of_body : float
        How far that is, in the body's length. Set by hand.
    doubt : float
        Cost of a leg that is not sure at all. Set by hand.
    crossing : float
        Cost of a pair of legs that cross. Set by hand.
    second : float
        Something else of this share of the animal's size is spoken of. Set by hand.
    odd_scale : tuple of float
        An animal smaller or larger than this, in its species file's, is spoken of. Set by hand.
    """

    noise_sds: float = 4.0
    noise_least: float = 0.5
    blur_px: float = 0.8
    blur_noise: float = 0.6
    surely_animal: float = 1.5
    pixels_least: int = 20
    contrast_percentile: float = 90.0
    pale: float = 0.25
    dark: float = 0.6
    unlit_grey: float = 20.0
    light_blocks: int = 12
    light_block_px: int = 8
    light_known: float = 0.3
    closing_px: int = 5
    largest_px: int = 420
    margin_px: int = 6
    grid_share: float = 0.35
    sharp_around: float = 0.35
    sharp_share: float = 0.5
    core_share: float = 0.55
    gap_cost: float = 6.0
    edge_cost: float = 1.5
    body_cost: float = 0.05
    limb_window_px: int = 7
    limb_width: float = 1.6
    limb_width_px: float = 1.5
    limbs_more: int = 4
    limb_shortest: float = 0.2
    body_points: int = 120
    body_rim: float = 1.5
    body_far: float = 20.0
    body_scale_weight: float = 30.0
    body_soft: float = 1.0
    body_misfit: float = 400.0
    area_range: tuple[float, float] = (0.6, 1.6)
    unmatched: float = 12.0
    unmatched_most: float = 3.0
    unmatched_other: float = 10.0
    left_over: float = 0.5
    direction_sd_deg: float = 22.0
    root_sd_deg: float = 18.0
    root_sd: float = 0.5
    length_sd_first: float = 0.4
    length_sd: float = 0.18
    length_short: float = 0.6
    longer_most: float = 0.7
    swap_cost: float = 3.0
    two_legs: float = 1.25
    two_legs_share: float = 0.5
    leg_samples: tuple[float, ...] = (0.34, 0.67, 1.0)
    leg_arc: float = 0.985
    leg_factor: tuple[float, float] = (0.35, 1.8)
    leg_tip: float = 2.0
    leg_middle: float = 1.0
    leg_along: float = 0.35
    leg_far: float = 8.0
    leg_natural: float = 0.5
    leg_beyond: float = 6.0
    leg_length_weight: float = 12.0
    leg_close: float = 0.08
    leg_own: float = 1.5
    frames_most: int = 40
    doubtful: float = 0.25
    frames_fitted: int = 5
    travel: float = 8.0
    travel_of_body: float = 0.5
    doubt: float = 3.0
    crossing: float = 4.0
    second: float = 0.4
    odd_scale: tuple[float, float] = (0.67, 1.5)


POSE_PROPOSAL = in_force("pose_proposal", PoseProposalParameters())
"""The parameters in force."""
