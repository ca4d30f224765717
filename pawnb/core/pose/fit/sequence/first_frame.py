"""The first fit: from a pose that a person put roughly on the animal to its exact pose and look."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.candidates.candidate_kernels import paint_base
from pawnb.core.pose.fit.candidates.candidate_sets import LegCandidates, only_choice
from pawnb.core.pose.fit.candidates.leg_candidates import (
    add_candidates,
    fit_leg,
    limb_candidates,
    part_about,
    side_energy,
    sides_of,
)
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.layout import Layout, leg_numbers
from pawnb.core.pose.fit.learning.anatomy import about
from pawnb.core.pose.fit.learning.appearance import learn_appearance
from pawnb.core.pose.fit.parallel import on_threads
from pawnb.core.pose.fit.rendering.blur import blurred
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior
from pawnb.core.pose.fit.rendering.paint_kernels import NOTHING, leg_chain
from pawnb.core.pose.fit.sequence.parameters import SEQUENCE
from pawnb.core.pose.fit.support import body_support
from pawnb.core.video.views import Frame

_XY = 2
"""Parameters of a pose that say where it is; the heading comes next."""


def partners(animal: StickAnimal) -> IntArray:
    """Return, for each leg, the leg of the other side that looks alike, or itself."""
    mirrored = animal.mirrored_names()
    names = animal.leg_names
    out = []
    for i, leg in enumerate(animal.legs):
        j = names.index(mirrored.get(leg.name, leg.name))
        alike = len(animal.legs[j].segments) == len(leg.segments)
        out.append(j if alike else i)
    return np.array(out)


def start_prior(fitter: FrameFitter, pose: FloatArray) -> Prior:
    """Return anatomy and what the person's pose says."""
    sd = np.full(fitter.n, np.inf)
    sd[:2] = SEQUENCE.start_sd_px
    sd[2] = np.radians(SEQUENCE.start_sd_deg)
    sd[fitter.angles] = np.radians(SEQUENCE.start_sd_deg)
    known = about(fitter.anatomy, pose, sd)
    high, precision = known.high.copy(), known.precision.copy()
    high[fitter.lengths] = np.log(SEQUENCE.first_frame_longer)
    precision[fitter.lengths] = 1.0 / SEQUENCE.longer_sd**2
    return known._replace(high=high, precision=precision)


def fit_start(
    fitter: FrameFitter, frame: Frame, pose: FloatArray, *, rounds: int = 3
) -> tuple[FloatArray, float]:
    """Fit the start frame; the fitter's layout learns the animal's look.

    Parameters
    ----------
    fitter : FrameFitter
        Its layout is replaced.
    frame : Frame
        The start frame.
    pose : ndarray, shape (n_parameters,)
        The person's pose, working pixels.
    rounds : int
        How often pose and look are fitted in turn.

    Returns
    -------
    pose : ndarray
        The fitted pose.
    support : float
        How dark the body's place is relative to what is expected, 0 to 1.
    """
    fitter.layout = first_darkness(fitter, frame, pose)
    fitter.first = fitter.layout
    partner = partners(fitter.animal)
    settings = fitter.settings
    prior = start_prior(fitter, pose)
    pose = _fit_body(fitter, frame, pose, prior)
    for turn in range(rounds):
        image_evidence, image, box = fitter.look(frame, pose)
        for blur in (
            SEQUENCE.first_frame_coarse_blurs
            if turn == 0
            else SEQUENCE.first_frame_coarse_blurs[1:]
        ):
            soft = blurred(image_evidence, blur)
            pose, _ = fitter.fit(pose, soft, prior, blur=fitter.blur + blur, rounds=8)
        if settings.choose_path:
            pose = _choose(fitter, frame.index, pose, image_evidence, (image, box), prior)
        pose, _ = fitter.fit(pose, image_evidence, prior, rounds=20)
        pose = _slid_along(fitter, pose, image_evidence, prior)
        fitter.layout = learn_appearance(
            fitter.layout,
            [(pose, image_evidence)],
            first=fitter.first,
            partner=partner,
            prior=prior,
            blur=fitter.blur,
            soft=settings.soft_error,
        )
    image_evidence, _, _ = fitter.look(frame, pose)
    pose = _learn_blur(fitter, pose, image_evidence, prior, partner=partner)
    pose = _slid_along(fitter, pose, image_evidence, prior)
    high = fitter.anatomy.high.copy()
    longest = pose[fitter.lengths] + np.log(SEQUENCE.later_longer)
    high[fitter.lengths] = np.maximum(high[fitter.lengths], longest)
    fitter.anatomy = fitter.anatomy._replace(high=high)
    return pose, body_support(fitter, pose, image_evidence)


def _learn_blur(
    fitter: FrameFitter,
    pose: FloatArray,
    image_evidence: ImageEvidence,
    prior: Prior,
    *,
    partner: IntArray,
) -> FloatArray:
    """Make the fitter's blur, and with it its layout, those that explain the start frame best.

    Too wide a blur paints a halo about a thin leg that costs nearly as much as the leg explains:
    its pale end is given up. The pose fitted with it would then speak for it, so every blur has a
    pose of its own, and all narrower ones are tried. Returned is the best one's.
    """

    def tried(blur: float, pose: FloatArray, layout: Layout) -> tuple[float, FloatArray, Layout]:
        for _ in range(SEQUENCE.blur_turns):
            layout = learn_appearance(
                layout, [(pose, image_evidence)], first=fitter.first, partner=partner, prior=prior,
                blur=blur, soft=fitter.settings.soft_error,
            )  # fmt: skip
            fitter.layout = layout
            pose, cost = fitter.fit(pose, image_evidence, prior, blur=blur, rounds=8)
        return cost, pose, layout

    best, blur = tried(fitter.blur, pose, fitter.layout), fitter.blur
    for factor in (SEQUENCE.blur_step, 1.0 / SEQUENCE.blur_step):
        first, trial = blur, blur * factor
        while SEQUENCE.first_frame_blurs[0] <= trial <= SEQUENCE.first_frame_blurs[1]:
            other = tried(trial, *best[1:])
            if other[0] < best[0]:
                best, blur = other, trial
            elif factor > 1.0:
                break
            trial *= factor
        if blur != first:
            break
    fitter.blur, fitter.layout = blur, best[2]
    return best[1]


def first_darkness(fitter: FrameFitter, frame: Frame, pose: FloatArray) -> Layout:
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
    Layout
        The fitter's, darker or lighter.
    """
    image_evidence, _, _ = fitter.look(frame, pose, margin=np.inf)
    canvas = fitter.canvas(image_evidence)
    paint_base(fitter.layout, pose, fitter.blur, image_evidence, canvas[0], canvas[1])
    inside = image_evidence.seen[canvas[1] != NOTHING]
    if not inside.size:
        return fitter.layout
    dark = float(np.clip(np.percentile(inside, 70), *SEQUENCE.dark_limits))
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
    image_evidence, _, _ = fitter.look(frame, pose, margin=np.inf)
    ellipse = fitter.layout.ellipse
    front, rear = ellipse[:, 0] + ellipse[:, 2], ellipse[:, 0] - ellipse[:, 2]
    half = float(front.max() - rear.min()) / 2.0
    for blur in SEQUENCE.body_blurs:
        if blur > max(half, SEQUENCE.body_blurs[-1]):
            continue
        soft = blurred(image_evidence, blur)
        pose, _ = fitter.fit(
            pose, soft, prior, active=np.arange(_XY), shown=shown, blur=fitter.blur + blur,
            rounds=8,
        )  # fmt: skip
    return pose


def _slid_along(
    fitter: FrameFitter, pose: FloatArray, image_evidence: ImageEvidence, prior: Prior
) -> FloatArray:
    """Return the pose fitted, after each leg was slid out- and inwards along its own limb.

    The end of a leg that stops short, on a limb that goes on in a bend, feels nothing of what lies
    ahead of it.
    """
    pose, _ = fitter.fit(pose, image_evidence, prior, rounds=20)

    def best_of_side(own: FrameFitter, side: int) -> FloatArray:
        best = pose.copy()
        for leg in sides[side]:
            best[own.numbers[leg]] = _best_slide(own, best, leg, image_evidence, prior)
        return best

    sides = sides_of(fitter.layout.side)
    found = on_threads(fitter, range(len(sides)), best_of_side)
    slid = pose.copy()
    for legs, best in zip(sides, found, strict=True):
        for leg in legs:
            slid[fitter.numbers[leg]] = best[fitter.numbers[leg]]
    return fitter.fit(slid, image_evidence, prior, rounds=8)[0]


def _best_slide(
    fitter: FrameFitter, pose: FloatArray, leg: int, image_evidence: ImageEvidence, prior: Prior
) -> FloatArray:
    """Return a leg's part of the pose vector, slid to where it explains most, if that is more."""
    numbers = fitter.numbers[leg]
    tried = [pose[numbers]]
    tried += [
        slid_leg(fitter.layout, pose, leg, factor=factor) for factor in SEQUENCE.first_frame_slides
    ]
    part = part_about(fitter, image_evidence, pose, leg=leg, guesses=tried)
    best, least = tried[0], np.inf
    for guess in tried:
        trial = pose.copy()
        trial[numbers] = guess
        trial, cost = fitter.fit(trial, part, prior, active=numbers, rounds=8)
        if cost < least - SEQUENCE.first_frame_better:
            best, least = trial[numbers], cost
    return best


def slid_leg(layout: Layout, pose: FloatArray, leg: int, *, factor: float) -> FloatArray:
    """Return a leg's part of the pose vector where it is longer, along the way that it takes now.

    Parameters
    ----------
    layout, pose : Layout, ndarray
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
    choices: LegCandidates = only_choice(fitter, frame, pose, image=crop[0], box=crop[1])

    def places(own: FrameFitter, leg: int) -> list[np.ndarray]:
        numbers = own.numbers[leg]
        found = limb_candidates(own, pose, leg, image_evidence=image_evidence, prior=prior)
        n = len(numbers) // 2
        for shorter in SEQUENCE.first_frame_shorter:
            guess = prior.middle[numbers].copy()
            guess[n:] += shorter
            found.append(
                fit_leg(
                    own,
                    pose,
                    leg,
                    guess=guess,
                    image_evidence=image_evidence,
                    prior=prior,
                    rounds=8,
                )
            )
        return found

    extra = dict(enumerate(on_threads(fitter, range(len(fitter.numbers)), places)))
    add_candidates(fitter, choices, extra, image_evidence=image_evidence, prior=prior)
    if not choices.is_open:
        return pose
    best, which = pose.copy(), dict.fromkeys(range(len(fitter.numbers)), 0)
    for legs in sides_of(fitter.layout.side):
        others = {leg: k for leg, k in which.items() if leg not in legs}
        energy = side_energy(choices, legs, fitter.settings.evidence_share, others=others)
        state = np.unravel_index(int(np.argmin(energy)), energy.shape)
        which.update(zip(legs, map(int, state), strict=True))
    for leg, k in which.items():
        best[fitter.numbers[leg]] = choices.legs[leg][k]
    return best
