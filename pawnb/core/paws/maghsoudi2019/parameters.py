"""Parameters of the stage ``maghsoudi2019``: what the paper leaves open beside its settings."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class Maghsoudi2019Parameters:
    """What the paper gives no number for; what it names is in :class:`Maghsoudi2019Settings`.

    Parameters
    ----------
    collision_step : float
        In a collision a front paw is nearer than this to where the filter has it, in
        Collision_Threshold. Measured: in rendered scenes 99 % of the superpixels that are on a
        front paw are within 0.33 of it, and those taken when the paw has just been hidden are at
        0.9 in the median.
    collision_found_again : float
        A lost paw is found again nearer than this to where the template has it, in
        Collision_Threshold. Set by hand between the two that were measured for
        ``collision_step``.
    collision_astray : float
        A front paw is nearer than this to where the template has it, found or lost, in
        Collision_Threshold. Set by hand.
    collision_same : float
        Two paws found nearer than this to each other are one, in Collision_Threshold. Set by
        hand: about a superpixel.
    collision_wrong_fit : float
        A fit that misses a paw by more than this at the beginning of a collision is given up, in
        Collision_Threshold. Set by hand.
    collision_beginning : int
        Frames after a collision began in which its fit may still be given up. Set by hand.
    collision_held : float
        The flag is held for so long after the paws have parted, in strides of the template. Set
        by hand: front paws are hidden right after a collision.
    collision_lost : float
        A paw that is not found for longer is no longer predicted by the template, in its strides.
        Set by hand.
    collision_history : int
        Strides that are kept for a fit, which uses the last one of them. Set by hand.
    slow_step : float
        A point that moves farther than this between two frames, in half the sub-image, was
        corrected, and the step is no velocity. Haji Maghsoudi et al. 2019, section 2.3.1: paws move
        at most 30 px along and 15 px across in sub-images of 70 and 40 px about their middle,
        0.43 and 0.38 of it; rounded up.
    search_positions : int
        Positions along a line of sight at which a hidden point is looked for. Set by hand.
    search_apart : float
        Another point's superpixel is not this point's where it is nearer than this, in half the
        height of the sub-image. Set by hand.
    template_odd_stride : float
        A stride this many times longer or shorter than the median is none, or two. Set by hand.
    template_gap : int
        Frames for which gaps of a path are bridged at most. Set by hand: 20 ms at 250 frames a
        second.
    template_surest : float
        A place whose standard deviation is above this share of the paw's range is not known. Set
        by hand.
    template_extent : tuple of float
        Percentiles of a path between which a paw ranges. Set by hand, so that outliers do not
        count.
    template_excursion : float
        A stride moves by so much of the paw's range at least. Set by hand.
    cutoff_of_rate : float
        Highest cut-off of the low-pass filter, in the frame rate. Set by hand: below the 0.5 that
        Nyquist's theorem allows, for the two passes of the filter.
    fit_frequencies : tuple of float
        Lowest and highest stride frequency that are tried in a fit, in that of the template. Set
        by hand.
    fit_n_frequencies : int
        Frequencies that are tried, in equal ratios. Set by hand.
    fit_n_shifts : int
        Shifts of the circular correlation. Set by hand: 6 degrees of a stride apart.
    fit_joined : int
        Frames before a collision through whose mean the fitted stride is laid. Measured: in
        rendered scenes the prediction is a quarter nearer to the truth than with the midpoints of
        the paper.
    """

    collision_step: float = 0.4
    collision_found_again: float = 0.5
    collision_astray: float = 0.7
    collision_same: float = 1 / 6
    collision_wrong_fit: float = 0.3
    collision_beginning: int = 5
    collision_held: float = 0.2
    collision_lost: float = 0.5
    collision_history: int = 3
    slow_step: float = 0.5
    search_positions: int = 16
    search_apart: float = 0.5
    template_odd_stride: float = 1.5
    template_gap: int = 5
    template_surest: float = 0.1
    template_extent: tuple[float, float] = (5.0, 95.0)
    template_excursion: float = 0.4
    cutoff_of_rate: float = 0.36
    fit_frequencies: tuple[float, float] = (0.5, 2.0)
    fit_n_frequencies: int = 17
    fit_n_shifts: int = 60
    fit_joined: int = 5


MAGHSOUDI2019 = in_force("maghsoudi2019", Maghsoudi2019Parameters())
"""The parameters in force."""
