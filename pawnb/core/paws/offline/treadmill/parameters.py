"""Parameters of the stage ``treadmill``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class TreadmillParameters:
    """How the stages are repeated, and what is believed of a track in between.

    Parameters
    ----------
    learnt_appearance_rounds : int
        Times that the look is learnt. Measured: of 725 visible labels of a grey film in H.264 of
        crf 28 (half scale, seed 31) 16 and 9 were wrong after one and two.
    learnt_appearance_predicted : float
        How much like a paw a place is that another program surely predicts: clicks have 1. Set by
        hand.
    pipeline_believed : float
        Standard deviation, in paw widths, at which a track is half believed. Set by hand.
    learnt_from : float
        The same for learning the stride and its swings from it. Set by hand.
    rising_s : float
        Time, s, after lift-off in which a paw goes on as it began. Set by hand.
    pipeline_stated : float
        Standard deviations of certain places are stated so much smaller than what is reckoned with
        while neighbouring frames may still err alike. Measured: so 93 to 97 % of the truth lie
        within 95 % limits, occluded places among them, in rendered scenes. Cameras on one side tell
        depth less well than they reckon.
    one_more : int
        Looks taken besides where tracks still change: a paw was decided on while another, for which
        it was mistaken, was not yet where it is now. Set by hand.
    pipeline_changes, changed_frames : float or int
        Tracks change where they go so many paw widths elsewhere in so many frames. Set by hand.
    pipeline_same : float
        A place that says that a point is so many paw widths from where it was placed is another's.
        Set by hand.
    tracker_beyond : float
        What no view found and is predicted further from the middle of the others than so many body
        sizes is missing. That of :class:`.quality.labels.QualityLimits`, set by hand. A walking man
        filmed by four cameras had a hand predicted 1000 body sizes away.
    least_seen : float
        Unlabelled targets that are seen as paws of their own in fewer frames are none. Set by hand.
    least_seen_aside : float
        The same where depth tells that they are on the other side. Set by hand.
    hidden_speed : float
        The standard deviation of a point that no view has grows by so many body sizes per second
        from the nearest frame in which one has it; a body is as long as its farthest points are
        apart. Measured: detections of one paw were left out for 5 to 40 frames of 250 a second in
        four rendered films, two in colour, two in grey, one of these in H.264 and one of another
        renderer. Of 31 paws of which more than a tenth was wrong 16 were called good without
        growth, 9 with 1.5 and 8 with 2.5, of 225 others 30, 38 and 51 were not. Of hidden
        coordinates in grey 71 % lay within their 95 % intervals, and then 85 and 89, in colour 92,
        94 and 95.
    hidden_most : float
        It grows no further, body sizes: paws go about so far from the middle of their strides. Set
        by hand.
    tracker_mistaken : float
        Share of what is about the animal that passes for paws from which on a person is warned.
        Measured: 0.2 to 6 % in rendered scenes that are tracked well, 9 to 23 % where belts are as
        brown as the paws: a third of these is lost and most others are poor.
    """

    learnt_appearance_rounds: int = 2
    learnt_appearance_predicted: float = 0.5
    pipeline_believed: float = 0.25
    learnt_from: float = 0.3
    rising_s: float = 0.012
    pipeline_stated: float = 0.7
    one_more: int = 1
    pipeline_changes: float = 2.0
    changed_frames: int = 5
    pipeline_same: float = 1.2
    tracker_beyond: float = 1.25
    least_seen: float = 0.3
    least_seen_aside: float = 0.1
    hidden_speed: float = 1.5
    hidden_most: float = 0.25
    tracker_mistaken: float = 0.08


TREADMILL = in_force("treadmill", TreadmillParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
