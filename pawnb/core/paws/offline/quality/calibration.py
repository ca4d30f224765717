"""How likely estimates are right, and how exact: learnt from marks on real clips."""

from __future__ import annotations

import numpy as np
from scipy.special import expit, ndtr

from pawnb.core.paws.offline.quality.signs import Signs

_WEIGHTS = np.array([0.45, 0.22, 0.35, -0.7, 0.39, 0.89])
_OFFSET = 1.8
"""Of the columns of :class:`.signs.Signs`, fitted to 1038 marks of camel, dog, fly, horse and mouse
from below with 1, 2, 3 and 5 clicked frames (the mouse 1 and 2), 18 runs, by
``benchmarks/learn_calibration.py``. The offset is 0.5 below the fit, as good that is said in vain
costs more than a look. Of clips that weights were not learnt from, 15 of 18 verdicts are right and
none is too kind, the area under the ROC curve is 0.89, and 58 % of wrong labels are doubted, 7 % of
right ones. Without what left-out clicks say: 14, 0.88, 50 and 7 %; without looks along stretches
15, 0.89, 55 and 8 %."""
_CLICK_SD, _ASTRAY_SD = 0.014, 0.4
"""Standard deviations of labels that are right, and of those that are astray, in extents."""
_BEYOND, _LIMIT = 0.05, 1.96
"""Share outside of 95 % limits, and where they are, in standard deviations."""
_HALVINGS = 40


def probability_right(signs: Signs) -> np.ndarray:
    """Return the probability (n,) that estimates lie within half a paw of the truth."""
    return np.minimum(expit(log_odds(signs.columns())), signs.probability)


def log_odds(columns: np.ndarray) -> np.ndarray:
    """Return the log-odds (n,) of that, of columns (n, 6) of :class:`.signs.Signs`."""
    return np.asarray(columns @ _WEIGHTS + _OFFSET)


def standard_deviation(sd: np.ndarray, right: np.ndarray, extent: float | np.ndarray) -> np.ndarray:
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
    near, far = np.hypot(sd, _CLICK_SD * extent), np.hypot(sd, _ASTRAY_SD * extent)
    low, high = np.zeros(np.shape(far)), _LIMIT * far
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = 2 * (right * ndtr(-middle / near) + (1 - right) * ndtr(-middle / far))
        low, high = (
            np.where(beyond > _BEYOND, middle, low),
            np.where(beyond > _BEYOND, high, middle),
        )
    return np.asarray(high / _LIMIT)
