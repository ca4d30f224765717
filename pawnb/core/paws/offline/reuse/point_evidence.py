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
    """

    begin: int
    end: int
    clicks: Annotations
    followed: Detections
    correlated: Detections
    looks: Mapping[int, np.ndarray]

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
        if not self.begin <= rows[0] < rows[1] <= self.end:
            return None
        same = [p for p in self.looks if _has_all(self.clicks, clicks, p)]
        same = [p for p in same if _has_all(clicks, self.clicks, p)]
        begin, end = rows[0] - self.begin, rows[1] - self.begin
        return PointEvidence(
            *rows,
            clicks,
            self.followed.of(same).part(begin, end),
            self.correlated.of(same).part(begin, end),
            {p: self.looks[p][begin:end].astype(np.float32) for p in same},
        )

    def updated(self, new: PointEvidence) -> PointEvidence:
        """Return it with what was found later in some of its rows.

        A point that has lost a click since is known in no row: what was found elsewhere may be
        owed to that click.

        Parameters
        ----------
        new : PointEvidence
            Of the same points.
        """
        if not self.begin <= new.begin < new.end <= self.end:
            return new
        points = [p for p in self.looks if p in new.looks and _has_all(new.clicks, self.clicks, p)]
        begin, end = new.begin - self.begin, new.end - self.begin
        looks = {}
        for p in points:
            looks[p] = self.looks[p].copy()
            looks[p][begin:end] = new.looks[p]
        return PointEvidence(
            self.begin,
            self.end,
            new.clicks,
            _replaced(self.followed.of(points), new.followed.of(points), begin, end),
            _replaced(self.correlated.of(points), new.correlated.of(points), begin, end),
            looks,
        )


def _has_all(here: Annotations, those: Annotations, point: int) -> bool:
    """Tell whether each click of a point is there too."""
    return all(
        row in here.places
        and point in here.places[row]
        and np.abs(here.places[row][point] - those.places[row][point]).max() < _SAME_PX
        for row in those.rows_of(point)
    )


def _replaced(old: Detections, new: Detections, begin: int, end: int) -> Detections:
    """Return detections with others in the rows from ``begin`` up to ``end``."""
    last = int(old.row.max(initial=0)) + 1
    return old.part(0, begin).joined(new.moved(begin)).joined(old.part(end, last).moved(end))
