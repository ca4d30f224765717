"""What tells of every label whether it is right, without knowing what is.

Points that look alike are wrong together and smoothly: places were exchanged where they met, and
from there on every frame agrees with the next. What tells is the way from the nearest click:
whether flow comes from it as far as this, and whether what came before and what comes after
fell apart on it; and how well the points of the view are recognised at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.estimates import Estimates
from pawnb.core.paws.offline.association.forward_backward import Posterior
from pawnb.core.paws.offline.parameters import APPEARANCE
from pawnb.core.paws.offline.quality.parameters import QUALITY

SIGNS = {
    "motion_along": 1, "look": 1, "other_look": 1, "broken": -1, "name_share": 1, "usual_look": 1,
    "left_out": 1,
}  # fmt: skip
"""Definition: the columns of :meth:`Signs.columns`, and whether each speaks for a label or against
it."""


@dataclass(frozen=True)
class Signs:
    """What tells whether estimates of one point in one view are right; n frames.

    Parameters
    ----------
    probability : ndarray, shape (n,)
        Probability within about half a paw, by the hidden Markov model: no label is surer.
    motion_along : ndarray, shape (n,)
        Logarithm of the ratio of likelihoods by motion at the estimate (0 where flow from no
        click comes so far), the mean over the stretch of the track that the frame belongs to: up
        to the next frames that are clicked or in which what came before and what comes after
        disagree.
    look : ndarray, shape (n,)
        The same by appearance, of the frame alone.
    other_look : ndarray, shape (n,)
        The same of the other points, the largest: what looks like another point is at least one of
        them, as legs look alike. The least that there is where there is no other.
    broken : ndarray, shape (n,)
        How far the way from a click is broken: the sum over its frames of minus the logarithm of
        how far what came before and what comes after agree, by the way that is broken least;
        infinite where there is no click.
    name_share : ndarray, shape (n,)
        How surely the tracklet there is its own: see :class:`.forward_backward.Posterior`; 1 where
        a point is alone.
    usual_look : float
        Mean of ``look`` over all points and frames of the view: where no place looks like any
        point, labels are wrong more often than each by itself tells.
    left_out : float
        How much more often clicks of the point that were left out were found than their own signs
        say (:func:`.left_out.offsets`); 0 where none could be left out.
    """

    probability: FloatArray
    motion_along: np.ndarray
    look: np.ndarray
    other_look: np.ndarray
    broken: FloatArray
    name_share: FloatArray
    usual_look: float
    left_out: float = 0.0

    def columns(self) -> FloatArray:
        """Return the signs (n, 7) as they enter the calibration."""
        broken = np.log1p(np.minimum(self.broken, QUALITY.broken_most))
        usual, left_out = (np.full(len(broken), own) for own in (self.usual_look, self.left_out))
        return np.stack(
            [
                self.motion_along,
                self.look,
                self.other_look,
                broken,
                self.name_share,
                usual,
                left_out,
            ],
            axis=-1,
        )


def read_signs(
    found: Mapping[int, Estimates],
    posteriors: Mapping[int, Posterior],
    *,
    motion: Mapping[int, AnyArray],
    looks: Mapping[int, AnyArray],
    clicked: Annotations,
    left_out: Mapping[int, float] | None = None,
) -> dict[int, Signs]:
    """Read the signs of the points of one view; n frames.

    Parameters
    ----------
    found : mapping
        Point to where it is.
    posteriors : mapping
        Point to how far what came before and what comes after agree, and whether its name is sure.
    motion, looks : mapping
        Point to ratios of likelihoods (n, h, w) by motion and by appearance.
    clicked : Annotations
        Where points were clicked.
    left_out : mapping, optional
        Point to what its clicks that were left out say (:func:`.left_out.offsets`).

    Returns
    -------
    dict
        Point to its signs.
    """
    here = {
        p: {q: _at_estimates(look, own) for q, look in looks.items()} for p, own in found.items()
    }
    usual = float(np.mean([here[p][p].mean() for p in found]))
    signs = {}
    for p, own in found.items():
        agreement, share = posteriors[p].agreement, posteriors[p].name_share
        rows = clicked.rows_of(p)
        stops = [*rows, *np.flatnonzero(agreement < QUALITY.agreement_break).tolist()]
        others = [look for q, look in here[p].items() if q != p]
        nothing = np.full(len(agreement), np.log(APPEARANCE.lowest))
        signs[p] = Signs(
            own.probability,
            mean_along(_at_estimates(motion[p], own), stops),
            here[p][p],
            np.max([*others, nothing], axis=0),
            sum_from_clicks(-np.log(np.clip(agreement, QUALITY.agreement_least, 1.0)), rows),
            np.ones(len(agreement)) if share is None else share,
            usual,
            (left_out or {}).get(p, 0.0),
        )
    return signs


def _at_estimates(ratios: np.ndarray, found: Estimates) -> np.ndarray:
    """Return logarithms (n,) of ratios (n, h, w) at the places nearest to estimates."""
    x, y = np.rint(found.place).astype(int).T
    return np.asarray(np.log(ratios[np.arange(len(x)), y, x]))


def sum_from_clicks(values: FloatArray, clicked: Sequence[int]) -> FloatArray:
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


def mean_along(values: AnyArray, stops: Sequence[int]) -> FloatArray:
    """Return the mean of values over the rows about each, up to the next stop on either side.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Any.
    stops : sequence of int
        Rows at which stretches end; they belong to those on both sides.

    Returns
    -------
    ndarray, shape (n,)
        Of a stop that of the stretches on both sides together.
    """
    n = len(values)
    rows, ends = np.arange(n), np.unique([0, n - 1, *stops])
    first = ends[np.maximum(np.searchsorted(ends, rows) - 1, 0)]
    last = ends[np.minimum(np.searchsorted(ends, rows, side="right"), len(ends) - 1)]
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray((total[last + 1] - total[first]) / (last + 1 - first))
