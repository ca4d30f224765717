"""Long recordings in windows: each goes on from what the one before it found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import RUN
from pawnb.core.paws.offline.pipeline import ViewTrack


def windows(n: int, clicked: Sequence[int]) -> list[tuple[int, int]]:
    """Return windows that cover n rows, in the order in which they are tracked.

    Parameters
    ----------
    n : int
        Number of rows.
    clicked : sequence of int
        Rows with clicks, in any view.

    Returns
    -------
    list of (int, int)
        Half-open ranges: first the one with the most clicks, then those after it, then those
        before it, each overlapping its neighbour.
    """
    if n <= RUN.window_rows:
        return [(0, n)]
    count = int(np.ceil((n - RUN.window_overlap) / (RUN.window_rows - RUN.window_overlap)))
    begins = np.linspace(0, n - RUN.window_rows, count).round().astype(int)
    spans = [(int(b), int(b) + RUN.window_rows) for b in begins]
    held = [sum(b <= row < e for row in clicked) for b, e in spans]
    best = int(np.argmax(held))
    return spans[best:] + spans[:best][::-1]


def handed_on(annotations: Annotations, found: ViewTrack, *, begin: int, end: int) -> Annotations:
    """Return what a window goes on from: its clicks, and what its neighbour found.

    Parameters
    ----------
    annotations : Annotations
        Clicks of the whole recording in this view.
    found : ViewTrack
        What was tracked so far; NaN elsewhere.
    begin, end : int
        The window.

    Returns
    -------
    Annotations
        Counted from ``begin``. Positions are handed on only where no click lies within the
        overlap.
    """
    own = dict(annotations.part(begin, end).places)
    known = np.flatnonzero(np.isfinite(found.probability[begin:end]).any(axis=1))
    if len(known):
        for row in known[np.linspace(0, len(known) - 1, RUN.handed_on + 2).astype(int)[1:-1]]:
            likely = np.flatnonzero(found.probability[begin + row] >= RUN.handed_on_likely)
            if len(likely) and row not in own:
                own[int(row)] = {int(p): found.uv[begin + row, p] for p in likely}
    return Annotations(own)


def chance_to_go_on(
    annotations: Annotations, found: ViewTrack, *, begin: int, end: int
) -> FloatArray:
    """Return how likely what a window goes on from is right, for each point.

    Parameters
    ----------
    annotations, found, begin, end
        As for :func:`handed_on`.

    Returns
    -------
    ndarray, shape (P,)
        1 for points that are clicked in the window, or not known in it; for others the mean
        probability of what is known: a point that was exchanged stays so.
    """
    known = found.probability[begin:end]
    count = np.isfinite(known).sum(axis=0)
    chance = np.where(count > 0, np.nansum(known, axis=0) / np.maximum(count, 1), 1.0)
    chance[annotations.part(begin, end).points] = 1.0
    return np.asarray(chance)


def take_over(whole: ViewTrack, part: ViewTrack, begin: int) -> None:
    """Write a window into the whole; where both are known each keeps its half of the overlap.

    Parameters
    ----------
    whole : ViewTrack
        The recording, changed in place.
    part : ViewTrack
        The window.
    begin : int
        Its first row.
    """
    rows = begin + np.arange(len(part.uv))
    known = np.isfinite(whole.probability[rows]).any(axis=1)
    keep = np.zeros(len(rows), bool)
    shared = np.flatnonzero(known)
    if len(shared):
        after = known[0]  # the neighbour lies before this window
        half = shared[: len(shared) // 2] if after else shared[len(shared) // 2 :]
        keep[half] = True
    new = rows[~keep]
    whole.uv[new] = part.uv[~keep]
    whole.probability[new] = part.probability[~keep]
    whole.sd_px[new] = part.sd_px[~keep]
