"""What looks wrong in which animal is which: pieces, animals found twice, exchanged animals."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.schema import Tracks

_HARDLY = 0.1
"""Share of the frames of the shorter of two tracks in which both are seen; below it they may be
pieces of one. Set by hand: programs begin a new piece some frames before the old one ends."""

_LYING_ON_ONE = 0.2
"""Of an animal's size (root mean square of points about their middle): points of two animals that
are nearer (median) are of one. Set by hand: two instances on one animal are some px apart, two
bodies by their width."""

_FRAMES_TO_BE_TWICE = 3
_EXCHANGED = 0.25
"""Of the way that each of two animals makes between two frames: where each is nearer than that to
where the other was, they have exchanged names. Animals cannot do it in a tenth of a second."""

_FAR = 0.3
"""Of an animal's size, by which both must have moved in an exchange. Set by hand: a fast mouse
moves by a tenth of it in a frame at 100 frames a second."""

_LONGEST_S = 0.1


def notes_on_identities(name: str, tracks: Tracks) -> Iterator[str]:
    """Say where the animals of a file may not be what their names say.

    Parameters
    ----------
    name : str
        What the notes call the file.
    tracks : xarray.Dataset
        Its tracks.

    Yields
    ------
    str
        Of animals that are never, or hardly ever, seen in one frame; of two that lie on one
        another; of two that exchange places from one frame to the next.
    """
    places = _places(tracks)
    seen = np.asarray(np.isfinite(places).any(axis=(2, 3)))
    animals = [str(one) for one in tracks["individual"].to_numpy()]
    alive = [i for i in range(len(animals)) if seen[:, i].any()]
    if len(alive) < 2:
        return
    yield from _pieces(name, [animals[i] for i in alive], seen[:, alive])
    frames = tracks["frame"].to_numpy()
    longest = max(1.0, _LONGEST_S * float(tracks.attrs["fps"]))
    for one, other in combinations(alive, 2):
        both = np.flatnonzero(seen[:, one] & seen[:, other])
        pair = places[both][:, [one, other]]
        size = _size(pair)
        if not len(both) or not size > 0.0:
            continue
        names = f"{name}: {animals[one]} and {animals[other]}"
        yield from _twice(names, pair, frames[both], size=size)
        yield from _exchanges(names, pair, frames[both], size=size, longest=longest)


def _places(tracks: Tracks) -> FloatArray:
    """Return places (n, individuals, points, axes), in the pictures where there are none else."""
    name = "position"
    if "image_position" in tracks and not np.isfinite(tracks[name]).any():
        name = "image_position"
    order = ("time", "individual", "keypoint")
    values = tracks[name].transpose(*order, ...).to_numpy()
    # each view shows the points once more
    return np.asarray(values.reshape(*values.shape[:2], -1, values.shape[-1]), dtype=float)


def _pieces(name: str, animals: list[str], seen: BoolArray) -> Iterator[str]:
    """Name animals that are hardly ever seen together with one of the others."""
    counts = seen.astype(float)
    shared = counts.T @ counts  # frames in which both are seen; on the diagonal one of them
    own = np.diag(shared)
    few = shared < _HARDLY * np.minimum(own, own[:, None])
    pieces = [animal for animal, apart in zip(animals, few.any(axis=0), strict=True) if apart]
    if pieces:
        often = "never" if (shared[few] == 0.0).all() else "hardly ever"
        yield (
            f"{name}: {' and '.join(pieces)} are {often} seen in one frame. Where they are pieces "
            "of the track of one animal, they must not count as animals: join them in the program "
            "that made them."
        )


def _size(pair: FloatArray) -> float:
    """Return how far points lie from the middle of their animal: root mean square, the median."""
    known = np.isfinite(pair)
    n = np.maximum(1, known.sum(axis=2, keepdims=True))
    middle = np.where(known, pair, 0.0).sum(axis=2, keepdims=True) / n
    square = np.where(known, pair - middle, 0.0) ** 2
    spread = np.sqrt(square.sum(axis=(2, 3)) / n[:, :, 0, 0])
    enough = known.any(axis=3).sum(axis=2) > 1
    return float(np.median(spread[enough])) if enough.any() else 0.0


def _apart(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the (upper) median distance between points of one name; infinite where none is."""
    distance = np.sort(np.sqrt(((one - other) ** 2).sum(axis=2)), axis=1)  # NaN last
    known = np.isfinite(distance).sum(axis=1)
    middle = distance[np.arange(len(distance)), known // 2]
    return np.where(known > 0, middle, np.inf)


def _twice(names: str, pair: FloatArray, frames: IntArray, *, size: float) -> Iterator[str]:
    """Say where two animals are one."""
    same = np.flatnonzero(_apart(pair[:, 0], pair[:, 1]) < _LYING_ON_ONE * size)
    if len(same) >= _FRAMES_TO_BE_TWICE:
        yield (
            f"{names} lie on one another in {len(same)} of the {len(frames)} frames in which both "
            f"are seen, first in frame {frames[same[0]]}: one animal was found twice there and "
            "counts as two. Delete the second one in the program that made these tracks."
        )


def _exchanges(
    names: str, pair: FloatArray, frames: IntArray, *, size: float, longest: float
) -> Iterator[str]:
    """Say where two animals take each other's place from one frame to the next."""
    before, after = pair[:-1], pair[1:]
    near = np.diff(frames) <= longest
    moved = np.minimum(*(_apart(before[:, i], after[:, i]) for i in (0, 1)))
    crossed = np.maximum(*(_apart(before[:, i], after[:, 1 - i]) for i in (0, 1)))
    at = np.flatnonzero(near & np.isfinite(moved) & (moved > _FAR * size))
    at = at[crossed[at] < _EXCHANGED * moved[at]]
    if len(at):
        times = "once" if len(at) == 1 else f"{len(at)} times"
        yield (
            f"{names} take each other's place {times}, first from frame {frames[at[0]]} to "
            f"{frames[at[0] + 1]}: their names were exchanged there, and the steps of both are "
            "mixed. Exchange them back in the program that made these tracks."
        )
