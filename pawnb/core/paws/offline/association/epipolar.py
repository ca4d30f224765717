"""What one calibrated view says of another: a point lies on the epipolar line of what is seen.

Clicks in two views may be of places on the skin that lie apart, and a calibration may be off by
some px. Each view follows what was clicked in it. So the lines of other views are moved by what
they miss the clicks by.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.core import dlt
from pawnb.core.parallel import in_parts
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.estimates import modes
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.core.rig import Rig
from pawnb.core.sightlines import find_fundamental_matrix

_REACH_SDS, _STEPS_A_SD = 4.5, 64
"""Numerics: across a line its support is in a table, so far and in so many steps a standard
deviation; beyond it is below exp(-10)."""


def epipolar_support(
    posteriors: Sequence[Mapping[int, Float32Array]],
    stacks: Sequence[BodyStack],
    *,
    names: Sequence[str],
    clicks: Sequence[Annotations],
    rig: Rig,
    radius: float,
) -> list[dict[int, Float32Array]]:
    """Return how far every place of each view is supported by the other views.

    Parameters
    ----------
    posteriors : sequence of mapping
        For each view: point to the probability of every place (n, h, w).
    stacks : sequence of BodyStack
        The views.
    names : sequence of str
        Their names in the rig.
    clicks : sequence of Annotations
        What is certain in them.
    rig : Rig
        The calibration.
    radius : float
        About half a paw, in places.

    Returns
    -------
    list of dict
        For each view: point to factors (n, h, w) of at most 1.
    """
    matrices = [dlt.to_matrix(L) for L in rig.subset(names).coefs.T]
    support: list[dict[int, np.ndarray]] = []
    seen = [
        {point: in_parts(_Seen(stack, radius), range(len(mass)), mass)
         for point, mass in own.items()}
        for own, stack in zip(posteriors, stacks, strict=True)
    ]  # fmt: skip
    for a, stack in enumerate(stacks):
        support.append({p: np.ones(stack.shape, np.float32) for p in posteriors[a]})
        others = [
            (b, find_fundamental_matrix(matrices[b], matrices[a]))
            for b in range(len(stacks)) if b != a
        ]  # fmt: skip
        for point, factor in support[a].items():
            told = [
                _EpipolarLines(
                    seen[b][point], F, _missed(stack, clicks[a], clicks[b], point=point, F=F)
                )
                for b, F in others
                if point in seen[b]
            ]
            draw = _Drawn(stack, told, LINKS.epipolar_sd_radii * radius)
            in_parts(draw, range(len(factor)), factor)
    return support


@dataclass(frozen=True)
class _EpipolarLines:
    """Lines on which a point lies, by where another view shows it.

    Parameters
    ----------
    seen : sequence of (ndarray (k, 3), ndarray (k,))
        Row by row where the point is seen: homogeneous positions, px, and probabilities.
    fundamental : ndarray, shape (3, 3)
        From such a position to its line in the view that is told of it.
    missed : ndarray, shape (2, clicks)
        Rows in which the point was clicked in both, and how far the line misses the click, in
        places along its normal.
    """

    seen: Sequence[tuple[FloatArray, FloatArray]]
    fundamental: FloatArray
    missed: FloatArray

    def lines(self, row: int, to_view: FloatArray) -> FloatArray:
        """Return lines (k, 3) of the grid, moved as clicks about that row say."""
        lines = _unit_lines(self.seen[row][0], self.fundamental, to_view)
        if self.missed.size:
            lines[:, 2] -= np.interp(row, *self.missed)
        return lines


def _missed(
    stack: BodyStack, clicks: Annotations, others: Annotations, *, point: int, F: FloatArray
) -> FloatArray:
    """Return rows (2, clicks) of clicks in two views, and how far lines of the others miss them."""
    rows = [row for row in clicks.rows_of(point) if point in others.places.get(row, {})]
    off = []
    for row in rows:
        (line,) = _unit_lines(np.r_[others.places[row][point], 1.0][None], F, _to_view(stack, row))
        off.append(line @ np.r_[stack.grid_of(clicks.places[row][point], row), 1.0])
    return np.array([rows, off], float)


def _unit_lines(uv: FloatArray, fundamental: FloatArray, to_view: FloatArray) -> FloatArray:
    """Return lines (k, 3) of the grid, with normals of length 1, of homogeneous px (k, 3)."""
    lines = uv @ fundamental.T @ to_view
    return np.asarray(lines / (np.linalg.norm(lines[:, :2], axis=1, keepdims=True) + 1e-300))


def _to_view(stack: BodyStack, row: int) -> FloatArray:
    """Return the map (3, 3) to homogeneous px of a view from those of its grid."""
    to_view = np.eye(3)
    corners = stack.picture_of(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), row)
    to_view[:2] = np.c_[corners[1] - corners[0], corners[2] - corners[0], corners[0]]
    return to_view


class _Seen:
    """What is seen of a point in one view: homogeneous positions (k, 3), px, and probabilities."""

    def __init__(self, stack: BodyStack, radius: float) -> None:
        self.stack, self.radius = stack, radius

    def __call__(self, row: int, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = modes(mass, self.radius, LINKS.epipolar_modes)
        places = np.array([place for place, _ in found]).reshape(-1, 2)
        uv = self.stack.picture_of(places, row)
        return np.c_[uv, np.ones(len(uv))], np.array([p for _, p in found])


class _Drawn:
    """Draws into the places (h, w) of a row how far other views support each of them."""

    def __init__(self, stack: BodyStack, told: Sequence[_EpipolarLines], sd: float) -> None:
        self.stack, self.told = stack, told
        reach = int(_REACH_SDS * _STEPS_A_SD)
        self.step, self.middle = _STEPS_A_SD / sd, reach
        across = np.exp(-0.5 * (np.arange(-reach, reach + 1) / _STEPS_A_SD) ** 2)
        self.profile = across.astype(np.float32)[None]

    def __call__(self, row: int, factor: np.ndarray) -> None:
        to_view = _to_view(self.stack, row)
        size = factor.shape[::-1]
        for told in self.told:
            probability = told.seen[row][1]
            on_line = np.full(
                factor.shape, LINKS.epipolar_floor + 1 - probability.sum(), np.float32
            )
            for line, p in zip(told.lines(row, to_view), probability, strict=True):
                to_profile = np.zeros((2, 3))
                to_profile[0] = line * self.step
                to_profile[0, 2] += self.middle
                ridge = cv2.warpAffine(
                    self.profile, to_profile, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
                )
                on_line += np.float32(p) * ridge
            factor *= np.minimum(on_line, 1.0, out=on_line)
