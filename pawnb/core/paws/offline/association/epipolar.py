"""What one calibrated view says of another: a point lies on the epipolar line of what is seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from pawnb.arrays import Float32Array
from pawnb.core import dlt
from pawnb.core.parallel import in_parts
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
            (found, find_fundamental_matrix(matrices[b], matrices[a]))
            for b, found in enumerate(seen) if b != a
        ]  # fmt: skip
        for point, factor in support[a].items():
            told = [(found[point], F) for found, F in others if point in found]
            draw = _Drawn(stack, told, LINKS.epipolar_sd_radii * radius)
            in_parts(draw, range(len(factor)), factor)
    return support


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

    def __init__(
        self,
        stack: BodyStack,
        told: Sequence[tuple[Sequence[tuple[np.ndarray, np.ndarray]], np.ndarray]],
        sd: float,
    ) -> None:
        self.stack, self.told = stack, told
        reach = int(_REACH_SDS * _STEPS_A_SD)
        self.step, self.middle = _STEPS_A_SD / sd, reach
        across = np.exp(-0.5 * (np.arange(-reach, reach + 1) / _STEPS_A_SD) ** 2)
        self.profile = across.astype(np.float32)[None]

    def __call__(self, row: int, factor: np.ndarray) -> None:
        # homogeneous px of the view from those of the grid
        to_view = np.eye(3)
        corners = self.stack.picture_of(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), row)
        to_view[:2] = np.c_[corners[1] - corners[0], corners[2] - corners[0], corners[0]]
        size = factor.shape[::-1]
        for seen, fundamental in self.told:
            uv, probability = seen[row]
            on_line = np.full(
                factor.shape, LINKS.epipolar_floor + 1 - probability.sum(), np.float32
            )
            for line, p in zip(uv @ fundamental.T @ to_view, probability, strict=True):
                to_profile = np.zeros((2, 3))
                to_profile[0] = line * self.step / (np.hypot(*line[:2]) + 1e-300)
                to_profile[0, 2] += self.middle
                ridge = cv2.warpAffine(
                    self.profile, to_profile, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
                )
                on_line += np.float32(p) * ridge
            factor *= np.minimum(on_line, 1.0, out=on_line)
