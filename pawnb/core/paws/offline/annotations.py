"""What a person placed, view by view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.paws.layout import Placement


@dataclass(frozen=True)
class Annotations:
    """Points placed by hand in one view.

    Parameters
    ----------
    places : mapping
        Row (frame, counted from the first that is tracked) to point number to (u, v).
    whole_extent : float, optional
        How large the whole animal is, px, where calibrated views tell it
        (:mod:`.scene.extents`): more than the distance of those points that this one shows.
    """

    places: Mapping[int, Mapping[int, np.ndarray]]
    whole_extent: float | None = None

    @property
    def rows(self) -> list[int]:
        """Rows with any point, in order."""
        return sorted(row for row, here in self.places.items() if here)

    @property
    def points(self) -> list[int]:
        """Points that are placed in any frame."""
        return sorted({point for here in self.places.values() for point in here})

    def rows_of(self, point: int) -> list[int]:
        """Return the rows in which a point is placed, in order."""
        return [row for row in self.rows if point in self.places[row]]

    def without(self, row: int) -> Annotations:
        """Return all but one frame."""
        places = {r: here for r, here in self.places.items() if r != row}
        return Annotations(places, self.whole_extent)

    def of(self, points: Sequence[int]) -> Annotations:
        """Return those of some points."""
        own = {
            row: {p: uv for p, uv in here.items() if p in points}
            for row, here in self.places.items()
        }
        return Annotations({row: here for row, here in own.items() if here}, self.whole_extent)

    def part(self, begin: int, end: int) -> Annotations:
        """Return the rows from ``begin`` up to ``end``, counted from ``begin``."""
        places = {r - begin: here for r, here in self.places.items() if begin <= r < end}
        return Annotations(places, self.whole_extent)

    def extent(self) -> float:
        """Return the largest distance of two points in one frame, the median over frames; or NaN.

        Frames in which only a part of the points could be placed say too little, so only
        those with the most points count. Where each frame has one, all frames together do.
        What all calibrated views say together goes before it.
        """
        if self.whole_extent is not None:
            return self.whole_extent
        most = max((len(here) for here in self.places.values()), default=0)
        if most < 2:
            uv = np.array([uv for here in self.places.values() for uv in here.values()])
            size = np.linalg.norm(uv[:, None] - uv, axis=-1).max() if len(self.points) > 1 else 0.0
            return float(size) if size > 0 else float("nan")
        sizes = []
        for here in self.places.values():
            if len(here) == most:
                uv = np.array(list(here.values()))
                sizes.append(np.linalg.norm(uv[:, None] - uv, axis=-1).max())
        return float(np.median(sizes))

    def moved(self, to: FloatArray) -> Annotations:
        """Return the places after a map (n, 2, 3) for each row."""
        return Annotations(
            {
                row: {point: to[row, :, :2] @ uv + to[row, :, 2] for point, uv in here.items()}
                for row, here in self.places.items()
            }
        )


def annotations_of_view(
    placed: Mapping[int, Sequence[Placement]], view: int, first: int
) -> Annotations:
    """Return what was placed in one view.

    Parameters
    ----------
    placed : mapping
        Frame to placements.
    view : int
        The view's number.
    first : int
        The frame that is row 0.

    Returns
    -------
    Annotations
        The view's own.
    """
    places: dict[int, dict[int, np.ndarray]] = {}
    for frame, here in placed.items():
        own = {place.point: np.asarray(place.uv, float) for place in here if place.view == view}
        if own:
            places[frame - first] = own
    return Annotations(places)
