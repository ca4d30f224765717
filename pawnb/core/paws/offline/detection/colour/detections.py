"""What is found in a picture: places that may be paws, and what is measured of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pawnb.arrays import AnyArray, BoolArray, Float32Array

N_COLUMNS = 8
"""Layout: numbers of a detection, in tables for loops and files."""

_UV, _DIRECTION, _COVERAGE, _SCORE, _TIP = slice(0, 2), slice(2, 4), 4, 5, slice(6, 8)
"""Layout: which of them are what."""


@dataclass(frozen=True)
class ColourDetections:
    """Detections of one view in one frame; side by side (:func:`pad_and_stack`) those of more.

    Parameters
    ----------
    table : ndarray, shape (..., 8), float32
        A row a detection, for loops and files; elsewhere it is read by the names below.
    """

    table: np.ndarray

    @classmethod
    def of(
        cls,
        uv: AnyArray,
        *,
        direction: AnyArray,
        coverage: AnyArray,
        score: AnyArray,
        tip: AnyArray,
    ) -> ColourDetections:
        """Return detections.

        Parameters
        ----------
        uv, direction : ndarray, shape (n, 2)
            Where they are, and towards where they end, px.
        coverage, score : ndarray, shape (n,)
            Share of mask about them, and its mean score.
        tip : ndarray, shape (n, 2)
            The end pixels, px.

        Returns
        -------
        ColourDetections
            These.
        """
        return cls(np.column_stack([uv, direction, coverage, score, tip]).astype(np.float32))

    @classmethod
    def none(cls) -> ColourDetections:
        """Return no detections."""
        return cls(np.empty((0, N_COLUMNS), np.float32))

    @classmethod
    def joined(cls, parts: Sequence[ColourDetections]) -> ColourDetections:
        """Return detections after each other."""
        return cls(np.concatenate([part.table for part in parts]))

    def __len__(self) -> int:
        return len(self.table)

    @property
    def uv(self) -> Float32Array:
        """Where they are (..., 2), px: the centre of the mask near the end."""
        return self.table[..., _UV]

    @property
    def direction(self) -> AnyArray:
        """Where the limb ends (..., 2), px: from the centre of a wider neighbourhood to ``uv``."""
        return self.table[..., _DIRECTION]

    @property
    def coverage(self) -> AnyArray:
        """Share (...,) of mask in the square about the end."""
        return np.asarray(self.table[..., _COVERAGE])

    @property
    def score(self) -> AnyArray:
        """Mean score (...,) of the mask near the end."""
        return np.asarray(self.table[..., _SCORE])

    @property
    def tip(self) -> Float32Array:
        """The end pixel itself (..., 2), px."""
        return self.table[..., _TIP]

    def take(self, which: AnyArray) -> ColourDetections:
        """Return some of them, by number or a mask."""
        return ColourDetections(self.table[which])

    def of_view(self, view: int) -> ColourDetections:
        """Return those of a view, of side by side (n, V, most), as a list (n * most)."""
        return ColourDetections(self.table[:, view].reshape(-1, N_COLUMNS))


InViews: TypeAlias = Sequence[ColourDetections]
"""The detections of each view in one frame."""

InFrames: TypeAlias = Sequence[Sequence[ColourDetections]]
"""For each frame, the detections of each view."""


def pad_and_stack(found: InFrames) -> tuple[ColourDetections, BoolArray]:
    """Put detections side by side.

    Parameters
    ----------
    found : sequence
        For each frame, the detections of each view.

    Returns
    -------
    detections : ColourDetections
        The detections, (n, V, most), and 0 where there is none.
    is_there : ndarray of bool, shape (n, V, most)
        Where there is one.
    """
    number = np.array([[len(rows) for rows in here] for here in found])
    is_there = np.arange(max(1, int(number.max()))) < number[..., None]
    table = np.zeros((*is_there.shape, N_COLUMNS), np.float32)
    table[is_there] = np.concatenate([own.table for here in found for own in here])
    return ColourDetections(table), is_there
