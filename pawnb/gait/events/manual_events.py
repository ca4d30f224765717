"""Events scored by hand or by another program: checked, and their names translated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from pawnb.errors import InputError
from pawnb.schema import EVENTS_COLUMNS, check_columns

EVENTS = ("AEP", "PEP", "TD", "LO")
"""Names of events; touch-down is TD, lift-off LO."""


def check_scored_events(
    events: pd.DataFrame, *, names: Mapping[str, str] | None = None
) -> pd.DataFrame:
    """Return an events table with every column and pawnb's names; refuse what cannot be meant.

    Parameters
    ----------
    events : pandas.DataFrame
        Columns leg, event and time_s; animal, trial, frame and method are filled in where they
        are missing.
    names : mapping, optional
        What the table calls an event to its name here: ``{"down": "TD", "up": "LO"}``.

    Returns
    -------
    pandas.DataFrame
        ``EVENTS_COLUMNS``, then the columns that the table has beside these.

    Raises
    ------
    InputError
        If a column is missing, there is no row, a name is missing, an event is unknown, or a time
        is not a number.
    """
    check_columns(events, ("leg", "event", "time_s"), where="events", cells=False)
    if len(events) == 0:
        raise InputError("events: the table has no rows; expected at least one event.")
    present = [name for name in EVENTS_COLUMNS if name in events]
    events = check_columns(events, present, where="events", cells=False).copy()
    for name in (name for name in ("animal", "trial", "leg") if name in events):
        empty = (events[name].isna() | (events[name].astype(str).str.strip() == "")).to_numpy()
        if empty.any():
            raise InputError(
                f"events: column {name!r} is empty in row {empty.argmax() + 1}; expected a name."
            )
    for name, default in (("animal", "animal"), ("trial", "trial"), ("method", "scored")):
        if name not in events:
            events[name] = default
    events["leg"] = events["leg"].astype(str)  # legs 1, 2, 3
    if "frame" not in events:
        events["frame"] = np.nan
    check_columns(events[["frame"]], ("frame",), where="events")
    events["event"] = _translate(events["event"], names or {})
    times = pd.to_numeric(events["time_s"], errors="coerce")
    if not np.isfinite(times.to_numpy(dtype=float)).all():
        row = int(np.flatnonzero(~np.isfinite(times.to_numpy(dtype=float)))[0])
        found = events["time_s"].iloc[row]
        shown = repr(found) if isinstance(found, str) else found
        raise InputError(f"events: time_s in row {row + 1} is {shown}; expected seconds.")
    events["time_s"] = times.astype(float)
    extra = [c for c in events.columns if c not in EVENTS_COLUMNS]
    return events[[*EVENTS_COLUMNS, *extra]]


def _translate(found: pd.Series, names: Mapping[str, str]) -> pd.Series:
    """Return events under pawnb's names."""
    wrong = sorted(set(names.values()) - set(EVENTS))
    if wrong:
        raise InputError(
            f"event_names: {wrong[0]!r} is no event; expected {', '.join(EVENTS)}, for instance "
            "down=TD."
        )
    own = found.astype(str).replace(dict(names))
    unknown = sorted(set(own) - set(EVENTS))
    if unknown:
        raise InputError(
            f"events: unknown event {unknown[0]!r}; expected {', '.join(EVENTS)} (touch-down is "
            f"TD, lift-off LO). Say what it means with event_names={{{unknown[0]!r}: 'TD'}}, or on "
            f"the command line --event-names {unknown[0]}=TD."
        )
    return own
