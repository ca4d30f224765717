"""Times of corrections where the frame rate of a recording was mended after they were made."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd

from pawnb.gait.events.event_edit_records import EventEdit, ExcludeStride, MoveEvent

_OFF_FRAME = 0.01
"""Frames by which a time may miss its frame where frames are counted at one rate."""
_SAME_RATE = 1e-6
"""Share by which two frame rates may differ and still be one."""


def frame_rate_of(events: pd.DataFrame, animal: str, trial: str) -> float | None:
    """Return at which rate the times of a trial were counted from its frames.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of an analysis.
    animal, trial : str
        Whose.

    Returns
    -------
    float or None
        Frames a second; None where events have no frames, or times come from time stamps.
    """
    if "frame" not in events:
        return None
    own = events[(events["animal"] == animal) & (events["trial"] == trial)]
    frames, times_s = own["frame"].to_numpy(float), own["time_s"].to_numpy(float)
    known = np.isfinite(frames) & (times_s > 0.0)
    if not known.any():
        return None
    last = int(np.where(known, times_s, 0.0).argmax())
    rate = float(f"{frames[last] / times_s[last]:.9g}")
    alike = np.abs(frames[known] - rate * times_s[known]) < _OFF_FRAME
    return rate if rate > 0.0 and alike.all() else None


def with_rate(edit: EventEdit, events: pd.DataFrame) -> EventEdit:
    """Return a correction with the frame rate by which its times are counted.

    Parameters
    ----------
    edit : EventEdit
        The correction, as it is made.
    events : pandas.DataFrame
        The events that it is made in.

    Returns
    -------
    EventEdit
        The same one; one that says its rate keeps it.
    """
    if edit.fps is not None:
        return edit
    return dataclasses.replace(edit, fps=frame_rate_of(events, edit.animal, edit.trial))


def mended_rate(edit: EventEdit, events: pd.DataFrame) -> float | None:
    """Return the frame rate of a recording where it is another one since a correction was made.

    Parameters
    ----------
    edit : EventEdit
        The correction.
    events : pandas.DataFrame
        The events as they are found now.

    Returns
    -------
    float or None
        Frames a second now; None where the rate is the same, or one of them is not known.
    """
    rate = None if edit.fps is None else frame_rate_of(events, edit.animal, edit.trial)
    if edit.fps is None or rate is None or abs(edit.fps / rate - 1.0) < _SAME_RATE:
        return None
    return rate


def in_time_of(edit: EventEdit, events: pd.DataFrame) -> EventEdit:
    """Return a correction of the same frames, in the times that events have now.

    Parameters
    ----------
    edit : EventEdit
        The correction, as it was made.
    events : pandas.DataFrame
        The events as they are found now.

    Returns
    -------
    EventEdit
        The same one where its frame rate was not mended.
    """
    rate = mended_rate(edit, events)
    if edit.fps is None or rate is None:
        return edit
    scale = edit.fps / rate
    if edit.beside_s is not None:
        edit = dataclasses.replace(edit, beside_s=edit.beside_s * scale)
    if isinstance(edit, ExcludeStride):
        return dataclasses.replace(edit, start_s=edit.start_s * scale, fps=rate)
    if isinstance(edit, MoveEvent):
        to_s = edit.to_s * scale
        return dataclasses.replace(edit, time_s=edit.time_s * scale, to_s=to_s, fps=rate)
    return dataclasses.replace(edit, time_s=edit.time_s * scale, fps=rate)
