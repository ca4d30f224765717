"""The body of the stick animal laid on the outline of a body, both ways round."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import least_squares

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.start_proposal.parameters import POSE_PROPOSAL
from pawnb.core.pose.start_proposal.silhouette import Silhouette, sample_grid

_MOST_BODY_STEPS = 60
"""Resource: of the search for a body's place."""


@dataclass(frozen=True)
class BodyFit:
    """Where the body lies.

    Parameters
    ----------
    xy : ndarray, shape (2,)
        The origin of the body's frame, grid px of the outline.
    heading_deg : float
        Direction of the front, degrees from +u towards +v.
    scale : float
        Grid px per unit of the species file's lengths.
    misfit : float
        Median distance between the outlines, as a share of the body's length.
    """

    xy: FloatArray
    heading_deg: float
    scale: float
    misfit: float

    def place(self, points: FloatArray) -> FloatArray:
        """Return (..., 2) points of the body's frame in grid px."""
        return _placed(np.asarray(points, dtype=float), self._parameters())

    def _parameters(self) -> FloatArray:
        return np.array([*self.xy, np.radians(self.heading_deg), np.log(self.scale)])


def body_outline(animal: StickAnimal) -> FloatArray:
    """Return points round the body, shape (n, 2): forward, right; unit of the species file.

    Points inside another part of the body are left out.
    """
    count = POSE_PROPOSAL.body_points // len(animal.body)
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) / 2
    points = []
    for part in animal.body:
        on_it = np.array(part.centre) + circle * [part.length, part.width]
        for other in animal.body:
            if other is not part:
                inside = (on_it - other.centre) / [other.length / 2, other.width / 2]
                on_it = on_it[np.hypot(*inside.T) > 1.0]
        points.append(on_it)
    return np.concatenate(points)


def fit_body(
    animal: StickAnimal, outline: Silhouette, *, scale: float | None = None
) -> list[BodyFit]:
    """Fit place, heading and scale of the body, once for each way round.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    outline : Silhouette
        The outline; its core is fitted. Legs beside the body spoil part of that, so the
        distances are weighted robustly.
    scale : float, optional
        Grid px per unit, where it is known: it may then change by a quarter or so.

    Returns
    -------
    list of BodyFit
        Two fits whose headings are about opposite.
    """
    own = POSE_PROPOSAL
    v, u = np.nonzero(outline.core)
    pixels = np.stack([u, v], axis=1).astype(float)
    middle = pixels.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((pixels - middle).T))
    along = float(np.arctan2(axes[1, 1], axes[0, 1]))
    area = sum(np.pi / 4 * part.length * part.width for part in animal.body)
    guess = np.sqrt(len(pixels) / area) if scale is None else scale
    model = body_outline(animal)
    centre = np.array([(model[:, 0].max() + model[:, 0].min()) / 2, 0.0])
    inside = cv2.distanceTransform(outline.core.astype(np.uint8), cv2.DIST_L2, 5)
    outside = cv2.distanceTransform(1 - outline.core.astype(np.uint8), cv2.DIST_L2, 5)
    signed = np.where(outline.core, inside - 0.5, 0.5 - outside).astype(np.float32)
    rim = pixels[inside[v, u] < own.body_rim]
    fits = []
    for heading in (along, along + np.pi):
        back = guess * np.array([np.cos(heading), np.sin(heading)]) * centre[0]
        start = np.array([*(middle - back), heading, np.log(guess)])

        def residuals(p: FloatArray) -> FloatArray:
            """How far the outlines are apart both ways, and the scale from what is known."""
            to_core = sample_grid(signed, _placed(model, p))
            to_model = _to_ellipses(animal, rim, p)
            known = [] if scale is None else [own.body_scale_weight * (p[3] - np.log(scale))]
            return np.concatenate([to_core, to_model * np.sqrt(len(model) / len(rim)), known])

        found = least_squares(
            residuals, start, loss="cauchy", f_scale=own.body_soft, max_nfev=_MOST_BODY_STEPS
        )
        x, y, turn, log = found.x
        size = float(np.exp(log))
        misfit = float(np.median(np.abs(residuals(found.x)))) / (size * animal.body_length)
        heading_deg = (np.degrees(turn) + 180) % 360 - 180
        fits.append(BodyFit(np.array([x, y]), float(heading_deg), size, misfit))
    return fits


def _placed(points: FloatArray, p: FloatArray) -> FloatArray:
    """Return points of the body's frame in grid px; p is x, y, heading (rad), log scale."""
    cos, sin = np.cos(p[2]) * np.exp(p[3]), np.sin(p[2]) * np.exp(p[3])
    x, y = points[..., 0], points[..., 1]
    return np.stack([p[0] + cos * x - sin * y, p[1] + sin * x + cos * y], axis=-1)


def _to_ellipses(animal: StickAnimal, pixels: FloatArray, p: FloatArray) -> FloatArray:
    """Return about how far pixels lie outside the nearest ellipse (inside: negative), grid px."""
    size = np.exp(p[3])
    cos, sin = np.cos(p[2]), np.sin(p[2])
    away = (pixels - p[:2]) / size
    x, y = cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]
    parts = []
    for part in animal.body:
        dx, dy = x - part.centre[0], y - part.centre[1]
        radius = np.hypot(dx / (part.length / 2), dy / (part.width / 2))
        steep = np.hypot(dx / (part.length / 2) ** 2, dy / (part.width / 2) ** 2)
        # the distance to first order (Sampson 1982): value over gradient
        parts.append(size * (radius - 1) * radius / np.maximum(steep, 1e-6))
    most = POSE_PROPOSAL.body_far
    return np.clip(np.min(parts, axis=0), -most, most)
