"""Tracklets: places that may be a point, joined from frame to frame until they meet others."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array, FloatArray, IntArray
from pawnb.core.paws.offline.association.parameters import LINKS
from pawnb.core.paws.offline.parameters import IdentityParameters

_NINE_PIXELS: np.ndarray = np.ones((3, 3), np.uint8)
"""Layout: the neighbours of a place."""
_ABOUT = np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), axis=-1).reshape(9, 2)
"""Layout: steps to them."""
_SAME_PLACE = 1e-6
"""Numerics: a clicked place is a candidate as it is; places of the grid."""


@dataclass(frozen=True)
class ViewTracklet:
    """One thing in consecutive rows that may be any of the points.

    Parameters
    ----------
    begin : int
        Its first row.
    places : ndarray, shape (m, 2)
        Places of the grid (x, y) in rows ``begin`` to ``end``.
    first_step, last_step : ndarray, shape (2,)
        Velocity at its begin and at its end, in places per row.
    rows_before_cut : int, optional
        How many rows the tracklet had that it was cut from; 0 where it was not cut.
    """

    begin: int
    places: FloatArray
    first_step: FloatArray
    last_step: FloatArray
    rows_before_cut: int = 0

    @property
    def end(self) -> int:
        """Its last row."""
        return self.begin + len(self.places) - 1

    @property
    def rows(self) -> IntArray:
        """Its rows."""
        return np.arange(self.begin, self.end + 1)

    def passes(self, row: int, place: FloatArray) -> bool:
        """Tell whether it was at a place in a row, as it is at places that were clicked."""
        if not self.begin <= row <= self.end:
            return False
        return bool(np.linalg.norm(self.places[row - self.begin] - place) < _SAME_PLACE)

    def cut(self, row: int) -> list[ViewTracklet]:
        """Return what comes before a row, and what begins with it."""
        m = row - self.begin
        if not 0 < m < len(self.places):
            return [self]
        near = self.places[max(0, m - LINKS.velocity_rows) : m + LINKS.velocity_rows]
        step = (near[-1] - near[0]) / (len(near) - 1)
        before = self.rows_before_cut or len(self.places)
        return [
            ViewTracklet(self.begin, self.places[:m], self.first_step, step, before),
            ViewTracklet(row, self.places[m:], step, self.last_step, before),
        ]


def find_candidates(
    score: Float32Array,
    *,
    sure: Sequence[FloatArray],
    most: int,
    radius: float,
    parameters: IdentityParameters,
) -> FloatArray:
    """Return the highest peaks of one frame.

    Parameters
    ----------
    score : ndarray of float32, shape (h, w)
        How likely any point is at a place, 0 to 1.
    sure : sequence of ndarray (2,)
        Clicked places; they come first, in order, however near to each other.
    most : int
        How many peaks at most.
    radius : float
        About half a paw, in places.
    parameters : IdentityParameters
        The stage's parameters.

    Returns
    -------
    ndarray, shape (m, 2)
        Places (x, y); peaks are ``apart`` radii from each other and from what is sure.
    """
    apart = parameters.apart * radius
    smooth = cv2.GaussianBlur(score, (0, 0), LINKS.peak_blur)
    left = np.where(smooth >= cv2.dilate(smooth, _NINE_PIXELS), smooth, 0)
    h, w = left.shape
    found = [np.asarray(place, float) for place in sure]

    def close(place: FloatArray) -> None:
        x0, x1 = max(0, int(place[0] - apart)), min(w, int(place[0] + apart) + 2)
        y0, y1 = max(0, int(place[1] - apart)), min(h, int(place[1] + apart) + 2)
        y, x = np.ogrid[y0:y1, x0:x1]
        part = left[y0:y1, x0:x1]
        part[(x - place[0]) ** 2 + (y - place[1]) ** 2 < apart**2] = 0

    for place in found:
        close(place)
    for _ in range(most):
        top = int(left.argmax())
        y, x = divmod(top, w)
        if left[y, x] < parameters.least:
            break
        y0, y1, x0, x1 = max(0, y - 1), min(h, y + 2), max(0, x - 1), min(w, x + 2)
        part = smooth[y0:y1, x0:x1] - smooth[y0:y1, x0:x1].min() + 1e-6
        place = np.array(
            [part.sum(axis=0) @ np.arange(x0, x1), part.sum(axis=1) @ np.arange(y0, y1)]
        )
        found.append(place / part.sum())
        close(np.array([x, y], float))
    return np.array(found).reshape(-1, 2)


def link(
    candidates: Sequence[FloatArray],
    forward: Float32Array,
    backward: Float32Array,
    *,
    radius: float,
    parameters: IdentityParameters,
) -> list[ViewTracklet]:
    """Join candidates of neighbouring frames where there is no choice.

    Two that come so near to each other that either may be the other's continuation are both cut
    there; one that is not seen for ``coasting`` rows, too.

    Parameters
    ----------
    candidates : sequence of ndarray (m, 2)
        For every row, places of the grid.
    forward, backward : ndarray of float32, shape (n - 1, h, w, 2)
        Optical flow, in places.
    radius : float
        About half a paw, in places.
    parameters : IdentityParameters
        The stage's parameters.

    Returns
    -------
    list of ViewTracklet
        In order of their first rows.
    """
    done: list[_Open] = []
    active = [_Open(0, place) for place in candidates[0]]
    for t in range(len(candidates) - 1):
        new = candidates[t + 1]
        pairs, fated = _match(active, new, forward[t], backward[t], radius)
        matched, kept = set(), []
        for i, one in enumerate(active):
            if i in pairs:
                one.go(new[pairs[i]], seen=True)
                matched.add(pairs[i])
                kept.append(one)
            elif i in fated or one.unseen >= parameters.coasting:
                done.append(one)
            else:
                one.go(one.places[-1] + _at(forward[t], one.places[-1]), seen=False)
                kept.append(one)
        kept += [_Open(t + 1, place) for j, place in enumerate(new) if j not in matched]
        active = kept
    done += active
    found = [one.closed(forward) for one in done]
    return sorted(found, key=lambda one: (one.begin, one.end))


def cut_at_meetings(tracklets: Sequence[ViewTracklet], radius: float) -> list[ViewTracklet]:
    """Cut tracklets where others begin or end beside them: either may be what went on.

    Candidates of one frame are not nearer to each other than ``apart`` radii. Of two that pass each
    other one is not seen meanwhile, so where it comes out again neither has a rival in one frame.

    Parameters
    ----------
    tracklets : sequence of ViewTracklet
        The tracklets.
    radius : float
        About half a paw, in places of the grid.

    Returns
    -------
    list of ViewTracklet
        In order of their first rows.
    """
    near = LINKS.beside_radii * radius
    events = [(one.begin, one.begin, one.places[0]) for one in tracklets]
    events += [(one.end, one.end + 1, one.places[-1]) for one in tracklets]
    parts = []
    for one in tracklets:
        rows = {
            cut
            for row, cut, place in events
            if one.begin < row < one.end
            and np.linalg.norm(one.places[row - one.begin] - place) < near
        }
        left = [one]
        for row in sorted(rows):
            left += left.pop().cut(row)
        parts += left
    return sorted(parts, key=lambda one: (one.begin, one.end))


def cut_between_clicks(
    tracklets: Sequence[ViewTracklet], clicked: Sequence[tuple[int, FloatArray]]
) -> list[ViewTracklet]:
    """Cut tracklets in which one point was clicked where they last beside each other.

    The point is in one of them only, so the end of the earlier one or the begin of the later one
    is something else. Each part is given to a point by itself; no click is lost.

    Parameters
    ----------
    tracklets : sequence of ViewTracklet
        The tracklets.
    clicked : sequence of (int, ndarray (2,))
        Rows and places at which the point was clicked, in order of rows.

    Returns
    -------
    list of ViewTracklet
        In order of their first rows.
    """
    left = list(tracklets)
    for (row, place), (next_row, next_place) in itertools.pairwise(clicked):
        one = next((own for own in left if own.passes(row, place)), None)
        other = next((own for own in left if own.passes(next_row, next_place)), None)
        if one is None or other is None or one is other or other.begin > one.end:
            continue
        end, begin = max(other.begin - 1, row), min(one.end + 1, next_row)
        left = [own for own in left if own is not one and own is not other]
        left += [*one.cut(end + 1), *other.cut(begin)]
    return sorted(left, key=lambda own: (own.begin, own.end))


class _Open:
    """A tracklet that is still going on."""

    def __init__(self, begin: int, place: FloatArray) -> None:
        self.begin, self.places, self.unseen = begin, [np.asarray(place, float)], 0

    def go(self, place: FloatArray, *, seen: bool) -> None:
        self.places.append(place)
        self.unseen = 0 if seen else self.unseen + 1

    def velocity(self) -> FloatArray | None:
        last = self.places[-LINKS.velocity_rows :]
        return None if len(last) < 3 else (last[-1] - last[0]) / (len(last) - 1)

    def closed(self, forward: Float32Array) -> ViewTracklet:
        """Return it without what was not seen at its end."""
        places = np.array(self.places[: len(self.places) - self.unseen])
        ends = []
        for some in (
            places[: LINKS.velocity_rows],
            places[-LINKS.velocity_rows :],
        ):
            ends.append((some[-1] - some[0]) / max(len(some) - 1, 1))
        if len(places) == 1 and len(forward):
            step = _at(forward[min(self.begin, len(forward) - 1)], places[0])
            ends = [step, step]
        return ViewTracklet(self.begin, places, ends[0], ends[1])


def _match(
    active: Sequence[_Open],
    new: FloatArray,
    forward: Float32Array,
    backward: Float32Array,
    radius: float,
) -> tuple[dict[int, int], set[int]]:
    """Return which goes on as which without any doubt, and which have met another."""
    if not len(active) or not len(new):
        return {}, set()
    here = np.array([one.places[-1] for one in active])
    steps = _at(forward, here)
    back = new + _at(backward, new)
    away = np.linalg.norm((here + steps)[:, None] - new, axis=-1)
    away = (away + np.linalg.norm(here[:, None] - back, axis=-1)) / 2
    velocities = [one.velocity() for one in active]
    known = np.array([step is not None for step in velocities])
    if known.any():
        ahead = here[known] + np.array([step for step in velocities if step is not None])
        away[known] = np.minimum(away[known], np.linalg.norm(ahead[:, None] - new, axis=-1))
    nearest = away.argmin(axis=1)
    row = np.arange(len(active))
    best = away[row, nearest]
    others = away.copy()
    others[row, nearest] = np.inf
    # of each new place: how near the nearest comes, and the nearest but one
    lowest, second = np.sort(np.vstack([away, np.full(len(new), np.inf)]), axis=0)[:2, nearest]
    rival = np.minimum(others.min(axis=1), np.where(best <= lowest, second, lowest))
    goes = best <= radius
    met = goes & (rival < best + LINKS.met_radii * radius)
    pairs = {int(i): int(nearest[i]) for i in np.flatnonzero(goes & ~met)}
    return pairs, set(np.flatnonzero(met).tolist())


def _at(flow: Float32Array, places: FloatArray) -> FloatArray:
    """Return the mean flow (..., 2) of 3 x 3 places about each of some (..., 2)."""
    last = np.array(flow.shape[1::-1]) - 1
    middle = np.clip(np.rint(places), 0, last).astype(int)[..., None, :]
    near = middle + _ABOUT
    within = ((near >= 0) & (near <= last)).all(axis=-1, keepdims=True)
    near = np.where(within, near, middle)
    sums = (flow[near[..., 1], near[..., 0]] * within).sum(axis=-2, dtype=float)
    return np.asarray(sums / within.sum(axis=-2))
