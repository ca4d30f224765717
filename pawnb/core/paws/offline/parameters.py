"""Parameters of each stage. Lengths are in working pixels unless their name says otherwise.

Every view is scaled until the *extent*, the largest distance between two points clicked in one
frame, is :attr:`SceneParameters.extent` working pixels: no length here depends on the camera.
They were chosen on horse_walk, mouse_below_grey and mouse_wheel_two_views of the real clips and
reported on the other four (``benchmarks/real_clips.py``); the ones not said to be chosen
there are those of the first trial and were not tuned.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

from pawnb.core.parameters import in_force, values_in_force


@dataclass(frozen=True)
class SceneParameters:
    """How views become stacks of pictures in the body's frame.

    Parameters
    ----------
    extent : float
        Largest distance between points clicked in one frame, working px. Measured: mean over horse
        and wheel with 1 and 2 clicked frames: 71 % at 160, 76 at 240, 75 at 300.
    spacing : int
        Distance of the places that are distinguished, working px. Set by hand.
    margin : float
        What is looked at beside the clicks, in extents. Set by hand.
    overview_px : int
        Longer side of the small pictures from which the body's frame is found. Set by hand.
    better : float
        A body's frame that moves or turns must make pictures this much more alike (correlation)
        than one that stays. Measured: 0.09 to 0.9 apart where animals travel, below 0.07 where they
        do not.
    largest_enlargement : float
        Pictures are enlarged at most so much. Set by hand.
    """

    extent: float = 240.0
    spacing: int = 4
    margin: float = 0.75
    overview_px: int = 320
    better: float = 0.1
    largest_enlargement: float = 3.0


@dataclass(frozen=True)
class MotionParameters:
    """Optical flow from every click (Bouguet 2001) with a forward-backward check.

    Parameters
    ----------
    window : int
        Side of the window that is followed, working px. After Kalal et al. 2010, who use as much.
    levels : int
        Pyramid levels. Set by hand.
    kept : float
        Share of the trust that is kept from frame to frame. Set by hand.
    check_px : float
        Forward-backward distance at which trust falls to 1/e, working px. Set by hand.
    lowest : float
        Below this trust a point is followed no further. Set by hand.
    gain : float
        Ratio of likelihoods at the place where the flow is fully trusted. Set by hand.
    sd : float
        Standard deviation of a place, in places of the grid. Set by hand.
    """

    window: int = 25
    levels: int = 3
    kept: float = 0.98
    check_px: float = 3.0
    lowest: float = 0.02
    gain: float = 15.0
    sd: float = 1.3


@dataclass(frozen=True)
class CorrelationParameters:
    """Patches about the clicks that are found again.

    The best place is right in 26 of 65 (camel), 5 of 25 (horse) and 21 of 28 marks (dog) for which
    there is any, from one clicked frame: legs look alike. Hence the low gain, and
    :func:`.agreement.trust_by_agreement`. None of these was tuned.

    Parameters
    ----------
    patch_radii : float
        Half the side of a patch, in radii. After CSRT (Lukezic et al. 2017), which takes as much
        about a box of two paws.
    turns_deg : tuple of float
        Turns of a patch that are tried beside the body's own. Set by hand.
    reach : float
        How far from its clicks a point is looked for, in extents. Set by hand.
    peaks : int
        Places that are taken from each picture, at most. Set by hand.
    sure : float
        Share of the highest trust from which flow says where a point is. Set by hand.
    gain : float
        Highest ratio of likelihoods. Set by hand.
    sd : float
        Standard deviation of a place, in places of the grid. Set by hand.
    """

    patch_radii: float = 1.5
    turns_deg: tuple[float, ...] = (-15.0, 0.0, 15.0)
    reach: float = 0.5
    peaks: int = 3
    sure: float = 0.7
    gain: float = 6.0
    sd: float = 1.3


@dataclass(frozen=True)
class AppearanceParameters:
    """A classifier that is learnt in the recording itself.

    Parameters
    ----------
    radius : float
        What lies so near a click is the point's, working px: about half a paw. Set by hand.
    copies : int
        Times that each clicked picture is taken, turned, scaled and lit differently. Set by hand.
    background : int
        Places beside the points that are taken from each picture. Set by hand.
    hidden : int
        Units of the hidden layer. Set by hand.
    networks : int
        Networks whose probabilities are averaged. Set by hand.
    epochs : int
        Times that every sample is seen. Set by hand.
    copies_again, networks_again, epochs_again : int
        The same after a correction or a further click, where one trains on frames of the run before
        as well. Measured: with 25, 12, 8 and 5 epochs 137, 136, 136 and 136 of 165 marks of horse
        and camel were right (one frame clicked after one or two). With as many copies, networks and
        ``iterations`` as in a first run 404 of 495 were (three further frames, one after the
        other), with these 408; 175 and 173 of 227 of the dog, not looked at before.
    rounds : int
        Times that it is learnt: first from clicks, then also from frames in which appearance and
        the whole model agree. Set by hand.
    learnt_frames : int
        Frames that are added for the second round. Set by hand.
    sure : float
        Probability from which a point of such a frame is taken. Set by hand.
    trust : float
        Power of the likelihood ratio, where the recording itself does not say (one clicked frame):
        classifiers of few clicks are too sure. Measured: mean over the three clips 79 % at 0.5 and
        78 at 1.
    trusts : tuple of float
        Powers that are tried where two frames or more are clicked. Set by hand.
    folds : int
        Clicked frames that are left out in turn to choose one, at most. Set by hand.
    lowest, highest : float
        Bounds of the ratio of likelihoods. Set by hand.
    """

    radius: float = 10.0
    copies: int = 8
    background: int = 450
    hidden: int = 48
    networks: int = 3
    epochs: int = 25
    copies_again: int = 4
    networks_again: int = 1
    epochs_again: int = 8
    rounds: int = 2
    learnt_frames: int = 16
    sure: float = 0.9
    trust: float = 0.5
    trusts: tuple[float, ...] = (0.0, 0.5, 1.0)
    folds: int = 4
    lowest: float = 0.01
    highest: float = 30.0


@dataclass(frozen=True)
class AssociationParameters:
    """The hidden Markov model of each point, and what points say of each other.

    Parameters
    ----------
    lost : float
        Probability in each frame of being anywhere that the positional prior allows. Set by hand.
    near_sd, far_sd : float
        Standard deviations of what flow does not explain, in places of the grid. Set by hand.
    far : float
        Probability of the larger one. Set by hand.
    exclusive : float
        How far a place taken by one point is closed to others. Set by hand.
    iterations : int
        Iterations in which points (and views) exclude each other from places. Set by hand.
    iterations_again : int
        The same after a correction or a further click. Measured: see ``epochs_again``; alone, 402
        of 495 marks were right.
    anywhere : float
        Share of the positional prior that is even. Set by hand.
    """

    lost: float = 1e-3
    near_sd: float = 0.5
    far_sd: float = 2.5
    far: float = 0.2
    exclusive: float = 0.9
    iterations: int = 3
    iterations_again: int = 2
    anywhere: float = 0.25


@dataclass(frozen=True)
class IdentityParameters:
    """Names of tracklets, decided jointly over the whole recording.

    With this stage, correlation and a frame that follows, % of marks that are right went from 59
    to 69 and from 73 to 89 (camel, 1 and 2 clicked frames) and from 50 to 58 (horse, 1). Camel,
    dog and horse were looked at while it was built. A mark lay in a tracklet that was given to
    another point in 6 of 64 (camel, 2), 0 of 22 (horse, 2), 3 of 42 (dog, 1), 5 of 26 (horse, 1)
    and 19 of 68 marks (camel, 1). Two or three times ``hidden``, or half or twice ``alike``,
    change the first four by up to 2, the last by up to 15.

    Parameters
    ----------
    least : float
        How likely any point must be at a place that is a candidate. Set by hand.
    apart : float
        Candidates of one frame are so far from each other, in radii. Set by hand.
    coasting : int
        Rows for which flow carries a tracklet on that is not seen. Set by hand.
    alike : float
        Correlation of the errors of appearance within a tracklet: however long it is, it is worth
        at most the inverse of this in frames. Measured: see above.
    lost : float
        What it costs to leave or to enter a tracklet without any continuity (natural logarithm).
        Set by hand.
    hidden : float
        What each row costs in which a point is in no tracklet. Measured: see above.
    gain : float
        Ratio of likelihoods at the place that was decided on. Set by hand.
    closed : float
        How far that place is closed to others. Set by hand.
    samples : int
        Perturbed decisions that tell how sure names are. Measured: on 1862 marks of camel, dog and
        horse, clicked in 46 ways, the mean log-likelihood of right and wrong is -0.454 without
        them, -0.417 with 8, -0.408 with 16 and 32 (of each clip by weights of the others).
    """

    least: float = 0.15
    apart: float = 1.5
    coasting: int = 3
    alike: float = 0.5
    lost: float = 4.0
    hidden: float = 0.1
    gain: float = 20.0
    closed: float = 0.95
    samples: int = 16


@dataclass(frozen=True)
class RunParameters:
    """How evidence is weighed, windows are joined and earlier results are used again.

    Parameters
    ----------
    agreement_pseudo : float
        Rows in which nothing agreed, assumed before any is looked at. Set by hand.
    agree_radii : float
        Appearance and the whole model agree if both put the point within so many radii. Set by
        hand.
    weighing_chance : float
        A click that was wholly missed counts as if so much of the probability had been there. Set
        by hand.
    weighing_clear : float
        The usual powers are left only where others are so much likelier (e to the power of this):
        by more than two clicks, as one that was missed and is found counts 3.0. Measured: with 2.0
        powers would have changed in 2 of 12 runs on real clips, and did no good: appearance left
        out, fly, 5 clicked frames, 87 % as before; dog, 5, 82 % for 89.
    weighing_near : float
        An estimate within so many radii of a click that was left out counts as right. Measured:
        half a paw, as those who marked the real clips saw it, is 1.1 to 2.0 of them; 1, 1.3 and 2
        tell right labels from wrong as well.
    window_overlap : int
        Rows by which stretches that are tracked one after the other overlap. Set by hand.
    handed_on : int
        Rows of the overlap in which positions are handed on, evenly spread. Set by hand.
    handed_on_likely : float
        Positions that are less likely than this to be right are not handed on. Set by hand.
    colour_enough : float
        Tracks by colour are compared with tracks by strides where fewer labels than this share are
        expected to be right. Measured: films in H.264 in which strides were right more often had
        0.87 to 0.90 (and one of another renderer, 45 of 1000 wrong by colour and 17 by strides),
        the others 0.92 and more.
    colour_poor : float
        The same in short recordings. Set by hand.
    colour_long : int
        Shorter are those of fewer frames than these: they hold too little of a stride to tell one
        way from the other. Set by hand.
    colour_surer : float
        They give way where so many more labels are expected to be right. Measured: of six rendered
        films in H.264 (100 frames, seeds 31 to 33, crf 23 and 28; all looked at) strides had 0.046
        to 0.085 more in four, and 0, 3, 0 and 8 of 1000 visible labels wrong, for 8, 3, 4 and 5 by
        colour; in one they had 0.02 more and 4 wrong for none, and the sixth is good by colour, as
        are the scenes without H.264. Tracks that are not good themselves replace failed ones only:
        at 50 frames per second (seed 31) strides were thought surer and had 84 of 1000 wrong,
        colour 11; neither was good. What is learnt is compared with tracks of which one point
        failed by the same margin: chosen on a balancing man filmed by four cameras, two clicked
        frames, where strides had 41 % right (51 expected) and what is learnt 65 (76).
    shared_much : float
        Tracks in which two paws share a place in space in more than this share of frames take the
        place of such only that share one in more: in a scene of another renderer (colour, 125
        frames) such strides were thought surer and had 86 of 1000 wrong, colour none. Measured: of
        one in H.264 of crf 28 strides had a hind paw beside the front paw in 0.022 of the frames,
        rightly: 0.8 of 1000 wrong, colour 16; in the truth of three scenes that lasts up to 0.02.
    retracking_sure : float
        Other points are certain at both ends of what is tracked again from this confidence on. Set
        by hand.
    kept_inside : float
        Pictures are kept for further clicks that lie so far within them, in extents: about 1.5
        standard deviations of the prior. Set by hand.
    kept_extent : float
        The extent of the clicks may differ by this factor from that for which pictures were scaled,
        as animals stretch. Measured: camel_walk with one of six further frames in which the camel
        is up to 1.6 times shorter had 88 % of marks right with the pictures of the first click, and
        89 % with new ones.
    seen : float
        Probability from which a view has a say in where a point is in space. Set by hand.
    measured : float
        Probability from which a label counts as measured; others are only predicted. Measured: of
        six clips that weights were not learnt from (the wheel, tracked otherwise, left out), 76 %
        of wrong labels and 6 % of right ones are below 0.55, 78 and 7 % below 0.6, 81 and 8 % below
        this.
    shown : float
        Probability, of all views together, from which a view that does not see a point shows where
        the others have it. Measured: with 0.5, 0.65 and never 32, 35 and 36 % of marks of the fly
        are right from one clicked frame, and as many from more; a paw that one camera cannot see
        needs it.
    clicks_apart_px : float
        Other views hit a click up to there, at least. Measured: they do with clicks 2 px (SD) off.
    lost : float
        Probability below which a point is missing. Measured: of the real clips without the wheel 0
        of 1004 right marks have less, and 2 of 225 wrong ones; with 0.03 0 and 9, and up to 4 % of
        right marks of clips filmed again in the dark, small or at half the rate.
    least_sd_px : float
        Standard deviation, px, of an estimate in a view, at least, when views are joined. Set by
        hand.
    window_rows : int
        Rows that are tracked at once: they take 2 GB for four points in a view. Set by hand.
    """

    agreement_pseudo: float = 4.0
    agree_radii: float = 0.7
    weighing_chance: float = 0.05
    weighing_clear: float = 6.5
    weighing_near: float = 1.5
    window_overlap: int = 60
    handed_on: int = 3
    handed_on_likely: float = 0.5
    colour_enough: float = 0.91
    colour_poor: float = 0.82
    colour_long: int = 64
    colour_surer: float = 0.04
    shared_much: float = 0.05
    retracking_sure: float = 0.9
    kept_inside: float = 0.35
    kept_extent: float = 1.75
    seen: float = 0.5
    measured: float = 0.65
    shown: float = 0.65
    clicks_apart_px: float = 10.0
    lost: float = 0.02
    least_sd_px: float = 0.3
    window_rows: int = 1000


SCENE = in_force("scene", SceneParameters())
MOTION = in_force("motion", MotionParameters())
CORRELATION = in_force("correlation", CorrelationParameters())
APPEARANCE = in_force("appearance", AppearanceParameters())
ASSOCIATION = in_force("association", AssociationParameters())
IDENTITY = in_force("identity", IdentityParameters())
RUN = in_force("run", RunParameters())


@dataclass(frozen=True)
class OfflineParameters:
    """Parameters of all stages; without ``identity`` names are not decided jointly."""

    scene: SceneParameters = field(default_factory=SceneParameters)
    motion: MotionParameters = field(default_factory=MotionParameters)
    correlation: CorrelationParameters = field(default_factory=CorrelationParameters)
    appearance: AppearanceParameters = field(default_factory=AppearanceParameters)
    association: AssociationParameters = field(default_factory=AssociationParameters)
    identity: IdentityParameters | None = field(default_factory=IdentityParameters)

    def again(self) -> OfflineParameters:
        """Return those for what is tracked again, from what an earlier run has learnt."""
        learning, association = self.appearance, self.association
        return dataclasses.replace(
            self,
            appearance=dataclasses.replace(
                learning,
                rounds=1,
                epochs=learning.epochs_again,
                copies=learning.copies_again,
                networks=learning.networks_again,
            ),
            association=dataclasses.replace(association, iterations=association.iterations_again),
        )


def parameters_in_force() -> OfflineParameters:
    """Return the parameters of all stages that a run which was given none takes."""
    return OfflineParameters(
        scene=values_in_force(SCENE),
        motion=values_in_force(MOTION),
        correlation=values_in_force(CORRELATION),
        appearance=values_in_force(APPEARANCE),
        association=values_in_force(ASSOCIATION),
        identity=values_in_force(IDENTITY),
    )
