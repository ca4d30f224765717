"""Corrections of events by hand, kept line by line, and an analysis made again with them.

A person moves, deletes or adds an event, or excludes a stride and says why. Each correction is a
line of ``event_edits.jsonl``, on disk as soon as it is made; undo and redo are lines too. The
events that were found are never changed: reading the file again gives the present state.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from pawnb.errors import InputError
from pawnb.gait.analysis.tables import GaitTables, rebuild_tables
from pawnb.gait.events.event_edit_effects import (
    HAND,
    UNNAMED_TRIAL,
    add_event,
    check_recording,
    exclude_stride,
    find_event,
    move_event,
    with_neighbour,
)
from pawnb.gait.events.event_edit_names import rename_event_edits, under_its_name
from pawnb.gait.events.event_edit_records import (
    EVENT_EDIT_LINES,
    EVENT_EDITS_FILE,
    AddEvent,
    DeleteEvent,
    Entry,
    EventEdit,
    ExcludeStride,
    MoveEvent,
)
from pawnb.gait.events.event_edit_times import in_time_of, mended_rate, with_rate
from pawnb.io.journal import Journal, enter_step, read_journal
from pawnb.schema.arguments import checked_arguments

__all__ = [
    "EVENT_EDITS_FILE", "HAND", "AddEvent", "DeleteEvent", "EventEdit", "EventEdits",
    "ExcludeStride", "MoveEvent", "apply_event_edits", "read_event_edits",
    "rename_event_edits", "replay_event_edits",
]  # fmt: skip

_KIND_WORDS = (
    (MoveEvent, "event", "moved"), (DeleteEvent, "event", "deleted"),
    (AddEvent, "event", "added"), (ExcludeStride, "stride", "excluded"),
)  # fmt: skip
"""Kinds of corrections in words: what, and what was done to it."""

_NOTES_OF_BEFORE = (
    "notes of the analysis on events, strides and phases are of the events as they were found, "
    "before the corrections by hand; the tables are of the corrected ones."
)


class EventEdits:
    """An analysis and the corrections a person makes in its events.

    Parameters
    ----------
    tables : GaitTables
        The analysis; it is not modified. Where it holds corrections already, they give way to
        those of ``path``.
    path : str or Path, optional
        ``event_edits.jsonl``. What it holds already is applied; without a path nothing is kept.

    Attributes
    ----------
    tables : GaitTables
        The present state.
    active : tuple of EventEdit
        The corrections in force, in the order they were made.
    left_out : tuple of EventEdit
        Those of them that do not fit these events, as where events were found anew since.
    notes : list of str
        What a person should know of the file.

    Raises
    ------
    InputError
        If the file cannot be read.
    """

    def __init__(self, tables: GaitTables, path: str | Path | None = None) -> None:
        self._found = tables if tables.found is None else tables.found
        self._file = None if path is None else Journal(path, EVENT_EDIT_LINES, made_in="analysis")
        self.notes = [] if self._file is None else list(self._file.notes)
        self._past: list[EventEdit] = []
        self._future: list[EventEdit] = []
        for entry in [] if self._file is None else self._file.entries:
            enter_step(self._past, self._future, entry)
        self.tables, self.left_out = _apply(self._found, self._past, known=len(self._past))
        self.notes += _say_unnamed(self.left_out)
        if path is not None and tables.found is not None and not _alike(tables, self.tables):
            self.notes.append(
                f"this analysis has corrections that are not in {Path(path)}, as those in the "
                "results of a single trial: they are not shown here, and pawnb gait makes both"
            )

    @property
    def active(self) -> tuple[EventEdit, ...]:
        """The corrections in force, in the order they were made."""
        return tuple(self._past)

    @property
    def can_undo(self) -> bool:
        """Whether there is a correction to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether an undone correction can be made again."""
        return bool(self._future)

    def apply(self, edit: EventEdit) -> GaitTables:
        """Make a correction: check it, write its line to disk, then let it be seen.

        Parameters
        ----------
        edit : MoveEvent, DeleteEvent or ExcludeStride
            The correction.

        Returns
        -------
        GaitTables
            The present state.

        Raises
        ------
        InputError
            If it does not fit the events or cannot be written; nothing has changed then.
        """
        edit = with_neighbour(with_rate(edit, self._found.events), self.tables)
        return self._become([*self._past, edit], [], edit)

    def undo(self) -> GaitTables:
        """Take the last correction back; raises InputError where there is none."""
        if not self._past:
            raise InputError("there is no correction to undo.")
        *rest, last = self._past
        return self._become(rest, [*self._future, last], "undo")

    def redo(self) -> GaitTables:
        """Make the last undone correction again; raises InputError where there is none."""
        if not self._future:
            raise InputError("there is no correction to make again.")
        *rest, last = self._future
        return self._become([*self._past, last], rest, "redo")

    def _become(self, past: list[EventEdit], future: list[EventEdit], entry: Entry) -> GaitTables:
        """Compute the new state, write the line, then take both."""
        known = min(len(self._past), len(past))
        tables, left_out = _apply(self._found, past, known=known)
        if self._file is not None:
            self._file.append(entry)
        self.tables, self._past, self._future = tables, past, future
        self.left_out = left_out
        return tables


@checked_arguments
def replay_event_edits(
    tables: GaitTables,
    paths: str | Path | Sequence[str | Path],
    *,
    renamed: Mapping[tuple[str, str], tuple[str, str]] | None = None,
) -> GaitTables:
    """Return an analysis with the corrections of files; a file that is not there has none.

    Parameters
    ----------
    tables : GaitTables
        The analysis as it came from tracks or events, of one trial or pooled; corrections that
        it holds already give way to those of the files.
    paths : str, Path or a sequence of them
        Files ``event_edits.jsonl``; they are only read.
    renamed : mapping, optional
        Other names of an animal and trial, which files may use, to those of this analysis.

    Returns
    -------
    GaitTables
        The tables with every correction in force. Their notes say how many there are, and how
        many are left out: those of trials or legs that are not in this analysis, and those that
        do not fit its events, as where events were found anew since.

    Raises
    ------
    InputError
        If a file cannot be read.

    Examples
    --------
    >>> from pawnb.gait.events.event_edits import EventEdits
    >>> from pawnb.gait.events.event_edit_records import DeleteEvent
    >>> gait = pawnb.gait.analyse(tracks, trial=run.trial)
    >>> first = gait.events.iloc[0]
    >>> edits = EventEdits(gait, "event_edits.jsonl")
    >>> key = first[["animal", "trial", "leg", "event", "time_s"]].to_dict()
    >>> corrected = edits.apply(DeleteEvent(**key))
    >>> again = pawnb.gait.replay_event_edits(gait, "event_edits.jsonl")
    >>> len(gait.events) - len(again.events)
    1
    """
    tables = tables if tables.found is None else tables.found
    files = [Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)]
    here = set(tables.events[["animal", "trial", "leg"]].itertuples(index=False, name=None))
    ours: list[EventEdit] = []
    of_files: list[tuple[str, list[EventEdit]]] = []
    notes: list[str] = []
    for file in files:
        edits, remarks = read_event_edits(file)
        edits = [under_its_name(edit, here, renamed or {}) for edit in edits]
        own = [edit for edit in edits if (edit.animal, edit.trial, edit.leg) in here]
        ours += own
        of_files.append((file.name, own))
        notes += remarks
        otherwise = sum(mended_rate(edit, tables.events) is not None for edit in own)
        if otherwise:
            notes.append(
                f"{file.name}: corrections made before the frame rate was changed, taken to the "
                f"same frames: {otherwise}."
            )
        odd = [edit for edit in edits if edit not in own]
        if odd:
            notes.append(
                f"{file.name}: corrections left out, as their trial or leg is not in this "
                f"analysis: {len(odd)} (the first is of {odd[0].leg} of {odd[0].animal}, "
                f"{odd[0].trial}). Where an animal, a trial or a leg was renamed since, its name "
                "is changed in that file, too, by pawnb.gait.rename_event_edits."
            )
    corrected, left_out = _apply(tables, ours, known=len(ours))
    in_force = [(name, [edit for edit in own if edit not in left_out]) for name, own in of_files]
    notes[:0] = [
        f"{name}: corrections by hand in force: {len(own)} ({describe_kinds(own)})."
        for name, own in in_force
        if own
    ]
    if tables.notes and any(own for _, own in in_force):
        notes.append(_NOTES_OF_BEFORE)
    if left_out:
        notes.append(
            f"corrections of events left out, as they do not fit the events any more: "
            f"{describe_left_out(left_out)}; look at them in the GaitExplorer."
        )
        notes += _say_unnamed(left_out)
    return dataclasses.replace(corrected, notes=(*tables.notes, *notes))


def read_event_edits(path: str | Path) -> tuple[list[EventEdit], list[str]]:
    """Read the corrections that are in force, without changing the file.

    Parameters
    ----------
    path : str or Path
        ``event_edits.jsonl``; one that does not exist holds none.

    Returns
    -------
    edits : list of MoveEvent, DeleteEvent or ExcludeStride
        In the order they were made, without what was undone.
    notes : list of str
        What a person should know of the file.

    Raises
    ------
    InputError
        If a line other than the last cannot be read.
    """
    entries, notes = read_journal(path, EVENT_EDIT_LINES)
    past: list[EventEdit] = []
    future: list[EventEdit] = []
    for entry in entries:
        enter_step(past, future, entry)
    return past, notes


def apply_event_edits(tables: GaitTables, edits: Sequence[EventEdit]) -> GaitTables:
    """Apply corrections to an analysis: events, then strides and phases again from them.

    Parameters
    ----------
    tables : GaitTables
        The analysis as it came from tracks or events; corrections that it holds already give way
        to these.
    edits : sequence of EventEdit
        Corrections, in the order they were made.

    Returns
    -------
    GaitTables
        The tables. Moved and added events have the method ``"hand"``; excluded strides are among
        what was dropped, with their reason. ``found`` is the analysis without corrections.

    Raises
    ------
    InputError
        If a correction does not fit the events.
    """
    return _apply(tables, edits)[0]


def _alike(one: GaitTables, other: GaitTables) -> bool:
    """Say whether two states of an analysis have the same events and strides."""
    return one.events.equals(other.events) and one.strides.equals(other.strides)


def describe_kinds(edits: Sequence[EventEdit]) -> str:
    """Return how many corrections of each kind there are, in words."""
    said = []
    for kind, thing, done in _KIND_WORDS:
        n = sum(isinstance(edit, kind) for edit in edits)
        said += [f"{n} {thing if n == 1 else f'{thing}s'} {done}"] if n else []
    return ", ".join(said)


def describe_left_out(edits: Sequence[EventEdit]) -> str:
    """Return how many corrections do not fit, and which the first is, in words."""
    return f"{len(edits)} (the first is of the {_describe_place(edits[0])})"


def describe_edit(edit: EventEdit) -> str:
    """Return one correction in words: what was done to what."""
    done = next(done for kind, _, done in _KIND_WORDS if isinstance(edit, kind))
    return f"{done} {_describe_place(edit)} ({edit.animal}, {edit.trial})"


def _say_unnamed(left_out: Sequence[EventEdit]) -> list[str]:
    """Say why corrections of a recording without a name are made at the very same events only."""
    if not any(edit.trial == UNNAMED_TRIAL for edit in left_out):
        return []
    return [
        "this recording has no name, so only corrections of events at the very same time are made: "
        "those of another recording without a name would fit by chance. Give each recording a name "
        "(trial=pawnb.load_trial(...)), or a file of corrections of its own."
    ]


def _describe_place(edit: EventEdit) -> str:
    """Return what a correction is about, its leg and time, in words."""
    what, at_s = (
        ("stride", edit.start_s) if isinstance(edit, ExcludeStride) else (edit.event, edit.time_s)
    )
    return f"{what} of {edit.leg} at {at_s:.3f} s"


def _apply(
    tables: GaitTables, edits: Sequence[EventEdit], *, known: int = 0
) -> tuple[GaitTables, tuple[EventEdit, ...]]:
    """Apply corrections; of those made earlier, the first ``known``, give back what does not fit.

    Tracks that are corrected give other events: one that is no longer there must not keep all
    others from being made again.
    """
    tables = tables if tables.found is None else tables.found
    if not edits:
        return tables, ()
    events = tables.events.copy()
    excluded: list[tuple[str, str, str, float, str]] = []
    left_out: list[EventEdit] = []
    for k, made in enumerate(edits):
        anew, edit = k < known, in_time_of(made, tables.events)
        try:
            if anew and edit.trial == UNNAMED_TRIAL:
                check_recording(events, edit, tables)
            if isinstance(edit, ExcludeStride):
                row = exclude_stride(events, edit, tables, before=excluded, anew=anew)
                excluded.append(row)
            elif isinstance(edit, DeleteEvent):
                events = events.drop(index=find_event(events, edit, anew=anew))
            elif isinstance(edit, AddEvent):
                events = add_event(events, edit, tables, anew=anew)
            else:
                events = move_event(events, edit, tables, anew=anew)
        except InputError:
            if not anew:
                raise
            left_out.append(made)
    columns = ["animal", "trial", "leg", "time_s", "why"]
    corrected = rebuild_tables(
        tables,
        events.reset_index(drop=True),
        excluded=pd.DataFrame(excluded, columns=columns),
        trials={(edit.animal, edit.trial) for edit in edits},
    )
    return dataclasses.replace(corrected, found=tables), tuple(left_out)
