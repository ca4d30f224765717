"""Evidence of a point tracker: a network that was trained elsewhere follows every click.

From a click a point is followed to the next and to the previous click of it, so that every click
is found without its own help: how far from clicks paths end says how far they are believed
(:mod:`.reliability`). Long recordings are looked at in pieces that overlap. Where a click lies
outside a piece, its path goes on from the surest place of the overlap, and is at most as sure as
that; where none is sure, it ends.
"""

from __future__ import annotations

import dataclasses
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.parameters import values_in_force
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.detection.parameters import POINT_TRACKER
from pawnb.core.paws.offline.detection.point_tracking.reliability import (
    PathEnd,
    find_reliability,
)
from pawnb.core.paws.offline.parameters import APPEARANCE, RUN
from pawnb.core.paws.offline.scene.stack import BodyStack

_Looked: TypeAlias = tuple[FloatArray, FloatArray]
"""x, y (working px) and probability of a point in each row of a piece."""


class PointNetwork(Protocol):
    """What follows points through pictures, such as :class:`.tapir.Tapir`."""

    def follow(self, pictures: ByteArray, queries: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Follow points; see :meth:`.tapir.Tapir.follow`."""
        ...


@dataclass(frozen=True)
class _Query:
    """A click that is followed, in working px, and the first and last row that are asked for."""

    point: int
    row: int
    xy: tuple[float, float]
    first: int
    last: int

    def ahead(self, begun: int, step: int) -> range:
        """Return the rows that are asked for from one on, ahead (1) or behind (-1)."""
        return range(begun, self.last + 1 if step > 0 else self.first - 1, step)


@dataclass(frozen=True)
class _Path:
    """Where a click was followed to: x, y (working px) and probability in each row."""

    query: _Query
    xy: FloatArray
    probability: FloatArray

    def serves(self, query: _Query) -> bool:
        """Tell whether it is that of a click, as far as is asked for."""
        own = self.query
        same = dataclasses.replace(query, first=own.first, last=own.last) == own
        return same and own.first <= query.first and own.last >= query.last


class KeptPaths:
    """Paths in pictures that were looked at before, as long as these are kept by others."""

    def __init__(self) -> None:
        self._of: dict[tuple[int, object], tuple[weakref.ref[ByteArray], list[_Path]]] = {}

    def of(self, stack: BodyStack) -> list[_Path]:
        """Return what was found in a stack by the parameters in force, to be added to."""
        self._of = {k: kept for k, kept in self._of.items() if kept[0]() is not None}
        asked = id(stack.grey), values_in_force(POINT_TRACKER)
        return self._of.setdefault(asked, (weakref.ref(stack.grey), []))[1]


@dataclass(frozen=True)
class PointTracker:
    """The kind of evidence (:class:`.evidence.EvidenceKind`).

    Parameters
    ----------
    network : PointNetwork
        What follows the points.
    name : str
        How a run calls it.
    stop : callable, optional
        Asked before each piece; when it answers True, nothing is found.
    kept : KeptPaths
        Paths of earlier runs on the same pictures: a click that is added is followed alone.
    """

    network: PointNetwork
    name: str = "point tracker"
    stop: Callable[[], bool] | None = None
    kept: KeptPaths = field(default_factory=KeptPaths)

    def detect(
        self, view: str, stack: BodyStack, annotations: Annotations, *, points: tuple[str, ...]
    ) -> Detections:
        """Return where the network follows the clicks of a view to.

        Parameters
        ----------
        view : str
            Its name; not used.
        stack : BodyStack
            Its pictures in the body's frame.
        annotations : Annotations
            The clicks.
        points : tuple of str
            Names of the points, by number; not used.

        Returns
        -------
        Detections
            At most two for each point and row: from the click before it, and from that after it.
            None where each point was clicked in one row.
        """
        del view, points
        placed = annotations.moved(stack.to_body)
        if all(len(placed.rows_of(point)) < 2 for point in placed.points):
            return _believed({}, stack, placed)  # no path could end at a click
        queries = _queries(placed, len(stack.grey))
        kept = self.kept.of(stack)
        new = [query for query in queries if not any(path.serves(query) for path in kept)]
        found = _follow(stack, new, self.network, self.stop)
        if found is None:
            return _believed({}, stack, placed)
        kept += found
        paths = {query: next(p for p in kept if p.serves(query)) for query in queries}
        return _believed(paths, stack, placed)


def _queries(placed: Annotations, n: int) -> list[_Query]:
    """Return the clicks, each with the rows of the previous and of the next one of its point."""
    queries = []
    for point in placed.points:
        rows = placed.rows_of(point)
        for before, row, after in zip([0, *rows], rows, [*rows[1:], n - 1], strict=False):
            x, y = placed.places[row][point]
            queries.append(_Query(point, row, (float(x), float(y)), before, after))
    return queries


def _believed(paths: Mapping[_Query, _Path], stack: BodyStack, placed: Annotations) -> Detections:
    """Return paths as far as they are believed; without the click from which each begins."""
    ends = list(_ends(paths, placed))
    near_px = RUN.weighing_near * APPEARANCE.radius
    reliability = find_reliability(ends, placed.points, near_px=near_px)
    found = []
    for query, path in paths.items():
        ratio = POINT_TRACKER.gain * path.probability * reliability.trust[query.point]
        for step in (1, -1):
            ahead = np.array(query.ahead(query.row + step, step)[: reliability.rows], int)
            rows = ahead[ratio[ahead] >= POINT_TRACKER.lowest]
            found.append(
                np.column_stack([rows, np.full(len(rows), query.point), path.xy[rows], ratio[rows]])
            )
    table = np.concatenate(found) if found else np.empty((0, 5))
    row = table[:, 0].astype(int)
    return Detections(
        row=row,
        point=table[:, 1].astype(int),
        uv=stack.picture_of(stack.to_grid(table[:, 2:4]), row),
        log_odds=np.log(table[:, 4]),
        sd_px=np.full(len(table), reliability.sd_px / stack.scale),
    )


def _ends(paths: Mapping[_Query, _Path], placed: Annotations) -> Iterator[PathEnd]:
    """Yield where paths are in the rows of the clicks to which they lead."""
    for query, path in paths.items():
        for row in {query.first, query.last}:
            clicked = placed.places.get(row, {}).get(query.point)
            # in its own row a path has no probability
            if clicked is not None and path.probability[row] > 0:
                off_px = float(np.linalg.norm(path.xy[row] - clicked))
                sure = float(path.probability[row])
                yield PathEnd(query.point, sure, off_px, abs(row - query.row))


@dataclass(frozen=True)
class _Start:
    """From where a point is followed in a piece: row, x, y (working px), how surely it is that."""

    row: int
    xy: tuple[float, float]
    sure: float = 1.0


def _follow(
    stack: BodyStack,
    queries: Sequence[_Query],
    network: PointNetwork,
    stop: Callable[[], bool] | None,
) -> list[_Path] | None:
    """Return the paths of clicks, piece by piece; None where it was stopped."""
    n = len(stack.grey)
    paths = [_Path(query, np.full((n, 2), np.nan), np.zeros(n)) for query in queries]
    if not queries:
        return paths
    pieces = _pieces(min(q.first for q in queries), 1 + max(q.last for q in queries))
    # a click is looked at once in each piece that shows it, and read both ways
    looked: dict[tuple[int, range], _Looked] = {}
    for step in (1, -1):
        carried: dict[int, _Start] = {}
        order = pieces[::step]
        for piece, following in zip(order, [*order[1:], range(0)], strict=True):
            if stop is not None and stop():
                return None
            clicked = {i: _Start(q.row, q.xy) for i, q in enumerate(queries) if q.row in piece}
            starts = {**carried, **clicked}
            asked = {i: start for i, start in starts.items() if (i, piece) not in looked}
            found = _look(stack, piece, asked, network)
            looked |= {(i, piece): own for i, own in found.items()}
            carried = {}
            for i, start in starts.items():
                own = looked[i, piece]
                _write(paths[i], own, piece, start.row + step, sure=start.sure, step=step)
                on = _surest(paths[i], piece, following, start.row + step, step)
                carried |= {} if on is None else {i: on}
    return paths


def _pieces(begin: int, end: int) -> list[range]:
    """Return the rows of each piece; neighbours overlap."""
    length, overlap = POINT_TRACKER.piece_rows, POINT_TRACKER.overlap_rows
    starts = range(begin, max(end - overlap, begin + 1), length - overlap)
    return [range(start, min(start + length, end)) for start in starts]


def _look(
    stack: BodyStack, piece: range, asked: Mapping[int, _Start], network: PointNetwork
) -> dict[int, _Looked]:
    """Return where points are in the rows of a piece, by the numbers of their clicks."""
    if not asked:
        return {}
    side = POINT_TRACKER.side_px
    shape = np.array(stack.grey.shape[:0:-1])
    rows = np.array([[start.row - piece.start] for start in asked.values()])
    # networks count px from the corner of the first, pawnb from its middle
    xy = (np.array([start.xy for start in asked.values()]) + 0.5) * side / shape
    places, probability = network.follow(_pictures(stack, piece, side), np.hstack([rows, xy]))
    found = zip(places * shape / side - 0.5, probability, strict=True)
    return dict(zip(asked, found, strict=True))


def _pictures(stack: BodyStack, piece: range, side: int) -> ByteArray:
    """Return the pictures of a piece in colour, as squares, as those that networks learn from."""
    pictures = np.empty((len(piece), side, side, 3), np.uint8)
    for picture, row in zip(pictures, piece, strict=True):
        grey = stack.grey[row]
        if stack.colour is None:
            whole = cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB)
        else:
            whole = cv2.cvtColor(np.dstack([grey, stack.colour[row]]), cv2.COLOR_LAB2RGB)
        picture[:] = cv2.resize(whole, (side, side), interpolation=cv2.INTER_AREA)
    return pictures


def _write(
    path: _Path, found: _Looked, piece: range, begun: int, *, sure: float, step: int
) -> None:
    """Take what was found in a piece from a row on, as far as is asked for.

    Parameters
    ----------
    path : _Path
        Takes it.
    found : tuple of ndarray
        Positions and probabilities in the rows of the piece.
    piece : range
        Its rows.
    begun : int
        The first row that is taken.
    sure : float
        How surely the point was followed from the right place.
    step : int
        1 ahead, -1 behind.
    """
    rows = np.array([row for row in path.query.ahead(begun, step) if row in piece], int)
    xy, probability = found
    path.xy[rows] = xy[rows - piece.start]
    path.probability[rows] = sure * probability[rows - piece.start]


def _surest(path: _Path, piece: range, following: range, begun: int, step: int) -> _Start | None:
    """Return from where a path goes on in the following piece; None where it ends."""
    ahead = path.query.ahead(begun, step)
    shared = [row for row in ahead if row in piece and row in following]
    if not shared or ahead[-1] in piece:
        return None
    best = max(shared, key=lambda row: path.probability[row])
    sure = float(path.probability[best])
    x, y = path.xy[best]
    return _Start(best, (float(x), float(y)), sure) if sure >= POINT_TRACKER.sure else None
