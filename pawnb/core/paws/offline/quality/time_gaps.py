"""Frames that a camera has dropped: gaps in the time stamps of tracks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.schema import Tracks


@dataclass(frozen=True)
class TimeGap:
    """Frames that lack in a recording.

    Parameters
    ----------
    after : int
        The frame after which they lack.
    frames : int
        How many.
    """

    after: int
    frames: int


def find_time_gaps(tracks: Tracks) -> tuple[TimeGap, ...]:
    """Find frames that were dropped when the recording was made.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks; their ``time`` holds the file's time stamps where its frame rate varies.

    Returns
    -------
    tuple of TimeGap
        In order; none where the time stamps tell of none, or there are no time stamps.
    """
    frames, time = tracks["frame"].to_numpy(), tracks["time"].to_numpy()
    if len(frames) < 3:
        return ()
    step = np.diff(time) / np.maximum(np.diff(frames), 1)
    usual = float(np.median(step))
    if not usual > 0:
        return ()
    rows = np.flatnonzero(step > QUALITY.time_gap * usual)
    return tuple(
        TimeGap(
            int(frames[i]), max(1, round(float(np.diff(time)[i]) / usual) - int(np.diff(frames)[i]))
        )
        for i in rows.tolist()
    )
