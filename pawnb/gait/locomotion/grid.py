"""Equally spaced samples: filters and derivatives need them, recordings may lack them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.errors import InputError
from pawnb.schema import Tracks, check_frames, rows_with_places

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
        If frame numbers or times do not rise, there are fewer than three frames, or a position is
        infinite.
    """
    tracks = _sampled(tracks)
    n = tracks.sizes["time"]
    if n < 3:
        raise InputError(f"{where}: {n} frame{'s' * (n != 1)}; expected at least three.")
    frames = check_frames(tracks["frame"].to_numpy(), where=where)
    times = tracks["time"].to_numpy().astype(float)
    if not np.all(np.diff(times) > 0):
        raise InputError(f"{where}: times must rise with the frames; sort them, no doubles.")
    _check_finite(tracks, frames, where)
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


def _check_finite(tracks: Tracks, frames: IntArray, where: str) -> None:
    """Refuse infinite positions: they are no places, and no missing ones either."""
    for name in (n for n in ("position", "image_position") if n in tracks):
        infinite = np.argwhere(np.isinf(tracks[name].to_numpy().astype(float)))
        if len(infinite):
            point = tracks["keypoint"].to_numpy()[infinite[0][-2]]
            raise InputError(
                f"{where}: frame {frames[infinite[0][0]]}, point {str(point)!r} is at infinity; "
                "expected a number, or NaN where it was not seen."
            )
