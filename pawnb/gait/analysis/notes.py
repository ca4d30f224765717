"""Notes: sentences on a result that a reader must know, with what they are about."""

from __future__ import annotations


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
