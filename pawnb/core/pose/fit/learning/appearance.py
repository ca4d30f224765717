"""How thick and how dark this animal is, learnt from frames whose pose is known."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.parallel import on_threads
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.learning.appearance_kernels import body_equations, look_equations
from pawnb.core.pose.fit.learning.body_equations import BodyEquations
from pawnb.core.pose.fit.learning.parameters import LEARNING
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import (
    ImageEvidence,
    Prior,
    normal_matrix,
    prior_cost,
)
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint, picture_cost


def learn_appearance(
    layout: PoseLayout,
    frames: Sequence[tuple[FloatArray, ImageEvidence]],
    *,
    first: PoseLayout,
    partner: IntArray,
    prior: Prior,
    blur: float,
    soft: float,
    rounds: int | None = None,
) -> PoseLayout:
    """Return the layout with thickness and darkness as the pictures have them.

    Parameters
    ----------
    layout : PoseLayout
        The animal as known so far.
    frames : sequence of (ndarray, ImageEvidence)
        Frames whose pose is known.
    first : PoseLayout
        The animal as the species file has it: where the pictures say little, thickness stays
        near its.
    partner : ndarray of int, shape (legs,)
        The leg of the other side that looks alike, or the leg itself.
    prior : Prior
        What is known of poses besides their pictures.
    blur, soft : float
        As in the fit.
    rounds : int, optional
        Gauss-Newton steps.

    Returns
    -------
    PoseLayout
        Lengths and places are unchanged, except the sizes of the body's parts.
    """
    known = _Known(first, partner, prior, blur, soft)
    here = list(frames)
    for _ in range(LEARNING.look_rounds if rounds is None else rounds):
        step = _step(layout, here, known)
        share = _helpful_share(layout, here, known, step)
        if share == 0.0:
            break
        layout, here = _taken(layout, here, step, share)
    return layout


def fit_appearance(
    fitter: FrameFitter,
    frames: Sequence[tuple[FloatArray, ImageEvidence]],
    *,
    prior: Prior,
    blur: float | None = None,
) -> FrameFitter:
    """Return the fitter with the animal's appearance as frames whose pose is known show it.

    Parameters
    ----------
    fitter : FrameFitter
        With the appearance as known so far.
    frames : sequence of (ndarray, ImageEvidence)
        Pose vectors, and what their frames show.
    prior : Prior
        What is known of poses besides their pictures.
    blur : float, optional
        Half width of the blur that is painted, working px; default that of the fitter.

    Returns
    -------
    FrameFitter
        With that blur.
    """
    blur = fitter.blur if blur is None else blur
    layout = learn_appearance(
        fitter.layout, frames, first=fitter.initial, partner=fitter.index.partner,
        prior=prior, blur=blur, soft=fitter.settings.soft_error,
    )  # fmt: skip
    return fitter.with_appearance(layout, blur=blur)


@dataclass(frozen=True)
class _Known:
    """What stays the same while an appearance is learnt; see :func:`learn_appearance`."""

    first: PoseLayout
    partner: IntArray
    prior: Prior
    blur: float
    soft: float


@dataclass(frozen=True)
class _Step:
    """A Gauss-Newton step: the appearance it leads to, and how the poses of frames move with it.

    Attributes
    ----------
    cost : float
        Of the appearance and poses before it.
    appearance : PoseLayout
        After the whole step.
    moves : list of ndarray, shape (n_parameters,)
        Of the pose of each frame.
    body : BodyEquations
        What they were solved by.
    """

    cost: float
    appearance: PoseLayout
    moves: list[FloatArray]
    body: BodyEquations


@dataclass(frozen=True)
class _OfFrame:
    """What one frame says: its cost, and the equations of legs, body and pose."""

    cost: float
    legs: tuple[FloatArray, FloatArray]
    body: tuple[FloatArray, FloatArray]
    pose: tuple[FloatArray, FloatArray]


def _step(
    layout: PoseLayout, frames: list[tuple[np.ndarray, ImageEvidence]], known: _Known
) -> _Step:
    """Return the step that the equations of all frames lead to."""
    body = BodyEquations(layout.ellipse, known.first.ellipse, len(frames))
    said = on_threads(lambda frame: _of_frame(layout, frame, known, body.meets), frames)
    for one in said:
        body.add(*one.body, of_pose=one.pose[0], slope=one.pose[1])
    matrix, vector = (np.sum([one.legs[i] for one in said], axis=0) for i in (0, 1))
    legs_learnt = learn_legs(
        layout, known.first, known.partner, equations=(matrix, vector), n_frames=len(frames)
    )
    cost = sum(one.cost for one in said) + _appearance_cost(layout, known, body, len(frames))
    ellipse, moves = body.solve()
    return _Step(cost, legs_learnt._replace(ellipse=ellipse), moves, body)


def _of_frame(
    layout: PoseLayout, frame: tuple[FloatArray, ImageEvidence], known: _Known, meets: FloatArray
) -> _OfFrame:
    """Return what one frame says near its pose; ``meets`` as in :class:`.BodyEquations`."""
    pose, image_evidence = frame
    blur, soft = known.blur, known.soft
    canvas, cost = _painted(layout, pose, image_evidence, known)
    value, owner, along, joints = canvas
    seen, weight, box = image_evidence.seen, image_evidence.weight, image_evidence.box
    legs, nodes = layout.radius.shape
    matrix, vector = np.zeros((legs, 2 * nodes, 2 * nodes)), np.zeros((legs, 2 * nodes))
    look_equations(
        layout, blur, box, value, owner, along, joints, seen, weight, soft, matrix, vector
    )
    parts, sums = np.zeros((len(meets), 9, 9)), np.zeros((len(meets), 9))
    body_equations(layout, meets, pose, blur, box, value, owner, seen, weight, soft, parts, sums)
    of_pose = _pose_equations(layout, frame, known, canvas)
    return _OfFrame(cost, (matrix, vector), (parts, sums), of_pose)


def _pose_equations(
    layout: PoseLayout,
    frame: tuple[FloatArray, ImageEvidence],
    known: _Known,
    canvas: tuple[np.ndarray, ...],
) -> tuple[FloatArray, FloatArray]:
    """Return the matrix and the gradient of a frame's pose, which is painted on the canvas."""
    pose, image_evidence = frame
    value, owner, along, joints = canvas
    n, shown = len(pose), np.ones(len(layout.radius) + 1, bool)
    matrix, slope = np.zeros((n, n)), np.zeros(n)
    normal_matrix(
        layout, pose, image_evidence, known.prior, np.arange(n), shown, known.blur, known.soft,
        value, owner, along, joints, matrix, slope,
    )  # fmt: skip
    return matrix + np.tril(matrix, -1).T, slope  # the loops fill the lower triangle


def _painted(
    layout: PoseLayout, pose: FloatArray, image_evidence: ImageEvidence, known: _Known
) -> tuple[tuple[np.ndarray, ...], float]:
    """Return the painted canvas of a frame, and what picture and pose cost."""
    canvas = make_canvas(len(image_evidence.seen), image_evidence.seen.shape[1], layout)
    paint(layout, pose, known.blur, image_evidence.box, *canvas)
    cost = picture_cost(
        canvas[0], canvas[1], image_evidence.seen, image_evidence.weight, known.soft
    )
    return canvas, cost + prior_cost(pose, known.prior, np.arange(len(pose)))


def _appearance_cost(
    layout: PoseLayout, known: _Known, body: BodyEquations, n_frames: int
) -> float:
    """Return what an appearance costs by itself."""
    return _prior_cost(layout, known.first, n_frames) + body.prior_cost(layout.ellipse)


def _taken(
    layout: PoseLayout, frames: list[tuple[np.ndarray, ImageEvidence]], step: _Step, share: float
) -> tuple[PoseLayout, list[tuple[np.ndarray, ImageEvidence]]]:
    """Return appearance and frames after a share of a step."""

    def between(now: FloatArray, then: FloatArray) -> FloatArray:
        return now + share * (then - now)

    radius = layout.radius.copy()
    thick = radius > 0.0  # legs with few segments are padded
    radius[thick] = np.exp(between(np.log(radius[thick]), np.log(step.appearance.radius[thick])))
    appearance = layout._replace(
        radius=radius,
        dark=between(layout.dark, step.appearance.dark),
        ellipse=between(layout.ellipse, step.appearance.ellipse),
    )
    moves = zip(frames, step.moves, strict=True)
    return appearance, [
        (pose + share * move, image_evidence) for (pose, image_evidence), move in moves
    ]


def _helpful_share(
    layout: PoseLayout, frames: list[tuple[np.ndarray, ImageEvidence]], known: _Known, step: _Step
) -> float:
    """Return the largest share of a step, halved again and again, that makes the cost fall; or 0.

    A whole step goes too far where the animal is not as it is painted (a banded leg, a body paler
    at one end), for errors that count less at their size now may count in full after it.
    """

    def cost(share: float) -> float:
        appearance, here = _taken(layout, frames, step, share)
        parts = on_threads(lambda frame: _painted(appearance, *frame, known)[1], here)
        return sum(parts) + _appearance_cost(appearance, known, step.body, len(frames))

    return next((share for share in LEARNING.appearance_shares if cost(share) < step.cost), 0.0)


def learn_legs(
    layout: PoseLayout,
    first: PoseLayout,
    partner: IntArray,
    *,
    equations: tuple[FloatArray, FloatArray],
    n_frames: int,
) -> PoseLayout:
    """Return the layout with legs as thick and dark as one step of the equations has them.

    Parameters
    ----------
    layout, first, partner
        As in :func:`learn_appearance`.
    equations : tuple of ndarray
        Matrix and vector that ``look_equations`` filled; changed.
    n_frames : int
        How many frames they are of.

    Returns
    -------
    PoseLayout
        The body is unchanged.
    """
    matrix, vector = equations
    legs, nodes = layout.radius.shape
    radius, dark = layout.radius.copy(), layout.dark.copy()
    both = np.arange(legs) != partner
    matrix[both] += matrix[partner[both]]
    vector[both] += vector[partner[both]]
    for leg in range(legs):
        n = int(layout.n_segments[leg]) + 1
        keep = np.concatenate([np.arange(n), nodes + np.arange(n)])
        share = n_frames * (2.0 if both[leg] else 1.0)
        now = np.concatenate([np.log(radius[leg, :n]), dark[leg, :n]])
        goal = np.concatenate([np.log(first.radius[leg, :n]), first.dark[leg, :n]])
        stiff = share * _appearance_prior(n)
        left = matrix[leg][np.ix_(keep, keep)] + stiff
        move = np.linalg.solve(left, -(vector[leg, keep] + stiff @ (now - goal)))
        now += np.clip(move, -LEARNING.most_change, LEARNING.most_change)
        most = np.maximum(LEARNING.most_radius * first.radius[leg, :n], LEARNING.least_radius_px)
        radius[leg, :n] = np.clip(np.exp(now[:n]), LEARNING.least_radius_px, most)
        least = max(LEARNING.least_dark, LEARNING.least_of_darkest * float(now[n:].max()))
        dark[leg, :n] = np.clip(now[n:], least, LEARNING.most_dark)
    return layout._replace(radius=radius, dark=dark)


def _prior_cost(layout: PoseLayout, first: PoseLayout, n_frames: int) -> float:
    """Return what the legs' thickness and darkness cost by themselves."""
    total = 0.0
    for leg, n_segments in enumerate(layout.n_segments):
        n = int(n_segments) + 1
        thicker = np.log(layout.radius[leg, :n] / first.radius[leg, :n])
        away = np.concatenate([thicker, layout.dark[leg, :n] - first.dark[leg, :n]])
        total += 0.5 * n_frames * float(away @ _appearance_prior(n) @ away)
    return total


@functools.cache
def _appearance_prior(n: int) -> FloatArray:
    """Return the precision of a leg's logarithmic radii and darknesses, shape (2n, 2n)."""
    out = np.zeros((2 * n, 2 * n))
    change = np.diff(np.eye(n), axis=0)
    smooth = change.T @ change
    out[:n, :n] = np.eye(n) / LEARNING.radius_sd**2 + smooth / LEARNING.radius_step_sd**2
    out[n:, n:] = np.eye(n) / LEARNING.dark_sd**2 + smooth / LEARNING.dark_step_sd**2
    out.setflags(write=False)
    return out
