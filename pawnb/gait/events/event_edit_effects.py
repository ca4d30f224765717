"""What one correction does to the events of an analysis."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.analysis.tables import GaitTables
from pawnb.gait.cycles.leg_signals import POSITION
from pawnb.gait.events.event_edit_records import (
    AddEvent,
    DeleteEvent,
    EventEdit,
    ExcludeStride,
    MoveEvent,
)
from pawnb.gait.strides.stride_table import choose_stride_event

HAND = "hand"
"""``method`` of events that a person moved or added."""

UNNAMED_TRIAL = "trial"
"""What the trial of tracks or events is called that are of no trial and name none."""

_SAME_EVENT_S = 1e-6

_SHIFTED = 0.25
"""Share of the usual time between two events of a kind by which one may lie elsewhere once events
are found anew, as after tracks were corrected: the next of its kind is four times as far."""

_NOT_BESIDE = 0.5
"""The same as a share of the time to the nearest other event of the kind: beyond it, what is found
anew may be that one, of a pair of which one was wrong and is no longer found."""


def own_events(events: pd.DataFrame, edit: EventEdit) -> pd.DataFrame:
    """Return the events of the leg that a correction names, in order of time."""
    known = (events["animal"] == edit.animal) & (events["trial"] == edit.trial)
    own = events[known & (events["leg"] == edit.leg)].sort_values("time_s", kind="stable")
    if own.empty:
        raise InputError(
            f"there are no events of leg {edit.leg!r} of animal {edit.animal!r}, trial "
            f"{edit.trial!r}; do these corrections belong to this analysis?"
        )
    return own


def find_event(events: pd.DataFrame, edit: MoveEvent | DeleteEvent, *, anew: bool = False) -> Any:
    """Return the label of the row of an event.

    Parameters
    ----------
    events : DataFrame
        Every event.
    edit : MoveEvent or DeleteEvent
        The correction.
    anew : bool
        Whether the events were found anew since, and may have shifted.

    Returns
    -------
    object
        The label.
    """
    own = own_events(events, edit)
    own = own[own["event"] == edit.event]
    k = _nearest(own["time_s"].to_numpy(float), edit.time_s, edit.beside_s, anew=anew)
    if k is None:
        raise InputError(
            f"trial {edit.trial!r}: {edit.leg} has no {edit.event} at {edit.time_s:.4f} s; the "
            "events were found anew since it was corrected, or it is deleted."
        )
    return own.index[k]


def _nearest(
    times_s: FloatArray, time_s: float, beside_s: float | None, *, anew: bool
) -> int | None:
    """Return which event a correction means: that at its time, or where found anew near it."""
    if not len(times_s):
        return None
    away = np.abs(times_s - time_s)
    k = int(away.argmin())
    reach = _SHIFTED * float(np.median(np.diff(times_s))) if anew and len(times_s) > 1 else 0.0
    if beside_s is not None:
        reach = min(reach, _NOT_BESIDE * abs(time_s - beside_s))
    return k if away[k] < max(_SAME_EVENT_S, reach) else None


def check_recording(events: pd.DataFrame, edit: EventEdit, tables: GaitTables) -> None:
    """Refuse a correction that was made in another recording without a name.

    All such recordings are called alike. Their events are at fractions of frames: one at the very
    time of the correction (for one that was added, of the event beside it) is the event meant.

    Parameters
    ----------
    events : DataFrame
        Every event, with the corrections before this one.
    edit : EventEdit
        The correction.
    tables : GaitTables
        The analysis.

    Raises
    ------
    InputError
        If there is no such event.
    """
    told: float | None
    if isinstance(edit, ExcludeStride):
        kind, told = _start_of(events, edit, tables), edit.start_s
    else:
        kind, told = edit.event, edit.beside_s if isinstance(edit, AddEvent) else edit.time_s
    own = own_events(events, edit)
    times = own.loc[own["event"] == kind, "time_s"].to_numpy(float)
    if told is not None and _nearest(times, told, None, anew=False) is None:
        raise InputError(f"{edit.leg} has no {kind} at just {told:.6f} s in this recording.")


def with_neighbour(edit: EventEdit, tables: GaitTables) -> EventEdit:
    """Return a correction with the time of the nearest other event of its kind.

    Parameters
    ----------
    edit : EventEdit
        The correction, as it is made.
    tables : GaitTables
        The analysis that it is made in.

    Returns
    -------
    EventEdit
        The correction; without that time where the leg has no other such event.
    """
    events = tables.events
    if isinstance(edit, ExcludeStride):
        kind, at = _start_of(events, edit, tables), edit.start_s
    else:
        kind, at = edit.event, edit.time_s
    own = own_events(events, edit)
    others = own.loc[own["event"] == kind, "time_s"].to_numpy(float)
    others = others[np.abs(others - at) >= _SAME_EVENT_S]
    beside = float(others[np.abs(others - at).argmin()]) if len(others) else None
    return dataclasses.replace(edit, beside_s=beside)


def _start_of(events: pd.DataFrame, edit: ExcludeStride, tables: GaitTables) -> str:
    """Return the kind of the events from which strides of a trial are counted."""
    trial = events[(events["animal"] == edit.animal) & (events["trial"] == edit.trial)]
    return choose_stride_event(trial, tables.settings.stride_events)


def add_event(
    events: pd.DataFrame, edit: AddEvent, tables: GaitTables, *, anew: bool = False
) -> pd.DataFrame:
    """Return the events with one more, in its place among those of its leg.

    Where events were found anew and it is found by now, it is moved to the time that was given.

    Parameters
    ----------
    events : DataFrame
        Every event; not modified.
    edit : AddEvent
        The correction.
    tables : GaitTables
        The analysis, for its signals and settings.
    anew : bool
        Whether the events were found anew since.

    Returns
    -------
    DataFrame
        Events in the order they had.

    Raises
    ------
    InputError
        If the correction does not fit the events.
    """
    own = own_events(events, edit)
    known = ", ".join(dict.fromkeys(own["event"]))
    if edit.event not in set(own["event"]):
        raise InputError(
            f"trial {edit.trial!r}: {edit.leg} has no events {edit.event!r}; expected {known}."
        )
    alike = own.loc[own["event"] == edit.event, "time_s"].to_numpy(float)
    k = _nearest(alike, edit.time_s, edit.beside_s, anew=True) if anew else None
    if k is not None:
        found = MoveEvent(
            animal=edit.animal, trial=edit.trial, leg=edit.leg, event=edit.event,
            time_s=float(alike[k]), to_s=edit.time_s,
        )  # fmt: skip
        return move_event(events, found, tables)
    same = own["event"].isin(_pair_of(edit.event)) & (
        (own["time_s"] - edit.time_s).abs() < _SAME_EVENT_S
    )
    begin, end = _recorded(tables, edit, events)
    if same.any() or not begin <= edit.time_s <= end:
        why = "there is one already" if same.any() else f"expected {begin:.4f} to {end:.4f} s"
        raise InputError(
            f"trial {edit.trial!r}: no {edit.event} of {edit.leg} can be added at "
            f"{edit.time_s:.4f} s; {why}."
        )
    row = own.iloc[[0]].copy()
    told: dict[str, Any] = {"event": edit.event, "time_s": edit.time_s, "method": HAND,
            "frame": _frame_at(own, edit.time_s),
            "position": _position_at(tables, edit, edit.time_s)}  # fmt: skip
    for name in row:
        if name in told:
            row[name] = told[name]
        elif name not in ("animal", "trial", "leg"):
            row[name] = np.nan
    earlier = own.index[own["time_s"].to_numpy(float) <= edit.time_s]
    beside = earlier[-1] if len(earlier) else own.index[0]
    place = int(np.flatnonzero(events.index == beside)[0]) + bool(len(earlier))
    row.index = [events.index.max() + 1]
    return pd.concat([events.iloc[:place], row, events.iloc[place:]])


def _pair_of(event: str) -> tuple[str, str]:
    """Return the kinds of events that take turns with one of them."""
    return ("AEP", "PEP") if event in ("AEP", "PEP") else ("TD", "LO")


def _recorded(tables: GaitTables, edit: AddEvent, events: pd.DataFrame) -> tuple[float, float]:
    """Return the first and the last second of a recording, by its signals or else its events."""
    whole = [
        one.time_s for one in tables.signals if (one.animal, one.trial) == (edit.animal, edit.trial)
    ]
    if not whole:
        of_trial = (events["animal"] == edit.animal) & (events["trial"] == edit.trial)
        whole = [events.loc[of_trial, "time_s"].to_numpy(float)]
    return min(float(t.min()) for t in whole), max(float(t.max()) for t in whole)


def move_event(
    events: pd.DataFrame, edit: MoveEvent, tables: GaitTables, *, anew: bool = False
) -> pd.DataFrame:
    """Return the events with one of them moved between its neighbours.

    Parameters
    ----------
    events : DataFrame
        Every event; changed in place.
    edit : MoveEvent
        The correction.
    tables : GaitTables
        The analysis, for its signals and settings.
    anew : bool
        Whether the events were found anew since, and may have shifted.

    Returns
    -------
    DataFrame
        Events in the order they had; the same table.

    Raises
    ------
    InputError
        If the correction does not fit the events.
    """
    label, own = find_event(events, edit, anew=anew), own_events(events, edit)
    others = own.loc[
        own["event"].isin(_pair_of(edit.event)) & (own.index != label), "time_s"
    ].to_numpy(float)
    at = float(own.loc[label, "time_s"])
    before = others[others <= at].max(initial=-math.inf)
    after = others[others > at].min(initial=math.inf)
    if not before < edit.to_s < after:
        raise InputError(
            f"trial {edit.trial!r}: {edit.event} of {edit.leg} cannot go to {edit.to_s:.4f} s; "
            f"expected a time between its neighbours, {before:.4f} to {after:.4f} s."
        )
    events.loc[label, "frame"] = _frame_at(own, edit.to_s)
    events.loc[label, "time_s"], events.loc[label, "method"] = edit.to_s, HAND
    if "position" in events:
        events.loc[label, "position"] = _position_at(tables, edit, edit.to_s)
    order = own.index.to_numpy()
    events.loc[order] = events.loc[order].sort_values("time_s", kind="stable").to_numpy()
    return events


def _frame_at(own: pd.DataFrame, time_s: float) -> float:
    """Return the frame of a time, from the frames of the leg's other events."""
    known = own.dropna(subset=["frame"])
    if len(known) < 2:
        return math.nan
    rate, start = np.polyfit(known["time_s"].to_numpy(float), known["frame"].to_numpy(float), 1)
    return float(start + rate * time_s)


def _position_at(tables: GaitTables, edit: MoveEvent | AddEvent, time_s: float) -> float:
    """Return where the foot was at a time, along forward; NaN where not known."""
    for one in tables.signals:
        same = (one.animal, one.trial, one.signal) == (edit.animal, edit.trial, POSITION)
        if same and edit.leg in one.legs:
            column = one.samples[:, one.legs.index(edit.leg)]
            return float(np.interp(time_s, one.time_s, column))
    return math.nan


def exclude_stride(
    events: pd.DataFrame,
    edit: ExcludeStride,
    tables: GaitTables,
    *,
    before: Sequence[tuple[str, str, str, float, str]],
    anew: bool = False,
) -> tuple[str, str, str, float, str]:
    """Return which stride shall not count.

    Parameters
    ----------
    events : DataFrame
        Every event; not modified.
    edit : ExcludeStride
        The correction.
    tables : GaitTables
        The analysis, for its signals and settings.
    before : sequence of tuple
        Those that are excluded already.
    anew : bool
        Whether the events were found anew since, and may have shifted.

    Returns
    -------
    tuple
        Animal, trial, leg, the middle of the stride, s, and why.

    Raises
    ------
    InputError
        If the correction does not fit the events.
    """
    if not edit.reason.strip():
        raise InputError("a stride is excluded for a reason; say why.")
    own = own_events(events, edit)
    start = _start_of(events, edit, tables)
    times = own.loc[own["event"] == start, "time_s"].to_numpy(float)
    at = _nearest(times, edit.start_s, edit.beside_s, anew=anew)
    if at is None or at + 1 == len(times):
        raise InputError(
            f"trial {edit.trial!r}: no stride of {edit.leg} begins at {edit.start_s:.4f} s."
        )
    middle = float(times[at] + times[at + 1]) / 2.0
    row = (edit.animal, edit.trial, edit.leg, middle)
    if any(row[:3] == other[:3] and abs(middle - other[3]) < _SAME_EVENT_S for other in before):
        raise InputError(f"the stride of {edit.leg} at {edit.start_s:.4f} s is excluded already.")
    return (*row, f"excluded by hand: {edit.reason.strip()}")
