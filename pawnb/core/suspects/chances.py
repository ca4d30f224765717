"""Suspects of tracks whose labels state their chance of being right: one row for each label.

Labels (a point in one view and frame) are doubted where they are likely to be wrong. What a
person sees in a frame holds for the frames beside it, so the list begins with one label of each
doubtful stretch, or of each part of a long one; the labels about them follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray, IntArray

SEEN_AROUND_FRAMES = 3
"""A look at a point shows whether it is right so many frames before and after."""

_PREFERENCE = 1e-3


@dataclass(frozen=True)
class DoubtedLabel:
    """One label to look at.

    Parameters
    ----------
    row, view, point : int
        Which one.
    score : float
        How many labels a look at it is expected to show as wrong, itself among them, besides
        those that labels listed before show.
    """

    row: int
    view: int
    point: int
    score: float


def doubted_labels(
    wrong: FloatArray, frames: IntArray, *, around: float, least: float
) -> list[DoubtedLabel]:
    """List labels that may be wrong so that the first ones show most of what is.

    Parameters
    ----------
    wrong : ndarray, shape (n, V, P)
        Chance that each label is wrong; 0 where none is to be looked at.
    frames : ndarray of int, shape (n,)
        Their numbers, ascending.
    around : float
        A look at a label shows those of its point and view so many frames before and after.
    least : float
        Labels with a smaller chance are left out.

    Returns
    -------
    list of DoubtedLabel
        First those that between them show every label, the one that shows most first; then all
        others, which show nothing more, the likeliest wrong first.
    """
    doubted = np.where(wrong >= least, wrong, 0.0)
    first: list[DoubtedLabel] = []
    rest: list[DoubtedLabel] = []
    for v, p in np.ndindex(wrong.shape[1:]):
        heads = _heads(doubted[:, v, p], frames, around)
        first += [DoubtedLabel(t, v, p, gain) for t, gain in heads]
        others = set(np.flatnonzero(doubted[:, v, p]).tolist()) - {t for t, _ in heads}
        rest += [DoubtedLabel(t, v, p, 0.0) for t in sorted(others)]
    rest.sort(key=lambda one: -doubted[one.row, one.view, one.point])
    return sorted(first, key=lambda one: -one.score) + rest


def _heads(doubted: FloatArray, frames: IntArray, around: float) -> list[tuple[int, float]]:
    """Return rows of one point from which all its doubted labels are seen, and what each shows."""
    left = doubted.copy()
    first = np.searchsorted(frames, frames - around)
    stop = np.searchsorted(frames, frames + around, side="right")

    def shown(rows: slice) -> FloatArray:
        begin = int(first[rows.start])
        total = np.concatenate([[0.0], np.cumsum(left[begin : int(stop[rows.stop - 1])])])
        seen = total[stop[rows] - begin] - total[first[rows] - begin]
        # of labels from which as much is seen the likeliest wrong is shown
        return np.where(left[rows] > 0, seen + _PREFERENCE * doubted[rows], 0.0)

    gain = shown(slice(0, len(left))) if len(left) else left
    chosen = []
    while left.any():
        t = int(np.argmax(gain))
        seen = slice(int(first[t]), int(stop[t]))
        chosen.append((t, float(left[seen].sum())))
        left[seen] = 0.0
        touched = slice(int(first[seen.start]), int(stop[seen.stop - 1]))
        gain[touched] = shown(touched)
    return chosen


def worth_a_look(suspects: pd.DataFrame) -> pd.DataFrame:
    """Leave out labels that are seen from one that is listed before.

    Parameters
    ----------
    suspects : DataFrame
        frame, view, point, reason and score, most doubtful first, of tracks of any kind.

    Returns
    -------
    DataFrame
        Rows without an earlier one of the same view and point within :data:`SEEN_AROUND_FRAMES`.
    """
    seen: dict[tuple[str, str], set[int]] = {}
    kept = []
    for frame, view, point in zip(
        suspects["frame"], suspects["view"], suspects["point"], strict=True
    ):
        near = seen.setdefault((str(view), str(point)), set())
        kept.append(int(frame) not in near)
        if kept[-1]:
            near.update(range(int(frame) - SEEN_AROUND_FRAMES, int(frame) + SEEN_AROUND_FRAMES + 1))
    return suspects[np.array(kept, dtype=bool)]
