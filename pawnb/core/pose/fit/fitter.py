"""One frame: the pose nearest to a prediction, and other poses that single legs might have."""

from __future__ import annotations

import copy

import cv2
import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.fit.layout import N_BODY, Layout
from pawnb.core.pose.fit.learning.anatomy import parameter_kinds
from pawnb.core.pose.fit.learning.attached_clutter_kernels import hide
from pawnb.core.pose.fit.parameters import FITTING
from pawnb.core.pose.fit.rendering.blur import blurred, part_of
from pawnb.core.pose.fit.rendering.evidence import Evidence, without_wide
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import (
    ImageEvidence,
    Prior,
    fit_pose,
    normal_matrix,
    paint_some,
)
from pawnb.core.pose.fit.rendering.paint_kernels import NOTHING, leg_chain, make_canvas
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.video.views import Frame

SQRT5 = float(np.sqrt(5.0))
"""Half width of the blur that is painted, in its standard deviation."""
_SUBPIXEL = 4
"""Bits of places between pixels."""


class FrameFitter:
    """Fits poses to frames; one a thread.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    layout : Layout
        As arrays, in working pixels.
    evidence : Evidence
        Makes the evidence of frames.
    anatomy : Prior
        What is known of any pose.
    settings : PoseSettings
        Settings.

    Attributes
    ----------
    attached_clutter : ndarray of bool, shape (side, side), or None
        Where something that is no leg is fixed to the body; see :mod:`.learning.attached_clutter`.
    body_clutter : ndarray, shape (side, side), or None
        How much places of the body count in the last fits; see :mod:`.learning.body_clutter`.
    leg_clutter : ndarray of bool, shape (legs, segments, along, across), or None
        Places beside legs that do not count in the last fits; see :mod:`.learning.leg_clutter`.
    usual_poses : list of ndarray, shape (poses, 2 links)
        Of each leg, parts of the pose vector that it is known to have; see
        :mod:`.learning.pose_prior`.
    """

    def __init__(
        self,
        animal: StickAnimal,
        layout: Layout,
        *,
        evidence: Evidence,
        anatomy: Prior,
        settings: PoseSettings,
    ) -> None:
        self.animal, self.layout, self.evidence = animal, layout, evidence
        self.first = layout
        self.anatomy, self.settings = anatomy, settings
        self.angles, self.lengths = parameter_kinds(animal)
        self.n = N_BODY + len(self.angles) + len(self.lengths)
        self.everything = np.arange(self.n)
        self.body = np.arange(N_BODY)
        n_legs = len(animal.legs)
        self.all_shown = np.ones(n_legs + 1, bool)
        self.body_shown = np.arange(n_legs + 1) == n_legs
        self.only = [np.isin(np.arange(n_legs + 1), (i, n_legs)) for i in range(n_legs)]
        self.neighbours = [
            [j for j in (i - 1, i + 1) if 0 <= j < n_legs and layout.side[j] == layout.side[i]]
            for i in range(n_legs)
        ]
        self.numbers = [
            np.arange(first, first + 2 * links)
            for first, links in zip(layout.first, layout.n_links, strict=True)
        ]
        reach = np.hypot(*layout.attach.T) + layout.length.sum(axis=1)
        self.reach = FITTING.reach_more * float(reach.max()) + FITTING.reach_more_px
        self.body_radius = float((np.abs(layout.ellipse[:, 0]) + layout.ellipse[:, 2]).max())
        self.blur = SQRT5 * settings.blur_px
        self._room = make_canvas(1, 1, layout)
        self.attached_clutter: np.ndarray | None = None
        self.body_clutter: np.ndarray | None = None
        self.leg_clutter: np.ndarray | None = None
        self.usual_poses = [np.empty((0, len(numbers))) for numbers in self.numbers]

    def twin(self) -> FrameFitter:
        """Return a fitter that is the same but for the canvas, for another thread."""
        other = copy.copy(self)
        other._room = make_canvas(1, 1, self.layout)
        return other

    def canvas(self, image_evidence: ImageEvidence) -> tuple[np.ndarray, ...]:
        """Return a canvas of a sight's size; its content does not last."""
        height, width = image_evidence.seen.shape
        size = height * width
        if size > self._room[0].size:
            self._room = make_canvas(1, size, self.layout)
        value, owner, along, joints = self._room
        shape = (height, width)
        return (
            value.ravel()[:size].reshape(shape),
            owner.ravel()[:size].reshape(shape),
            along.ravel()[:size].reshape(shape),
            joints,
        )

    def box(self, expected: FloatArray) -> tuple[int, int, int, int]:
        """Return the crop that holds the expected animal."""
        return self.evidence.crop_box(expected[:2], self.reach)

    def look(
        self, frame: Frame, expected: FloatArray, *, margin: float | None = None
    ) -> tuple[ImageEvidence, FloatArray, tuple]:
        """Return what a frame shows about the expected pose, its grey pixels and their box.

        Parameters
        ----------
        frame : Frame
            The frame.
        expected : ndarray
            The pose vector that is expected.
        margin : float, optional
            Room about its body, working px; default the parameter ``body_margin_px``.

        Returns
        -------
        tuple
            What the frame shows (Sight), its grey pixels (H, W), and their box, px.
        """
        box = self.box(expected)
        image = self.evidence.pixels(frame, box)
        return self.image_evidence(image, box, expected, margin=margin), image, box

    def image_evidence(
        self,
        image: FloatArray,
        box: tuple[int, int, int, int],
        expected: FloatArray,
        *,
        margin: float | None = None,
    ) -> ImageEvidence:
        """Return what grey pixels show, the expected animal left out of the light.

        What is wider than a leg and further than ``margin`` (working px) from the expected body
        does not count as dark; see :func:`.evidence.without_wide`.

        Parameters
        ----------
        image : ndarray, shape (H, W)
            Grey pixels.
        box : tuple of int
            Their place in the picture, px.
        expected : ndarray
            The pose vector that is expected.
        margin : float, optional
            Room about its body, working px; default the parameter ``body_margin_px``.

        Returns
        -------
        ImageEvidence
            What they show.
        """
        empty = ImageEvidence(image, image, np.array([float(box[0]), float(box[1])]))
        seen = self.evidence.image_evidence(image, box, self._cover(expected, empty))
        return seen if margin == np.inf else self.narrowed(seen, expected, margin=margin)

    def _cover(self, pose: FloatArray, image_evidence: ImageEvidence) -> IntArray:
        """Return where the animal and what is beside it may be: not -1; it does not last."""
        value, owner, along, joints = self.canvas(image_evidence)
        paint_some(
            self.layout,
            pose,
            FITTING.cover_px,
            image_evidence.box,
            self.body_shown,
            value,
            owner,
            along,
            joints,
        )
        for places, radius in zip(self.joints(pose), self.layout.radius, strict=True):
            known = places[np.isfinite(places[:, 0])] - image_evidence.box
            ends = np.round(known * (1 << _SUBPIXEL)).astype(np.int32)
            wide = round(2.0 * (float(radius.max()) + FITTING.cover_px))
            cv2.polylines(owner, [ends], False, 0, wide, cv2.LINE_8, _SUBPIXEL)
        return owner

    def narrowed(
        self,
        image_evidence: ImageEvidence,
        expected: FloatArray,
        *,
        margin: float | None = None,
    ) -> ImageEvidence:
        """Return a sight in which what is wider than a leg, but for the body, is not dark.

        Parameters
        ----------
        image_evidence : ImageEvidence
            What a frame shows.
        expected : ndarray
            The pose vector that is expected.
        margin : float
            Room about the body, working px.

        Returns
        -------
        ImageEvidence
            The same without what is wide.
        """
        body = self.near_body(expected, image_evidence, margin=margin)
        if self.attached_clutter is not None:
            image_evidence = image_evidence._replace(
                seen=image_evidence.seen.copy(), weight=image_evidence.weight.copy()
            )
            hide(
                self.attached_clutter,
                expected,
                body,
                image_evidence.box,
                image_evidence.seen,
                image_evidence.weight,
            )
        return without_wide(image_evidence, body, size=self.disc_px)

    def near_body(
        self,
        pose: FloatArray,
        image_evidence: ImageEvidence,
        *,
        margin: float | None = None,
    ) -> BoolArray:
        """Return where the body is, and what is nearer to it than ``margin``: bool, (H, W).

        Parameters
        ----------
        pose : ndarray
            The pose vector.
        image_evidence : ImageEvidence
            What the frame shows.
        margin : float
            How near, working px.

        Returns
        -------
        ndarray of bool, shape (H, W)
            True at and about the body.
        """
        value, owner, along, joints = self.canvas(image_evidence)
        paint_some(
            self.layout,
            pose,
            FITTING.body_margin_px if margin is None else margin,
            image_evidence.box,
            self.body_shown,
            value,
            owner,
            along,
            joints,
        )
        return owner != NOTHING

    @property
    def disc_px(self) -> int:
        """Diameter of a disc that fits into no leg, an odd number."""
        thickest = 2.0 * float(min(self.layout.radius.max(), self.first.radius.max())) + self.blur
        return 2 * round(FITTING.fitter_wider * thickest / 2) + 1

    @property
    def leg_area(self) -> float:
        """Area of a leg in the picture, working pixels."""
        layout = self.layout
        return float(np.median((2 * layout.radius[:, :-1] * layout.length).sum(axis=1)))

    def fit(
        self,
        pose: FloatArray,
        image_evidence: ImageEvidence,
        prior: Prior,
        *,
        active: IntArray | None = None,
        shown: BoolArray | None = None,
        blur: float | None = None,
        rounds: int = 6,
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
        rounds : int
            Steps at most.
        enough : float
            A step that gains less ends the fit.

        Returns
        -------
        tuple of (ndarray, float)
            The pose vector, and its cost.
        """
        return fit_pose(
            self.layout, pose, image_evidence, prior,
            self.everything if active is None else active,
            self.all_shown if shown is None else shown,
            self.blur if blur is None else blur,
            self.settings.soft_error, rounds, FITTING.fitter_enough if enough is None else enough,
            *self.canvas(image_evidence),
        )  # fmt: skip

    def body_found(self, expected: FloatArray, image_evidence: ImageEvidence) -> FloatArray:
        """Return the expected pose, moved as a whole onto the body where that is elsewhere.

        Where it is in its place, as it is in most frames, that is the array given.
        """
        pose = expected
        reach = 2.0 * self.body_radius + max(FITTING.body_blurs)  # further away it is not felt
        image_evidence = part_of(image_evidence, expected[:2] - reach, expected[:2] + reach)
        for blur, surely in zip(FITTING.body_blurs, FITTING.body_surely_px, strict=True):
            pose, _ = self.fit(
                pose,
                blurred(image_evidence, blur),
                self.anatomy,
                active=self.body,
                shown=self.body_shown,
                blur=self.blur + blur,
                rounds=6,
                enough=FITTING.enough_of_body,
            )
            turned = self.body_radius * abs(pose[2] - expected[2])
            if np.hypot(*(pose[:2] - expected[:2])) + turned <= surely:
                return expected
        return pose

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
        matrix, slope = np.zeros((self.n, self.n)), np.zeros(self.n)
        value, owner, along, joints = self.canvas(image_evidence)
        paint_some(
            self.layout,
            pose,
            self.blur,
            image_evidence.box,
            self.all_shown,
            value,
            owner,
            along,
            joints,
        )
        normal_matrix(
            self.layout,
            pose,
            image_evidence,
            prior,
            self.everything,
            self.all_shown,
            self.blur,
            self.settings.soft_error,
            value,
            owner,
            along,
            joints,
            matrix,
            slope,
        )
        return matrix + np.tril(matrix, -1).T, slope  # the loops fill the lower triangle

    def joints(self, pose: FloatArray) -> FloatArray:
        """Return the joints and tips of all legs, shape (legs, segments + 1, 2)."""
        out = np.full((*self.layout.radius.shape, 2), np.nan)
        for leg in range(len(out)):
            leg_chain(self.layout, pose, leg, out[leg])
        return out
