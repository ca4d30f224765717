"""The empty scene: mean and standard deviation of every pixel without the animal.

Pullar 2009, §3.2.1, Eq. 3.6 and 3.7.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, IntArray
from pawnb.core.pixels.grey import grey
from pawnb.core.pose.contrast import squared_gradient
from pawnb.core.pose.presence import KNOWN_FRAMES, Presence, find_animal_frames
from pawnb.core.video import open_view
from pawnb.core.video.views import ViewReader
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.signals.robust import MAD_TO_SD
from pawnb.trial import View

QUANTISATION_SD = 1 / math.sqrt(12)
"""Standard deviation of rounding to whole grey values: no pixel is known better."""
_MOST_EMPTY_FRAMES = 200
"""More empty frames than this add nothing to mean and standard deviation."""
_SAMPLED = 60
_KEPT_SDS, _KEPT_GREY = 3.0, 2.0
"""Values no further than this from a pixel's median tell its standard deviation."""
_BLOB_GREY, _BLOB_SDS = 12.0, 6.0
"""How far pixels that an animal covers differ from the empty scene, at least."""
_RARE = 0.15
"""Share of the frames in which a pixel must be uncovered to be known: some ten of those sampled."""
_BLOB_SHARE = 3e-4
"""Smallest animal, as a share of the picture's area."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Background:
    """The empty scene.

    Parameters
    ----------
    mean : ndarray of float32, shape (H, W)
        Mean grey value of every pixel (Eq. 3.6).
    sd : ndarray of float32, shape (H, W)
        Its standard deviation over time (Eq. 3.7), not below that of rounding to whole values.
    n_frames : int
        Frames it was estimated from.
    source : str
        Where it comes from, in words: ``frames 0 to 8``, ``picture empty.png``.
    doubt : str
        Why it may be wrong, and how to mend it; empty where no empty frame had to be guessed.
    """

    mean: np.ndarray
    sd: np.ndarray
    n_frames: int
    source: str
    doubt: str = ""


def find_background(
    reader: ViewReader,
    view: View,
    *,
    folder: Path,
    frames: tuple[int, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Background:
    """Find the empty scene of a view.

    Parameters
    ----------
    reader : ViewReader
        The open view.
    view : View
        Its description: the picture ``background`` is used, else ``background_frames``, else
        the empty frames that :func:`find_animal_frames` finds.
    folder : Path
        Folder that ``view.background`` is relative to.
    frames : tuple of int, optional
        Where to look for empty frames, first and one past the last; default: all.
    progress : callable, optional
        ``progress(done, total)`` in frames read, of the most that may have to be: where the animal
        is there from the first on, it ends earlier.

    Returns
    -------
    Background
        The empty scene.

    Raises
    ------
    InputError
        If the picture is missing or of another size than the view, or ``background_frames``
        reaches outside the recording.

    Warns
    -----
    InputWarning
        If no frame is empty: the median of every pixel over the recording is used instead
        (:func:`median_background`). Also if
        nothing moves at all.
    """
    if progress is not None:
        most = _most_read(view, frames or (0, reader.n_frames))
        reader = cast("ViewReader", _CountedFrames(reader, progress, most))
    if view.background is not None:
        return _from_picture(reader, view, Path(folder), frames)
    if view.background_frames is not None:
        first, stop = view.background_frames
        if not 0 <= first < stop <= reader.n_frames:
            raise InputError(
                f"view {view.name!r}: background_frames is {[first, stop]}, but the recording "
                f"has frames 0 to {reader.n_frames - 1}; name frames within it."
            )
        return mean_background(reader, range(first, stop))
    return _found(reader, view, frames or (0, reader.n_frames))


def _most_read(view: View, frames: tuple[int, int]) -> int:
    """Return how many frames are read at most to find the empty scene."""
    n = frames[1] - frames[0]
    if view.background is not None:
        return min(n, _SAMPLED)
    if view.background_frames is not None:
        return min(view.background_frames[1] - view.background_frames[0], _MOST_EMPTY_FRAMES)
    return min(n, _SAMPLED) + KNOWN_FRAMES + n + min(n, _MOST_EMPTY_FRAMES)


class _CountedFrames:
    """A reader that tells how many frames were read of it."""

    def __init__(self, reader: ViewReader, progress: Callable[[int, int], None], most: int) -> None:
        self._reader, self._progress, self._most = reader, progress, most
        self._count = itertools.count(1)

    def frame(self, index: int, /) -> Any:
        """Return a frame, and say so."""
        picture = self._reader.frame(index)
        self._progress(min(next(self._count), self._most), self._most)
        return picture

    def __getattr__(self, name: str) -> Any:
        """Return what the reader itself knows."""
        return getattr(self._reader, name)


def mean_background(reader: ViewReader, numbers: Iterable[int]) -> Background:
    """Estimate the empty scene from empty frames (Eq. 3.6, 3.7).

    Parameters
    ----------
    reader : ViewReader
        The view.
    numbers : iterable of int
        Two or more empty frames; of more than 200, 200 evenly spread ones are used.

    Returns
    -------
    Background
        Mean and standard deviation (n - 1) of each pixel.

    Raises
    ------
    InputError
        If there are fewer than two frames.
    """
    every = np.array(sorted(set(numbers)))
    if len(every) < 2:
        raise InputError(
            f"{len(every)} empty frame{'s' * (len(every) != 1)} for the background; expected two "
            "or more, to tell how much a pixel varies."
        )
    chosen = _spread(every, _MOST_EMPTY_FRAMES)
    shift = grey(reader.frame(int(chosen[0])).image()).astype(float)
    total, squares = np.zeros_like(shift), np.zeros_like(shift)
    for i in chosen:
        step = grey(reader.frame(int(i)).image()) - shift
        total += step
        squares += step**2
    n = len(chosen)
    variance = (squares - total**2 / n) / (n - 1)
    return Background(
        mean=(shift + total / n).astype(np.float32),
        sd=_floored(np.sqrt(np.maximum(variance, 0.0))),
        n_frames=n,
        source=_in_words(every),
    )


def median_background(reader: ViewReader, *, frames: tuple[int, int] | None = None) -> Background:
    """Estimate the empty scene as the median of every pixel over a recording.

    Parameters
    ----------
    reader : ViewReader
        The view.
    frames : tuple of int, optional
        First frame and one past the last; 60 evenly spread ones are used.

    Returns
    -------
    Background
        Median, and the standard deviation of the values near it. Where the median is the animal
        because it was there for most of the time, the values of the rest of it. That is the
        empty scene wherever the animal is away for a sixth of the time.
    """
    chosen = _spread(np.arange(*(frames or (0, reader.n_frames))), _SAMPLED)
    stack = _stack(reader, chosen)
    median, sd = _uncovered(stack, *_median_and_sd(stack))
    return Background(
        mean=median, sd=sd, n_frames=len(chosen), source=f"median of {len(chosen)} frames"
    )


def _found(reader: ViewReader, view: View, frames: tuple[int, int]) -> Background:
    """Return the background from frames found to be empty, or the median one."""
    first, stop = frames
    how = (
        f"name empty frames (background_frames) or a picture of the empty scene (background) "
        f"for view {view.name!r} if this is wrong."
    )
    median = median_background(reader, frames=frames)
    if stop - first < 2 * KNOWN_FRAMES:
        few = f"{stop - first} frames are too few to tell empty ones"
        return _doubted(median, f"{few}; the background is the {median.source}: {how}")
    known = mean_background(reader, range(first, first + KNOWN_FRAMES))
    if _shows_animal(known, median):
        return _doubted(
            median,
            f"no empty frames: the animal is there in frame {first} already; the background is "
            f"the {median.source}, right wherever the animal is away for a sixth of the time: "
            f"{how}",
        )
    presence = find_animal_frames(reader, frames=frames)
    if not _is_seen(reader, presence, known):
        still = f"nothing moves in frames {first} to {stop - 1}: they are all taken for empty"
        return _doubted(mean_background(reader, range(first, stop)), f"{still}; {how}")
    empty = presence.empty_frames()
    return mean_background(
        reader, empty if len(empty) >= KNOWN_FRAMES else range(first, first + KNOWN_FRAMES)
    )


def _doubted(background: Background, doubt: str) -> Background:
    """Return a background that may be wrong, and warn of it."""
    warn_of_input(doubt, InputWarning, stacklevel=4)
    return dataclasses.replace(background, doubt=doubt)


def _is_seen(reader: ViewReader, presence: Presence, known: Background) -> bool:
    """Say whether something as large as an animal is there in the frames that differ."""
    if presence.first is None or presence.last is None:
        return False
    middle = (presence.first + presence.last) // 2
    return bool(_blobs(grey(reader.frame(middle).image()) - known.mean, known))


def _shows_animal(known: Background, median: Background) -> bool:
    """Say whether frames thought to be empty show an animal that the median does not.

    Where the two differ in a blob, one of them shows an animal there: the one with more edges.
    """
    for blob in _blobs(known.mean - median.mean, median):
        near = cv2.dilate(blob, np.ones((5, 5), np.uint8)) > 0
        edges = [squared_gradient(picture)[near].sum() for picture in (known.mean, median.mean)]
        if edges[0] > edges[1]:
            return True
    return False


def _blobs(step: Float32Array, background: Background) -> list[np.ndarray]:
    """Return masks of what stands out of the background and is as large as an animal."""
    out = (_outstanding(step, background) != 0).astype(np.uint8)
    _, names, stats, _ = cv2.connectedComponentsWithStats(out, connectivity=8)
    large = np.flatnonzero(stats[:, cv2.CC_STAT_AREA] > _BLOB_SHARE * out.size)
    return [(names == i).astype(np.uint8) for i in large if i > 0]


def _outstanding(step: Float32Array, median: Background) -> Float32Array:
    """Return differences to the background, less the light's change, 0 where they are small."""
    step = step - np.median(step[::4, ::4])
    return np.where(np.abs(step) > np.maximum(_BLOB_GREY, _BLOB_SDS * median.sd), step, 0.0)


def _from_picture(
    reader: ViewReader, view: View, folder: Path, frames: tuple[int, int] | None
) -> Background:
    """Return the background from a picture, its noise from the recording."""
    name = str(view.background)
    mean = _read_picture(reader, view, folder)
    if mean.shape != (reader.height, reader.width):
        raise InputError(
            f"view {view.name!r}: the background {name} is {mean.shape[1]} x {mean.shape[0]} px, "
            f"but the view is {reader.width} x {reader.height} px; take it with the same camera "
            "settings."
        )
    chosen = _spread(np.arange(*(frames or (0, reader.n_frames))), _SAMPLED)
    _, sd = _median_and_sd(_stack(reader, chosen))
    return Background(mean=mean, sd=sd, n_frames=1, source=f"picture {name}")


def _read_picture(reader: ViewReader, view: View, folder: Path) -> Float32Array:
    """Return the grey picture, cropped and mirrored as the view unless it has its size already."""
    name = str(view.background)
    whole = dataclasses.replace(view, video=name, crop=None, mirror=False)
    with open_view(whole, folder, lens=reader.lens) as picture:
        if (picture.width, picture.height) == (reader.width, reader.height):
            return grey(picture.read(0))
    with open_view(dataclasses.replace(view, video=name), folder, lens=reader.lens) as picture:
        return grey(picture.read(0))


def _stack(reader: ViewReader, numbers: IntArray) -> ByteArray:
    """Return frames as grey values, uint8, shape (n, H, W)."""
    return np.stack(
        [np.round(grey(reader.frame(int(i)).image())).astype(np.uint8) for i in numbers]
    )


def _median_and_sd(stack: ByteArray) -> tuple[Float32Array, Float32Array]:
    """Return median and robust standard deviation of each pixel, a band of rows at a time."""
    median = np.empty(stack.shape[1:], np.float32)
    sd = np.empty_like(median)
    for v in range(0, stack.shape[1], 64):
        band = stack[:, v : v + 64].astype(np.float32)
        median[v : v + 64] = np.median(band, axis=0)
        away = np.abs(band - median[v : v + 64])
        # the median deviation of whole grey values is too coarse, but tells which values belong
        limit = np.maximum(_KEPT_SDS * MAD_TO_SD * np.median(away, axis=0), _KEPT_GREY)
        kept = away <= limit
        sd[v : v + 64] = np.sqrt((away**2 * kept).sum(axis=0) / kept.sum(axis=0))
    return median, _floored(sd)


def _uncovered(
    stack: np.ndarray, median: np.ndarray, sd: np.ndarray
) -> tuple[Float32Array, Float32Array]:
    """Return median and sd with the rarer values where the median shows the animal.

    A pixel that an animal comes over has two usual values. All over the picture either the
    brighter or the darker are the empty scene's: those that continue what lies around, without
    an edge where the animal's places end.
    """
    count = len(stack)
    rare = round(_RARE * (count - 1))
    dark, bright = np.empty_like(median), np.empty_like(median)
    for v in range(0, stack.shape[1], 64):
        band = np.sort(stack[:, v : v + 64], axis=0)
        dark[v : v + 64], bright[v : v + 64] = band[rare], band[count - 1 - rare]
    limit = max(_BLOB_GREY, _BLOB_SDS * float(np.median(sd)))
    covered = (bright - dark > limit).astype(np.uint8)
    covered = cv2.morphologyEx(covered, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    rim = cv2.morphologyEx(covered, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)) > 0
    edges = [float(squared_gradient(picture)[rim].sum()) for picture in (dark, bright)]
    empty = dark if edges[0] < edges[1] else bright
    wrong = (covered > 0) & (np.abs(median - empty) > limit)
    values = stack[:, wrong].astype(np.float32)
    kept = np.abs(values - empty[wrong]) < limit / 2.0
    n = np.maximum(kept.sum(axis=0), 1)
    median, sd = median.copy(), sd.copy()
    median[wrong] = (values * kept).sum(axis=0) / n
    sd[wrong] = np.sqrt((((values - median[wrong]) ** 2) * kept).sum(axis=0) / n)
    return median, _floored(sd)


def _floored(sd: np.ndarray) -> Float32Array:
    """Return standard deviations not below that of rounding."""
    return np.maximum(sd, QUANTISATION_SD).astype(np.float32)


def _spread(numbers: IntArray, most: int) -> IntArray:
    """Return at most so many of the numbers, evenly spread."""
    if len(numbers) <= most:
        return numbers
    return numbers[np.linspace(0, len(numbers) - 1, most).round().astype(int)]


def _in_words(numbers: IntArray) -> str:
    """Return frame numbers as runs: ``frames 0 to 8, 95 to 120``."""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
    text = [f"{r[0]} to {r[-1]}" if len(r) > 1 else str(r[0]) for r in runs]
    return (
        "frames "
        + ", ".join(text[:4])
        + (f" and {len(runs) - 4} more runs" if len(runs) > 4 else "")
    )
