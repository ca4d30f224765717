"""Where points meet, pieces of path are cut: who went on which way is decided later.

A hind paw that lands where a front paw lifts off takes over its place, and the front paw
its speed: the smoothest paths there are those of changed identities. So no piece leads
through a meeting, and where each point usually is decides between the ways on.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet, joined

_STANDS, _SLIDES = 0.5, 0.6
"""A paw that stands stays within so many thicknesses of its place on the ground, and does not
stand again as many farther on."""
_BETWEEN = 2
"""Frames before and after such a slide that belong to neither place."""


def cut_meetings(pieces: Sequence[Tracklet], apart: float) -> list[Tracklet]:
    """Cut pieces where they come near each other: at the first, the nearest and the last frame.

    Parameters
    ----------
    pieces : sequence of Tracklet
        Pieces of path.
    apart : float
        Distance at which points meet.

    Returns
    -------
    list of Tracklet
        The parts, in the order of their first frames.
    """
    cuts: list[set[int]] = [set() for _ in pieces]
    order = sorted(range(len(pieces)), key=lambda i: pieces[i].first)
    for place, i in enumerate(order):
        for j in order[place + 1 :]:
            if pieces[j].first > pieces[i].last:
                break
            for one, other in ((i, j), (j, i)):
                cuts[one].update(_cuts(pieces[one], pieces[other], apart))
    parts = [part for piece, own in zip(pieces, cuts, strict=True) for part in _split(piece, own)]
    return sorted(parts, key=lambda piece: piece.first)


def _cuts(one: Tracklet, other: Tracklet, apart: float) -> set[int]:
    """Return the frames with which new parts of ``one`` begin because of ``other``."""
    first, last = max(one.first, other.first), min(one.last, other.last)
    if first > last:
        return set()
    step = one.at[first - one.first : last - one.first + 1]
    step = step - other.at[first - other.first : last - other.first + 1]
    away = np.linalg.norm(step, axis=1)
    near = np.concatenate([[False], away < apart, [False]])
    cuts = set()
    for start, end in np.flatnonzero(np.diff(near.astype(int))).reshape(-1, 2).tolist():
        nearest = start + int(away[start:end].argmin())
        cuts |= {first + start, first + nearest, first + end}
    return cuts


def cut_takeovers(pieces: Sequence[Tracklet], apart: float, frames: int) -> list[Tracklet]:
    """Cut pieces where another ends or begins beside them: one point may have taken over.

    Where two paws come together only one of them has a place for a while, and the piece of
    one may go on as the other. It then has a bend, and there it is cut.

    Parameters
    ----------
    pieces : sequence of Tracklet
        Pieces of path.
    apart : float
        Distance at which a piece that ends is beside another.
    frames : int
        Frames about the end in which the bend is looked for.

    Returns
    -------
    list of Tracklet
        The parts, in the order of their first frames.
    """
    cuts: list[set[int]] = [set() for _ in pieces]
    for i, t in beside_ends(pieces, apart):
        piece = pieces[i]
        low = max(t - frames, piece.first + 1)
        high = min(t + frames, piece.last - 1)
        bend = np.linalg.norm(np.diff(piece.at[low - piece.first - 1 :], n=2, axis=0), axis=1)
        if high >= low:
            cuts[i].add(low + 1 + int(bend[: high - low + 1].argmax()))
    parts = [part for piece, own in zip(pieces, cuts, strict=True) for part in _split(piece, own)]
    return sorted(parts, key=lambda piece: piece.first)


def cut_slides(
    pieces: Sequence[Tracklet],
    *,
    drift: np.ndarray,
    axes: np.ndarray,
    thickness: float,
    frames: int,
) -> list[Tracklet]:
    """Cut pieces that stand on one place of the ground and then on another close by.

    No paw slides on. A hind paw landed just where a front paw lifted off, and the piece of one
    goes on as the other; where that one had no piece of its own nothing else tells of it.

    Parameters
    ----------
    pieces : sequence of Tracklet
        Pieces of path.
    drift : ndarray, shape (d,)
        Speed of the ground, length per frame.
    axes : ndarray, shape (2, d)
        Unit vectors forward and up: that a paw stands is told along them, as depth may be vague.
    thickness : float
        Thickness of a paw.
    frames : int
        Frames for which a paw goes with the ground to be known to stand, three at least.

    Returns
    -------
    list of Tracklet
        The parts, in the order of their first frames.
    """
    parts = []
    for piece in pieces:
        still = piece.at - np.arange(len(piece.picks))[:, None] * drift
        parts += _split(piece, {piece.first + i for i in _slides(still, axes, thickness, frames)})
    return sorted(parts, key=lambda piece: piece.first)


def _slides(still: np.ndarray, axes: np.ndarray, thickness: float, frames: int) -> list[int]:
    """Return where places on the ground (n, d) slide: the first frame after each slide's middle."""
    apart = frames + 2 * _BETWEEN
    if len(still) < apart + frames:
        return []
    window = np.lib.stride_tricks.sliding_window_view(still, frames, axis=0)
    place = np.median(window, axis=-1)
    stands = np.ptp(axes @ window, axis=-1).max(axis=1) < _STANDS * thickness
    step = np.linalg.norm(place[apart:] - place[:-apart], axis=1)
    step = np.where(stands[apart:] & stands[:-apart], step, 0.0)
    slid = np.concatenate([[False], step > _SLIDES * thickness, [False]])
    edges = np.flatnonzero(np.diff(slid.astype(int))).reshape(-1, 2).tolist()
    return [(a + b - 1) // 2 + frames + _BETWEEN for a, b in edges]


def beside_ends(pieces: Sequence[Tracklet], apart: float) -> list[tuple[int, int]]:
    """Return the pieces beside which another begins or ends while they go on, and the frames."""
    if not pieces:
        return []
    frame, at, begins = joined(pieces)
    piece = np.repeat(np.arange(len(pieces)), [len(one.picks) for one in pieces])
    first = frame[begins]
    ends = np.append(begins[1:], len(frame)) - 1
    last = frame[ends]
    # the first place and the last of every piece, each with all places of its frame
    own = np.concatenate([begins, ends])
    order = np.argsort(frame, kind="stable")
    low, high = (np.searchsorted(frame[order], frame[own], side) for side in ("left", "right"))
    which = np.repeat(np.arange(len(own)), high - low)
    there = order[np.arange(len(which)) - np.repeat(np.cumsum(high - low) - high, high - low)]
    t, i = frame[own[which]], piece[there]
    near = (first[i] < t) & (last[i] > t) & (i != piece[own[which]])
    near &= np.linalg.norm(at[there] - at[own[which]], axis=1) <= apart
    return list(zip(i[near].tolist(), t[near].tolist(), strict=True))


def _split(piece: Tracklet, cuts: set[int]) -> list[Tracklet]:
    """Return the parts of a piece; new ones begin with the frames of the cuts."""
    inside = sorted(cut - piece.first for cut in cuts if piece.first < cut <= piece.last)
    bounds = [0, *inside, len(piece.picks)]
    return [
        Tracklet(piece.first + a, piece.picks[a:b], piece.at[a:b], piece.cost[a:b])
        for a, b in itertools.pairwise(bounds)
    ]
