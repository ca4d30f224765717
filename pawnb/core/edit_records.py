"""Corrections as frozen records, and the file that keeps them: ``edits.jsonl``.

One JSON object a line, appended and forced to disk as it is made. Undo and redo
are lines too, so nothing a person entered is ever taken out of the file.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from pawnb.errors import InputError, did_you_mean


@dataclass(frozen=True, kw_only=True)
class Move:
    """The point is here.

    Parameters
    ----------
    frame : int
        Frame number.
    view, point : str
        Which point in which view.
    u, v : float
        Its position in px of the view.
    """

    frame: int
    view: str
    point: str
    u: float
    v: float


@dataclass(frozen=True, kw_only=True)
class Accept:
    """The point is right as it is; a person says so, and the position is written down.

    Parameters
    ----------
    frame : int
        Frame number.
    view, point : str
        Which point in which view.
    u, v : float
        The position that was accepted, in px of the view.
    """

    frame: int
    view: str
    point: str
    u: float
    v: float


@dataclass(frozen=True, kw_only=True)
class Hide:
    """The point cannot be seen here.

    Parameters
    ----------
    frame : int
        Frame number.
    view, point : str
        Which point in which view.
    """

    frame: int
    view: str
    point: str


@dataclass(frozen=True, kw_only=True)
class Swap:
    """Two points were mistaken for one another from a frame on.

    Parameters
    ----------
    frame : int
        First frame in which they are exchanged.
    first, second : str
        The two points.
    view : str, optional
        The one view in which it happened; None for every view and the 3D points.
    """

    frame: int
    first: str
    second: str
    view: str | None = None


@dataclass(frozen=True, kw_only=True)
class Retrack:
    """The trial was tracked again from a frame on, every state of the tracker reset.

    Parameters
    ----------
    frame : int
        The frame it was started from.
    learn : bool
        Whether the colours of the corrected points were learnt anew there.
    """

    frame: int
    learn: bool = False


Edit: TypeAlias = Move | Accept | Hide | Swap | Retrack
Entry: TypeAlias = Edit | Literal["undo", "redo"]

_KINDS: dict[str, type[Edit]] = {
    "move": Move, "accept": Accept, "hide": Hide, "swap": Swap, "retrack": Retrack,
}  # fmt: skip
_NAMES = {cls: name for name, cls in _KINDS.items()}
_WORDS = {"frame": "a whole number", "u": "a number", "v": "a number", "learn": "true or false"}
# what a crash left of a line is kept under this name, so that the file stays readable
_FRAGMENT = "unfinished"


def edit_to_line(entry: Entry) -> str:
    """Write one entry as a line of JSON, without the end of line.

    Parameters
    ----------
    entry : Move, Accept, Hide, Swap, Retrack, "undo" or "redo"
        What was done.

    Returns
    -------
    str
        The line; numbers are written in full, so that reading gives the same record.
    """
    if isinstance(entry, str):
        return json.dumps({"edit": entry})
    record = dataclasses.asdict(entry)
    if not record.get("learn", True):
        del record["learn"]
    return json.dumps({"edit": _NAMES[type(entry)], **record})


def edit_from_line(line: str, *, where: str = "edits.jsonl") -> Entry | None:
    """Read one line of ``edits.jsonl``.

    Parameters
    ----------
    line : str
        The line.
    where : str
        File and line number for the message.

    Returns
    -------
    Move, Accept, Hide, Swap, Retrack, "undo", "redo" or None
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
    if kind == "undo" or kind == "redo":
        return kind
    if kind == _FRAGMENT:
        return None
    if not isinstance(kind, str) or kind not in _KINDS:
        known = [*_KINDS, "undo", "redo"]
        raise InputError(
            f"{where}: unknown kind of edit {kind!r}{did_you_mean(str(kind), known)}; "
            f"expected {', '.join(known)}."
        )
    fields = {f.name: f for f in dataclasses.fields(_KINDS[kind])}
    for name in record:
        if name not in fields:
            raise InputError(
                f"{where}: unknown field {name!r}{did_you_mean(name, fields)}; "
                f"a {kind} has {', '.join(fields)}."
            )
    for name, field in fields.items():
        if name not in record and field.default is dataclasses.MISSING:
            raise InputError(f"{where}: a {kind} needs {name!r}; mend or remove that line.")
        if name in record and not _fits(name, record[name]):
            raise InputError(
                f"{where}: {name} is {record.get(name)!r}; expected {_WORDS.get(name, 'text')}."
            )
    return _KINDS[kind](**record)


def _fits(name: str, value: Any) -> bool:
    """Whether a value of a line has the type of its field."""
    if name == "frame":
        return isinstance(value, int) and not isinstance(value, bool)
    if name == "learn":
        return isinstance(value, bool)
    if name in ("u", "v"):
        return (
            isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        )
    return isinstance(value, str) or (name == "view" and value is None)


class EditFile:
    """``edits.jsonl`` open for appending.

    Parameters
    ----------
    path : Path
        The file; it is made, with its folder, when the first line is appended.

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

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.entries, self._fragment, self.notes = _read(self.path)
        self._size = self._size_now()

    def append(self, entry: Entry) -> None:
        """Add one line and force it to disk before returning.

        Parameters
        ----------
        entry : Move, Accept, Hide, Swap, Retrack, "undo" or "redo"
            What was done.

        Raises
        ------
        InputError
            If the file was changed by somebody else since it was read, or cannot be written.
        """
        if self._size_now() != self._size:
            raise InputError(
                f"{self.path}: changed by another window or program since it was opened here, so "
                "this correction was not made; open the tracks again and repeat it."
            )
        line = edit_to_line(entry) + "\n"
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


def read_edits(path: str | Path) -> tuple[list[Entry], list[str]]:
    """Read ``edits.jsonl`` without changing it.

    Parameters
    ----------
    path : str or Path
        The file; one that does not exist holds no edits.

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
    entries, _, notes = _read(Path(path))
    return entries, notes


def _read(path: Path) -> tuple[list[Entry], str, list[str]]:
    """Read the entries, what stands after the last end of line, and the notes."""
    if not path.exists():
        return [], "", []
    try:
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text ({error.reason}); is this edits.jsonl?") from None
    *lines, last = text.split("\n")
    whole = _whole_line(last) == last
    entries = []
    for number, line in enumerate([*lines, last] if whole else lines, start=1):
        entry = edit_from_line(line, where=f"{path.name}, line {number}") if line.strip() else None
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
