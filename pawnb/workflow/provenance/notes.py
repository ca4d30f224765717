"""Every note and warning of a run, as a table beside its results."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import IntArray
from pawnb.errors import InputWarning, ResumptionWarning
from pawnb.gait.analysis.notes import Note

NOTES_COLUMNS = ("where", "what", "rows")
"""``where``: the trial, file or table that a note is about (empty: all of them); ``what``: the
sentence; ``rows``: which rows of a table, the first below its header being 1."""


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
    with warnings.catch_warnings():
        show = warnings.showwarning
        if not _are_errors():  # Python shows a warning of one line of code only once
            warnings.simplefilter("always", InputWarning)

        def note(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            of_result = issubclass(category, InputWarning) and category is not ResumptionWarning
            sentence = without_folders(str(message))
            if of_result and sentence not in said:
                said.append(sentence)
            show(message, category, *place, **more)

        warnings.showwarning = note
        yield said


def without_folders(sentence: str) -> str:
    """Return a sentence in which absolute paths are cut to their last part.

    What is written beside results is the same wherever they lie.
    """
    return re.sub(r"(?<![\w.])(?:/|[A-Za-z]:[\\/])(?:[^\s:;,/\\]+[\\/])*(?=[^\s/\\])", "", sentence)


def _are_errors() -> bool:
    """Say whether the user turned warnings of this kind into errors."""
    for action, message, category, module, _ in warnings.filters:
        if message is None and module is None and issubclass(InputWarning, category):
            return action == "error"
    return False


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
    """Return whole numbers in words: ``1-3, 7``."""
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    return ", ".join(f"{r[0]}-{r[-1]}" if len(r) > 1 else f"{r[0]}" for r in runs)
