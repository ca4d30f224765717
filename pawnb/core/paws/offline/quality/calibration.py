"""How likely estimates are right, and how exact: learnt from marks on real clips."""

from __future__ import annotations

import numpy as np
from scipy.special import expit, logit, ndtr

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.core.paws.offline.quality.signs import Signs

_BEYOND, _LIMIT = 0.05, 1.96
"""Definition: share outside of 95 % limits, and where they are, in standard deviations."""
_HALVINGS = 40
"""Numerics: halvings of an interval, to one part in 1e12."""


def probability_right(signs: Signs) -> FloatArray:
    """Return the probability (n,) that estimates lie within half a paw of the truth."""
    return np.minimum(expit(log_odds(signs.columns())), signs.probability)


def log_odds(columns: FloatArray) -> FloatArray:
    """Return the log-odds (n,) of that, of columns (n, 7) of :class:`.signs.Signs`."""
    return np.asarray(columns @ np.array(QUALITY.weights) + QUALITY.offset)


def of_all_views(chance: FloatArray) -> FloatArray:
    """Return the probability that labels are right, told by all calibrated views together.

    A point is in one place: views that support each other along epipolar lines are right or wrong
    together, also where one of them by itself is sure. So it is the mean of their log-odds that
    counts. Measured on the fly of the real clips, 1 to 5 clicked frames, with weights of other
    clips: the area under the ROC curve is 0.89, of each view by itself 0.84.

    Parameters
    ----------
    chance : ndarray, shape (..., V)
        That of each view by itself; NaN where it has none.

    Returns
    -------
    ndarray, shape (..., V)
        The same for all views; 0 where none has any.
    """
    known = np.isfinite(chance)
    odds = logit(
        np.clip(np.where(known, chance, 0.5), 1.0 - QUALITY.view_surest, QUALITY.view_surest)
    )
    n = known.sum(axis=-1, keepdims=True)
    mean = np.where(known, odds, 0.0).sum(axis=-1, keepdims=True) / np.maximum(n, 1)
    return np.broadcast_to(np.where(n > 0, expit(mean), 0.0), chance.shape)


def standard_deviation(sd: FloatArray, right: FloatArray, extent: float | AnyArray) -> FloatArray:
    """Return the standard deviation of estimates along each axis.

    An estimate is either right, but for what a click is off by, or astray by about the size of
    the animal. One standard deviation says both where the 95 % limits that follow from it are
    those of this mixture: labels that are wrong more rarely than that are as exact as right ones.

    Parameters
    ----------
    sd : ndarray
        That of the distribution over places.
    right : ndarray
        Probability that the estimate is right.
    extent : float or ndarray
        Size of the animal, in the unit of ``sd``.

    Returns
    -------
    ndarray
        1.96 of it hold 95 %.
    """
    near, far = np.hypot(sd, QUALITY.click_sd * extent), np.hypot(sd, QUALITY.astray_sd * extent)
    low, high = np.zeros(np.shape(far)), _LIMIT * far
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = 2 * (right * ndtr(-middle / near) + (1 - right) * ndtr(-middle / far))
        low, high = (
            np.where(beyond > _BEYOND, middle, low),
            np.where(beyond > _BEYOND, high, middle),
        )
    return np.asarray(high / _LIMIT)
