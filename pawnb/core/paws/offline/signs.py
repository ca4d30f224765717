"""What tells of every label whether it is right, without knowing what is.

Points that look alike are wrong together and smoothly: places were exchanged where they met, and
from there on every frame agrees with the next. What tells is the way from the nearest click:
whether flow comes from it as far as this, and whether what came before and what comes after
fell apart on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.association.estimates import Estimates

SIGNS = {"motion": 1, "broken": -1}
"""The columns of :meth:`Signs.columns`, and whether each speaks for a label or against it."""

_LEAST = 1e-2
"""Agreement below this breaks a way no more."""
_MOST = 200.0
"""No way is broken more than this."""


@dataclass(frozen=True)
class Signs:
    """What tells whether estimates of one point in one view are right; n frames.

    Parameters
    ----------
    motion : ndarray, shape (n,)
        Logarithm of the ratio of likelihoods by motion at the estimate; 0 where flow from no
        click comes so far.
    broken : ndarray, shape (n,)
        How far the way from a click is broken: the sum over its frames of minus the logarithm of
        how far what came before and what comes after agree, by the way that is broken least;
        infinite where there is no click.
    """

    motion: np.ndarray
    broken: np.ndarray

    def columns(self) -> np.ndarray:
        """Return the signs (n, 2) as they enter the calibration."""
        return np.stack([self.motion, np.log1p(np.minimum(self.broken, _MOST))], axis=-1)


def read_signs(
    found: Estimates, *, motion: np.ndarray, agreement: np.ndarray, clicked: Sequence[int]
) -> Signs:
    """Read the signs of one point in one view.

    Parameters
    ----------
    found : Estimates
        Where it is.
    motion : ndarray, shape (n, h, w)
        Ratios of likelihoods by motion.
    agreement : ndarray, shape (n,)
        See :class:`.association.forward_backward.Posterior`.
    clicked : sequence of int
        Rows in which the point was clicked.

    Returns
    -------
    Signs
        Of the n frames.
    """
    x, y = np.rint(found.place).astype(int).T
    return Signs(
        np.log(motion[np.arange(len(x)), y, x]),
        sum_from_clicks(-np.log(np.clip(agreement, _LEAST, 1.0)), clicked),
    )


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
