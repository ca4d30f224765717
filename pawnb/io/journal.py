"""Files that keep what a person did, one JSON object a line, such as ``edits.jsonl``.

Lines are appended and forced to disk as things are done, by one writer at a time. Undo and redo
are lines too, so nothing a person entered is ever taken out of a file.
"""

from __future__ import annotations

import dataclasses
import json
import math
import reprlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import NoneType
from typing import Any, Generic, Literal, TypeAlias, TypeVar, get_args, get_type_hints

from pawnb.errors import InputError, did_you_mean
from pawnb.files import (
    check_file,
    find_standing_folder,
    how_to_write,
    locked,
    open_growing,
    read_bytes,
    say_moved,
    sync_folder,
    write_at,
    write_whole,
)

RecordT = TypeVar("RecordT")
Step: TypeAlias = Literal["undo", "redo"]

_STEPS: tuple[Step, ...] = ("undo", "redo")
# what a crash left of a line is kept under this name, so that the file stays readable
_FRAGMENT = "unfinished"
# how much of the end of a file is compared with what is known of it
_TAIL_BYTES = 4096
_WAIT_S = 10.0
# beyond it a float has no room for every whole number
_LARGEST = 2**53
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
        numbers, texts, switches or numbers by name; a text or a number may be None.
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
            switch that is off is left out, and so is a number that is not there.
        """
        if isinstance(entry, str):
            return json.dumps({"edit": entry})
        fields: dict[str, Any] = dataclasses.asdict(entry)  # type: ignore[call-overload]
        kind = self._names[type(entry)]
        types = self._types[kind]
        written = {
            name: value
            for name, value in fields.items()
            if value is not False
            and not (value is None and {int, float} & {*get_args(types[name])})
        }
        return json.dumps({"edit": kind, **written})

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
        except (ValueError, RecursionError):  # no JSON; too many digits; nested too deep
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
            hint = did_you_mean(str(kind)[:60], known)
            raise InputError(
                f"{where}: unknown kind of edit {reprlib.repr(kind)}{hint}; "
                f"expected {', '.join(known)}."
            )
        self._check(kind, record, where)
        return self._kinds[kind](**record)

    def _check(self, kind: str, record: Mapping[str, Any], where: str) -> None:
        """Raise InputError unless the fields of a line are those of its kind."""
        fields = {f.name: f for f in dataclasses.fields(self._kinds[kind])}  # type: ignore[arg-type]
        for name in record:
            if name not in fields:
                hint = did_you_mean(name[:60], fields)
                raise InputError(
                    f"{where}: unknown field {reprlib.repr(name)}{hint}; "
                    f"a {kind} has {', '.join(fields)}."
                )
        for name, field in fields.items():
            if name not in record and field.default is dataclasses.MISSING:
                raise InputError(f"{where}: a {kind} needs {name!r}; mend or remove that line.")
            expected = self._types[kind][name]
            if name in record and not _fits(record[name], expected):
                word = _WORDS.get(_given(expected), "text")
                found = reprlib.repr(record[name])
                raise InputError(f"{where}: {name} is {found}; expected {word}.")


def _given(expected: Any) -> Any:
    """Return the type of a field where it is given; it may be one that can be left out."""
    types = get_args(expected)
    return next(t for t in types if t is not NoneType) if NoneType in types else expected


def _fits(value: Any, expected: Any) -> bool:
    """Whether a value of a line has the type of its field."""
    if value is None:
        return NoneType in get_args(expected)
    expected = _given(expected)
    if expected == _NUMBERS:
        return isinstance(value, dict) and all(_fits(number, float) for number in value.values())
    if isinstance(value, bool) or expected is bool:
        return isinstance(value, bool) and expected is bool
    if isinstance(value, int):
        return expected in (int, float) and abs(value) <= _LARGEST
    if expected is float:
        return isinstance(value, float) and math.isfinite(value)
    return expected is not int and isinstance(value, str)


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
        self.path = Path(path).absolute()  # a notebook may go to another folder meanwhile
        self._folder = find_standing_folder(self.path)
        self._lines, self._made_in = lines, made_in
        self.entries, data, self.notes = _read(self.path, lines)
        self._size, self._tail = len(data), data[-_TAIL_BYTES:]

    def append(self, entry: RecordT | Step) -> None:
        """Add one line and force it to disk before returning.

        What a crash or a full disk left of a line becomes a line that keeps it.

        Parameters
        ----------
        entry : record, "undo" or "redo"
            What was done.

        Raises
        ------
        InputError
            If the file was changed by somebody else since it was read, its folder was moved, or
            it cannot be written; the line is not in it then.
        """
        if not self._folder.is_dir():
            raise InputError(
                f"{say_moved(self._folder, self.path)}, so this correction was not made; open the "
                f"{self._made_in} there and repeat it."
            )
        line = (self._lines.to_line(entry) + "\n").encode()
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with locked(self.path, remedy="try again in a moment", wait_s=_WAIT_S):
                self._append(line)
        except OSError as error:
            raise InputError(
                f"{self.path}: cannot be written ({error.strerror}), so this correction was not "
                f"made; {how_to_write(error, elsewhere='another place for the edits')}."
            ) from None
        self.entries.append(entry)

    def _append(self, line: bytes) -> None:
        """Add a line behind what is known, while nobody else may write."""
        is_new = not self.path.exists()
        if is_new and self._size:
            raise self._changed()  # it was taken away
        with open_growing(self.path) as file:
            file.seek(self._size - len(self._tail))
            found = file.read()
            fragment = found[len(self._tail) :]
            # a line is acknowledged with its end, so what has none was never made
            if not found.startswith(self._tail) or b"\n" in fragment:
                raise self._changed()
            end = b"" if self._tail.endswith(b"\n") or not self._tail else b"\n"
            kept = _kept_fragment(fragment) if fragment else b""
            write_at(file, self._size, end + kept + line, forced=True, put_back=fragment)
            file.seek(self._size)
            if file.read() != end + kept + line:
                raise self._changed()
        if is_new:
            sync_folder(self.path.parent)
        self._size += len(end + kept + line)
        self._tail = (self._tail + end + kept + line)[-_TAIL_BYTES:]

    def _changed(self) -> InputError:
        """Say that somebody else wrote to the file."""
        return InputError(
            f"{self.path}: changed by another window or program since it was opened here, so "
            f"this correction was not made; open the {self._made_in} again and repeat it."
        )


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


def change_journal(
    path: str | Path, lines: LineFormat[RecordT], change: Callable[[RecordT], RecordT]
) -> int:
    """Change records where they stand in a file; every other line stays as it is.

    Whoever has the file open meanwhile is told so at the next correction.

    Parameters
    ----------
    path : str or Path
        The file. It is written whole or not at all.
    lines : LineFormat
        The records that it may hold.
    change : callable
        Takes a record and returns what it is to be.

    Returns
    -------
    int
        How many lines are others now; nothing is written where there is none.

    Raises
    ------
    InputError
        If the file is not there, a line other than the last cannot be read, or it cannot be
        written.
    """
    path = check_file(path, expected="a file of edits")
    with locked(path, remedy="try again in a moment", wait_s=_WAIT_S):
        _, data, _ = _read(path, lines)
        whole = read_bytes(path, expected="a file of edits")  # a crash may have left half a line
        kept, n_changed = [], 0
        for number, raw in enumerate(data.splitlines(keepends=True), start=1):
            entry = None
            if raw.strip():
                entry = lines.from_line(raw.decode(), where=f"{path.name}, line {number}")
            new = entry if entry is None or isinstance(entry, str) else change(entry)
            n_changed += new != entry
            kept.append(
                raw if new is None or new == entry else (lines.to_line(new) + "\n").encode()
            )
        if n_changed:
            write_whole(path, b"".join([*kept, whole[len(data) :]]))
    return n_changed


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


def _read(path: Path, lines: LineFormat[RecordT]) -> tuple[list[RecordT | Step], bytes, list[str]]:
    """Read the entries, the bytes that hold them, and the notes."""
    if not path.exists():
        return [], b"", []
    data = read_bytes(path, expected="a file of edits")
    whole, newline, last = data.rpartition(b"\n")
    if _is_entry(last):
        whole, newline, last = data, b"", b""
    elif not newline and not last.startswith(b"{") and last.strip(b"\0 \r"):
        # no line of ours, not even the beginning of one
        raise InputError(f"{path}: not lines of JSON; is this a file of edits?")
    entries = []
    for number, raw in enumerate(whole.split(b"\n"), start=1):
        if not raw.strip():
            continue
        try:
            line = raw.decode("utf-8")
        except UnicodeDecodeError as error:
            raise InputError(
                f"{path}, line {number}: not UTF-8 text ({error.reason}); is this a file of edits?"
            ) from None
        entry = lines.from_line(line, where=f"{path.name}, line {number}")
        if entry is not None:
            entries.append(entry)
    if not last:
        return entries, whole + newline, []
    note = (
        f"{path.name}: the last line was only half written when the program ended, and is left "
        f"out: {last[:80].decode(errors='replace')!r}. Everything before it is there."
    )
    return entries, whole + newline, [note]


def _is_entry(last: bytes) -> bool:
    """Say whether what stands after the last end of line is whole."""
    try:
        return isinstance(json.loads(last), dict)
    except (ValueError, RecursionError):
        return False


def _kept_fragment(fragment: bytes) -> bytes:
    """Return a line that keeps what was left of one."""
    text = fragment.decode(errors="backslashreplace")
    return json.dumps({"edit": _FRAGMENT, "text": text}).encode() + b"\n"
