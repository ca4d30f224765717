"""How sure a proposal is, in words."""

from __future__ import annotations

import numpy as np

SURE_FROM = 0.5
"""From here on a point or a leg of a proposal is sure."""
_SURENESS_WORDS = (
    (SURE_FROM, "sure"),
    (0.25, "fairly sure, look at it"),
    (0.0, "unsure, check it"),
)


def sureness_in_words(sure: float) -> str:
    """Say how sure a point or a leg is.

    Parameters
    ----------
    sure : float
        0 to 1; 0 for one that was not found.

    Returns
    -------
    str
        A few words.
    """
    if sure <= 0 or not np.isfinite(sure):
        return "not found, place it by hand"
    return next(words for least, words in _SURENESS_WORDS if sure >= least)
