"""Frames with and without the animal, from the sum of differences to the first frame.

Pullar 2009, §3.1 and Fig. 3.1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student_t

from pawnb.arrays import BoolArray, Float32Array, FloatArray, IntArray
from pawnb.core.pixels.grey import grey
from pawnb.core.video.views import ViewReader
from pawnb.errors import InputError

KNOWN_FRAMES = 5
"""The thesis: videos always held at least five frames of background before the animal came."""


@dataclass(frozen=True, kw_only=True)
class Presence:
    """Which frames show the animal (Fig. 3.1).

    Parameters
    ----------
    frames : ndarray of int, shape (n,)
        Frame numbers.
    difference : ndarray, shape (n,)
        Sum over the picture of the absolute differences to the first frame, grey values.
    threshold : float
        Upper prediction limit for an empty frame; infinite where the known empty frames are
        too few to tell.
    known_mean : float
        Mean difference of the frames known to be empty, the first left out: it differs from
        itself by nothing.
    has_animal : ndarray of bool, shape (n,)
        Whether the difference exceeds the threshold.
    first, last : int or None
        First and last frame of the longest run of frames with the animal (runs that are no more
        than ``gap`` frames apart count as one); None where there is none.
    """

    frames: IntArray
    difference: FloatArray
    threshold: float
    known_mean: float
    has_animal: BoolArray
    first: int | None
    last: int | None

    def empty_frames(self, *, guard: int = 2) -> IntArray:
        """Return the frames without the animal.

        Parameters
        ----------
        guard : int
            Frames left out on either side of the animal's stay.

        Returns
        -------
        ndarray of int
            Frame numbers, ascending.
        """
        empty = ~self.has_animal
        if self.first is not None and self.last is not None:
            near = (self.frames >= self.first - guard) & (self.frames <= self.last + guard)
            empty &= ~near
        return self.frames[empty]


def find_animal_frames(
    reader: ViewReader,
    *,
    frames: tuple[int, int] | None = None,
    known: tuple[int, int] | None = None,
    confidence: float = 0.99,
    gap: int = 2,
) -> Presence:
    """Find the frames that show the animal, from the sum of differences to an empty frame.

    Parameters
    ----------
    reader : ViewReader
        The view.
    frames : tuple of int, optional
        First frame and one past the last; default: all.
    known : tuple of int, optional
        Frames known to be empty, half open, of which the first is the one compared with;
        default: the first five of ``frames``.
    confidence : float
        One-sided confidence of the prediction limit.
    gap : int
        Runs of frames with the animal are joined over so many frames without.

    Returns
    -------
    Presence
        The differences, the threshold and what follows.

    Raises
    ------
    InputError
        If the frames known to be empty are fewer than three or outside the recording, or the
        confidence is not between 0.5 and 1.

    Notes
    -----
    The threshold is a prediction limit, mean + t s sqrt(1 + 1/n) of the n differences of frames
    known to be empty, t of n - 1 degrees of freedom: one more empty frame stays below with the
    confidence given. The thesis writes of the confidence interval of the mean, which more than
    every tenth empty frame would exceed.
    """
    first, stop = frames or (0, reader.n_frames)
    start, end = known or (first, min(first + KNOWN_FRAMES, stop))
    if not (0 <= start < end <= reader.n_frames):
        raise InputError(
            f"empty frames {start} to {end - 1}: the recording has frames 0 to "
            f"{reader.n_frames - 1}; name frames within it."
        )
    if end - start < 3:
        raise InputError(
            f"{end - start} frames are known to be empty; expected three or more, to tell how "
            "much empty frames differ."
        )
    if not 0.5 < confidence < 1:
        raise InputError(f"confidence is {confidence:g}; expected a number between 0.5 and 1.")
    reference = grey(reader.frame(start).image())
    numbers = np.union1d(np.arange(first, stop), np.arange(start, end))
    difference = np.array([_difference(reader, int(i), reference) for i in numbers])
    inside = (numbers >= start) & (numbers < end)
    own = difference[inside & (numbers != start)]
    threshold = prediction_limit(own, confidence=confidence)
    wanted = (numbers >= first) & (numbers < stop)
    numbers, difference = numbers[wanted], difference[wanted]
    has = (difference > threshold) & ~inside[wanted]
    run = _longest_run(has, gap)
    return Presence(
        frames=numbers,
        difference=difference,
        threshold=threshold,
        known_mean=float(own.mean()),
        has_animal=has,
        first=None if run is None else int(numbers[run[0]]),
        last=None if run is None else int(numbers[run[1]]),
    )


def prediction_limit(values: FloatArray, *, confidence: float) -> float:
    """Return the upper limit below which one more value of the same kind lies.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Two or more values.
    confidence : float
        One-sided confidence.

    Returns
    -------
    float
        mean + t s sqrt(1 + 1/n).
    """
    n = len(values)
    t = float(student_t.ppf(confidence, n - 1))
    return float(values.mean() + t * values.std(ddof=1) * math.sqrt(1 + 1 / n))


def _difference(reader: ViewReader, index: int, reference: Float32Array) -> float:
    """Return the sum of absolute differences of a frame to the reference."""
    return float(np.abs(grey(reader.frame(index).image()) - reference).sum(dtype=float))


def _longest_run(has: BoolArray, gap: int) -> tuple[int, int] | None:
    """Return first and last index of the longest run, short gaps bridged."""
    at = np.flatnonzero(has)
    if not len(at):
        return None
    runs = np.split(at, np.flatnonzero(np.diff(at) > gap + 1) + 1)
    best = max(runs, key=lambda run: run[-1] - run[0])
    return int(best[0]), int(best[-1])
