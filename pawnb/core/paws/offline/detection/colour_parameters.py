"""Parameters of the stage ``colour``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class ColourParameters:
    """How paws of a colour of their own are found in a picture.

    Parameters
    ----------
    background_samples : int
        Frames, evenly spread, of which the background is the median. Set by hand.
    blob_detection_width : float
        Standard deviation of the smoothing, in reaches of the search. Set by hand.
    blob_detection_least : float
        Least smoothed score of a spot, in that which clicked paws have. Set by hand.
    colour_model_rounds : int
        Times that the colour is learnt from what it found. Set by hand.
    colour_model_reach, reach_grey : float
        A paw's look is learnt this far from its click, as a share of the picture's width. Fur,
        shadow and belt that mix with the colour at a paw's edge would pass for paws. Set by hand.
    colour_model_few, colour_model_distinct, reach_few : int or float
        With fewer clicks than the first, as in one view by itself, half as far again, where the
        ratio at the clicks says that paws are distinguished well from the rest: the little that two
        paws show close to their clicks is not all of their colours. Measured: over 27 single views
        of rendered mice 15 % of labels were wrong without it, 11 % with it, and 10 and 9 % with
        0.008 and 0.012.
    learnt_width : int
        Larger colour pictures are reduced to about this width before their look is learnt. Set by
        hand.
    colour_model_wide : tuple[float, ...]
        What lies this far from clicks tells against paws, as shares of the picture's width: each
        share counts alike, as shadows about the paws are a small part of the picture and fur, ears
        and tail are not near them. Set by hand.
    colour_model_limit : float
        Largest log-likelihood ratio either way: one pixel never decides alone. Set by hand.
    colour_model_like, colour_model_sure : float
        Log-likelihood ratio from which pixels about a click are taken for paw, and the one that
        counts as 0 in the end. Set by hand.
    colour_model_usual, most_gain : float
        Least ratio that is usual at clicks. Where ears and tail have the colour of the paws it is
        lower; it is raised to this, at most so many times, as scores tell how much more like a
        clicked paw one place is than another. Set by hand.
    least_usual : float
        Scores at clicks below this mean that paws are hardly distinguished from the rest at all.
        Set by hand.
    colour_model_alike : float
        Share of what is about the animal that passes for paws from which on finer steps of colour
        are used. Measured: 0.2 to 1.7 % in 80 rendered scenes, 2.4 to 23 % in 14, most of which
        have a belt as brown as the paws. In those 14 of 10,071 wrong labels 2,355 are left.
    colour_model_faint : float
        Share of the same from which on pictures are smoothed more as well, and a place is told from
        what is about it. Measured: beyond it 13 of 15 rendered scenes were lost without, as noise
        is larger there than what tells paws from the belt; below it most are tracked.
    colour_model_passing, most_limit : float
        With finer steps the limit from which a place counts as paw is that which this share of what
        is near paws would pass, shadow among it, but no higher than this share of what is usual at
        clicks. Set by hand.
    colour_quantisation_steps : tuple[float, ...]
        How much finer than 8 levels the steps of each are. Set by hand.
    colour_quantisation_noise : tuple[float, ...]
        What a colour varies by at least, in the steps of :class:`FineColours`: noise of 8 levels of
        brightness and 2 of colour. Set by hand.
    colour_quantisation_smooth, smooth_much : tuple[int, float]
        Side and standard deviation of what smooths a picture, px. Noise is as large as these steps:
        pictures are smoothed a little more than for the usual ones. Set by hand.
    about_px, colour_quantisation_less : int or float
        The score about a place is the mean over a square of this side, some seven paws, of what
        speaks for paws there; so many times of it are taken off. Set by hand.
    detector_share : float
        Share of mask about a pixel that is neither an end nor further along a limb. Set by hand.
    share_spread : float
        Difference of that share over which a pixel turns from an end into none. Set by hand.
    ends_apart : float
        Two ends are no nearer to each other than this, in reaches of the search. Set by hand.
    score_blur_px : float
        Standard deviation, px, of what takes the noise of single pixels out of a score. Set by
        hand.
    least_behind : float
        Mask about an end, in squares of the reach, below which it is a speck. Set by hand.
    direction_usual, direction_gain : float
        What an end that points across where limbs tend to end counts, and how much more or less one
        that points there or back: that is a heel, an elbow or the tail's. Set by hand.
    least_likeness : float
        However little a detection looks like a paw, it counts this much. Set by hand.
    reduced_paw_px : float
        Pictures are reduced until a paw is about so many pixels thick. Set by hand.
    search_reach : float
        Half the side of the square in which an end is looked for, in paw widths. Set by hand.
    most_found : int
        Detections usually kept in one picture. Set by hand.
    looked_at : int
        Ends in one picture that are looked at closely. Set by hand.
    least_change : float
        Means that change by less are left alone: those of parts that follow the animal change by up
        to 0.06 as it moves, in steady light. Set by hand.
    most_change : float
        Light is not thought to change by a larger factor: then other things are to be seen. Set by
        hand.
    label_offsets_worse : float
        A detection this much worse than the best of its kind says nothing about offsets. Set by
        hand.
    label_offsets_click : float
        Least standard deviation of a click, in paw widths. Set by hand.
    label_offsets_reach : float
        An end farther than so many paw widths from a click is not that of the clicked paw: half a
        long hind foot, clicked in its middle, measures nearly two. Set by hand.
    label_offsets_far : float
        What an end a paw width farther from the click is worth less: it may be another paw's. Set
        by hand.
    label_offsets_beside : float
        To the side counts so much more than along: a paw lies behind its own end. Set by hand.
    likelihood_near : float
        A detection farther than so many paw widths from a click is not the clicked paw. Set by
        hand.
    least_score : float
        Scores at clicks below this mean that paws are hardly distinguished from the rest at all.
        Set by hand.
    smooth_px, paw_width_fine : float or int
        Standard deviation of the smoothing, px, and steps in a pixel, with which the thickness is
        measured. Set by hand.
    look_px, touch_px : int
        A paw's thickness is measured in a part of the picture this far about a click, at the pixels
        this near to it. Set by hand.
    scan_follow : float
        Share by which the searched region follows the detections from frame to frame. Set by hand.
    scan_most_step : float
        The region moves by no more than that share of so much of half its width a frame. Set by
        hand.
    scan_stride : int
        Frames between those in which the animal is sought back from the clicks: the region follows
        over twice as many. Set by hand.
    most_faint : int
        Detections kept in one picture where paws are hardly distinguished from their surroundings.
        Set by hand.
    in_hand : int
        Frames that may wait to be searched: no thread stands idle for the slowest view. Set by
        hand.
    blob_detection_apart : float
        Blobs are so many of their widths apart. Set by hand.
    fine_blur_px : float
        Blur before colours are counted, px of the reduced picture. Set by hand.
    least_margin : float
        Log-odds that paws usually have above the limit, at least, when they are scaled. Set by
        hand.
    floor_lab : tuple of float
        Least standard deviations of a paw's colour in CIE Lab. Set by hand.
    floor_grey : tuple of float
        The same of grey values: its own, over its surroundings, over what stays. Set by hand.
    wider : float
        The variance of a paw's colour is so many times that of its members. Set by hand.
    histogram_blur : float
        Blur of a histogram of colours, bins. Set by hand.
    histogram_even : float
        Share of a histogram that is even. Set by hand.
    fewest_members : int
        Grown regions of no more pixels are not taken. Set by hand.
    paw_width_ground : float
        Percentile of the score about a click that is its surroundings. Set by hand.
    stays : float
        Weight, in that of what views tell, of staying where it was in directions that they do not
        tell. Set by hand.
    curve_score : tuple of float
        Log-odds of being a paw by ``score``, in that at clicks: knots, and values there. Measured
        by ``benchmarks/learn_likeness.py`` on 26 rendered scenes.
    curve_share : tuple of float
        Log-odds of being a paw by ``share`` of mask: knots, and values there. Measured by
        ``benchmarks/learn_likeness.py`` on 26 rendered scenes.
    curve_ahead : tuple of float
        Log-odds of being a paw by ``ahead``, the cosine with the direction of limbs: knots, and
        values there. Measured by ``benchmarks/learn_likeness.py`` on 26 rendered scenes.
    curve_beside : tuple of float
        Log-odds of being a paw by ``beside``, its sine: knots, and values there. Measured by
        ``benchmarks/learn_likeness.py`` on 26 rendered scenes.
    curve_length : tuple of float
        Log-odds of being a paw by ``length`` from the wider centre to the near one, in paw widths:
        knots, and values there. Measured by ``benchmarks/learn_likeness.py`` on 26 rendered scenes.
    """

    background_samples: int = 32
    blob_detection_width: float = 0.4
    blob_detection_least: float = 0.13
    colour_model_rounds: int = 3
    colour_model_reach: float = 0.004
    reach_grey: float = 0.03
    colour_model_few: int = 4
    colour_model_distinct: float = 2.0
    reach_few: float = 0.006
    learnt_width: int = 1024
    colour_model_wide: tuple[float, ...] = (0.06, 0.2)
    colour_model_limit: float = 6.0
    colour_model_like: float = 1.5
    colour_model_sure: float = 1.0
    colour_model_usual: float = 2.5
    most_gain: float = 3.0
    least_usual: float = 1.0
    colour_model_alike: float = 0.02
    colour_model_faint: float = 0.06
    colour_model_passing: float = 0.005
    most_limit: float = 0.85
    colour_quantisation_steps: tuple[float, ...] = (2.0, 4.0, 4.0)
    colour_quantisation_noise: tuple[float, ...] = (16.0, 8.0, 8.0)
    colour_quantisation_smooth: tuple[int, float] = (5, 0.9)
    smooth_much: tuple[int, float] = (13, 1.9)
    about_px: int = 45
    colour_quantisation_less: float = 1.5
    detector_share: float = 0.34
    share_spread: float = 0.03
    ends_apart: float = 0.7
    score_blur_px: float = 0.6
    least_behind: float = 0.25
    direction_usual: float = 0.8
    direction_gain: float = 0.6
    least_likeness: float = 0.05
    reduced_paw_px: float = 6.0
    search_reach: float = 0.85
    most_found: int = 16
    looked_at: int = 60
    least_change: float = 0.07
    most_change: float = 4.0
    label_offsets_worse: float = 0.3
    label_offsets_click: float = 0.05
    label_offsets_reach: float = 2.5
    label_offsets_far: float = 0.25
    label_offsets_beside: float = 2.0
    likelihood_near: float = 1.2
    least_score: float = 0.5
    smooth_px: float = 0.8
    paw_width_fine: int = 4
    look_px: int = 16
    touch_px: int = 2
    scan_follow: float = 0.06
    scan_most_step: float = 0.1
    scan_stride: int = 8
    most_faint: int = 24
    in_hand: int = 2
    blob_detection_apart: float = 1.6
    fine_blur_px: float = 0.8
    least_margin: float = 0.1
    floor_lab: tuple[float, ...] = (5.0, 2.0, 2.0)
    floor_grey: tuple[float, ...] = (12.0, 12.0, 12.0)
    wider: float = 1.3
    histogram_blur: float = 0.7
    histogram_even: float = 0.01
    fewest_members: int = 9
    paw_width_ground: float = 20.0
    stays: float = 0.01
    curve_score: tuple[tuple[float, ...], tuple[float, ...]] = (
        (-0.5, 0.0, 0.25, 0.5, 0.75, 1.0, 1.3),
        (-4.9, -4.8, -3.4, -1.1, 1.4, 4.0, 3.5),
    )
    curve_share: tuple[tuple[float, ...], tuple[float, ...]] = (
        (0.04, 0.1, 0.14, 0.18, 0.22, 0.26, 0.3, 0.35, 0.4, 0.5),
        (-0.9, 0.2, 0.5, 1.7, 0.8, 0.1, -0.5, -1.0, -2.3, -3.8),
    )
    curve_ahead: tuple[tuple[float, ...], tuple[float, ...]] = (
        (-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 0.85, 1.0),
        (-4.0, -1.2, -1.0, -1.6, -0.3, 1.5, 0.9, 0.5),
    )
    curve_beside: tuple[tuple[float, ...], tuple[float, ...]] = (
        (-1.0, -0.6, -0.3, 0.0, 0.3, 0.6, 1.0),
        (-1.9, -0.5, -1.1, -0.1, 0.0, -1.0, -0.8),
    )
    curve_length: tuple[tuple[float, ...], tuple[float, ...]] = (
        (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8),
        (-0.3, -2.0, -0.3, 1.0, -1.1, -1.5, -0.6, -0.5),
    )


COLOUR = in_force("colour", ColourParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
