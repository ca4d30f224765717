"""Parameters of the stage ``quality``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force
from pawnb.core.paws.offline.quality.labels import QualityLimits


@dataclass(frozen=True)
class QualityParameters:
    """What tells how likely labels are right, beside :class:`.labels.QualityLimits`.

    Parameters
    ----------
    weights : tuple of float
        Of the columns of :class:`.signs.Signs`. Measured by ``benchmarks/learn_calibration.py`` on
        camel, dog, fly, horse and mouse from below with 1, 2, 3 and 5 clicked frames, 20 runs. Of
        the 28 runs of all seven clips, each by weights of the others of these five: the mean
        log-likelihood of right and wrong is -0.270 and the area under the ROC curve 0.913; without
        ``name_share`` -0.273 and 0.912, without ``other_look`` -0.292 and 0.900, without both
        -0.293 and 0.900.
    offset : float
        Log-odds without any sign. 0.4 below what was measured with the weights, as good that is
        said in vain costs more than a look.
    view_surest : float
        Guard: no view is surer than this, or less sure than the rest of it, when calibrated views
        are put together. Set by hand.
    click_sd, astray_sd : float
        Standard deviations of labels that are right, and of those that are astray, in extents. Set
        by hand.
    left_out_sd : float
        Standard deviation, in log-odds, of recordings about none and of points about their
        recording. Measured: with 0.5, 1 and 2 the area under the ROC curve is 0.885, 0.884 and
        0.881 on clips that weights were not learnt from.
    agreement_least : float
        Agreement below this breaks a way no more. Set by hand.
    agreement_break : float
        Agreement below this ends a stretch over which motion is averaged. Set by hand.
    broken_most : float
        No way is broken more than this. Set by hand.
    likeness_reach : float
        Half the side of what is compared with clicks, in body sizes: a paw and little of what is
        about it. Measured: 0.05 and 0.1 tell right from wrong labels as well.
    likeness_side : int
        Pixels along it after it was scaled: no more can be expected to look alike again. Set by
        hand.
    likeness_spare : int
        Pixels by which a label may be off: half of what counts as right. Set by hand.
    likeness_finest : float
        Px of a view in one of these, at least. Set by hand.
    likeness_frames : int
        Frames in which labels are compared. Mathematics: a share is known to 8 % from so many.
    stayed_px : float
        A label that moved less, px, was not moved. Set by hand.
    sure : float
        Looks lower a label that is sure to this by all else as odds do. Measured: the likeliest
        value for labels of nine films of three scenes by another renderer; where pictures look
        least like the clicks up to four fifths of them are wrong in grey, and none in colour.
    alike, alike_against : float
        A likeness s adds ``alike_against + alike * s`` to the log-odds of being right. Measured:
        fitted to labels of two trackers in four real clips with marks (mouse in a wheel, mouse from
        below, horse, fly).
    alone : float
        Looks alone make no label surer than this: a point may ride on what looks alike, such as the
        other hind paw. Measured: of 165 labels in seven real clips that look best, 0.8 and more, 70
        % are right.
    usual_share, usual_weight : float
        Share of labels that were right there, and how much it counts beside a point's own labels,
        which follow each other and tell less than so many by themselves. The share was measured
        there; the weight set by hand.
    beyond_fall : tuple of float
        Beyond the body: at so many times the limit this is left of the probability. Set by hand.
    leap_fall : tuple of float
        The same of leaps. Set by hand.
    disagree_fall : tuple of float
        The same of views that disagree, in what counts as right. Set by hand.
    unsure_weights : tuple of float
        Log-odds of being right: without any sign, for the logarithm of body sizes a standard
        deviation, and for each of these by which passes forwards and backwards are apart. Measured:
        fitted to 28,902 labels seen in two views or more, of nine films of three scenes by another
        renderer and 15 rendered films (colour, grey, H.264), (-4.15, 1.92, -2.14): the area under
        the ROC curve is 0.90; before, of four of the nine films, 0.61 to 0.73. So a real clip of
        which 95 % of marks are right (mouse in a wheel, two views) would not have been good; these
        are kinder by as much as it takes, chosen on it and on the films. Of labels whose deviation
        is 0.02 body sizes with passes 1.5 apart half were right on the films, not 0.9.
    hardly_fall : tuple of float
        The same of one less the confidence. Set by hand.
    shared_left : float
        Mathematics: of two names on one place at most one is right.
    shared_clicked : float
        Share of the distance of clicks beyond which two points are on two places. Set by hand.
    usual_most : float
        Share of a point's steps from frame to frame that are no longer than its usual longest one;
        a track departs from a click where it jumps by more and by twice what counts as right.
        Set by hand, on a walking man filmed by four cameras; in 15 rendered films in colour, grey
        and H.264 no verdict changed.
    departs : float
        Shorter jumps, in leaps, are none: what animals were measured to move in one frame
        (``leap`` is twice that).
    departed_left : float
        What is left of labels of a track that departed from a click. Set by hand.
    telling : float
        A measure that takes less than this share of a point's labels is not named. Set by hand.
    telling_left : float
        Labels of which less is left are counted where it is named. Set by hand.
    most_reasons : int
        Reasons that are named, at most. Set by hand.
    hardly_any : float
        Ends of a recording in which more labels than this are expected to be right are not proposed
        to be left out. Measured: 0.10 to 0.21 where a horse is not in view yet or no more, 0.27 and
        0.34 where a fly and a woman are lost though they are in view.
    fewest_frames : int
        Fewer frames are not proposed to be used: they hold hardly a stride. Set by hand.
    doubted_found : float
        A click that was left out is missed where less of the probability is within half a paw.
        Set by hand.
    doubted_sure, doubted_off : float
        Such a click is doubted where the others lead so surely to another place, so many halves of
        a paw away. Measured: chosen on camel, horse, dog and mouse from above with three clicked
        frames, in one of which a point was clicked 0.5 or 1.2 body lengths away (then 0.86 and
        more, and 9 and more, in seven of eight), and on a fly (0.88 at 6.7 and 0.81 at 7.5, though
        its clicks are right). No click is doubted in these clips as they are, nor in four others
        that were not looked at before (two more flies, male, female).
    doubted_on_others : float
        Nor is one whose point may be on another point's click, with so much of the probability:
        legs that look alike are exchanged. Set by hand, on a camel of whose film two frames of
        three were left out (0.41); where a click was on the ground it was 0.01 at most.
    doubted_together : float
        So surely where two points are led to each other's click, or most points of a frame far from
        theirs. Measured: chosen on the same clips, with two names exchanged in one frame, or all
        clicks of a frame made in another: 0.65 and more in ten of twelve, and never two at once as
        they are.
    time_gap : float
        Steps in time longer than so many usual ones are gaps; time stamps are rounded. Set by hand.
    """

    weights: tuple[float, ...] = (0.99, 0.7, 0.47, -0.27, 1.17, 0.33, 0.99)
    offset: float = 1.89
    view_surest: float = 0.999
    click_sd: float = 0.014
    astray_sd: float = 0.4
    left_out_sd: float = 0.5
    agreement_least: float = 1e-2
    agreement_break: float = 0.5
    broken_most: float = 200.0
    likeness_reach: float = 0.07
    likeness_side: int = 21
    likeness_spare: int = 3
    likeness_finest: float = 0.25
    likeness_frames: int = 40
    stayed_px: float = 1.0
    sure: float = 0.98
    alike: float = 3.9
    alike_against: float = -1.95
    alone: float = 0.75
    usual_share: float = 0.3
    usual_weight: float = 0.5
    beyond_fall: tuple[float, float] = (1.4, 0.1)
    leap_fall: tuple[float, float] = (1.4, 0.3)
    disagree_fall: tuple[float, float] = (3.0, 0.1)
    unsure_weights: tuple[float, float, float] = (-3.3, 2.0, -1.5)
    hardly_fall: tuple[float, float, float] = (0.7, 1.0, 0.5)
    shared_left: float = 0.5
    shared_clicked: float = 0.5
    usual_most: float = 0.9
    departs: float = 0.5
    departed_left: float = 0.1
    telling: float = 0.04
    telling_left: float = 0.75
    most_reasons: int = 3
    hardly_any: float = 0.25
    fewest_frames: int = 20
    doubted_found: float = 0.05
    doubted_sure: float = 0.85
    doubted_off: float = 8.0
    doubted_on_others: float = 0.2
    doubted_together: float = 0.5
    time_gap: float = 1.5


QUALITY = in_force("quality", QualityParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
LIMITS = in_force("quality_limits", QualityLimits())
"""The same."""
