"""What fits the painted animal to a frame: the animal as it looks, its anatomy, the evidence.

A fitter is a value. What is learnt of the animal makes a new one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import PoseLayout
from pawnb.core.pose.fit.learning.clutter import Clutter
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.pose_index import PoseIndex, index_pose
from pawnb.core.pose.fit.rendering.blur import SQRT5
from pawnb.core.pose.fit.rendering.canvas import Canvas
from pawnb.core.pose.fit.rendering.evidence import Evidence
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import (
    ImageEvidence,
    Prior,
    fit_pose,
    normal_matrix,
    paint_some,
)
from pawnb.core.pose.fit.rendering.paint_kernels import leg_chain
from pawnb.core.pose.fit.settings import PoseSettings


@dataclass(frozen=True, eq=False, kw_only=True)
class FrameFitter:
    """Fits poses to frames, in any thread; :func:`make_fitter` makes one.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    layout : PoseLayout
        Its appearance as far as it was learnt, working pixels.
    initial : PoseLayout
        Its appearance before it was learnt, of which that is no more than a change.
    blur : float
        Half width of the blur that is painted, working px.
    anatomy : Prior
        What is known of any pose.
    usual_poses : tuple of ndarray, shape (poses, 2 links)
        Of each leg, parts of the pose vector that it is known to have; see
        :mod:`.learning.pose_prior`.
    clutter : Clutter
        What is not the animal as it is painted.
    evidence : Evidence
        Makes the evidence of frames.
    settings : PoseSettings
        Settings.
    index : PoseIndex
        Places in the pose vector.
    canvas_room : Canvas
        What poses are painted on.
    """

    animal: StickAnimal
    layout: PoseLayout
    initial: PoseLayout
    blur: float
    anatomy: Prior
    usual_poses: tuple[FloatArray, ...]
    clutter: Clutter
    evidence: Evidence
    settings: PoseSettings
    index: PoseIndex
    canvas_room: Canvas

    def with_initial_appearance(self, layout: PoseLayout) -> FrameFitter:
        """Return a fitter of an animal that looks like this before it is learnt.

        Parameters
        ----------
        layout : PoseLayout
            The animal's appearance.

        Returns
        -------
        FrameFitter
            A new one.
        """
        return replace(self, layout=layout, initial=layout)

    def with_appearance(self, layout: PoseLayout, *, blur: float | None = None) -> FrameFitter:
        """Return a fitter of an animal whose appearance was learnt.

        Parameters
        ----------
        layout : PoseLayout
            The animal's appearance.
        blur : float, optional
            Half width of the blur that is painted, working px; default as it is.

        Returns
        -------
        FrameFitter
            A new one.
        """
        return replace(self, layout=layout, blur=self.blur if blur is None else blur)

    def with_prior(
        self, anatomy: Prior, *, usual_poses: tuple[FloatArray, ...] | None = None
    ) -> FrameFitter:
        """Return a fitter that knows something else of poses.

        Parameters
        ----------
        anatomy : Prior
            What is known of any pose.
        usual_poses : tuple of ndarray, optional
            Of each leg, poses that it is known to have; default as they are.

        Returns
        -------
        FrameFitter
            A new one.
        """
        known = self.usual_poses if usual_poses is None else usual_poses
        return replace(self, anatomy=anatomy, usual_poses=known)

    def with_clutter(self, clutter: Clutter) -> FrameFitter:
        """Return a fitter that knows what is not the animal as it is painted.

        Parameters
        ----------
        clutter : Clutter
            Places that do not count.

        Returns
        -------
        FrameFitter
            A new one.
        """
        return replace(self, clutter=clutter)

    @property
    def reach(self) -> float:
        """How far from the body a leg may be seen, working px."""
        reach = np.hypot(*self.initial.attach.T) + self.initial.length.sum(axis=1)
        return FITTING.reach_more * float(reach.max()) + FITTING.reach_more_px

    @property
    def body_radius(self) -> float:
        """How far the body reaches from its origin, working px."""
        ellipse = self.initial.ellipse
        return float((np.abs(ellipse[:, 0]) + ellipse[:, 2]).max())

    @property
    def leg_area(self) -> float:
        """Area of a leg in the picture, working pixels."""
        layout = self.layout
        return float(np.median((2 * layout.radius[:, :-1] * layout.length).sum(axis=1)))

    def canvas(self, image_evidence: ImageEvidence) -> tuple[AnyArray, ...]:
        """Return a canvas of the size of a frame's evidence; its content does not last."""
        return self.canvas_room.of_shape(image_evidence.seen.shape)

    def fit(
        self,
        pose: FloatArray,
        image_evidence: ImageEvidence,
        prior: Prior,
        *,
        active: IntArray | None = None,
        shown: BoolArray | None = None,
        blur: float | None = None,
        rounds: int | None = None,
        enough: float | None = None,
    ) -> tuple[FloatArray, float]:
        """Return the pose nearby that fits best, and its cost; see :func:`fit_pose`.

        Parameters
        ----------
        pose : ndarray
            The pose vector to begin with.
        image_evidence : ImageEvidence
            What the frame shows.
        prior : Prior
            What is expected of the pose.
        active : ndarray of int, optional
            Numbers of the pose that may change, ascending; default all.
        shown : ndarray of bool, shape (legs + 1,), optional
            Legs, and last the body, that are painted; default all.
        blur : float, optional
            Blur of the picture, working px; default that of the fitter.
        rounds : int, optional
            Steps at most; default :attr:`.FittingParameters.rounds`.
        enough : float
            A step that gains less ends the fit.

        Returns
        -------
        tuple of (ndarray, float)
            The pose vector, and its cost.
        """
        return fit_pose(
            self.layout, pose, image_evidence, prior,
            self.index.everything if active is None else active,
            self.index.all_shown if shown is None else shown,
            self.blur if blur is None else blur,
            self.settings.soft_error, FITTING.rounds if rounds is None else rounds,
            FITTING.fitter_enough if enough is None else enough,
            *self.canvas(image_evidence),
        )  # fmt: skip

    def equations(
        self, pose: FloatArray, image_evidence: ImageEvidence, prior: Prior
    ) -> tuple[FloatArray, FloatArray]:
        """Return the Gauss-Newton matrix and the gradient of picture and prior.

        The pose is painted on the canvas.

        Parameters
        ----------
        pose : ndarray
            The pose vector.
        image_evidence : ImageEvidence
            What the frame shows.
        prior : Prior
            What is expected of the pose.

        Returns
        -------
        tuple of (ndarray, ndarray)
            The matrix (n, n) and the gradient (n,).
        """
        layout, index, blur = self.layout, self.index, self.blur
        matrix, slope = np.zeros((index.n, index.n)), np.zeros(index.n)
        value, owner, along, joints = canvas = self.canvas(image_evidence)
        paint_some(layout, pose, blur, image_evidence.box, index.all_shown, *canvas)
        normal_matrix(
            layout, pose, image_evidence, prior, index.everything, index.all_shown, blur,
            self.settings.soft_error, value, owner, along, joints, matrix, slope,
        )  # fmt: skip
        return matrix + np.tril(matrix, -1).T, slope  # the loops fill the lower triangle

    def joints(self, pose: FloatArray) -> FloatArray:
        """Return the joints and tips of all legs, shape (legs, segments + 1, 2)."""
        out = np.full((*self.layout.radius.shape, 2), np.nan)
        for leg in range(len(out)):
            leg_chain(self.layout, pose, leg, out[leg])
        return out


def make_fitter(
    animal: StickAnimal,
    layout: PoseLayout,
    *,
    evidence: Evidence,
    anatomy: Prior,
    settings: PoseSettings,
) -> FrameFitter:
    """Return the fitter of an animal of which nothing was learnt yet.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    layout : PoseLayout
        As arrays, in working pixels.
    evidence : Evidence
        Makes the evidence of frames.
    anatomy : Prior
        What is known of any pose.
    settings : PoseSettings
        Settings.

    Returns
    -------
    FrameFitter
        As blurred as the settings say; no pose of a leg is known, and no clutter.
    """
    index = index_pose(animal, layout)
    return FrameFitter(
        animal=animal,
        layout=layout,
        initial=layout,
        blur=SQRT5 * settings.blur_px,
        anatomy=anatomy,
        usual_poses=tuple(np.empty((0, len(numbers))) for numbers in index.numbers),
        clutter=Clutter(),
        evidence=evidence,
        settings=settings,
        index=index,
        canvas_room=Canvas(layout),
    )
