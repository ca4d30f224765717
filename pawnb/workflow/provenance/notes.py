"""Every note and warning of a run, as a table beside its results."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import pandas as pd

from pawnb.arrays import IntArray
from pawnb.errors import InputWarning, ResumptionWarning
from pawnb.gait.analysis.notes import Note
from pawnb.input_warnings import hearing_input_warnings

NOTES_COLUMNS = ("where", "what", "rows")
"""``where``: the trial, file or table that a note is about (empty: all of them); ``what``: the
sentence; ``rows``: which rows of a table, the first below its header being 1 (the note stands in
each of them)."""
_SPANS_TOLD = 8


@contextmanager
def noted_warnings() -> Iterator[list[str]]:
    """Collect what is warned of in the block; it is shown as ever, too.

    Yields
    ------
    list of str
        Each warning (:class:`~pawnb.errors.InputWarning`) about the results once, in order, with
        files called by their names alone; it grows.
    """
    said: list[str] = []

    def note(warning: InputWarning) -> None:
        sentence = without_folders(str(warning))
        if not isinstance(warning, ResumptionWarning) and sentence not in said:
            said.append(sentence)

    with hearing_input_warnings(note, shown=True):
        yield said


def without_folders(sentence: str) -> str:
    """Return a sentence in which absolute paths are cut to their last part.

    What is written beside results is the same wherever they lie.
    """
    return re.sub(r"(?<![\w.])(?:/|[A-Za-z]:[\\/])(?:[^\s:;,/\\]+[\\/])*(?=[^\s/\\])", "", sentence)


def notes_table(
    notes: Iterable[str], tables: Mapping[str, pd.DataFrame] | None = None
) -> pd.DataFrame:
    """Put notes into a table, with those that stand in the rows of other tables.

    Parameters
    ----------
    notes : iterable of str
        Sentences; a :class:`~pawnb.gait.analysis.notes.Note` says where it belongs.
    tables : mapping, optional
        Tables by the names of their files; those with a column ``note`` are read.

    Returns
    -------
    pandas.DataFrame
        :data:`NOTES_COLUMNS`, every note once.
    """
    found = [Note(note) for note in notes]
    for name, table in (tables or {}).items():
        if "note" not in table:
            continue
        told = table["note"].fillna("").astype(str).to_numpy()
        for what in dict.fromkeys(told[told != ""]):
            rows = _spans(np.flatnonzero(told == what) + 1)
            found.append(Note(str(what), where=name, rows=rows))
    once = dict.fromkeys((note.where, note.what, note.rows) for note in found)
    return pd.DataFrame(list(once), columns=list(NOTES_COLUMNS))


def _spans(numbers: IntArray) -> str:
    """Return whole numbers in words: ``1-3, 7``; of very many the first, and how many more."""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    said = ", ".join(f"{r[0]}-{r[-1]}" if len(r) > 1 else f"{r[0]}" for r in runs[:_SPANS_TOLD])
    more = sum(len(run) for run in runs[_SPANS_TOLD:])
    return f"{said} and {more} more" if more else said
