"""Parameters of the stage ``sequence``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class SequenceParameters:
    """The way through the frames, and the fit of all of them together.

    Parameters
    ----------
    between_annotations_coarse_blurs : tuple[float, ...]
        Half widths of the blur, working px, of the first fits between two annotated frames. Set by
        hand.
    final_fit_sweeps : int
        How often frames are fitted at most, each time with what the last fits of the others say.
        Set by hand.
    final_fit_gain : float
        A frame is fitted again where the cost of one of its legs is expected to fall by this, which
        is that of one standard deviation (mathematics: half its square).
    final_fit_rounds : int
        Steps of each of these fits: they begin close to their end. Set by hand.
    final_fit_first_rounds, final_fit_enough : int or float
        Most steps of the first of these fits, in which the animal's appearance is new, and what
        its cost must fall by in a step to go on. Set by hand.
    alike_px : float
        Errors of pixels nearer than this go together: so many pixels count as one in each
        direction. Set by hand, on rendered spiders.
    model_sd : float
        What the painted shape errs by itself, alike in all frames (hairs, shadow, bends), half
        widths of the picture's blur. Set by hand, on rendered spiders.
    start_sd_px, start_sd_deg : float
        Standard deviation of a place, working px, and of an angle, degrees, in a start pose. Set by
        hand.
    first_frame_longer, longer_sd : float
        In the start frame links may be this much longer than given, with this spread within a leg:
        the person's scale and the species file's proportions need not be this animal's. Set by
        hand.
    later_longer : float
        Factor by which a leg may be longer than in the start frame. Set by hand.
    first_frame_shorter : tuple[float, ...]
        Logarithms of foreshortening of whole legs that are tried in the start frame. Set by hand.
    first_frame_coarse_blurs : tuple[float, ...]
        Half widths of the blur, working px, of the first fits of the start frame. Set by hand.
    body_blurs : tuple[float, ...]
        The same of the body alone. Set by hand.
    dark_limits : tuple[float, ...]
        Least and most darkness of the animal in the start frame. Set by hand.
    first_frame_slides : tuple[float, ...]
        Lengths of legs that are tried, of their own. Set by hand.
    first_frame_better : float
        What a cost falls by, at least, where another pose is taken: that of one standard deviation.
        Set by hand.
    blur_step, blur_turns : float or int
        Factor between half widths of the blur that are tried, and turns of doing so. Set by hand.
    first_frame_blurs : tuple[float, ...]
        Half widths of the blur that are tried, working px: with a narrower one the painted edge
        lies between the middles of pixels, and the fit does not feel which way to move it. Set by
        hand.
    angle_sd_deg, length_sd : float
        Standard deviation of second differences before anything is known of this animal: wide. Set
        by hand.
    least_deg, least_length : float
        What is added to the spread of second differences: no joint of a living leg moves more
        evenly. Set by hand.
    leg_motion_counts : float
        So many frames is that least spread worth. Set by hand.
    leg_motion_tail : float
        Degrees of freedom of Student's t: a leg that leaps in a few frames, because it is wrong
        there, does not say how legs move. Set by hand.
    leg_motion_rounds : int
        Times that spread and weights are found in turn. Set by hand.
    coarse_blur : float
        Blur, px, of the first fit of a lost animal, which draws from further away. Set by hand.
    body_lost : float
        Share of the body's darkness below which it is not there. Set by hand.
    lost_frames : int
        Following ends after more frames in a row without a body. Set by hand.
    leg_lost, tip_lost : float
        Support of a leg, and of its outer third, below which it is taken for lost. Set by hand.
    unexplained_share : float
        Dark pixels left over beyond the usual, as a share of a leg's area, from which on legs are
        looked for. Set by hand.
    one_direction_unlikely : float
        Cost of a leg's pose by anatomy from which on it is doubted. Set by hand.
    usual_grows : float
        Factor by which what is left over may grow a frame and still be usual. Set by hand.
    first_frames : int
        Frames after the start in which it is not known yet how the legs move. Set by hand.
    keep_velocity : float
        Share of a step that is expected again: legs stop and turn. Set by hand.
    leap_px : float
        Three times as far is no motion of a leg from one frame to the next: it was lost. Set by
        hand.
    one_direction_rival : float
        A candidate whose best path costs this much more than the best is followed no further. Set
        by hand.
    learn_length : float
        Share by which the usual length of each segment follows each frame: about 30 frames. Set by
        hand.
    jump_of_median, jump_frames : float or int
        Spread of the places of legs, as a multiple of how far the middle one strays over so many
        frames: a walking fly takes half a step between two frames at 25 a second. Set by hand.
    start_rounds : int
        Times that pose and look of the start frame are found in turn. Set by hand.
    rounds_blurred : int
        Steps at most of a fit to a blurred picture, of a leg alone, or from nearby. Set by hand.
    rounds_whole : int
        Steps at most of a fit of a whole pose that a person placed. Set by hand.
    rounds_coarse : int
        Steps at most of the next frame's first fit, to a more blurred picture. Set by hand.
    rounds_next : int
        Steps at most of its second. Set by hand.
    rounds_alternative : int
        Steps at most of a leg from another place in the frame before. Set by hand.
    rounds_decided : int
        Steps at most of a pose after legs were decided on. Set by hand.
    leap_far : float
        A leg that moved so many times ``leap_px`` does not go on as it moved. Set by hand.
    close : float
        Legs are close where their tips are within so many times ``candidates.same_px``. Set by
        hand.
    dark_percentile : float
        How dark the animal is: a percentile of the pixels within its outline. Set by hand.
    """

    between_annotations_coarse_blurs: tuple[float, ...] = (8.0, 4.0)
    final_fit_sweeps: int = 5
    final_fit_gain: float = 0.5
    final_fit_rounds: int = 3
    final_fit_first_rounds: int = 8
    final_fit_enough: float = 0.01
    alike_px: float = 4.5
    model_sd: float = 0.3
    start_sd_px: float = 6.0
    start_sd_deg: float = 8.0
    first_frame_longer: float = 1.12
    longer_sd: float = 0.08
    later_longer: float = 1.02
    first_frame_shorter: tuple[float, ...] = (0.05, -0.05, -0.15, -0.25, -0.4)
    first_frame_coarse_blurs: tuple[float, ...] = (8.0, 4.0)
    body_blurs: tuple[float, ...] = (16.0, 8.0, 3.0)
    dark_limits: tuple[float, float] = (0.2, 1.0)
    first_frame_slides: tuple[float, ...] = (0.92, 1.08, 1.16)
    first_frame_better: float = 0.5
    blur_step: float = 0.85
    blur_turns: int = 2
    first_frame_blurs: tuple[float, ...] = (0.75, 4.0)
    angle_sd_deg: float = 8.0
    length_sd: float = 0.12
    least_deg: float = 0.5
    least_length: float = 0.005
    leg_motion_counts: float = 20.0
    leg_motion_tail: float = 4.0
    leg_motion_rounds: int = 3
    coarse_blur: float = 4.0
    body_lost: float = 0.5
    lost_frames: int = 2
    leg_lost: float = 0.75
    tip_lost: float = 0.5
    unexplained_share: float = 0.12
    one_direction_unlikely: float = 5.0
    usual_grows: float = 1.02
    first_frames: int = 2
    keep_velocity: float = 0.9
    leap_px: float = 12.0
    one_direction_rival: float = 30.0
    learn_length: float = 0.03
    jump_of_median: float = 1.5
    jump_frames: int = 30
    start_rounds: int = 3
    rounds_blurred: int = 8
    rounds_whole: int = 20
    rounds_coarse: int = 2
    rounds_next: int = 5
    rounds_alternative: int = 3
    rounds_decided: int = 4
    leap_far: float = 3.0
    close: float = 2.0
    dark_percentile: float = 70.0


SEQUENCE = in_force("sequence", SequenceParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
