"""Events scored by hand, as files give them: tables of events, and of ground contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from pawnb.errors import InputError, did_you_mean
from pawnb.gait.events.contacts import events_from_contacts, is_contact_table
from pawnb.io.tables import read_cells, read_column_names, read_numbers
from pawnb.schema import check_columns
from pawnb.trial import Trial

NAMES = ("animal", "trial", "group")
"""Columns of words that either table may have: whose its rows are."""

_NUMBERS = ("frame", "time_s", "position")


def read_scored_file(path: Path, *, fps: float | None) -> pd.DataFrame | None:
    """Read a csv of events or of ground contact, or return None where it is neither.

    Parameters
    ----------
    path : Path
        A csv with ``event`` and ``leg``, ``time_s`` or ``frame`` (an ``events.csv`` of pawnb's own
        among them), or with ``frame`` and 0 or 1 for each leg. Either may name ``animal``,
        ``trial`` and ``group`` of its rows; without, animal and trial are called as the file.
    fps : float or None
        Frames per second, for a table that gives frames only.

    Returns
    -------
    pandas.DataFrame or None
        Events, as :func:`pawnb.gait.analyse_events` takes them.

    Raises
    ------
    InputError
        If it is such a table and cannot be read.
    """
    if path.suffix.lower() != ".csv":
        return None
    names = read_column_names(path, expected="a csv table")
    if not {"event", "frame"} & set(names):
        return None
    cells = read_cells(path, ())
    if "event" in cells:
        return _events(path, fps)
    if is_contact_table(cells.drop(columns=[name for name in NAMES if name in cells])):
        return _contacts(path, cells, fps)
    return None


def read_trial_events(trial: Trial) -> pd.DataFrame | None:
    """Read the events that a trial of kind ``tracks`` names instead of tracks.

    Parameters
    ----------
    trial : Trial
        ``[tracks] file`` names a file of any kind; ``[tracks] legs`` what it calls the legs.

    Returns
    -------
    pandas.DataFrame or None
        Events of the trial's animal and ``frames``; None where the file is no table of events or
        of ground contact.

    Raises
    ------
    InputError
        If it is one and cannot be read, names other animals, or has no event in ``frames``.
    """
    if trial.tracks_file is None:
        return None  # one file a view holds points
    path = trial.path(trial.tracks_file)
    events = read_scored_file(path, fps=trial.fps) if path.is_file() else None
    if events is None:
        return None
    for name, own in (("animal", trial.animal.id), ("trial", trial.name)):
        others = sorted(set(events[name].astype(str)) - {own, path.stem} if name in events else ())
        if others:
            raise InputError(
                f"{path}: {name} {others[0]!r}, where trial {trial.name!r} is of {name} {own!r}; "
                f"leave the column {name!r} away, or give this file to pawnb gait by itself."
            )
    events = events.assign(animal=trial.animal.id, trial=trial.name)
    if trial.tracks_legs:
        events = choose_event_legs(events, trial.tracks_legs, where=str(path))
    if trial.frames is None:
        return events
    first, stop = trial.frames
    at = events["time_s"] * trial.fps
    inside = events[(at >= first) & (at < stop)]
    if inside.empty:
        raise InputError(
            f"{path}: no event in frames {first} to {stop - 1} of trial {trial.name!r}; mend "
            "[trial] frames."
        )
    return inside.reset_index(drop=True)


def choose_event_legs(
    events: pd.DataFrame, legs: Sequence[str] | Mapping[str, str], *, where: str
) -> pd.DataFrame:
    """Return the events of some legs, under the names that were asked for.

    Parameters
    ----------
    events : pandas.DataFrame
        Events, with a column ``leg``.
    legs : sequence of str or mapping
        Legs to keep, or names of legs to what the table calls them.
    where : str
        How messages name the table.

    Returns
    -------
    pandas.DataFrame
        The rows of these legs.

    Raises
    ------
    InputError
        If the table has no such leg, or two legs are one of it.
    """
    named = dict(legs) if isinstance(legs, Mapping) else {leg: leg for leg in legs}
    there = events["leg"].astype(str)
    for name in named.values():
        if name not in set(there):
            raise InputError(
                f"{where}: no leg {name!r}{did_you_mean(name, set(there))}; there are "
                f"{', '.join(sorted(set(there)))}."
            )
    points = list(named.values())
    twice = next((name for i, name in enumerate(points) if name in points[:i]), None)
    if twice is not None:
        both = " and ".join(leg for leg, name in named.items() if name == twice)
        raise InputError(f"{where}: {both} are both {twice!r}; give each leg a name of its own.")
    chosen = events[there.isin(points)]
    return chosen.assign(leg=chosen["leg"].astype(str).map({v: k for k, v in named.items()}))


def groups_of_events(events: pd.DataFrame, *, where: str) -> dict[tuple[str, str], str]:
    """Return the group of each animal and trial of a table of events that names groups.

    Parameters
    ----------
    events : pandas.DataFrame
        ``animal``, ``trial`` and ``group``; without a column ``group`` there are none.
    where : str
        How messages name the table.

    Returns
    -------
    dict
        (animal, trial) to group; empty cells count as no group.

    Raises
    ------
    InputError
        If one trial of an animal is in two groups.
    """
    if "group" not in events:
        return {}
    named = events[events["group"].notna() & (events["group"] != "")]
    rows = named[list(NAMES)].astype(str).drop_duplicates()
    double = rows[rows.duplicated(["animal", "trial"])]
    if len(double):
        animal, trial, group = double.iloc[0]
        raise InputError(
            f"{where}: trial {trial!r} of animal {animal!r} is in group {group!r} and in another; "
            "expected one group a trial."
        )
    return {(animal, trial): group for animal, trial, group in rows.to_numpy()}


def _events(path: Path, fps: float | None) -> pd.DataFrame:
    """Read a table of events."""
    events = _named(read_cells(path, ("leg", "event")), path)
    for name in _NUMBERS:
        if name in events:
            events[name] = read_numbers(events, name, where=str(path), empty=True)
    if "time_s" not in events:
        check_columns(events, ("frame",), where=f"{path} (without time_s)", cells=False)
        events["time_s"] = events["frame"] / _needed_fps(fps, path)
    return events


def _contacts(path: Path, cells: pd.DataFrame, fps: float | None) -> pd.DataFrame:
    """Read a table of ground contact, for each animal and trial that it names."""
    cells = _named(cells, path)
    names = [name for name in NAMES if name in cells]
    numbers = {
        name: read_numbers(
            cells, name, where=str(path), whole=name == "frame", empty=name != "frame"
        )
        for name in map(str, cells)
        if name not in names
    }
    table, rate = pd.DataFrame(numbers), _needed_fps(fps, path)
    parts = []
    for rows, own in table.groupby([cells[name] for name in names], sort=False):
        who = dict(zip(names, map(str, rows), strict=True))
        events = events_from_contacts(own, fps=rate, animal=who["animal"], trial=who["trial"])
        parts.append(events.assign(group=who["group"]) if "group" in who else events)
    return pd.concat(parts, ignore_index=True)


def _named(cells: pd.DataFrame, path: Path) -> pd.DataFrame:
    """Return the cells with animal and trial: without such a column, called as the file."""
    for name in ("animal", "trial"):
        if name not in cells:
            cells[name] = path.stem
        empty = (cells[name] == "").to_numpy()
        if empty.any():
            raise InputError(
                f"{path}: line {empty.argmax() + 2}, column {name!r} is empty; expected a name in "
                "every row."
            )
    return cells


def _needed_fps(fps: float | None, path: Path) -> float:
    """Return the frame rate, or say that it is needed."""
    if fps is None:
        raise InputError(
            f"{path}: this file does not say its frame rate; give it with --fps, for instance "
            "--fps 250."
        )
    return fps
