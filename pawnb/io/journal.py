"""Files that keep what a person did, one JSON object a line, such as ``edits.jsonl``.

Lines are appended and forced to disk as things are done. Undo and redo are lines too, so
nothing a person entered is ever taken out of a file.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from types import NoneType
from typing import Any, Generic, Literal, TypeAlias, TypeVar, get_args, get_type_hints

from pawnb.errors import InputError, did_you_mean

RecordT = TypeVar("RecordT")
Step: TypeAlias = Literal["undo", "redo"]

_STEPS: tuple[Step, ...] = ("undo", "redo")
# what a crash left of a line is kept under this name, so that the file stays readable
_FRAGMENT = "unfinished"
_NUMBERS = dict[str, float]
_WORDS = {
    int: "a whole number", float: "a number", bool: "true or false", str: "text",
    _NUMBERS: "numbers by name",
}  # fmt: skip


class LineFormat(Generic[RecordT]):
    """How records of some kinds are written as lines, and read again.

    Parameters
    ----------
    kinds : mapping of str to type
        The name of each kind in a line, and its frozen dataclass. Fields are whole numbers,
        numbers, texts, switches or numbers by name; a text may be None.
    """

    def __init__(self, kinds: Mapping[str, type[RecordT]]) -> None:
        self._kinds = dict(kinds)
        self._names = {cls: name for name, cls in kinds.items()}
        self._types = {name: get_type_hints(cls) for name, cls in kinds.items()}

    def to_line(self, entry: RecordT | Step) -> str:
        """Write one entry as a line of JSON, without the end of line.

        Parameters
        ----------
        entry : record, "undo" or "redo"
            What was done.

        Returns
        -------
        str
            The line; numbers are written in full, so that reading gives the same record. A
            switch that is off is left out.
        """
        if isinstance(entry, str):
            return json.dumps({"edit": entry})
        fields: dict[str, Any] = dataclasses.asdict(entry)  # type: ignore[call-overload]
        written = {name: value for name, value in fields.items() if value is not False}
        return json.dumps({"edit": self._names[type(entry)], **written})

    def from_line(self, line: str, *, where: str) -> RecordT | Step | None:
        """Read one line.

        Parameters
        ----------
        line : str
            The line.
        where : str
            File and line number for the message.

        Returns
        -------
        record, "undo", "redo" or None
            None for a line that keeps what a crash left of an unfinished one.

        Raises
        ------
        InputError
            If the line is not JSON, of an unknown kind, or lacks a field.
        """
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            raise InputError(
                f"{where}: not a JSON object: {line.strip()[:60]!r}; mend or remove that line."
            ) from None
        kind = record.pop("edit", None) if isinstance(record, dict) else None
        for step in _STEPS:
            if kind == step:
                return step
        if kind == _FRAGMENT:
            return None
        if not isinstance(kind, str) or kind not in self._kinds:
            known = [*self._kinds, *_STEPS]
            raise InputError(
                f"{where}: unknown kind of edit {kind!r}{did_you_mean(str(kind), known)}; "
                f"expected {', '.join(known)}."
            )
        self._check(kind, record, where)
        return self._kinds[kind](**record)

    def _check(self, kind: str, record: Mapping[str, Any], where: str) -> None:
        """Raise InputError unless the fields of a line are those of its kind."""
        fields = {f.name: f for f in dataclasses.fields(self._kinds[kind])}  # type: ignore[arg-type]
        for name in record:
            if name not in fields:
                raise InputError(
                    f"{where}: unknown field {name!r}{did_you_mean(name, fields)}; "
                    f"a {kind} has {', '.join(fields)}."
                )
        for name, field in fields.items():
            if name not in record and field.default is dataclasses.MISSING:
                raise InputError(f"{where}: a {kind} needs {name!r}; mend or remove that line.")
            expected = self._types[kind][name]
            if name in record and not _fits(record[name], expected):
                word = _WORDS.get(expected, "text")
                raise InputError(f"{where}: {name} is {record[name]!r}; expected {word}.")


def _fits(value: Any, expected: Any) -> bool:
    """Whether a value of a line has the type of its field."""
    if value is None:
        return NoneType in get_args(expected)
    if expected == _NUMBERS:
        return isinstance(value, dict) and all(_fits(number, float) for number in value.values())
    if isinstance(value, bool) or expected is bool:
        return isinstance(value, bool) and expected is bool
    if expected is float:
        return isinstance(value, int | float) and math.isfinite(value)
    return isinstance(value, int if expected is int else str)


class Journal(Generic[RecordT]):
    """A file of records open for appending.

    Parameters
    ----------
    path : str or Path
        The file; it is made, with its folder, when the first line is appended.
    lines : LineFormat
        The records that it may hold.
    made_in : str
        What is open while it is written, for a message: ``"tracks"``.

    Attributes
    ----------
    entries : list
        What was read, in order; appended entries are added.
    notes : list of str
        What a person should know: an unfinished last line, for instance.

    Raises
    ------
    InputError
        If a line other than the last cannot be read.
    """

    def __init__(self, path: str | Path, lines: LineFormat[RecordT], *, made_in: str) -> None:
        self.path = Path(path)
        self._lines, self._made_in = lines, made_in
        self.entries, self._fragment, self.notes = _read(self.path, lines)
        self._size = self._size_now()

    def append(self, entry: RecordT | Step) -> None:
        """Add one line and force it to disk before returning.

        Parameters
        ----------
        entry : record, "undo" or "redo"
            What was done.

        Raises
        ------
        InputError
            If the file was changed by somebody else since it was read, or cannot be written.
        """
        if self._size_now() != self._size:
            raise InputError(
                f"{self.path}: changed by another window or program since it was opened here, so "
                f"this correction was not made; open the {self._made_in} again and repeat it."
            )
        line = self._lines.to_line(entry) + "\n"
        if self._fragment:
            # what a crash left of a line becomes a whole one, written over itself
            line = _whole_line(self._fragment) + "\n" + line
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("r+b" if self.path.exists() else "xb") as file:
                file.seek(self._size - len(self._fragment.encode()))
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise InputError(
                f"{self.path}: cannot be written ({error.strerror}), so this correction was not "
                "made; free some space or choose another place for the edits."
            ) from None
        self._fragment = ""
        self._size = self._size_now()
        self.entries.append(entry)

    def _size_now(self) -> int:
        """Return the size of the file in bytes, 0 where there is none."""
        return self.path.stat().st_size if self.path.exists() else 0


def read_journal(
    path: str | Path, lines: LineFormat[RecordT]
) -> tuple[list[RecordT | Step], list[str]]:
    """Read a file of records without changing it.

    Parameters
    ----------
    path : str or Path
        The file; one that does not exist holds no records.
    lines : LineFormat
        The records that it may hold.

    Returns
    -------
    entries : list
        Every entry in order, undo and redo among them.
    notes : list of str
        What was left out, and why.

    Raises
    ------
    InputError
        If a line other than the last cannot be read.
    """
    entries, _, notes = _read(Path(path), lines)
    return entries, notes


def enter_step(past: list[RecordT], future: list[RecordT], entry: RecordT | Step) -> None:
    """Take one entry in, in order: what is in force then, and what can be made again.

    Parameters
    ----------
    past, future : list
        Records in force, and undone ones with the last undone at the end; both are changed. An
        undo or redo of nothing does nothing.
    entry : record, "undo" or "redo"
        What was done.
    """
    if entry == "undo":
        if past:
            future.append(past.pop())
    elif entry == "redo":
        if future:
            past.append(future.pop())
    elif not isinstance(entry, str):
        past.append(entry)
        future.clear()


def _read(path: Path, lines: LineFormat[RecordT]) -> tuple[list[RecordT | Step], str, list[str]]:
    """Read the entries, what stands after the last end of line, and the notes."""
    if not path.exists():
        return [], "", []
    try:
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: not UTF-8 text ({error.reason}); is this a file of edits?"
        ) from None
    *whole_lines, last = text.split("\n")
    whole = _whole_line(last) == last
    entries = []
    for number, line in enumerate([*whole_lines, last] if whole else whole_lines, start=1):
        if not line.strip():
            continue
        entry = lines.from_line(line, where=f"{path.name}, line {number}")
        if entry is not None:
            entries.append(entry)
    if whole:
        return entries, last, []
    note = (
        f"{path.name}: the last line was only half written when the program ended, and is left "
        f"out: {last[:80]!r}. Everything before it is there."
    )
    return entries, last, [note]


def _whole_line(last: str) -> str:
    """Return the text after the last end of line if it is an entry, else an entry keeping it."""
    try:
        json.loads(last or "{}")
    except json.JSONDecodeError:
        return json.dumps({"edit": _FRAGMENT, "text": last})
    return last
