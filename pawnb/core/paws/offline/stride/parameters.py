"""Parameters of the stage ``stride``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class StrideParameters:
    """The stride that is learnt in the recording: stance, duty factor and swing.

    Parameters
    ----------
    cycle_bins : int
        Bins of a stride in which its mean course is learnt. Set by hand.
    cycle_window : float
        Standard deviation, in strides, of the window in which a phase is estimated. Set by hand.
    cycle_rounds : int
        Times that phase and course are fitted in turn. Set by hand.
    least_share : float
        Less of the motion than this explained by the cycle means that there is none. Set by hand.
    least_strides : float
        Strides that a recording holds at least, or nothing is learnt. Set by hand.
    cycle_ridge : float
        Where little is seen nothing changes: in the information that a window usually holds. Two
        points of one side hardly tell the body's place from the phase of their stride. Set by hand.
    cycle_alike : float
        Neighbouring frames of a stride that err alike. Set by hand.
    duty_factor_least : int
        Strides of a kind of paw from which its share is learnt. Set by hand.
    unusual_ratio : float
        A stride or a swing this many times as long as the usual one, or as short, is not learnt
        from: a stance was missed. Set by hand.
    duty_factor_covered : float
        Share of the time, of all points, that their usual strides make up at least. Measured: in
        rendered scenes 0.42 to 0.92. In a clip of a mouse whose paws are seen to stand for a few
        frames here and there it is 0.15, and what such strides say of lift-offs is wrong.
    duty_factor_finest : float
        Standard deviation of the share from stride to stride. What lift-offs that are estimated
        wrongly make of it would be far more. Set by hand.
    like_others : float
        Standard deviation of how much front and hind paws differ in it. Set by hand.
    duty_factor_mad : float
        Standard deviation of a normal distribution in median absolute deviations: mathematics, one
        over the 3/4 quantile of the standard normal distribution, rounded.
    of_median : float
        Standard error of a median in that of a mean, of a normal distribution: mathematics, the
        square root of half of pi, rounded.
    duty_factor_hop : float
        A swing shorter than so much of the usual one was none. Set by hand.
    stance_half : int
        Frames before and after over which a speed is taken. Set by hand.
    with_ground : float
        A point goes with the ground if its speed differs by less than this share of the ground's.
        Set by hand.
    stance_slow : float
        Or if it differs by less than so many paw widths a frame. Set by hand.
    stance_off : float
        A point has left the ground if it is so many paw widths from where it stood. Set by hand.
    stance_least : int
        Frames needed to tell that a point stands. Set by hand.
    stance_beside : float
        Another paw covers a point up to so many paw widths from it in the picture. Set by hand.
    stance_up : float
        Change of speed at lift-off before anything is learnt, in that of the fastest swings:
        upwards. Set by hand.
    stance_assumed : float
        That counts as so many lift-offs seen. Set by hand.
    most_cost : float
        Largest cost of lifting off at another time than is due. Set by hand.
    half_frame : float
        A paw lifts off so many frames after the last one in which it stands, and lands as long
        before the first, on average: mathematics, half the time between two frames.
    still_near : float
        A stance seems to last so many frames longer at either end: what leaves the ground is still
        near it. Set by hand.
    back_share, back_acceleration : float
        Standard deviation of how much faster than the ground a point goes back: in the speed of the
        ground, and besides in the usual acceleration. Set by hand.
    lifted_above, lifted_within : float
        A point more than so many paw widths above where it stands is lifted, surely after as much
        more as the second. Set by hand.
    ride : float
        Cost of a frame in which a lifted point goes as the ground does. Set by hand.
    sunk : float
        The middle of a paw may be so many paw widths below its clicked end. Set by hand.
    strangest : float
        Squared standard deviations beyond which a speed backwards costs no more. Set by hand.
    swing_shape, swing_shape_sd : tuple of float
        Exponents a and b of a swing's height before any swing is seen, and their standard
        deviations. Set by hand after what was measured: front paws of mice are highest early on a
        belt, but late where they reach out (a of 2 to 3 in the LocoMouse data).
    landing_speed, landing_speed_sd : float
        Speed at landing in the mean speed of the swing, and its standard deviation. Set by hand
        after what was measured: LocoMouse's mice land with 0.3 to 0.55.
    swing_height_sd : float
        Standard deviation of heights, in their median. Set by hand.
    swing_shortest : float
        Frames for which a swing lasts at least. Set by hand.
    swing_noise : float
        Standard deviation of a place about its arc, in paw widths, forward and up. Set by hand.
    swing_alike : float
        Neighbouring frames that err alike. Set by hand.
    swing_tail : float
        Places farther off than so many standard deviations count less and less. Set by hand.
    swing_least : int
        Swings of a kind from which its arc is learnt. Set by hand.
    least_step : float
        Paw widths that a swing goes forward at least. Set by hand.
    swing_margin : int
        Frames before and after a swing that are fitted too. Set by hand.
    swing_seen : float
        Weight from which a place counts as seen. Set by hand.
    swing_uncertain : float
        How much a place counts that is not certain, in a swing of which one end is not known. Set
        by hand.
    swing_unsure, unsure_aside : float
        Standard deviations of places about their arc, in paw widths. Set by hand.
    near_s, swing_nearest : float or int
        A lift-off belongs to a stretch that begins or ends so near, s, and frames. Set by hand.
    due_sd : float
        Least standard deviation, frames, of a lift-off that an arc tells. Set by hand.
    least_frames : int
        Frames between two stances from which on a swing is looked for. Set by hand.
    touch_s, swing_detection_touch : float
        Standard deviation of when a stance that is seen begins or ends: time, s, and frames. Set by
        hand.
    swing_detection_open, swing_detection_vague : float
        So much larger where the stance begins or ends with a place that is seen but not certain,
        and where it is not seen. Set by hand.
    swing_detection_anywhere : float
        Where nothing shows when a stance ends, it may be anywhere in the frames between: its
        standard deviation is so much of their number, that of what is equally likely throughout:
        mathematics, one over the square root of 12, rounded.
    swing_detection_around : int
        Frames about a stance's end that must be seen to tell it. Set by hand.
    swing_detection_spread : float
        Least standard deviation of strides, in their length. Set by hand.
    on_place : float
        A paw that is seen within so many paw widths of where it will stand has landed. Set by hand.
    least_shape, largest_shape : float
        Least and largest exponent of a swing. Set by hand.
    swing_trajectory_lowest, swing_trajectory_highest : float
        A swing's height lies between these, in the median: what goes lower was mistaken. Set by
        hand.
    swing_trajectory_steps, swing_trajectory_rounds, swing_trajectory_fits : int
        Steps of a fit of one swing, rounds of swings and what they share, and fits of all in all.
        Set by hand.
    most_frames, most_slope, most_shape : float
        Largest changes in one step of a fit. Set by hand.
    least_high : float
        A swing that is seen no higher than so many paw widths says nothing of heights. Set by hand.
    cycle_full : float
        A phase counts fully where more than one over this of the frames about it show the point.
        Set by hand.
    cycle_phase_rounds : int
        Times that points are brought to one phase. Set by hand.
    cycle_stiff : float
        Weight of third differences of the cycle's curve, for each place. Set by hand.
    cycle_curve_rounds : int
        Times that the curve is found while places far from it count less. Set by hand.
    cycle_tail : float
        Median squares at which a place far from the cycle counts half. Set by hand.
    cycle_most_shift : float
        Largest correction of the phase in one round, cycles. Set by hand.
    cycle_farthest : float
        Median squares beyond which a place makes expectations no vaguer. Set by hand.
    cycle_sd_bins : float
        Smoothing of how far places are from the cycle, bins. Set by hand.
    cycle_typical : float
        Places that a bin is thought to hold besides, as far off as is typical. Set by hand.
    cycle_noise : float
        Standard deviation of a place from the cycle, in paw widths, at least. Set by hand.
    """

    cycle_bins: int = 48
    cycle_window: float = 0.6
    cycle_rounds: int = 3
    least_share: float = 0.6
    least_strides: float = 3.0
    cycle_ridge: float = 0.1
    cycle_alike: float = 5.0
    duty_factor_least: int = 2
    unusual_ratio: float = 1.5
    duty_factor_covered: float = 0.35
    duty_factor_finest: float = 0.02
    like_others: float = 0.02
    duty_factor_mad: float = 1.48
    of_median: float = 1.25
    duty_factor_hop: float = 0.5
    stance_half: int = 2
    with_ground: float = 0.25
    stance_slow: float = 0.04
    stance_off: float = 0.35
    stance_least: int = 4
    stance_beside: float = 1.2
    stance_up: float = 1.0
    stance_assumed: float = 2.0
    most_cost: float = 8.0
    half_frame: float = 0.5
    still_near: float = 0.5
    back_share: float = 0.25
    back_acceleration: float = 0.5
    lifted_above: float = 0.6
    lifted_within: float = 0.5
    ride: float = 7.0
    sunk: float = 0.7
    strangest: float = 9.0
    swing_shape: tuple[float, float] = (1.5, 2.0)
    swing_shape_sd: tuple[float, float] = (0.5, 0.8)
    landing_speed: float = 0.3
    landing_speed_sd: float = 0.3
    swing_height_sd: float = 0.15
    swing_shortest: float = 2.0
    swing_noise: float = 0.15
    swing_alike: float = 3.0
    swing_tail: float = 3.0
    swing_least: int = 3
    least_step: float = 2.0
    swing_margin: int = 4
    swing_seen: float = 0.3
    swing_uncertain: float = 0.2
    swing_unsure: float = 0.1
    unsure_aside: float = 0.2
    near_s: float = 0.02
    swing_nearest: int = 5
    due_sd: float = 0.7
    least_frames: int = 3
    touch_s: float = 0.003
    swing_detection_touch: float = 0.5
    swing_detection_open: float = 2.0
    swing_detection_vague: float = 3.0
    swing_detection_anywhere: float = 0.3
    swing_detection_around: int = 2
    swing_detection_spread: float = 0.05
    on_place: float = 0.7
    least_shape: float = 0.7
    largest_shape: float = 4.0
    swing_trajectory_lowest: float = 0.6
    swing_trajectory_highest: float = 1.6
    swing_trajectory_steps: int = 4
    swing_trajectory_rounds: int = 6
    swing_trajectory_fits: int = 4
    most_frames: float = 1.5
    most_slope: float = 0.2
    most_shape: float = 0.3
    least_high: float = 0.2
    cycle_full: float = 3.0
    cycle_phase_rounds: int = 5
    cycle_stiff: float = 0.005
    cycle_curve_rounds: int = 4
    cycle_tail: float = 6.0
    cycle_most_shift: float = 0.1
    cycle_farthest: float = 16.0
    cycle_sd_bins: float = 1.5
    cycle_typical: float = 2.0
    cycle_noise: float = 0.25


STRIDE = in_force("stride", StrideParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
