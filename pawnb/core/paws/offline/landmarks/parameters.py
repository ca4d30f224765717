"""Parameters of the stage ``landmarks``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class LandmarkParameters:
    """Landmarks of the body, followed by their own picture.

    Parameters
    ----------
    window_share : float
        Side of a patch as a share of the picture's width: after Haji Maghsoudi et al. 2019, 41 px
        in its pictures.
    least_window_px : int
        Least side of a patch. Set by hand.
    template_tracking_around : int
        Half the side of the region that is searched, in patches. Set by hand.
    template_tracking_alike, template_tracking_lost : float
        Correlation from which a patch is the clicked one; below the other, flow alone is no help.
        Set by hand.
    template_tracking_same, template_tracking_about, template_tracking_forget : float
        Correlation from which a patch that was sought everywhere around is the clicked one, or the
        share of its usual one in the frames before where that is less: pictures may be noisy. Set
        by hand.
    back_px : float
        Flow there and back again ends as near as this to where it began, or it is not believed. Set
        by hand.
    changed_frames : int
        A patch that flow alone has followed this long is how the landmark looks now. Set by hand.
    most_patches : int
        Looks of a landmark that are remembered: the clicked one, and the latest others. Set by
        hand.
    young_frames, template_tracking_largest : int
        A patch grows in its first frames, to so many times its side, until it can be distinguished.
        Set by hand.
    least_likeness : float
        Likeness that a landmark which was found has at least. Set by hand.
    blur_px : float
        Standard deviation of the smoothing before patches are compared. Set by hand.
    template_tracking_apart, template_tracking_together : float
        Views that disagree by more than the first, in patches, hold one that is wrong: the one
        without which the others agree to within the second, or of two the one that looks less
        alike. Set by hand.
    tracks_sigma : float
        Standard deviation of a landmark that looks as it was clicked, in patches. Set by hand.
    tracks_alike : float
        What is wrong in the same way from frame to frame: the look changes with the light. Set by
        hand.
    tracks_jerk : float
        Change of acceleration from frame to frame at 200 frames/s, in patches. Set by hand.
    rate_hz : float
        Frame rate that the change of acceleration is given for: a unit, not a choice.
    tracks_tail : float
        Residuals beyond this many standard deviations count less and less. Set by hand.
    by_hand : float
        What a person has put in place counts this many times as much as what was seen. Set by hand.
    tracks_steps : int
        Times that residuals are weighed anew. Set by hand.
    flow_steps : int
        Most steps of the optical flow on each level; OpenCV's usual number is 30. Set by hand.
    flow_ends_px : float
        Step, px, at which it ends. The
        default of OpenCV's calcOpticalFlowPyrLK.
    flow_levels : int
        Pyramid levels of the flow from frame to frame. The
        default of OpenCV's calcOpticalFlowPyrLK.
    align_levels : int
        Pyramid levels where a patch is laid on a place that is nearly known. Set by hand.
    larger : float
        Windows with too little texture become so many times larger. Set by hand.
    gains : tuple of float
        Contrast of a patch is changed by no less and no more than this. Set by hand.
    least_clear : float
        Standard deviations are those of a likeness of this, at least. Set by hand.
    """

    window_share: float = 0.02
    least_window_px: int = 15
    template_tracking_around: int = 3
    template_tracking_alike: float = 0.75
    template_tracking_lost: float = 0.6
    template_tracking_same: float = 0.9
    template_tracking_about: float = 0.97
    template_tracking_forget: float = 0.1
    back_px: float = 0.5
    changed_frames: int = 5
    most_patches: int = 8
    young_frames: int = 3
    template_tracking_largest: int = 3
    least_likeness: float = 0.05
    blur_px: float = 1.0
    template_tracking_apart: float = 1 / 3
    template_tracking_together: float = 1 / 6
    tracks_sigma: float = 0.03
    tracks_alike: float = 0.06
    tracks_jerk: float = 0.01
    rate_hz: float = 200.0
    tracks_tail: float = 3.0
    by_hand: float = 10.0
    tracks_steps: int = 4
    flow_steps: int = 20
    flow_ends_px: float = 0.01
    flow_levels: int = 3
    align_levels: int = 1
    larger: float = 1.5
    gains: tuple[float, float] = (0.5, 2.0)
    least_clear: float = 0.3


LANDMARKS = in_force("landmarks", LandmarkParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
