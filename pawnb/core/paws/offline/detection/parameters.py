"""Parameters of the stages ``learnt_detection``, ``predictions`` and ``point_tracker``."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force
from pawnb.errors import InputError


@dataclass(frozen=True)
class LearntDetectionParameters:
    """How a point's look is learnt in the recording, beside ``appearance`` and ``correlation``.

    Parameters
    ----------
    copies_turn_deg : float
        Copies of a clicked picture are turned by so much, degrees, either way, where points are
        learnt; paws have ``paw_turn_deg``. Set by hand.
    copies_scale : float
        They are scaled by so much, as a share, either way. Set by hand.
    copies_shift_px : float
        They are shifted by so much, working px, either way. Set by hand.
    copies_light : tuple of float
        Factors between which their light is changed. Set by hand.
    copies_noise : float
        Standard deviation of the noise that is added, grey values. Set by hand.
    nowhere : float
        Where points together are less likely, the places about it are not looked at: ratios of
        likelihoods begin above it (``appearance.lowest``). Set by hand.
    own_radii : float
        What is so near to a point is the point's, in radii. Set by hand.
    doubtful_radii : float
        What is so near is neither its nor background, in radii. Set by hand.
    open_radii : float
        What is so near to a place that may be a point without a name says nothing, in radii. Set by
        hand.
    batch : int
        Samples of one step of learning. Set by hand.
    learning_rate : float
        Size of a step. Set by hand.
    weight_decay : float
        Weight of the square of the weights. Set by hand.
    patch_shrink : int
        Pictures and patches are made so much smaller before they are correlated. Set by hand.
    score_mean : float
        Mean score of the point itself before any is seen. Set by hand.
    score_sd : float
        Its standard deviation. Set by hand.
    score_worth : float
        How many seen scores these two are worth. Set by hand.
    least_peak : float
        Peaks that are the point with less probability carry nothing. Set by hand.
    highest_correlation : float
        Correlations are not taken to be higher: a patch matches itself exactly. Set by hand.
    fine_sd_px : float
        Standard deviation of the finest scale, px at half size: 1.5 px at full size, 1 px of them
        by halving. Set by hand.
    texture_sd_px : float
        That of what texture is gathered over, px at half size. Set by hand.
    least_thickness : float
        Paws are at least so thick, in distances of front from hind paws: brightness shows a part of
        them only. Measured: 0.04 in a grey film whose colours show 0.057.
    paw_px : float
        Pictures are scaled until a paw is so thick, px. Measured: of 725 visible labels of a grey
        film (half scale, seed 31) 0 and 21 were wrong where it was enlarged 3.3 and 2.0 times; this
        is 2.8.
    paw_spacing_px : int
        They are looked at in such steps, px. Set by hand.
    paw_own : float
        In paw widths: what lies so near to a paw's point is the paw. Set by hand.
    paw_doubtful : float
        What lies so near is neither it nor background. Set by hand.
    paw_open : float
        What lies so near may be a paw where one was not clicked. Set by hand.
    paw_most_odds : float
        Largest logarithm of odds: networks that learnt from few clicks are too sure. Set by hand.
    paw_neutral : float
        Logarithm of odds that tells neither way: a paw lies in one of so many (13) places. Set by
        hand.
    paw_copies : int
        How often a clicked picture is taken, turned, scaled and lit differently. Measured with
        ``paw_turn_deg``.
    paw_turn_deg : float
        It is turned by so much, degrees, either way: a paw that swings is turned, and the clicks
        show few that do. Measured: of 1000 visible labels of three scenes of another renderer, in
        grey and in H.264 of crf 28, 33 were wrong with 10, a scale of 0.08 and 8 copies, and 15
        with these; of three more scenes 34 and 19.
    paw_scale : float
        It is scaled by so much, as a share, either way. Measured with ``paw_turn_deg``.
    paw_copies_tracked : int
        The same of a tracked one. Set by hand.
    paw_frames : int
        Frames from which is learnt again, spread over the recording. Set by hand.
    paw_sure : float
        Standard deviation, in paw widths, below which a track is learnt from. Set by hand.
    found_blur : float
        Blur of probabilities, places of the grid. Set by hand.
    found_unsure : float
        Added to the probability that a point is elsewhere: keeps what is certain within what the
        samples can tell. Set by hand.
    copies_fewer : int
        Frames that were not clicked are taken so many times less often. Set by hand.
    background_radii : float
        Places of the background that are so many radii away are taken half as often as near ones.
        Set by hand.
    moment_decays : tuple of float
        Decay of the mean gradient and of its square. Kingma & Ba 2015, who propose both.
    near_sd_px : float
        Scale of derivatives, px at half the working size. Set by hand.
    middle_sd_px : float
        The same, of the second, beyond the first. Set by hand.
    far_sd_px : float
        The same, of the third, beyond the second. Set by hand.
    colour_sd_px : float
        The same of colour. Set by hand.
    rings_px : tuple of float
        Radii of the rings about a place, working px. Set by hand.
    ring_minus : float
        Share of the brightness at the place that is taken from that of the rings. Set by hand.
    texture_least : float
        Added to the strength of texture, so that noise has no direction. Set by hand.
    paw_usual_least : float
        Likeness that paws usually have at clicks, at least. Set by hand.
    paw_background : float
        Places of the background so many paw widths away are taken half as often as near ones. Set
        by hand.
    """

    copies_turn_deg: float = 10.0
    copies_scale: float = 0.08
    copies_shift_px: float = 2.0
    copies_light: tuple[float, float] = (0.8, 1.25)
    copies_noise: float = 3.0
    nowhere: float = 0.004
    own_radii: float = 0.55
    doubtful_radii: float = 1.0
    open_radii: float = 1.2
    batch: int = 256
    learning_rate: float = 3e-3
    weight_decay: float = 0.3
    patch_shrink: int = 2
    score_mean: float = 4.0
    score_sd: float = 1.5
    score_worth: float = 10.0
    least_peak: float = 0.05
    highest_correlation: float = 0.98
    fine_sd_px: float = 0.56
    texture_sd_px: float = 1.4
    least_thickness: float = 0.05
    paw_px: float = 18.0
    paw_spacing_px: int = 4
    paw_own: float = 0.35
    paw_doubtful: float = 0.7
    paw_open: float = 1.2
    paw_most_odds: float = 4.0
    paw_neutral: float = -2.5
    paw_copies: int = 16
    paw_turn_deg: float = 40.0
    paw_scale: float = 0.25
    paw_copies_tracked: int = 1
    paw_frames: int = 32
    paw_sure: float = 0.3
    found_blur: float = 0.8
    found_unsure: float = 0.02
    copies_fewer: int = 4
    background_radii: float = 3.0
    moment_decays: tuple[float, float] = (0.9, 0.999)
    near_sd_px: float = 1.3
    middle_sd_px: float = 5.2
    far_sd_px: float = 10.4
    colour_sd_px: float = 5.1
    rings_px: tuple[float, ...] = (10.0, 20.0, 35.0)
    ring_minus: float = 0.7
    texture_least: float = 1e-4
    paw_usual_least: float = 0.1
    paw_background: float = 4.0


LEARNT = in_force("learnt_detection", LearntDetectionParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""


@dataclass(frozen=True)
class PredictionParameters:
    """How far predictions of another program are believed.

    Parameters
    ----------
    least_likelihood : float
        A prediction's likelihood counts as this much at least. Set by hand.
    sd : float
        Standard deviation of predictions before any click is seen, in extents. Set by hand.
    sd_clicks : float
        How many clicks that is worth. Set by hand.
    sd_least : float
        It is at least so large, in extents. Set by hand.
    sd_least_px : float
        And at least so large, px. Set by hand.
    misplaced : float
        A right prediction is not where it was clicked in this share of clicks. Set by hand.
    on_another : float
        A wrong prediction is on another point in this share of clicks. Set by hand.
    sure : float
        Most that a prediction is believed. Set by hand.
    longest_wrong : float
        Longer stretches of errors, in frames, are known from clicks alone and make no evidence
        weaker. Set by hand.
    rounds : int
        Times that reliability and its parameters are estimated in turn. Set by hand.
    unknown_extent : float
        Extent where there are no two points, in shorter sides of the picture. Set by hand.
    mostly : float
        Steps are mostly below this percentile of them. Predictions may be wrong in a tenth of
        frames, which is a fifth of steps. Set by hand.
    mostly_times : float
        Times this. Set by hand.
    least_step : float
        But at least so long, in extents a frame. Set by hand.
    most_step : float
        And at most so long. Set by hand.
    step_gap : int
        Predictions farther apart than so many frames say nothing of steps. Set by hand.
    crossed : float
        Two points exchange places if crossed steps are shorter than this share of straight ones.
        Set by hand.
    counts_of_changes : tuple of float
        Pseudo-counts of states (right, astray, elsewhere, mistaken) from one frame to the next. Set
        by hand.
    at_first : tuple of float
        Probabilities of states in the first frame. Set by hand.
    counts_of_likelihoods : tuple of float
        Pseudo-counts of likelihoods in each state; those where it is mistaken are those where
        right. Set by hand.
    counts_of_steps : tuple of float
        Pseudo-counts of steps: in one state, from or to being astray, from or to being elsewhere.
        Set by hand.
    """

    least_likelihood: float = 0.02
    sd: float = 0.03
    sd_clicks: float = 2.0
    sd_least: float = 0.01
    sd_least_px: float = 1.0
    misplaced: float = 0.02
    on_another: float = 0.5
    sure: float = 0.98
    longest_wrong: float = 30.0
    rounds: int = 12
    unknown_extent: float = 0.4
    mostly: float = 75.0
    mostly_times: float = 1.5
    least_step: float = 0.01
    most_step: float = 0.1
    step_gap: int = 5
    crossed: float = 0.5
    counts_of_changes: tuple[tuple[float, ...], ...] = (
        (98.7, 0.9, 0.4, 0.001),
        (8.0, 1.6, 0.4, 0.0),
        (0.8, 0.2, 9.0, 0.0),
        (0.001, 0.9, 0.4, 98.7),
    )
    at_first: tuple[float, ...] = (0.9, 0.03, 0.04, 0.03)
    counts_of_likelihoods: tuple[tuple[float, ...], ...] = (
        (0.1, 0.3, 1.0, 2.0, 3.0, 3.6),
        (2.5, 2.0, 1.8, 1.5, 1.2, 1.0),
        (1.5, 1.5, 1.8, 1.8, 1.7, 1.7),
    )
    counts_of_steps: tuple[tuple[float, ...], ...] = (
        (450.0, 40.0, 7.0, 2.0, 0.1),
        (0.4, 0.8, 1.0, 7.6, 0.2),
        (0.5, 0.8, 1.0, 3.7, 4.0),
    )


PREDICTIONS = in_force("predictions", PredictionParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""


@dataclass(frozen=True)
class PointTrackerParameters:
    """How a trained network that a trial names follows clicks.

    No trained weights were at hand: nothing here was chosen by what it does to tracks.

    Parameters
    ----------
    side_px : int
        Pictures are scaled to squares of this side, a multiple of 8. Doersch et al. 2024, whose
        network was trained with 256 and does best with 512.
    piece_rows : int
        Frames that are looked at together: with 512 px they take about 4 GB. Measured: 24 took 2.
    overlap_rows : int
        Frames that two pieces share. Set by hand.
    sure : float
        A path goes on into the next piece from a place of at least this probability. Doersch et al.
        2023, who call a point visible from there on.
    right : float
        Share of paths that are right at the next click, before any is seen; at 0.5 they say nothing
        then. Measured: two patches of the same look that pass each other, one clicked frame, and a
        network that goes over to the other one 8 frames after a click. With 0.7, 99 % of labels
        that were right without it became 23 %, at a confidence of 0.91.
    worth_clicks : float
        How many clicks that is worth. Set by hand.
    sd_px : float
        Standard deviation of a place before any click is seen, working px: that of ``motion``. Set
        by hand.
    reach : float
        Paths are believed so many times as far from a click as any was found right. Set by hand.
    gain : float
        Ratio of likelihoods at a place that is fully trusted: that of ``motion``. Set by hand.
    lowest : float
        Places of a lower ratio carry nothing. Set by hand.
    """

    side_px: int = 512
    piece_rows: int = 48
    overlap_rows: int = 12
    sure: float = 0.5
    right: float = 0.5
    worth_clicks: float = 2.0
    reach: float = 2.0
    sd_px: float = 5.2
    gain: float = 15.0
    lowest: float = 0.1

    def __post_init__(self) -> None:
        if self.side_px < 8 or self.side_px % 8:
            raise InputError(
                f"point_tracker.side_px is {self.side_px}; expected a multiple of 8, such as 256."
            )
        if not 0 < self.overlap_rows < self.piece_rows:
            raise InputError(
                f"point_tracker.overlap_rows is {self.overlap_rows}; expected 1 or more, and fewer "
                f"than piece_rows, {self.piece_rows}."
            )


POINT_TRACKER = in_force("point_tracker", PointTrackerParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
