"""What tells of every label whether it is right, without knowing what is.

Points that look alike are wrong together and smoothly: places were exchanged where they met, and
from there on every frame agrees with the next. What tells is the way from the nearest click:
whether flow comes from it as far as this, and whether what came before and what comes after
fell apart on it; and how well clicks were found when they were left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.association.estimates import Estimates

SIGNS = {"probability": 1, "motion": 1, "look": 1, "broken": -1, "left_out": 1}
"""The columns of :meth:`Signs.columns`, and whether each speaks for a label or against it."""

_SUREST = 2.5e-3
"""No probability counts as nearer to 0 or 1."""
_LEAST = 1e-2
"""Agreement below this breaks a way no more."""
_MOST = 200.0
"""No way is broken more than this."""


@dataclass(frozen=True)
class Signs:
    """What tells whether estimates of one point in one view are right; n frames.

    Parameters
    ----------
    probability : ndarray, shape (n,)
        Probability within about half a paw, by the hidden Markov model.
    motion : ndarray, shape (n,)
        Logarithm of the ratio of likelihoods by motion at the estimate; 0 where flow from no
        click comes so far.
    look : ndarray, shape (n,)
        The same by appearance.
    broken : ndarray, shape (n,)
        How far the way from a click is broken: the sum over its frames of minus the logarithm of
        how far what came before and what comes after agree, by the way that is broken least;
        infinite where there is no click.
    left_out : float
        Log-odds of finding a click of the recording that was left out; 0 where none could be.
    """

    probability: np.ndarray
    motion: np.ndarray
    look: np.ndarray
    broken: np.ndarray
    left_out: float

    def columns(self) -> np.ndarray:
        """Return the signs (n, 5) as they enter the calibration."""
        p = np.clip(self.probability, _SUREST, 1 - _SUREST)
        broken = np.log1p(np.minimum(self.broken, _MOST))
        left_out = np.full(len(broken), self.left_out)
        return np.stack([np.log(p / (1 - p)), self.motion, self.look, broken, left_out], axis=-1)


def read_signs(
    found: Estimates,
    *,
    motion: np.ndarray,
    look: np.ndarray,
    agreement: np.ndarray,
    clicked: Sequence[int],
    left_out: float,
) -> Signs:
    """Read the signs of one point in one view.

    Parameters
    ----------
    found : Estimates
        Where it is.
    motion, look : ndarray, shape (n, h, w)
        Ratios of likelihoods by motion and by appearance.
    agreement : ndarray, shape (n,)
        See :class:`.association.forward_backward.Posterior`.
    clicked : sequence of int
        Rows in which the point was clicked.
    left_out : float
        See :func:`found_again`.

    Returns
    -------
    Signs
        Of the n frames.
    """
    x, y = np.rint(found.place).astype(int).T
    rows = np.arange(len(x))
    return Signs(
        found.probability,
        np.log(motion[rows, y, x]),
        np.log(look[rows, y, x]),
        sum_from_clicks(-np.log(np.clip(agreement, _LEAST, 1.0)), clicked),
        left_out,
    )


def found_again(found: np.ndarray) -> float:
    """Return the log-odds of finding a click that was left out.

    Parameters
    ----------
    found : ndarray, shape (m,)
        Probability that the model gave to within half a paw of each (:mod:`.weighing`).

    Returns
    -------
    float
        With one click more of either kind, so that few say little; 0 of none.
    """
    hits = float(found.sum())
    return float(np.log((hits + 1.0) / (len(found) - hits + 1.0)))


def sum_from_clicks(values: np.ndarray, clicked: Sequence[int]) -> np.ndarray:
    """Return the sum of values over the way from a click, by the way on which it is least.

    Parameters
    ----------
    values : ndarray, shape (n,)
        At least 0.
    clicked : sequence of int
        Rows at which ways begin, and whose own values do not count.

    Returns
    -------
    ndarray, shape (n,)
        The row itself is part of its way; 0 in clicked rows, infinite where there are none.
    """
    rows = np.arange(len(values))
    own = np.where(np.isin(rows, clicked), 0.0, values)
    total = np.cumsum(own)
    least = np.full(len(values), np.inf)
    for row in clicked:
        way = np.where(rows >= row, total - total[row], total[row] - total + own)
        least = np.minimum(least, np.maximum(way, 0.0))
    return least
