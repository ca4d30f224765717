"""Corrections of events whose animal, trial or leg has another name by now."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from pathlib import Path

from pawnb.errors import InputError, did_you_mean
from pawnb.gait.events.event_edit_records import EVENT_EDIT_LINES, EventEdit
from pawnb.io.journal import change_journal, read_journal
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def rename_event_edits(
    path: str | Path,
    *,
    animals: Mapping[str, str] | None = None,
    trials: Mapping[str, str] | None = None,
    legs: Mapping[str, str] | None = None,
) -> int:
    """Give animals, trials and legs other names in a file of corrections of events.

    Corrections hold for what they name. After a renaming in ``trial.toml``, in a study or by
    ``--legs`` their file is renamed alike; the other way round undoes it.

    Parameters
    ----------
    path : str or Path
        ``event_edits.jsonl``. It is written whole or not at all; undo and redo go on.
    animals, trials, legs : mapping of str to str, optional
        Former name to new name; two names may be exchanged. A trial's name is changed whichever
        animal it belongs to.

    Returns
    -------
    int
        How many corrections have another name now.

    Raises
    ------
    InputError
        If the file is not there or cannot be read or written, or holds no correction of a
        former name.

    Examples
    --------
    >>> from pawnb.gait.events.event_edits import EventEdits
    >>> from pawnb.gait.events.event_edit_records import DeleteEvent
    >>> gait = pawnb.gait.analyse(tracks, trial=run.trial)
    >>> key = gait.events.iloc[0][["animal", "trial", "leg", "event", "time_s"]].to_dict()
    >>> corrected = EventEdits(gait, "renamed_edits.jsonl").apply(DeleteEvent(**key))
    >>> pawnb.gait.rename_event_edits("renamed_edits.jsonl", animals={key["animal"]: "s17"})
    1
    """
    names = {"animal": animals or {}, "trial": trials or {}, "leg": legs or {}}
    entries, _ = read_journal(path, EVENT_EDIT_LINES)
    edits = [entry for entry in entries if not isinstance(entry, str)]
    for field, new in names.items():
        there = sorted({getattr(edit, field) for edit in edits})
        for former in new:
            if former not in there:
                raise InputError(
                    f"{path}: no correction is of {field} {former!r}{did_you_mean(former, there)}; "
                    f"there are {', '.join(there) or 'none'}."
                )

    def renamed(edit: EventEdit) -> EventEdit:
        now = {field: new.get(was := getattr(edit, field), was) for field, new in names.items()}
        return dataclasses.replace(edit, **now)

    return change_journal(path, EVENT_EDIT_LINES, renamed)


def under_its_name(
    edit: EventEdit,
    here: Collection[tuple[str, str, str]],
    renamed: Mapping[tuple[str, str], tuple[str, str]],
) -> EventEdit:
    """Return a correction under what its animal and trial are called in an analysis.

    Parameters
    ----------
    edit : MoveEvent, DeleteEvent, AddEvent or ExcludeStride
        The correction.
    here : collection of tuple
        Animal, trial and leg of everything in the analysis.
    renamed : mapping
        Other names of an animal and trial to those of the analysis.

    Returns
    -------
    MoveEvent, DeleteEvent, AddEvent or ExcludeStride
        The correction; as it is where it is of the analysis, or not known by another name.
    """
    now = renamed.get((edit.animal, edit.trial))
    if now is None or (edit.animal, edit.trial, edit.leg) in here:
        return edit
    return dataclasses.replace(edit, animal=now[0], trial=now[1])
