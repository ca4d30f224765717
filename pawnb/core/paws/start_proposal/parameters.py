"""Parameters of the stage ``paw_proposal``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class PawProposalParameters:
    """Paws found without a click. A *span* is the distance from hind to front paws.

    :func:`pawnb.propose_start` reads them; a run of a tracker takes its start as it is.

    Parameters
    ----------
    paw_of_width : float
        Length of a hind paw, in the picture's width. Measured: 40 of 2048 px in the rig of Haji
        Maghsoudi et al. 2019.
    blobs_most : int
        Spots kept of one picture. Set by hand: four paws, and what else looks like one.
    skin : tuple of float
        How much skin differs from a grey or dark ground in L*, a* and b*, whatever the length of
        this. Set by hand: about alike in all three.
    colour_noise : float
        Standard deviation of the camera's noise in CIELAB: what varies by less tells nothing. Set
        by hand.
    top_hat : float
        Side of what is taken away as large, in paw lengths: a paw at any angle fits in it. Set by
        hand.
    blob_blur, blob_blur_px : float
        Standard deviation of the smoothing before spots are found, in paw lengths, and its least
        in px. Set by hand.
    blob_percentile : float
        Percentile of a picture's contrast that counts as standing out most. Set by hand.
    blob_radius : float
        Spots are no nearer to each other than this, in paw lengths. Set by hand.
    still_worth : float
        What a spot that never moves counts: it is left to choose from where nothing moves. Set by
        hand.
    digits_blur, digits_blur_px : float
        Standard deviation of the smoothing before digits are found, in their length, and its least
        in px. Set by hand.
    digits_ground : float
        Percentile of paw-likeness around a paw that is not the paw. Set by hand.
    digits_edge : float
        A paw's pixels are no less like a paw than its middle by more than this share of what lies
        between its middle and that percentile. Set by hand: fur often lies half way.
    digits_tip : float
        Percentile of a paw's pixels forwards that is the tip. Set by hand.
    digits_reach, digits_length : float
        Reach of a paw and length of its digits, in spans. Set by hand.
    digits_down : float
        How much digits point down in the picture for each part forward. Set by hand.
    digits_lift_sd : float
        Standard deviation of the digits' height above the ground, in spans. Set by hand.
    digits_residual : float
        How many times farther views disagree about digits than about a paw. Set by hand.
    least_strength : float
        A spot less like a paw than this, of 1, makes no place. Set by hand.
    worst_residual : float
        Views that disagree by more than this do not see the same place, in paw lengths. Set by
        hand.
    place_residual_sd : float
        Usual disagreement of views about a place in space, in paw lengths. Set by hand.
    ground_range : tuple of float
        Percentiles of the places' heights between which the ground is looked for. Set by hand.
    ground_bands : int
        Heights that it is looked for at. Set by hand.
    ground_narrow, ground_wide : float
        Standard deviations, in bands, of the two Gaussians whose difference shows a narrow peak.
        Set by hand.
    ground_gathered : float
        The ground is the lowest height where places gather this much of the most they do. Set by
        hand.
    ground_thickness : float
        Places that stand on it are nearer to it than so many bands. Set by hand.
    place_far : float
        Places further from the middle of all than this many times the median are no animal's. Set
        by hand.
    places_least : int
        Fewer places tell neither a ground nor an animal. Set by hand.
    crowd_sd : float
        Paws stand within so many robust standard deviations of the median. Set by hand.
    above_sd, below_sd : float
        Standard deviation of a paw's height above the ground and below it, in spans. Set by hand.
    along_sd : float
        Standard deviation of its place along forward, in spans. Set by hand.
    aside, aside_sd : float
        How far it stands from the middle line, and the standard deviation of that, in spans. Set
        by hand.
    pair_apart : float
        Front and hind paw of a side are no nearer along forward than this, in spans. Set by hand.
    pair_clear : float
        They are clear of each other from about this on, in spans. Set by hand: paws that touch
        hide each other.
    pair_better : float
        Of two equal pairs, the one whose better paw is better: what that counts. Set by hand.
    same_place : float
        Two paws nearer to each other than this are one, in spans. Set by hand.
    paw_residual_sd : float
        Usual disagreement of views about a paw, in paw lengths. Set by hand.
    in_line : float
        Paws nearer to each other in a view, in paw lengths, may be taken for one another. Set by
        hand.
    one_view : float
        How sure a place is that one view alone sees, in one that two see. Set by hand.
    still_frames : int
        Frames, spread over those that are looked through, that tell what stays where it is. Set by
        hand: fewer may all fall into one stance.
    mean_share : float
        What the mean of all paws counts beside the least sure one. Set by hand.
    sure : float
        Where each paw is so sure, they are not looked for in another way. Set by hand.
    rare : float
        Paws that so large a share of the picture has the colour of are half as sure. Set by hand.
    found : float
        Where half of the paws are less sure than this no animal was found, whatever one of them
        says. Measured: in a real clip of a mouse on a wheel the four were 0, 0, 0.06 and 0.72
        sure, the last wrongly.
    sides_unknown : float
        No paw is surer than this where the calibration does not tell left from right. Set by hand:
        "unsure" in words.
    frames_measured : int
        Frames in which the digits are measured before one is chosen. Set by hand.
    """

    paw_of_width: float = 0.02
    blobs_most: int = 24
    skin: tuple[float, float, float] = (1.0, 1.0, 1.0)
    colour_noise: float = 1.0
    top_hat: float = 2.0
    blob_blur: float = 0.12
    blob_blur_px: float = 0.8
    blob_percentile: float = 99.9
    blob_radius: float = 0.3
    still_worth: float = 0.1
    digits_blur: float = 0.1
    digits_blur_px: float = 0.5
    digits_ground: float = 20.0
    digits_edge: float = 0.25
    digits_tip: float = 98.0
    digits_reach: float = 0.35
    digits_length: float = 0.06
    digits_down: float = 0.6
    digits_lift_sd: float = 0.13
    digits_residual: float = 2.0
    least_strength: float = 0.1
    worst_residual: float = 0.2
    place_residual_sd: float = 0.07
    ground_range: tuple[float, float] = (5.0, 95.0)
    ground_bands: int = 80
    ground_narrow: float = 1.0
    ground_wide: float = 5.0
    ground_gathered: float = 0.4
    ground_thickness: float = 2.0
    place_far: float = 4.0
    places_least: int = 20
    crowd_sd: float = 3.0
    above_sd: float = 0.2
    below_sd: float = 0.06
    along_sd: float = 0.6
    aside: float = 0.3
    aside_sd: float = 0.25
    pair_apart: float = 0.22
    pair_clear: float = 0.25
    pair_better: float = 1e-3
    same_place: float = 0.15
    paw_residual_sd: float = 0.1
    in_line: float = 0.5
    one_view: float = 0.6
    still_frames: int = 9
    mean_share: float = 0.1
    sure: float = 0.25
    rare: float = 0.03
    found: float = 0.1
    sides_unknown: float = 0.24
    frames_measured: int = 12


PAW_PROPOSAL = in_force("paw_proposal", PawProposalParameters())
"""The parameters in force."""
