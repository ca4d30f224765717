"""One frame in space: heights chosen first, then every joint fitted to both views."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_dilation, label

from pawnb.arrays import AnyArray, BoolArray, FloatArray, Points2D
from pawnb.core import dlt
from pawnb.core.pose.fit.rendering.blur import SQRT5
from pawnb.core.pose.fit.rendering.evidence import BackgroundPicture, Evidence, make_evidence
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, picture_cost
from pawnb.core.pose.space.frame import SpaceFrame, even_arches
from pawnb.core.pose.space.geometry import view_slope
from pawnb.core.pose.space.model import SpaceModel
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.picture_kernels import (
    Known,
    add_known,
    add_picture,
    paint_parts,
    paint_space,
)
from pawnb.core.video.views import Frame

_SPACE_DAMPING, _SPACE_EASIER, _SPACE_LEAST, _SPACE_HARDER, _MORE, _SPACE_MOST = (
    1e-3,
    4,
    1e-6,
    8,
    1e-4,
    1e4,
)
"""Numerics: the schedule of damping of a Levenberg-Marquardt descent (Marquardt 1963). It tells how
steps are found, not where the bottom is."""


@dataclass(frozen=True, eq=False)
class SpaceFitter:
    """Fits frames in space; :func:`make_space_fitter` makes one.

    Parameters
    ----------
    model : SpaceModel
        The animal and the views.
    evidence : Evidence
        Turns frames of the second view into evidence.
    """

    model: SpaceModel
    evidence: Evidence

    def with_model(self, model: SpaceModel) -> SpaceFitter:
        """Return a fitter of the animal as it is known now."""
        return replace(self, model=model)

    @property
    def blur(self) -> float:
        """Half width of the blur that is painted, working px."""
        return SQRT5 * self.model.settings.blur_px

    @property
    def shown(self) -> BoolArray:
        """All legs are painted."""
        return np.ones(len(self.model.animal.legs), bool)

    def crop(
        self, frame: Frame, xy: Points2D, *, places: Points2D, heights: tuple[float, float]
    ) -> tuple[FloatArray, tuple[int, int, int, int]]:
        """Return the second view's crop that holds the animal at some heights, and its box.

        Parameters
        ----------
        frame : Frame
            A frame of the second view.
        xy : ndarray, shape (2,)
            Place of the body in the first view, px.
        places : ndarray, shape (n, 2)
            Places of the animal in the first view, px.
        heights : tuple of float
            Least and greatest height.

        Returns
        -------
        tuple
            Grey pixels (H, W), and their box, px.
        """
        lines = self.model.lines
        uv = np.concatenate([xy[None], places.reshape(-1, 2)])
        start, direction = lines.lines(uv[np.isfinite(uv).all(axis=1)])
        ends = np.concatenate([start + h * direction for h in heights])
        seen = dlt.project(self.model.coefs, ends)[:, 0]
        size = np.array([self.evidence.width, self.evidence.height])
        low = np.clip(np.floor(seen.min(axis=0)) - IN_SPACE.margin_px, 0, size - 2).astype(int)
        high = np.clip(np.ceil(seen.max(axis=0)) + IN_SPACE.margin_px + 1, low + 2, size).astype(
            int
        )
        box = (int(low[0]), int(low[1]), int(high[0]), int(high[1]))
        return self.evidence.pixels(frame, box), box

    def image_evidence(self, image: FloatArray, box: tuple[int, int, int, int]) -> ImageEvidence:
        """Return the darkness of a crop of the second view."""
        u0, v0, u1, v1 = box
        mean, sd = self.evidence.mean[v0:v1, u0:u1], self.evidence.sd[v0:v1, u0:u1]
        animal = np.abs(image - mean) > np.maximum(
            IN_SPACE.dark_share * mean, IN_SPACE.dark_sds * sd
        )
        covered = np.where(binary_dilation(animal, iterations=2), 0, -1)
        return self.evidence.image_evidence(image.astype(float), box, covered)

    def canvas(self, image_evidence: ImageEvidence) -> tuple[AnyArray, ...]:
        """Return an empty canvas of the evidence's size."""
        height, width = image_evidence.seen.shape
        return make_canvas(height, width, self.model.layout)

    def body_height(
        self, one: SpaceFrame, image_evidence: ImageEvidence, heights: FloatArray
    ) -> float:
        """Return at which of some heights the body explains most of the second picture.

        Parameters
        ----------
        one : SpaceFrame
            The frame.
        image_evidence : ImageEvidence
            What its second picture shows.
        heights : ndarray, shape (n,)
            Heights to try.

        Returns
        -------
        float
            The best of them.
        """
        value, owner, _, _ = self.canvas(image_evidence)
        costs = []
        for height in heights:
            parts = self.model.body_parts(one.xy, one.heading_deg, float(height))
            value[:] = 0.0
            owner[:] = -1
            paint_parts(parts, float(height), self.blur, image_evidence.box, value, owner)
            soft = self.model.settings.soft_error
            costs.append(
                picture_cost(value, owner, image_evidence.seen, image_evidence.weight, soft)
            )
        return float(heights[int(np.argmin(costs))])

    def guess(
        self, one: SpaceFrame, image_evidence: ImageEvidence, body: float | None = None
    ) -> FloatArray:
        """Return unknowns to start from: every leg in an even arch from body to ground.

        Parameters
        ----------
        one : SpaceFrame
            The frame.
        image_evidence : ImageEvidence
            Its second picture.
        body : float, optional
            The body's height; default where the second picture shows it.

        Returns
        -------
        ndarray
            The unknowns; see :mod:`.picture_kernels`.
        """
        model = self.model
        if body is None:
            step = IN_SPACE.body_step * model.span
            lowest = np.fmax(model.heights[0], model.ground)
            body = self.body_height(one, image_evidence, np.arange(lowest, model.heights[1], step))
        places, heights = even_arches(model, one, body)
        joints = np.nan_to_num(model.lines.at(places, heights))
        return np.concatenate([[body], joints.ravel()])

    def refine(
        self,
        one: SpaceFrame,
        image_evidence: ImageEvidence,
        x: FloatArray,
        *,
        known: Known,
        coarse: bool = False,
    ) -> tuple[FloatArray, float]:
        """Return the unknowns that fit both views best near ``x``, and their cost.

        ``coarse`` looks further away first.

        Parameters
        ----------
        one : SpaceFrame
            The frame.
        image_evidence : ImageEvidence
            What its second picture shows.
        x : ndarray
            Unknowns to begin with.
        known : Known
            What is known without the second picture.
        coarse : bool
            Whether a fit to a more blurred picture comes before.

        Returns
        -------
        tuple of (ndarray, float)
            Unknowns and cost.
        """
        if coarse:
            x, _ = self._descend(one, image_evidence, x, known, IN_SPACE.coarse * self.blur)
        return self._descend(one, image_evidence, x, known, self.blur)

    def _descend(
        self,
        one: SpaceFrame,
        image_evidence: ImageEvidence,
        x: np.ndarray,
        known: Known,
        blur: float,
    ) -> tuple[np.ndarray, float]:
        """Return the unknowns at the bottom of the cost's valley, and their cost."""
        cost, matrix, vector = self.equations(one, image_evidence, x, known=known, blur=blur)
        damping = _SPACE_DAMPING
        for _ in range(IN_SPACE.rounds):
            step = self.solve(matrix, -vector, damping)
            most = IN_SPACE.most_step * self.model.span
            step = np.clip(step, -most, most)
            new = self.equations(one, image_evidence, x + step, known=known, blur=blur)
            gained = cost - new[0]
            if gained > 0:
                x, damping = x + step, max(damping / _SPACE_EASIER, _SPACE_LEAST)
                cost, matrix, vector = new
                if gained < IN_SPACE.enough:
                    break
            else:
                damping = damping * _SPACE_HARDER + _MORE
                if damping > _SPACE_MOST:
                    break
        return x, cost

    def solve(self, matrix: FloatArray, right: FloatArray, damping: float) -> FloatArray:
        """Return the solution of the damped equations; legs meet only through the body's height.

        Parameters
        ----------
        matrix : ndarray, shape (n, n)
            Gauss-Newton matrix.
        right : ndarray, shape (n,)
            Right side.
        damping : float
            Share of the diagonal that is added to it.

        Returns
        -------
        ndarray, shape (n,)
            The solution.
        """
        legs = len(self.model.animal.legs)
        m = (len(right) - 1) // legs
        blocks = matrix[1:, 1:].reshape(legs, m, legs, m)[np.arange(legs), :, np.arange(legs)]
        blocks = blocks + damping * np.eye(m) * blocks
        border = matrix[1:, 0].reshape(legs, m)
        both = np.linalg.solve(blocks, np.stack([right[1:].reshape(legs, m), border], axis=-1))
        body = matrix[0, 0] * (1.0 + damping) - (border * both[..., 1]).sum()
        first = (right[0] - (border * both[..., 0]).sum()) / body
        return np.concatenate([[first], (both[..., 0] - first * both[..., 1]).ravel()])

    def ground_below(self, one: SpaceFrame, image_evidence: ImageEvidence) -> float:
        """Return the lowest height that the animal in the second picture reaches."""
        model = self.model
        middle = model.lines.at(one.xy, 0.0)
        change = view_slope(model.coefs, middle) @ model.lines.axis
        # where the scene itself is dark, noise looks like an animal
        sure = image_evidence.weight > 0.5 / model.settings.unexplained_sd**2
        names, n = label((image_evidence.seen > IN_SPACE.animal_dark) & sure)
        if not n:
            return np.nan
        largest = 1 + int(np.argmax(np.bincount(names.ravel())[1:]))
        dark = np.argwhere(names == largest)[:, ::-1] + image_evidence.box
        heights = (dark - dlt.project(model.coefs, middle)[0]) @ change / (change @ change)
        return float(heights.min())

    def equations(
        self,
        one: SpaceFrame,
        image_evidence: ImageEvidence,
        x: FloatArray,
        *,
        known: Known,
        blur: float,
    ) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, Gauss-Newton matrix and gradient at ``x``.

        Parameters
        ----------
        one : SpaceFrame
            The frame.
        image_evidence : ImageEvidence
            What its second picture shows.
        x : ndarray
            Unknowns.
        known : Known
            What is known without the second picture.
        blur : float
            Blur of the picture, working px.

        Returns
        -------
        tuple of (float, ndarray, ndarray)
            Cost, matrix (n, n), gradient (n,).
        """
        model, settings = self.model, self.model.settings
        parts = model.body_parts(one.xy, one.heading_deg, float(x[0]))
        value, owner, along, joints = self._paint(parts, image_evidence, x, blur)
        matrix, vector = np.zeros((len(x), len(x))), np.zeros(len(x))
        matrix[0, 0] = 1e-9
        cost = add_picture(
            model.layout, x, model.coefs, parts, blur, image_evidence.box, value, owner, along,
            joints, image_evidence.seen, image_evidence.weight, settings.soft_error,
            settings.evidence_share, matrix, vector,
        )  # fmt: skip
        cost += add_known(model.layout, x, known, matrix, vector)
        return cost, matrix, vector

    def painted(
        self, one: SpaceFrame, image_evidence: ImageEvidence, x: FloatArray
    ) -> tuple[AnyArray, ...]:
        """Return the second picture as ``x`` has it: value, owner, along and joints.

        Parameters
        ----------
        one : SpaceFrame
            The frame.
        image_evidence : ImageEvidence
            What its second picture shows.
        x : ndarray
            Unknowns.

        Returns
        -------
        tuple of ndarray
            As :func:`paint` fills them.
        """
        parts = self.model.body_parts(one.xy, one.heading_deg, float(x[0]))
        return self._paint(parts, image_evidence, x, self.blur)

    def _paint(
        self, parts: FloatArray, image_evidence: ImageEvidence, x: FloatArray, blur: float
    ) -> tuple[np.ndarray, ...]:
        """Return the second picture with the body's parts and the legs of ``x``."""
        model, canvas = self.model, self.canvas(image_evidence)
        paint_space(
            model.layout, x, model.coefs, parts, self.shown, blur, image_evidence.box, *canvas
        )
        return canvas


def make_space_fitter(
    model: SpaceModel, background: BackgroundPicture, frame: Frame
) -> SpaceFitter:
    """Return the fitter of an animal of which nothing was learnt yet.

    Parameters
    ----------
    model : SpaceModel
        The animal and the views.
    background : Background
        The second view without the animal.
    frame : Frame
        A frame of the second view with the animal; tells whether it is dark or light.

    Returns
    -------
    SpaceFitter
        Whose evidence is of such an animal.
    """
    spread = model.settings.unexplained_sd
    evidence = make_evidence(background, factor=model.factor, light=0.0, spread=spread)
    image = evidence.pixels(frame, (0, 0, evidence.width, evidence.height))
    change = image - evidence.mean
    strong = np.abs(change) >= np.percentile(np.abs(change), IN_SPACE.strong_percentile)
    if np.median(change[strong]) > 0:
        light = float(np.percentile(image[strong], IN_SPACE.light_percentile))
        evidence = replace(evidence, light=light)
    return SpaceFitter(model, evidence)
