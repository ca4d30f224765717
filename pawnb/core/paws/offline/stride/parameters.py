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
    duty_factor_odd : float
        A stride this many times as long as the usual one, or as short, teaches nothing: a stance
        was missed. Set by hand.
    duty_factor_covered : float
        Share of the time, of all points, that their usual strides make up at least: in rendered
        scenes 0.42 to 0.92. In a clip of a mouse whose paws are seen to stand for a few frames here
        and there it is 0.15, and what such strides say of lift-offs is wrong.
    duty_factor_finest : float
        Standard deviation of the share from stride to stride. What lift-offs that are estimated
        wrongly make of it would be far more. Set by hand.
    like_others : float
        Standard deviation of how much front and hind paws differ in it. Set by hand.
    duty_factor_mad : float
        Standard deviation in median absolute deviations. Set by hand.
    of_median : float
        Standard error of a median in that of a mean. Set by hand.
    duty_factor_hop : float
        A swing shorter than so much of the usual one was none. Set by hand.
    stance_half : int
        Frames before and after over which a speed is taken. Set by hand.
    with_ground : float
        A point goes with the ground if its speed differs by less than this share of the ground's,
        or
    stance_slow : float
        by less than so many paw widths a frame. Set by hand.
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
    half_frame : float
        A paw lifts off so long after the last frame in which it stands, on average. Set by hand.
    swing_least : int
        Swings of a kind from which its arc is learnt, and
    least_step : float
        paw widths that a swing goes forward. Set by hand.
    swing_odd : float
        Swings so many times as long as the usual one, or as short, are none. Set by hand.
    swing_margin : int
        Frames before and after a swing that are fitted too. Set by hand.
    swing_seen : float
        Weight from which a place counts as seen. Set by hand.
    swing_uncertain : float
        How much a place counts that is not certain, in a swing of which one end is not known. Set
        by hand.
    swing_unsure, unsure_aside : float
        Standard deviations of places about their arc, in paw widths. Set by hand.
    bend_to : float
        Share of a swing after which its bends are not expected: landings differ. Set by hand.
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
        standard deviation is so much of their number, that of what is equally likely throughout.
        Set by hand.
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
    noise_aside : float
        Standard deviation of a place about its arc, in paw widths, aside. Set by hand.
    swing_trajectory_steps, swing_trajectory_rounds, swing_trajectory_fits : int
        Steps of a fit of one swing, rounds of swings and what they share, and fits of all in all.
        Set by hand.
    most_frames, most_slope, most_shape : float
        Largest changes in one step of a fit. Set by hand.
    aside_sd : float
        Standard deviation of how far a swing leads aside, in its length. Set by hand.
    least_high : float
        A swing that is seen no higher than so many paw widths says nothing of heights. Set by hand.
    swing_trajectory_seen : float
        Weight from which a place counts as seen. Set by hand.
    """

    cycle_bins: int = 48
    cycle_window: float = 0.6
    cycle_rounds: int = 3
    least_share: float = 0.6
    least_strides: float = 3.0
    cycle_ridge: float = 0.1
    cycle_alike: float = 5.0
    duty_factor_least: int = 2
    duty_factor_odd: float = 1.5
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
    half_frame: float = 0.5
    swing_least: int = 3
    least_step: float = 2.0
    swing_odd: float = 1.5
    swing_margin: int = 4
    swing_seen: float = 0.3
    swing_uncertain: float = 0.2
    swing_unsure: float = 0.1
    unsure_aside: float = 0.2
    bend_to: float = 0.9
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
    noise_aside: float = 0.3
    swing_trajectory_steps: int = 4
    swing_trajectory_rounds: int = 6
    swing_trajectory_fits: int = 4
    most_frames: float = 1.5
    most_slope: float = 0.2
    most_shape: float = 0.3
    aside_sd: float = 0.3
    least_high: float = 0.2
    swing_trajectory_seen: float = 0.3


STRIDE = in_force("stride", StrideParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
