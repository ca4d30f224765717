"""Equally spaced samples: filters and derivatives need them, recordings may lack them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.schema import Tracks, rows_with_places

_SAMPLES_FOR_A_STEP = 10
"""Frames with a place from which on their common step is no chance: ten at random are all even, or
all odd, in 1 of 500 cases."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Equally spaced samples of a recording.

    Parameters
    ----------
    time_s, frame : ndarray, shape (n,)
        Time and (fractional) frame number of each sample.
    fs_hz : float
        Samples per second.
    """

    time_s: FloatArray
    frame: FloatArray
    fs_hz: float

    def time_at(self, sample: float) -> float:
        """Return the time of a fractional sample, in seconds."""
        return float(np.interp(sample, np.arange(len(self.time_s)), self.time_s))

    def frame_at(self, sample: float) -> float:
        """Return the frame number of a fractional sample."""
        return float(np.interp(sample, np.arange(len(self.frame)), self.frame))


def put_on_grid(tracks: Tracks, *, where: str) -> tuple[Grid, Tracks]:
    """Put Tracks on equally spaced samples.

    Frames that were left out become missing; where only every second (third, ...) frame has a
    place, these frames are the samples. Where time stamps are uneven by more than
    a fiftieth of a frame, positions are interpolated linearly between them.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    where : str
        How a message names them.

    Returns
    -------
    grid : Grid
        The samples.
    tracks : xarray.Dataset
        The same Tracks at these samples; ``time`` is the grid's.

    Raises
    ------
    InputError
        If frame numbers or times do not rise, or there are fewer than three frames.
    """
    tracks = _sampled(tracks)
    frames = tracks["frame"].to_numpy().astype(np.int64)
    times = tracks["time"].to_numpy().astype(float)
    if len(frames) < 3:
        frame_s = "frame" if len(frames) == 1 else "frames"
        raise InputError(f"{where}: {len(frames)} {frame_s}; expected at least three.")
    if not (np.all(np.diff(frames) > 0) and np.all(np.diff(times) > 0)):
        raise InputError(f"{where}: frame numbers and times must rise; sort them, no doubles.")
    step = int(np.gcd.reduce(np.diff(frames)))
    full = np.arange(frames[0], frames[-1] + 1, step)
    full_times = np.interp(full, frames, times)
    fs = (len(full) - 1) / (full_times[-1] - full_times[0])
    rate = float(tracks.attrs.get("fps", fs)) / step
    fs = rate if abs(fs - rate) < 1e-9 * rate else fs  # whichever the first frame's number
    even = full_times[0] + np.arange(len(full)) / fs
    index = np.searchsorted(full, frames)
    rows = np.full(len(full), -1)
    rows[index] = np.arange(len(frames))
    dense = tracks.isel(time=np.maximum(rows, 0)).assign_coords(time=even, frame=("time", full))
    names = [n for n in ("position", "image_position") if n in tracks]
    dense = dense.assign({n: dense[n].where(dense[n].time.isin(even[rows >= 0])) for n in names})
    if "heading" in dense:
        dense = dense.assign(heading=dense["heading"].where(dense.time.isin(even[rows >= 0])))
    if np.max(np.abs(full_times - even)) * fs <= 0.02:
        return Grid(time_s=even, frame=full.astype(float), fs_hz=float(fs)), dense
    for name in names:
        flat = dense[name].to_numpy().reshape(len(full), -1)
        moved = np.column_stack([np.interp(even, full_times, c) for c in flat.T])
        dense[name] = (dense[name].dims, moved.reshape(dense[name].shape))
    if "heading" in dense:
        turn = np.radians(dense["heading"].to_numpy())
        cos, sin = (
            np.column_stack([np.interp(even, full_times, c) for c in part.T])
            for part in (np.cos(turn), np.sin(turn))
        )
        dense["heading"] = (dense["heading"].dims, np.degrees(np.arctan2(sin, cos)))
    frame = np.interp(even, full_times, full)
    return Grid(time_s=even, frame=frame, fs_hz=float(fs)), dense


def _sampled(tracks: Tracks) -> Tracks:
    """Return tracks without the rows between samples, where a file has rows that are all empty.

    So do exports of SLEAP in which every second (third, ...) frame was tracked.
    """
    places = rows_with_places(tracks)
    frames = tracks["frame"].to_numpy()
    if places.all() or places.sum() < _SAMPLES_FOR_A_STEP:
        return tracks
    steps = [int(np.gcd.reduce(np.diff(own))) for own in (frames[places], frames)]
    return tracks.isel(time=places) if steps[0] > steps[1] > 0 else tracks
