"""Frame numbers that a file gives: checked, and frames that it lacks put in as missing."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from pawnb.arrays import BoolArray, IntArray
from pawnb.errors import InputError
from pawnb.schema.tracks import Tracks, add_provenance

MOST_FRAMES = 1_000_000_000
"""Largest frame number: more than eleven days at 1000 frames per second."""

_FEW_ROWS, _LONG_SPAN = 1000, 1_000_000
"""A span of more frames than this is filled up only where one row in so many is there."""


def check_frames(frames: Sequence[int] | np.ndarray, *, where: str) -> IntArray:
    """Return frame numbers if they rise from row to row.

    Parameters
    ----------
    frames : sequence of int, shape (n,)
        The frame of each row of a file.
    where : str
        How messages name the file.

    Returns
    -------
    ndarray, shape (n,)
        The same numbers as int64.

    Raises
    ------
    InputError
        If there is none, one is no whole number or too large, one is there twice, they are not
        in order, or a few of them span so many frames that a number must be wrong.
    """
    values = np.asarray(frames)
    if values.size == 0:
        raise InputError(f"{where}: no frames; expected one row for each.")
    if values.dtype.kind not in "iuf":
        raise InputError(f"{where}: frames are {values.ravel()[0]!r} ...; expected whole numbers.")
    exact = values.astype(float)
    bad = ~(np.isfinite(exact) & (exact == np.rint(exact)) & (np.abs(exact) <= MOST_FRAMES))
    if bad.any():
        raise InputError(
            f"{where}: row {int(np.argmax(bad)) + 1} is of frame {values[np.argmax(bad)]}; "
            f"expected a whole number up to {MOST_FRAMES:,}."
        )
    whole = values.astype(np.int64)
    numbers, counts = np.unique(whole, return_counts=True)
    if (counts > 1).any():
        n = int((counts > 1).sum())
        more = f", and {n - 1} more frames are" if n > 1 else ""
        raise InputError(
            f"{where}: frame {numbers[counts > 1][0]} is there twice{more}; keep one row a frame."
        )
    falls = np.flatnonzero(np.diff(whole) < 0)
    if falls.size:
        i = int(falls[0])
        raise InputError(
            f"{where}: frame {whole[i + 1]} comes after frame {whole[i]}; sort the rows by frame."
        )
    span = int(whole[-1] - whole[0])
    if span > _LONG_SPAN and span > _FEW_ROWS * len(whole):
        raise InputError(
            f"{where}: {len(whole)} rows span frames {whole[0]} to {whole[-1]}; mend the frame "
            "number that is wrong."
        )
    return whole


def every_frame(frames: IntArray) -> IntArray:
    """Return all frames of a recording of which a file has some.

    Parameters
    ----------
    frames : ndarray of int, shape (n,)
        The frames that are there, rising.

    Returns
    -------
    ndarray of int
        From the first to the last in the largest step that meets them all: 1, unless only every
        second (third, ...) frame was tracked.
    """
    steps = np.diff(frames)
    step = int(np.gcd.reduce(steps)) if len(steps) else 1
    return np.arange(frames[0], frames[-1] + 1, step)


def rows_with_places(tracks: Tracks) -> BoolArray:
    """Return in which frames any point of any animal has a place.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    ndarray of bool, shape (n_time,)
        Whatever the confidence.
    """
    found = np.zeros(tracks.sizes["time"], dtype=bool)
    for name in ("position", "image_position"):
        if name in tracks:
            places = tracks[name].transpose("time", ...).to_numpy()
            found |= np.isfinite(places).reshape(len(found), -1).any(axis=1)
    return found


def note_absent(tracks: Tracks, frames: IntArray, *, file: str) -> Tracks:
    """Return Tracks that say in their provenance which of their frames a file did not have.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of every frame; not modified.
    frames : ndarray of int
        The frames that were in the file.
    file : str
        Its name.

    Returns
    -------
    xarray.Dataset
        The same Tracks where nothing lacks.
    """
    runs = _absent_runs(tracks["frame"].to_numpy(), frames)
    if not runs:
        return tracks
    return add_provenance(tracks, step="read", file=file, absent_frames=runs)


def absent_frames(tracks: Tracks) -> list[tuple[int, int, str]]:
    """Return the frames for which there is no row, in the file they were read from or here.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    list of tuple
        First and last frame of each gap, and the name of what lacks them.
    """
    found = []
    for step in json.loads(tracks.attrs.get("provenance", "{}")).get("steps", []):
        if step.get("step") == "read":
            found += [(*run, str(step["file"])) for run in step.get("absent_frames", [])]
    frames = tracks["frame"].to_numpy().astype(np.int64)
    if len(frames) > 1:
        own = _absent_runs(every_frame(frames), frames)
        found += [(first, last, "the tracks") for first, last in own]
    return sorted(found)


def _absent_runs(every: IntArray, frames: IntArray) -> list[tuple[int, int]]:
    """Return first and last of each run of frames that are not among ``frames``."""
    absent = ~np.isin(every, frames)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], absent, [False]]).astype(np.int8)))
    return [(int(every[a]), int(every[b - 1])) for a, b in edges.reshape(-1, 2)]
