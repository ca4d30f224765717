"""What clicks that were left out say of labels that nobody clicked.

Signs tell how likely a label is right (:mod:`.calibration`). Whether they tell that of this
recording and of this point is seen at clicks: where they were found less often than their signs
say, labels are wrong more often than theirs say. The difference of log-odds is estimated for the
recording, then for each point, with normal priors (a logistic model with random intercepts).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import expit

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.paws.offline.quality.calibration import log_odds
from pawnb.core.paws.offline.quality.parameters import QUALITY


@dataclass(frozen=True)
class LeftOutClick:
    """A click whose frame was tracked without its clicks.

    Parameters
    ----------
    point : int
        The point.
    found : float
        Probability within half a paw of the click.
    right : bool
        Whether the estimate was there.
    signs : ndarray, shape (7,)
        Signs of the estimate (:meth:`.signs.Signs.columns`).
    view : str
        The view.
    row : int
        The row of the view that was left out.
    off : float
        How far the estimate is from the click, in halves of a paw.
    taken : int or None
        The other point whose click of that frame is within half a paw of the estimate.
    on_others : float
        Probability within half a paw of another point's click of that frame, the largest.
    """

    point: int
    found: float
    right: bool
    signs: FloatArray
    view: str = ""
    row: int = 0
    off: float = 0.0
    taken: int | None = None
    on_others: float = 0.0


def offsets(
    clicks: Sequence[LeftOutClick], *, log_odds: Callable[[AnyArray], AnyArray] = log_odds
) -> dict[int, float]:
    """Return by how much the log-odds of labels differ from what their signs say.

    Parameters
    ----------
    clicks : sequence of LeftOutClick
        Those of one recording.
    log_odds : callable
        From signs (n, 7) to log-odds (n,) of being right.

    Returns
    -------
    dict
        Point to the difference, for points that were left out at all; above 0 where they were
        found more often.
    """
    if not clicks:
        return {}
    point = np.array([click.point for click in clicks])
    right = np.array([click.right for click in clicks], float)
    odds = log_odds(np.stack([click.signs for click in clicks]))
    of_all = _offset(right, odds, 0.0)
    return {
        p: _offset(right[point == p], odds[point == p], of_all) for p in np.unique(point).tolist()
    }


def _offset(right: FloatArray, odds: FloatArray, middle: float) -> float:
    """Return the offset that is likeliest with a normal prior about ``middle``."""

    def slope(offset: float) -> float:
        return float(
            (right - expit(odds + offset)).sum() - (offset - middle) / QUALITY.left_out_sd**2
        )

    reach = (len(right) + 1) * QUALITY.left_out_sd**2
    return float(brentq(slope, middle - reach, middle + reach))
