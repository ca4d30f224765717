"""The first fit: from a pose that a person put roughly on the animal to pose and appearance."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.candidates.candidate_kernels import paint_base
from pawnb.core.pose.fit.candidates.candidate_sets import only_candidate
from pawnb.core.pose.fit.candidates.leg_candidates import (
    fit_leg,
    limb_candidates,
    part_about,
    with_candidates,
)
from pawnb.core.pose.fit.candidates.weighing import side_energy
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.layout import PoseLayout, leg_numbers
from pawnb.core.pose.fit.learning.anatomy import about
from pawnb.core.pose.fit.learning.appearance import fit_appearance
from pawnb.core.pose.fit.observation import observe
from pawnb.core.pose.fit.rendering.blur import blurred
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior
from pawnb.core.pose.fit.rendering.paint_kernels import NOTHING, leg_chain
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.support import body_support
from pawnb.core.video.views import Frame

_XY = 2
"""Layout: parameters of a pose that say where it is; the heading comes next."""


def start_prior(fitter: FrameFitter, pose: FloatArray) -> Prior:
    """Return anatomy and what the person's pose says."""
    sd = np.full(fitter.index.n, np.inf)
    sd[:2] = SEQUENCE.start_sd_px
    sd[2] = np.radians(SEQUENCE.start_sd_deg)
    sd[fitter.index.angles] = np.radians(SEQUENCE.start_sd_deg)
    known = about(fitter.anatomy, pose, sd)
    high, precision = known.high.copy(), known.precision.copy()
    high[fitter.index.lengths] = np.log(SEQUENCE.first_frame_longer)
    precision[fitter.index.lengths] = 1.0 / SEQUENCE.longer_sd**2
    return known._replace(high=high, precision=precision)


def fit_start(
    fitter: FrameFitter, frame: Frame, pose: FloatArray, *, rounds: int | None = None
) -> tuple[FrameFitter, FloatArray, float]:
    """Fit the start frame, and learn the animal's appearance from it.

    Parameters
    ----------
    fitter : FrameFitter
        Of which nothing was learnt yet.
    frame : Frame
        The start frame.
    pose : ndarray, shape (n_parameters,)
        The person's pose, working pixels.
    rounds : int, optional
        How often pose and appearance are fitted in turn.

    Returns
    -------
    fitter : FrameFitter
        With the animal's appearance, the blur, and limits wide enough for its legs.
    pose : ndarray
        The fitted pose.
    support : float
        How dark the body's place is relative to what is expected, 0 to 1.
    """
    fitter = fitter.with_initial_appearance(first_darkness(fitter, frame, pose))
    prior = start_prior(fitter, pose)
    pose = _fit_body(fitter, frame, pose, prior)
    for turn in range(SEQUENCE.start_rounds if rounds is None else rounds):
        image_evidence, image, box = observe(fitter, frame, pose)
        for blur in SEQUENCE.first_frame_coarse_blurs[0 if turn == 0 else 1 :]:
            soft = blurred(image_evidence, blur)
            pose, _ = fitter.fit(
                pose, soft, prior, blur=fitter.blur + blur, rounds=SEQUENCE.rounds_blurred
            )
        if fitter.settings.choose_path:
            pose = _choose(fitter, frame.index, pose, image_evidence, (image, box), prior)
        pose, _ = fitter.fit(pose, image_evidence, prior, rounds=SEQUENCE.rounds_whole)
        pose = _slid_along(fitter, pose, image_evidence, prior)
        fitter = fit_appearance(fitter, [(pose, image_evidence)], prior=prior)
    image_evidence, _, _ = observe(fitter, frame, pose)
    fitter, pose = _learn_blur(fitter, pose, image_evidence, prior)
    pose = _slid_along(fitter, pose, image_evidence, prior)
    return _long_enough(fitter, pose), pose, body_support(fitter, pose, image_evidence)


def _long_enough(fitter: FrameFitter, pose: FloatArray) -> FrameFitter:
    """Return a fitter by whose anatomy legs may be a little longer than in a pose."""
    lengths, high = fitter.index.lengths, fitter.anatomy.high.copy()
    longest = pose[lengths] + np.log(SEQUENCE.later_longer)
    high[lengths] = np.maximum(high[lengths], longest)
    return fitter.with_prior(fitter.anatomy._replace(high=high))


def _learn_blur(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, prior: Prior
) -> tuple[FrameFitter, FloatArray]:
    """Return a fitter whose blur and appearance explain the start frame best, and the pose.

    Too wide a blur paints a halo about a thin leg that costs nearly as much as the leg explains:
    its pale end is given up. The pose fitted with it would then speak for it, so every blur has a
    pose of its own, and all narrower ones are tried. Returned is the best one's.
    """

    def tried(
        blur: float, fitter: FrameFitter, pose: FloatArray
    ) -> tuple[float, FrameFitter, FloatArray]:
        for _ in range(SEQUENCE.blur_turns):
            fitter = fit_appearance(fitter, [(pose, image_evidence)], prior=prior, blur=blur)
            pose, cost = fitter.fit(pose, image_evidence, prior, rounds=SEQUENCE.rounds_blurred)
        return cost, fitter, pose

    best = tried(fitter.blur, fitter, pose)
    for factor in (SEQUENCE.blur_step, 1.0 / SEQUENCE.blur_step):
        first = best[1].blur
        trial = first * factor
        while SEQUENCE.first_frame_blurs[0] <= trial <= SEQUENCE.first_frame_blurs[1]:
            other = tried(trial, *best[1:])
            if other[0] < best[0]:
                best = other
            elif factor > 1.0:
                break
            trial *= factor
        if best[1].blur != first:
            break
    return best[1], best[2]


def first_darkness(fitter: FrameFitter, frame: Frame, pose: FloatArray) -> PoseLayout:
    """Return the layout as dark as the place that the person gave the body.

    Parameters
    ----------
    fitter : FrameFitter
        Not changed.
    frame : Frame
        The start frame.
    pose : ndarray, shape (n_parameters,)
        The person's pose, working pixels.

    Returns
    -------
    PoseLayout
        The fitter's, darker or lighter.
    """
    image_evidence, _, _ = observe(fitter, frame, pose, margin=np.inf)
    canvas = fitter.canvas(image_evidence)
    paint_base(fitter.layout, pose, fitter.blur, image_evidence, canvas[0], canvas[1])
    inside = image_evidence.seen[canvas[1] != NOTHING]
    if not inside.size:
        return fitter.layout
    dark = float(np.clip(np.percentile(inside, SEQUENCE.dark_percentile), *SEQUENCE.dark_limits))
    layout = fitter.layout
    factor = dark / float(layout.dark.max())
    ellipse = layout.ellipse.copy()
    ellipse[:, [4, 6]] *= factor
    return layout._replace(dark=layout.dark * factor, ellipse=ellipse)


def _fit_body(fitter: FrameFitter, frame: Frame, pose: FloatArray, prior: Prior) -> FloatArray:
    """Return the pose with its body moved onto the picture, coarse to fine.

    Never coarser than it is large, and without turning it: a small body that is shown without
    its legs would be drawn and turned onto what is seen of them.
    """
    shown = np.zeros(len(fitter.animal.legs) + 1, bool)
    shown[-1] = True
    image_evidence, _, _ = observe(fitter, frame, pose, margin=np.inf)
    ellipse = fitter.layout.ellipse
    front, rear = ellipse[:, 0] + ellipse[:, 2], ellipse[:, 0] - ellipse[:, 2]
    half = float(front.max() - rear.min()) / 2.0
    for blur in SEQUENCE.body_blurs:
        if blur > max(half, SEQUENCE.body_blurs[-1]):
            continue
        soft = blurred(image_evidence, blur)
        pose, _ = fitter.fit(
            pose, soft, prior, active=np.arange(_XY), shown=shown, blur=fitter.blur + blur,
            rounds=SEQUENCE.rounds_blurred,
        )  # fmt: skip
    return pose


def _slid_along(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, prior: Prior
) -> FloatArray:
    """Return the pose fitted, after each leg was slid out- and inwards along its own limb.

    The end of a leg that stops short, on a limb that goes on in a bend, feels nothing of what lies
    ahead of it.
    """
    pose, _ = fitter.fit(pose, image_evidence, prior, rounds=SEQUENCE.rounds_whole)

    numbers = fitter.index.numbers

    def best_of_side(legs: list[int]) -> FloatArray:
        best = pose.copy()
        for leg in legs:
            best[numbers[leg]] = _best_slide(fitter, best, leg, image_evidence, prior)
        return best

    sides = fitter.index.sides
    found = on_threads(best_of_side, sides)
    slid = pose.copy()
    for legs, best in zip(sides, found, strict=True):
        for leg in legs:
            slid[numbers[leg]] = best[numbers[leg]]
    return fitter.fit(slid, image_evidence, prior, rounds=SEQUENCE.rounds_blurred)[0]


def _best_slide(
    fitter: FrameFitter, pose: FloatArray, leg: int, image_evidence: ImageEvidence, prior: Prior
) -> FloatArray:
    """Return a leg's part of the pose vector, slid to where it explains most, if that is more."""
    numbers = fitter.index.numbers[leg]
    tried = [pose[numbers]]
    tried += [
        slid_leg(fitter.layout, pose, leg, factor=factor) for factor in SEQUENCE.first_frame_slides
    ]
    part = part_about(fitter, image_evidence, pose, leg=leg, guesses=tried)
    best, least = tried[0], np.inf
    for guess in tried:
        trial = pose.copy()
        trial[numbers] = guess
        trial, cost = fitter.fit(trial, part, prior, active=numbers, rounds=SEQUENCE.rounds_blurred)
        if cost < least - SEQUENCE.first_frame_better:
            best, least = trial[numbers], cost
    return best


def slid_leg(layout: PoseLayout, pose: FloatArray, leg: int, *, factor: float) -> FloatArray:
    """Return a leg's part of the pose vector where it is longer, along the way that it takes now.

    Parameters
    ----------
    layout, pose : PoseLayout, ndarray
        The animal and its pose.
    leg : int
        Which leg.
    factor : float
        How much longer; beyond its tip it goes straight on.

    Returns
    -------
    ndarray, shape (2 links,)
        Angles and foreshortening.
    """
    n = int(layout.n_segments[leg])
    joints = np.zeros((layout.radius.shape[1], 2))
    leg_chain(layout, pose, leg, joints)
    joints = joints[: n + 1]
    steps = np.hypot(*np.diff(joints, axis=0).T)
    far = np.concatenate([[0.0], np.cumsum(steps)])
    ahead = joints[-1] + (joints[-1] - joints[-2]) * far[-1] / max(steps[-1], 1e-6)
    path, at = np.vstack([joints, ahead]), np.append(far, 2.0 * far[-1])
    moved = np.column_stack([np.interp(factor * far, at, path[:, i]) for i in (0, 1)])
    return leg_numbers(layout, leg, moved, heading=float(pose[2]))


def _choose(
    fitter: FrameFitter,
    frame: int,
    pose: FloatArray,
    image_evidence: ImageEvidence,
    crop: tuple,
    prior: Prior,
) -> FloatArray:
    """Return the pose with each leg at the best of the places that the silhouette offers."""
    candidates = only_candidate(fitter, frame, pose, image=crop[0], box=crop[1])

    def places(leg: int) -> list[FloatArray]:
        numbers = fitter.index.numbers[leg]
        found = limb_candidates(fitter, pose, leg, image_evidence=image_evidence, prior=prior)
        n = len(numbers) // 2
        for shorter in SEQUENCE.first_frame_shorter:
            guess = prior.middle[numbers].copy()
            guess[n:] += shorter
            fitted = fit_leg(
                fitter, pose, leg, guess=guess, image_evidence=image_evidence, prior=prior,
                rounds=SEQUENCE.rounds_blurred,
            )  # fmt: skip
            found.append(fitted)
        return found

    extra = dict(enumerate(on_threads(places, range(len(fitter.index.numbers)))))
    candidates = with_candidates(
        fitter, candidates, extra, image_evidence=image_evidence, prior=prior
    )
    if not candidates.is_open:
        return pose
    best, which = pose.copy(), dict.fromkeys(range(len(fitter.index.numbers)), 0)
    for legs in fitter.index.sides:
        others = {leg: k for leg, k in which.items() if leg not in legs}
        energy = side_energy(candidates, legs, fitter.settings.evidence_share, others=others)
        state = np.unravel_index(int(np.argmin(energy)), energy.shape)
        which.update(zip(legs, map(int, state), strict=True))
    for leg, k in which.items():
        best[fitter.index.numbers[leg]] = candidates.legs[leg][k]
    return best
