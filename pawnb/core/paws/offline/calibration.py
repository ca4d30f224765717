"""From the model's own probability to one that holds on real marks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Signs:
    """What tells whether estimates of one point are right; n frames.

    Parameters
    ----------
    probability : ndarray, shape (n,)
        Probability within about half a paw, by the hidden Markov model.
    motion : ndarray, shape (n,)
        Logarithm of the ratio of likelihoods by motion at the estimate; 0 where flow says nothing.
    apart : ndarray, shape (n,)
        Distance between where appearance alone puts the point and the estimate, in radii, at
        most 3.
    travelled : ndarray, shape (n,)
        Way of the point in the body's frame since (or until) the nearest click, in extents: every
        swing is an occasion to be taken for another.
    between : ndarray of bool, shape (n,)
        Whether there are clicks on both sides.
    agreement : ndarray, shape (n,)
        How far what came before and what comes after put the point in one place, 0 to 1.
    """

    probability: np.ndarray
    motion: np.ndarray
    apart: np.ndarray
    travelled: np.ndarray
    between: np.ndarray
    agreement: np.ndarray

    def columns(self) -> np.ndarray:
        """Return the signs (n, 6) as they enter the calibration."""
        p = np.clip(self.probability, 2.5e-3, 1 - 2.5e-3)
        return np.stack(
            [
                np.log(p / (1 - p)),
                self.motion,
                np.minimum(self.apart, 3.0),
                np.log1p(self.travelled),
                self.between.astype(float),
                np.where(self.between, np.log(np.clip(self.agreement, 1e-2, 1.0)), 0.0),
            ],
            axis=-1,
        )


def way_to_clicks(
    place: np.ndarray, rows: list[int], extent: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a point has moved since its nearest click, and where clicks are on both sides.

    Parameters
    ----------
    place : ndarray, shape (n, 2)
        Its track in the body's frame.
    rows : list of int
        Rows in which it was clicked.
    extent : float
        Size of the animal in the same unit.

    Returns
    -------
    travelled : ndarray, shape (n,)
        In extents.
    between : ndarray of bool, shape (n,)
        Whether a click lies before and one after (or in) the row.
    """
    steps = np.linalg.norm(np.diff(place, axis=0), axis=1) / extent
    way = np.concatenate([[0.0], np.cumsum(steps)])
    n = len(place)
    travelled = np.min([np.abs(way - way[row]) for row in rows], axis=0)
    row = np.arange(n)
    return travelled, (row >= min(rows)) & (row <= max(rows))


_WEIGHTS = np.array([0.37, 1.34, 0.0, 0.0, 2.19, 0.0])
_OFFSET = -1.01


def probability_right(signs: Signs) -> np.ndarray:
    """Return the probability (n,) that estimates lie within half a paw of the truth.

    Logistic regression on the marks of the clips on which parameters were chosen.
    """
    return np.asarray(1 / (1 + np.exp(-(signs.columns() @ _WEIGHTS + _OFFSET))))
