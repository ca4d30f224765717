"""Whether a film shows a picture again where the animal went on: freezes, and films doubled.

A camera or a program that copies a film and cannot keep up writes the last picture again. Time
stamps say nothing of it, and a tracker finds every point where it was. The name is that of
FFmpeg's filter ``freezedetect``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import cv2
import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.pixels.grey import grey
from pawnb.core.video.views import Source
from pawnb.core.video.viewset import ViewSet
from pawnb.trial import Trial

FEWEST_REPEATED = 3
"""Pictures in a row that are shown again, of which fewer are bridged by what is about them. Set by
hand."""

_CHANGE_NEAR_PX = 5
"""Change is the largest mean, over so many px either way, of the absolute difference in grey."""
_SHOWN_AGAIN, _MOST_AGAIN, _WENT_ON = 0.1, 0.35, 0.6
"""Change from picture to picture over what is usual in the film: the median and the most in a
freeze, and the least right before and after it: an animal that rests goes slowly into it. Chosen
and measured on the same real clips (mice, horse, dog, camel; Motion JPEG and H.264 of crf 18 to
35): in films as they are the least is 0.11; in eight copies in a row the median is 0.00 to 0.07 up
to crf 28 (0.13 at 35) and the most 0.14 (0.23), and 28 of 30 such freezes are found, none where
there is none."""
_SMALL = 0.5
"""A picture that is shown again takes fewer bytes than so many times the usual in films that code
differences. Measured on the same: 0.01 to 0.4 up to crf 35, but 0.64 at crf 28 where a mouse hardly
moves."""
_PAIRS = 16
"""Pairs of pictures that tell the usual change."""
_STRETCHES, _STRETCH = (0.25, 0.5, 0.75), 24
"""Where in a film, and over how many changes, it is asked whether pictures repeat regularly."""
_LONGEST_CYCLE = 6
_MOST_FREEZES_TOLD = 3
"""Freezes that are named, so that a sentence stays one."""
_AGAIN_IN_CYCLE = 0.3
"""Change at one place of the cycle over the median of the others, in each stretch. Measured on the
same, doubled: 0.00 to 0.22 up to crf 28, 0.35 at crf 35; as they are, 0.85 and more."""


def find_freezes(source: Source, start: int, stop: int) -> list[tuple[int, int]]:
    """Find where a film shows one picture again though the animal went on.

    Parameters
    ----------
    source : Source
        The film.
    start, stop : int
        Frames of the file that are used, half open.

    Returns
    -------
    list of (int, int)
        Half-open ranges of frames that show the picture before them, in order.
    """
    candidates = _candidates(source.frame_bytes, start, stop)
    runs = _joined(_runs(candidates, start))
    runs = [run for run in runs if run[1] - run[0] >= FEWEST_REPEATED]
    if not runs:
        return []
    usual = _usual_change(source, start, stop)
    if not usual > 0.0:
        return []
    return [freeze for run in runs for freeze in _freezes_in(source, run, (start, stop), usual)]


def freezes_of_views(
    trial: Trial, views: ViewSet, *, start: int, stop: int
) -> dict[str, list[tuple[int, int]]]:
    """Find where the films of views stand still; a film of several views is looked at once.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    start, stop : int
        Frames of the trial, half open.

    Returns
    -------
    dict
        View to half-open ranges of frames of the trial; views without any are left out.
    """
    of_files: dict[tuple[str, int], list[tuple[int, int]]] = {}
    found = {}
    for name, reader in views.readers.items():
        offset = trial.view(name).offset
        key = (trial.view(name).video, offset)
        if key not in of_files:
            freezes = find_freezes(reader.source, start + offset, stop + offset)
            of_files[key] = [(a - offset, b - offset) for a, b in freezes]
        if of_files[key]:
            found[name] = of_files[key]
    return found


def tell_freezes(views: ViewSet, freezes: Mapping[str, Sequence[tuple[int, int]]]) -> list[str]:
    """Say where films stand still, once a film.

    Parameters
    ----------
    views : ViewSet
        The open views.
    freezes : mapping
        As from :func:`freezes_of_views`.

    Returns
    -------
    list of str
        A sentence a film.
    """
    of_files = {views.readers[name].source.name: own for name, own in freezes.items()}
    said = []
    for file, own in of_files.items():
        places = ", ".join(f"{a} to {b - 1}" for a, b in own[:_MOST_FREEZES_TOLD])
        more = (
            f" and {len(own) - _MOST_FREEZES_TOLD} more times"
            if len(own) > _MOST_FREEZES_TOLD
            else ""
        )
        said.append(
            f"{file} stands still in frames {places}{more}: the picture before is shown again "
            "while the animal went on, as where a camera, or a program that copied the film, "
            "could not keep up; nothing is measured there, so copy it once more from the camera, "
            "or leave these frames out of what you conclude"
        )
    return said


def tell_repeats(trial: Trial, views: ViewSet, *, start: int, stop: int) -> list[str]:
    """Say which films show pictures again in a regular way, once a film.

    Parameters
    ----------
    trial, views, start, stop
        As for :func:`freezes_of_views`.

    Returns
    -------
    list of str
        A sentence a film.
    """
    offsets = {id(views.readers[n].source): trial.view(n).offset for n in views.names}
    sources = {id(reader.source): reader.source for reader in views.readers.values()}
    said = []
    for key, source in sources.items():
        cycle = repeats_every(source, start + offsets[key], stop + offsets[key])
        if cycle is not None:
            how = "every picture twice" if cycle == 2 else f"one picture of every {cycle} again"
            rate = trial.fps * (cycle - 1) / cycle
            said.append(
                f"{source.name} shows {how}, as films do that were saved at another rate than they "
                f"were filmed at: of {trial.fps:g} pictures a second only {rate:g} are new, so "
                "feet stop and leap in turn, and events are no more exact than that; save the "
                f"film anew at {rate:g} pictures a second, and set fps to that"
            )
    return said


def repeats_every(source: Source, start: int, stop: int) -> int | None:
    """Return the number of frames of which one always shows the picture before it again.

    Parameters
    ----------
    source, start, stop
        As for :func:`find_freezes`.

    Returns
    -------
    int or None
        2 where every picture is there twice, 5 where 24 pictures a second were made 30; None where
        pictures do not repeat so, or too few tell.
    """
    if stop - start <= 2 * _STRETCH:
        return None
    begins = [start + int(at * (stop - start - _STRETCH)) for at in _STRETCHES]
    stretches = [_changes(source, range(begin, begin + _STRETCH + 1)) for begin in begins]
    for cycle in range(2, _LONGEST_CYCLE + 1):
        if all(_has_cycle(changes, cycle) for changes in stretches):
            return cycle
    return None


def _has_cycle(changes: FloatArray, cycle: int) -> bool:
    """Say whether one change in so many is next to nothing, always at the same place."""
    whole = changes[: len(changes) // cycle * cycle].reshape(-1, cycle)
    places = np.median(whole, axis=0)
    least = int(places.argmin())
    others = np.delete(whole, least, axis=1)
    return bool(np.median(whole[:, least]) <= _AGAIN_IN_CYCLE * np.median(others)) and bool(
        np.mean(whole[:, least] < others.min(axis=1)) > 0.9 and np.median(others) > 0.0
    )


def _candidates(sizes: IntArray | None, start: int, stop: int) -> BoolArray:
    """Tell of frames ``start`` to ``stop`` which may repeat, by the bytes that they take.

    A copy is as long as the picture before it where every picture is coded by itself, else short.
    """
    if sizes is None:
        return np.ones(stop - start, bool)
    own = sizes[start:stop]
    before = np.concatenate([[-1], own[:-1]])
    return np.asarray((own == before) | (own < _SMALL * np.median(sizes)))


def _runs(marked: BoolArray, start: int) -> list[tuple[int, int]]:
    """Return the half-open ranges of frames that are marked."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(np.int8), [0]]))) + start
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _joined(runs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Join ranges with a frame or two between them: a coder refines a copy now and then."""
    joined: list[tuple[int, int]] = []
    for a, b in runs:
        if joined and a - joined[-1][1] < FEWEST_REPEATED:
            a = joined.pop()[0]
        joined.append((a, b))
    return joined


def _freezes_in(
    source: Source, run: tuple[int, int], frames: tuple[int, int], usual: float
) -> list[tuple[int, int]]:
    """Return the freezes among frames that may repeat; those at the ends of a film tell nothing."""
    first, last = max(run[0] - FEWEST_REPEATED, frames[0]), min(run[1] + FEWEST_REPEATED, frames[1])
    share = _changes(source, range(first, last)) / usual
    found = []
    for a, b in _runs(share < _MOST_AGAIN, 0):
        about = share[max(a - 1, 0) : a].tolist() + share[b : b + 1].tolist()
        went_on = len(about) == 2 and min(about) >= _WENT_ON
        if b - a >= FEWEST_REPEATED and went_on and np.median(share[a:b]) <= _SHOWN_AGAIN:
            found.append((first + a + 1, first + b + 1))
    return found


def _usual_change(source: Source, start: int, stop: int) -> float:
    """Return the median change from a picture to the next, of pairs spread over a film."""
    at = np.unique(np.linspace(start, stop - 2, _PAIRS).astype(int)).tolist()
    return float(np.median([_changes(source, range(k, k + 2))[0] for k in at]))


def _changes(source: Source, frames: Sequence[int]) -> FloatArray:
    """Return how much each picture differs from that before it, in grey; one fewer than frames."""
    pictures = (grey(source.grab(k).region(0, 0, source.width, source.height)) for k in frames)
    side = 2 * (_CHANGE_NEAR_PX // 2) + 1
    return np.array(
        [cv2.blur(np.abs(now - before), (side, side)).max() for before, now in pairwise(pictures)]
    )
