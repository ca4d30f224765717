"""Stances and swings too short to be steps: slips of the hand that scored ground contact.

One frame scored wrongly in the middle of a stance is a lift-off and a touch-down, and so a stride
more. Such a flip is much shorter than the leg's usual stance or swing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.strides.stride_table import PARTNER

CONTACT_BY_HAND = "contact by hand"
"""What the column ``method`` says of events that were read from a table of ground contact."""

SHORTEST_SHARE = 0.4
"""Shortest stance (swing) by default, as a share of the leg's median one.

Set by hand between what was seen in two recordings scored by hand: of a tardigrade, 184 stances
and swings, the shortest is 0.62 of its leg's median; of a fly at 100 frames a second the shortest
swing is two frames of three (0.67), and one frame scored wrongly is a third of it.
"""

_STATES = {**dict.fromkeys(PARTNER, "stance"), **dict.fromkeys(PARTNER.values(), "swing")}


def drop_short_states(
    events: pd.DataFrame, who: Mapping[str, str], *, settings: EventSettings
) -> tuple[pd.DataFrame, list[dict[str, Any]]]:
    """Take out stances and swings that are too short to be any, with the events at their ends.

    Those farthest below their limit go first, so that a stance that one wrong frame has cut in
    two is whole again before its parts are looked at.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one animal and trial: leg, event, time_s, method.
    who : mapping
        ``animal`` and ``trial``, for what is dropped.
    settings : EventSettings
        ``min_stance_s`` and ``min_swing_s``. Where they are None, events of tables of ground
        contact take :data:`SHORTEST_SHARE` of the leg's median; other events stay as they are.

    Returns
    -------
    events : pandas.DataFrame
        Those left, in their order.
    dropped : list of dict
        ``DROPPED_COLUMNS`` of each stance and swing taken out.
    """
    gone: list[Any] = []
    dropped: list[dict[str, Any]] = []
    for start, end in PARTNER.items():
        for leg, own in events[events["event"].isin((start, end))].groupby("leg", sort=False):
            own = own.sort_values("time_s", kind="stable")
            share = SHORTEST_SHARE if (own["method"] == CONTACT_BY_HAND).all() else 0.0
            asked = {"stance": settings.min_stance_s, "swing": settings.min_swing_s}
            kept, short = _without_short(own, asked, share)
            gone += own.index[~kept].tolist()
            dropped += [{**who, "leg": str(leg), **one} for one in short]
    return events.drop(index=gone), sorted(dropped, key=lambda row: row["start_s"])


def _without_short(
    own: pd.DataFrame, asked: Mapping[str, float | None], share: float
) -> tuple[BoolArray, list[dict[str, Any]]]:
    """Return which events of a leg, in order, are kept, and the stances and swings that go."""
    time_s = own["time_s"].to_numpy(dtype=float)
    state = own["event"].map(_STATES).to_numpy(dtype=str)
    at = np.arange(len(own))
    dropped = []
    while len(at) > 1:
        lasts, here = np.diff(time_s[at]), state[at][:-1]
        known = here != state[at][1:]  # between two touch-downs in a row it is not known
        limit = _limits(lasts, np.where(known, here, ""), asked, share)
        # a length of whole frames is not below a limit of as many
        short = np.flatnonzero(known & (lasts < limit * (1.0 - 1e-9)))
        if not len(short):
            break
        i = short[np.argmin(lasts[short] / limit[short])]
        span = {"start_s": time_s[at[i]], "end_s": time_s[at[i + 1]], "what": str(here[i])}
        why = f"shorter than {limit[i]:.3g} s (min_{here[i]}_s): taken for a slip of the scoring"
        dropped.append({**span, "why": why})
        at = np.delete(at, [i, i + 1])
    kept = np.zeros(len(own), dtype=bool)
    kept[at] = True
    return kept, dropped


def _limits(
    lasts: FloatArray, state: np.ndarray, asked: Mapping[str, float | None], share: float
) -> FloatArray:
    """Return how long each stance and swing must last at least, s."""
    limit = np.zeros(len(lasts))
    for name, least in asked.items():
        own = state == name
        if own.any():
            limit[own] = share * np.median(lasts[own]) if least is None else least
    return limit
