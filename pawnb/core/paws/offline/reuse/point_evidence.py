"""Evidence of points as one run found it, for points whose clicks stay what they are.

A correction changes the clicks of one point in one view. What flow, correlation and appearance say
of the others there, and of all points in the other views, needs not be found again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections

_SAME_PX = 0.05
"""Layout: clicks that went through a file of tracks are the same within so much."""


@dataclass(frozen=True)
class PointEvidence:
    """What was found of some points of one view in rows from ``begin`` up to ``end``.

    Parameters
    ----------
    begin, end : int
        First row and one past the last, of the whole view.
    clicks : Annotations
        What was placed in the whole view.
    followed, correlated : Detections
        By flow from clicks, and by patches about them; rows are counted from ``begin``.
    looks : mapping
        Point to ratios of likelihoods (end - begin, h, w) by appearance; float16 saves memory.
    spans : mapping
        Point to the rows in which all of this was found by its present clicks.
    """

    begin: int
    end: int
    clicks: Annotations
    followed: Detections
    correlated: Detections
    looks: Mapping[int, np.ndarray]
    spans: Mapping[int, tuple[int, int]]

    @property
    def nbytes(self) -> int:
        """Bytes of memory, but for a few hundred a frame."""
        return sum(own.nbytes for own in self.looks.values())

    def compact(self) -> PointEvidence:
        """Return the same in half of the memory."""
        looks = {p: own.astype(np.float16, copy=False) for p, own in self.looks.items()}
        return dataclasses.replace(self, looks=looks)

    def unchanged(self, clicks: Annotations, rows: tuple[int, int]) -> PointEvidence | None:
        """Return that of points whose clicks are the same; None where there is none.

        Parameters
        ----------
        clicks : Annotations
            What is placed in the whole view by now.
        rows : tuple of int
            First row that is asked for and one past the last.
        """
        same = self._found_by(clicks, rows)
        if not same:
            return None
        begin, end = rows[0] - self.begin, rows[1] - self.begin
        return PointEvidence(
            *rows,
            clicks,
            self.followed.of(same).part(begin, end),
            self.correlated.of(same).part(begin, end),
            {p: self.looks[p][begin:end].astype(np.float32) for p in same},
            dict.fromkeys(same, rows),
        )

    def updated(self, new: PointEvidence) -> PointEvidence:
        """Return it with what was found later in some of its rows.

        A point that was clicked anew since is known in these rows only: what was found elsewhere
        knows nothing of that click, or may be owed to one that was taken back.

        Parameters
        ----------
        new : PointEvidence
            Of the same points.
        """
        if not self.begin <= new.begin < new.end <= self.end:
            return new
        rows = (new.begin, new.end)
        kept = self._found_by(new.clicks, rows)
        fresh = [p for p in new.looks if p not in kept]
        looks = {p: self.looks[p] for p in kept}
        begin, n = new.begin - self.begin, self.end - self.begin
        for p in fresh:
            looks[p] = np.zeros((n, *new.looks[p].shape[1:]), new.looks[p].dtype)
            looks[p][begin : begin + len(new.looks[p])] = new.looks[p]
        followed, correlated = (
            old.of(kept).joined(found.of(fresh).moved(begin))
            for old, found in (
                (self.followed, new.followed),
                (self.correlated, new.correlated),
            )
        )
        spans = {p: self.spans[p] for p in kept} | dict.fromkeys(fresh, rows)
        return PointEvidence(self.begin, self.end, new.clicks, followed, correlated, looks, spans)

    def _found_by(self, clicks: Annotations, rows: tuple[int, int]) -> list[int]:
        """Return the points of which all rows were found by just these clicks."""
        return [
            p
            for p, (begin, end) in self.spans.items()
            if begin <= rows[0] < rows[1] <= end
            and _has_all(self.clicks, clicks, p)
            and _has_all(clicks, self.clicks, p)
        ]


def _has_all(here: Annotations, those: Annotations, point: int) -> bool:
    """Tell whether each click of a point is there too."""
    return all(
        row in here.places
        and point in here.places[row]
        and np.abs(here.places[row][point] - those.places[row][point]).max() < _SAME_PX
        for row in those.rows_of(point)
    )
