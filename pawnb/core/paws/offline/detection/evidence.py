"""What every kind of evidence yields, and the protocol of one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Protocol

import numpy as np

from pawnb.arrays import Float32Array, FloatArray
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.scene.stack import BodyStack
from pawnb.errors import InputError, PawnbError

ENTRY_POINTS = "pawnb.evidence"
"""Group of entry points under which other packages offer kinds of evidence."""


@dataclass(frozen=True)
class Detections:
    """Places at which points were found in one view; m in all.

    Parameters
    ----------
    row, point : ndarray of int, shape (m,)
        Row (frame, counted from the first that is tracked) and number of the point.
    uv : ndarray, shape (m, 2)
        Position, px of the view.
    log_odds : ndarray, shape (m,)
        Logarithm of how much likelier the point is there than at a place without evidence.
    sd_px : ndarray, shape (m,)
        Standard deviation of the position, px of the view.
    """

    row: np.ndarray
    point: np.ndarray
    uv: np.ndarray
    log_odds: np.ndarray
    sd_px: np.ndarray

    def within(self, n: int) -> Detections:
        """Return those of the first n rows that have a position."""
        return self._where((self.row >= 0) & (self.row < n) & np.isfinite(self.uv).all(axis=1))

    def part(self, begin: int, end: int) -> Detections:
        """Return those of the rows from ``begin`` up to ``end``, counted from ``begin``."""
        return self._where((self.row >= begin) & (self.row < end)).moved(-begin)

    def of(self, points: Sequence[int]) -> Detections:
        """Return those of some points."""
        return self._where(np.isin(self.point, list(points)))

    def moved(self, rows: int) -> Detections:
        """Return the same so many rows later."""
        return dataclasses.replace(self, row=self.row + rows)

    def joined(self, others: Detections) -> Detections:
        """Return these and others."""
        pairs = zip(self._columns(), others._columns(), strict=True)
        return Detections(*(np.concatenate(pair) for pair in pairs))

    def _where(self, kept: np.ndarray) -> Detections:
        return Detections(*(a[kept] for a in self._columns()))

    def _columns(self) -> tuple[np.ndarray, ...]:
        return self.row, self.point, self.uv, self.log_odds, self.sd_px


class EvidenceKind(Protocol):
    """A kind of evidence of its own, for example another program's predictions.

    Offer it as an entry point of the group ``pawnb.evidence``: a class that can be called
    without arguments.
    """

    name: str

    def detect(
        self, view: str, stack: BodyStack, annotations: Annotations, *, points: tuple[str, ...]
    ) -> Detections:
        """Return where points were found in a view.

        Parameters
        ----------
        view : str
            Its name.
        stack : BodyStack
            Its pictures in the body's frame.
        annotations : Annotations
            What was placed in it by hand.
        points : tuple of str
            Names of the points, by number.

        Returns
        -------
        Detections
            Any number for a point and row.
        """
        ...


def installed_evidence() -> list[EvidenceKind]:
    """Return the kinds of evidence that other installed packages offer.

    Raises
    ------
    InputError
        If one of them cannot be loaded.
    """
    kinds: list[EvidenceKind] = []
    for entry in entry_points(group=ENTRY_POINTS):
        try:
            kinds.append(entry.load()())
        except Exception as error:
            raise InputError(
                f"the kind of evidence {entry.name!r} of {entry.value} cannot be used: {error}; "
                "mend or remove the package that offers it."
            ) from error
    return kinds


def found_by(
    kind: EvidenceKind,
    view: str,
    stack: BodyStack,
    *,
    annotations: Annotations,
    points: tuple[str, ...],
) -> Detections:
    """Return what a kind of evidence finds in a view, if it is what a tracker can use.

    Parameters
    ----------
    kind, view, stack, annotations, points
        The kind, and what its ``detect`` is called with.

    Returns
    -------
    Detections
        As arrays; places without a position are left out later (:meth:`Detections.within`).

    Raises
    ------
    InputError
        If it fails, or what it returns are no detections: arrays of other lengths, points that
        there are not, log odds or standard deviations that are no numbers.
    """
    try:
        found = kind.detect(view, stack, annotations=annotations, points=points)
        row, point = (np.asarray(a) for a in (found.row, found.point))
        uv, odds, sd = (np.asarray(a, dtype=float) for a in (found.uv, found.log_odds, found.sd_px))
    except PawnbError:
        raise
    except Exception as error:
        raise InputError(_of_kind(kind, view, f"fails: {type(error).__name__}: {error}")) from error
    m = len(row) if row.ndim == 1 else -1
    shapes = (row.shape, point.shape, uv.shape, odds.shape, sd.shape)
    placed = np.isfinite(uv).all(axis=-1) if uv.ndim == 2 else np.zeros(0, bool)
    fault = ""
    if shapes != ((m,), (m,), (m, 2), (m,), (m,)):
        fault = "returns row, point, uv, log_odds and sd_px of shapes " + ", ".join(
            map(str, shapes)
        )
    elif m and not (row.dtype.kind in "iu" and point.dtype.kind in "iu"):
        fault = "returns rows or points that are no whole numbers"
    elif m and not (point.min() >= 0 and point.max() < len(points)):
        fault = f"returns points {point.min()} to {point.max()}; there are 0 to {len(points) - 1}"
    elif not (np.isfinite(odds[placed]).all() and np.isfinite(sd[placed]).all()):
        fault = "returns log_odds or sd_px that are no finite numbers"
    elif (sd[placed] < 0).any():
        fault = "returns an sd_px below 0"
    if fault:
        raise InputError(_of_kind(kind, view, fault))
    return Detections(row, point, uv, odds, sd)


def _of_kind(kind: EvidenceKind, view: str, fault: str) -> str:
    """Return a sentence on a kind of evidence that cannot be used."""
    name = getattr(kind, "name", type(kind).__name__)
    return (
        f"the kind of evidence {name!r} {fault} (view {view!r}); mend or remove the package that "
        "offers it."
    )


def paint(found: Detections, stack: BodyStack, point: int) -> Float32Array:
    """Return a point's detections as ratios of likelihoods over places.

    Parameters
    ----------
    found : Detections
        In the same view.
    stack : BodyStack
        The view.
    point : int
        The point.

    Returns
    -------
    ndarray of float32, shape (n, h, w)
        1 where nothing was found.
    """
    n, h, w = stack.shape
    ratio = np.ones((n, h, w), np.float32)
    own = found.within(n)
    spread = stack.scale / stack.spacing
    for i in np.flatnonzero(own.point == point):
        row = own.row[i]
        x, y = stack.grid_of(own.uv[i], row)
        sd = max(own.sd_px[i] * spread, 0.5)
        reach = int(np.ceil(4 * sd))
        x0, x1 = max(0, int(x) - reach), min(w, int(x) + reach + 2)
        y0, y1 = max(0, int(y) - reach), min(h, int(y) + reach + 2)
        if x0 < x1 and y0 < y1:
            bump = bump_at((y1 - y0, x1 - x0), (x - x0, y - y0), sd)
            ratio[row, y0:y1, x0:x1] += np.exp(own.log_odds[i]) * bump
    return ratio


def bump_at(shape: tuple[int, int], place: Sequence[float] | FloatArray, sd: float) -> Float32Array:
    """Return a Gaussian of height 1 about a place (x, y), float32.

    Parameters
    ----------
    shape : tuple of int
        Rows and columns.
    place : sequence of float
        x and y of its top.
    sd : float
        Standard deviation, in places.

    Returns
    -------
    ndarray of float32, shape ``shape``
        The Gaussian.
    """
    x = np.exp(-((np.arange(shape[1]) - place[0]) ** 2) / (2 * sd**2))
    y = np.exp(-((np.arange(shape[0]) - place[1]) ** 2) / (2 * sd**2))
    return np.outer(y, x).astype(np.float32)
