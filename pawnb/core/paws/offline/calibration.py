"""From the model's own probability to one that holds on real marks."""

from __future__ import annotations

import numpy as np

_SLOPE, _OFFSET = 0.55, 0.3
"""Logistic calibration (Platt 1999) of the log-odds."""


def probability_right(probability: np.ndarray) -> np.ndarray:
    """Return the probability that an estimate lies within half a paw of the truth.

    Parameters
    ----------
    probability : ndarray
        What the hidden Markov model says, 0 to 1, NaN where nothing was estimated.

    Returns
    -------
    ndarray
        Calibrated; NaN stays.
    """
    p = np.clip(probability, 1e-6, 1 - 1e-6)
    return 1 / (1 + np.exp(-(_SLOPE * np.log(p / (1 - p)) + _OFFSET)))
