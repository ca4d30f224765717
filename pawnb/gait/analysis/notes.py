"""Notes: sentences on a result that a reader must know, with what they are about."""

from __future__ import annotations

import re
from collections.abc import Sequence

_FEW = 3
"""So many notes that differ in their numbers only are given one by one."""


class Note(str):
    """One sentence, and where it belongs.

    It reads as ``where: what``.

    Parameters
    ----------
    what : str
        The sentence.
    where : str
        The trial, file or table that it is about; empty: all of them.
    rows : str
        Which rows of that table, where it is one.
    """

    what: str
    where: str
    rows: str

    def __new__(cls, what: str, *, where: str = "", rows: str = "") -> Note:
        """Make the sentence; a note that says already where it belongs keeps that."""
        words = what
        if isinstance(what, Note):
            words, where, rows = what.what, what.where or where, what.rows or rows
        note = super().__new__(cls, f"{where}: {words}" if where else words)
        note.what, note.where, note.rows = words, where, rows
        return note


def trial_of(animal: str, trial: str) -> str:
    """Return what notes call a trial of which other animals have one of the same name."""
    return f"{animal} {trial}"


def alike_in_one(notes: Sequence[str]) -> list[str]:
    """Return notes, of many trials' that differ in their numbers alone the first one.

    What is said of every trial of a study would hide what is said of one.

    Parameters
    ----------
    notes : sequence of str
        The notes.

    Returns
    -------
    list of str
        The notes; one that stands for others says of how many trials, and where they are.
    """
    kinds: dict[str, list[str]] = {}
    for note in notes:
        if isinstance(note, Note) and note.where:
            kind = re.sub(r"\d+(\.\d+)?(e[-+]?\d+)?", "0", note.what)
        else:
            kind = note
        kinds.setdefault(kind, []).append(note)
    told = []
    for same in kinds.values():
        if len(same) > _FEW:
            told.append(f"{same[0]} The like is said of {len(same) - 1} more trials (notes.csv).")
        else:
            told += same
    return told
