"""Ground contact given by hand or by force plates: to events, and compared with events."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.errors import InputError
from pawnb.gait.events.debounce import CONTACT_BY_HAND
from pawnb.gait.legs import sort_legs
from pawnb.schema import EVENTS_COLUMNS, check_columns
from pawnb.schema.arguments import checked_arguments

AGREEMENT_COLUMNS = (
    "leg", "n_frames", "agreement", "kappa", "duty_by_hand", "duty_found", "n_td", "td_shift_s",
    "n_lo", "lo_shift_s", "agreement_one_frame", "td_missed", "td_extra", "lo_missed", "lo_extra",
)  # fmt: skip

UNSCORED_COLUMNS = ("unscored_from_s", "unscored_to_s")
"""Columns of an event before which frames were not scored: the last one before, the first after."""


@checked_arguments
def events_from_contacts(
    contacts: pd.DataFrame, *, fps: float, animal: str = "animal", trial: str = "trial"
) -> pd.DataFrame:
    """Turn a table of ground contact into touch-downs and lift-offs.

    Parameters
    ----------
    contacts : pandas.DataFrame
        ``frame`` and one column a leg: 1 where the foot is on the ground, 0 where it is not,
        empty (NaN) where that is not known.
    fps : float
        Frames per second.
    animal, trial : str
        Names for the table.

    Returns
    -------
    pandas.DataFrame
        ``EVENTS_COLUMNS`` with TD and LO. A change between two successive frames is put half
        way between them; next to a frame that is missing or not known there is no event. Where
        frames lack, :data:`UNSCORED_COLUMNS` say so at the next event of the leg: no stride may
        hold such a stretch (:func:`unscored_gaps`). Slips of the hand are still among them:
        :func:`~pawnb.gait.analyse_events` takes them out.

    Raises
    ------
    InputError
        If there is no column ``frame`` or no leg, a cell is neither 0 nor 1, or frames are not
        in order.
    """
    legs = _legs_of(contacts)
    frame = contacts["frame"].to_numpy(dtype=float)
    back = np.flatnonzero(~(np.diff(frame) > 0))
    if len(back):
        raise InputError(
            f"contacts: frame {frame[back[0] + 1]:g} follows frame {frame[back[0]]:g}; expected "
            "each frame once, in order."
        )
    next_to = np.diff(frame) == 1
    rows = []
    for leg in legs:
        state = contacts[leg].to_numpy(dtype=float)
        gaps = _unscored(frame, state)
        change = np.diff(state)
        for i in np.flatnonzero((np.abs(change) == 1) & next_to):
            at = (frame[i] + frame[i + 1]) / 2.0
            before = [gaps.pop(0) for _ in gaps.copy() if gaps[0][1] <= at]
            unscored = (before[0][0] / fps, before[-1][1] / fps) if before else (np.nan, np.nan)
            rows.append(
                {
                    **dict(zip(UNSCORED_COLUMNS, unscored, strict=True)),
                    "animal": animal,
                    "trial": trial,
                    "leg": leg,
                    "event": "TD" if change[i] > 0 else "LO",
                    "frame": at,
                    "time_s": at / fps,
                    "method": CONTACT_BY_HAND,
                }
            )
    events = pd.DataFrame(rows, columns=[*EVENTS_COLUMNS, *UNSCORED_COLUMNS])
    gap = events[list(UNSCORED_COLUMNS)].notna().to_numpy().any()
    return events if gap else events[list(EVENTS_COLUMNS)]


@checked_arguments
def unscored_gaps(events: pd.DataFrame) -> pd.DataFrame:
    """Return the stretches of each leg in which nobody scored its contact.

    Parameters
    ----------
    events : pandas.DataFrame
        As :func:`events_from_contacts` gives them.

    Returns
    -------
    pandas.DataFrame
        leg, start_s and end_s (the last frame scored before it and the first after it), what;
        none where the table has no :data:`UNSCORED_COLUMNS`.
    """
    columns = ["leg", "start_s", "end_s", "what"]
    if not set(UNSCORED_COLUMNS) <= set(events):
        return pd.DataFrame(columns=columns)
    start, end = (pd.to_numeric(events[name], errors="coerce") for name in UNSCORED_COLUMNS)
    gaps = pd.DataFrame({"leg": events["leg"].astype(str), "start_s": start, "end_s": end})
    return gaps.dropna().assign(what="not scored")[columns].reset_index(drop=True)


def _unscored(frame: FloatArray, state: FloatArray) -> list[tuple[float, float]]:
    """Return the frames around each stretch in which a leg is not scored, in order."""
    there = np.isfinite(state)
    known, states = frame[there], state[there]
    lacking = np.diff(known) - 1
    change = states[1:] != states[:-1]
    lasts = np.diff(known[1:][change & (lacking == 0)])  # stances and swings, in frames
    # the same state around fewer frames than the shortest step has: nothing happened in them
    seamless = ~change & (lacking < (lasts.min() if len(lasts) else 0))
    return [(known[i], known[i + 1]) for i in np.flatnonzero((lacking > 0) & ~seamless)]


@checked_arguments
def is_contact_table(table: pd.DataFrame) -> bool:
    """Say whether a table is one of ground contact: ``frame`` and legs with 0 and 1."""
    columns = [name for name in table if name != "frame"]
    if "frame" not in table or not columns:
        return False
    cells = table[columns].apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
    given = (table[columns].notna() & (table[columns] != "")).to_numpy(dtype=bool)
    if (given.any(axis=0) & ~np.isfinite(cells).any(axis=0)).any():
        return False  # a column of words is no leg
    return bool(np.isin(cells[np.isfinite(cells)], (0.0, 1.0)).all() and np.isfinite(cells).any())


@checked_arguments
def contact_agreement(
    events: pd.DataFrame, contacts: pd.DataFrame, *, fps: float, start: str = "TD", end: str = "LO"
) -> pd.DataFrame:
    """Compare events found in tracks with ground contact scored by hand.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one animal and trial.
    contacts : pandas.DataFrame
        As for :func:`events_from_contacts`.
    fps : float
        Frames per second.
    start, end : str
        Events that begin and end contact: TD and LO, or AEP and PEP.

    Returns
    -------
    pandas.DataFrame
        One row a leg: ``agreement`` is the share of frames with the same state, ``kappa``
        Cohen's kappa (1: perfect, 0: chance), duty factors as shares of the compared frames,
        and for each event by hand the nearest found one within half a usual stride:
        ``td_shift_s``, ``lo_shift_s`` are medians of found minus by hand. Frames before the
        first and after the last found event of a leg are not compared. ``agreement_one_frame``
        is the share of frames that agree or lie next to a change by hand: where the film has
        few frames a swing, the hand itself cannot tell better. ``..._missed`` and ``..._extra``
        count events by hand, and found ones, without a partner, between the first and last of
        the others.

    Raises
    ------
    InputError
        As :func:`events_from_contacts`.
    """
    check_columns(events, ("leg", "event", "frame", "time_s"), where="events")
    hand = events_from_contacts(contacts, fps=fps)
    rows = []
    for leg in _legs_of(contacts):
        own = events[(events["leg"] == leg) & events["event"].isin((start, end))]
        own = own.sort_values("frame", kind="stable")
        frame = contacts["frame"].to_numpy(dtype=float)
        state = contacts[leg].to_numpy(dtype=float)
        at = np.searchsorted(own["frame"].to_numpy(dtype=float), frame, side="right")
        inside = (at > 0) & (at < len(own)) & np.isfinite(state)
        found = (own["event"] == start).to_numpy()[np.maximum(at - 1, 0)] if len(own) else inside
        row: dict[str, Any] = {"leg": leg, "n_frames": int(inside.sum())}
        if inside.any():
            row |= _agreement_of_frames(frame, state, found, inside)
        for name, label, kind in (("td", "TD", start), ("lo", "LO", end)):
            by_hand = hand.loc[(hand["leg"] == leg) & (hand["event"] == label), "time_s"]
            times = own.loc[own["event"] == kind, "time_s"]
            pairs = _match(by_hand.to_numpy(dtype=float), times.to_numpy(dtype=float))
            row |= {f"{name}_{key}": value for key, value in pairs.items() if key != "n"}
            row[f"n_{name}"] = pairs["n"]
        rows.append(row)
    return pd.DataFrame(rows, columns=list(AGREEMENT_COLUMNS))


def _agreement_of_frames(
    frame: FloatArray, state: FloatArray, found: BoolArray, inside: BoolArray
) -> dict[str, float]:
    """Compare the state in every frame that both know."""
    a, b = state[inside] == 1, found[inside]
    same = float((a == b).mean())
    chance = a.mean() * b.mean() + (1 - a.mean()) * (1 - b.mean())
    # a change by hand lies between two frames: either may be wrong by one
    changes = (np.abs(np.diff(state)) == 1) & (np.diff(frame) == 1)
    beside = np.append(changes, False) | np.append(False, changes)
    return {
        "agreement": same,
        "kappa": (same - chance) / (1 - chance) if chance < 1 else np.nan,
        "duty_by_hand": float(a.mean()),
        "duty_found": float(b.mean()),
        "agreement_one_frame": float(((a == b) | beside[inside]).mean()),
    }


def _match(by_hand: FloatArray, found: FloatArray) -> dict[str, float]:
    """Pair events that are nearest to each other, within half a usual stride."""
    if len(by_hand) < 2 or not len(found):
        return {"n": 0, "shift_s": np.nan, "missed": np.nan, "extra": np.nan}
    apart = np.abs(found[None, :] - by_hand[:, None])
    nearest, back = apart.argmin(axis=1), apart.argmin(axis=0)
    own = np.arange(len(by_hand))
    paired = (back[nearest] == own) & (apart[own, nearest] < np.median(np.diff(by_hand)) / 2.0)
    extra = np.setdiff1d(np.arange(len(found)), nearest[paired])
    lost = by_hand[~paired]
    return {
        "n": int(paired.sum()),
        "shift_s": float(np.median(found[nearest[paired]] - by_hand[paired]))
        if paired.any()
        else np.nan,
        "missed": int(((lost > found.min()) & (lost < found.max())).sum()),
        "extra": int(((found[extra] > by_hand.min()) & (found[extra] < by_hand.max())).sum()),
    }


def _legs_of(contacts: pd.DataFrame) -> list[str]:
    """Return the legs of a contact table, or say what is wrong with it."""
    if "frame" not in contacts:
        raise InputError(
            "contacts: column 'frame' is missing; expected frame and one column a leg."
        )
    legs = [str(name) for name in contacts if name != "frame"]
    if not legs:
        raise InputError("contacts: no column for a leg; expected frame and one column a leg.")
    for leg in legs:
        state = pd.to_numeric(contacts[leg], errors="coerce").to_numpy(dtype=float)
        wrong = ~np.isin(state, (0.0, 1.0)) & ~contacts[leg].isna().to_numpy()
        if wrong.any():
            raise InputError(
                f"contacts: leg {leg} is {contacts[leg].to_numpy()[wrong][0]} in one frame; "
                "expected 1 (on the ground) or 0."
            )
    return sort_legs(legs)
