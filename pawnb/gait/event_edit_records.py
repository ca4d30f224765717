"""Corrections of events as frozen records, and the file that keeps them: one JSON object a line.

Undo and redo are lines too, so nothing a person entered is ever taken out of the file.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from pawnb.errors import InputError, did_you_mean

FILE_NAME = "event_edits.jsonl"
_FRAGMENT = "unfinished"


@dataclass(frozen=True, kw_only=True)
class MoveEvent:
    """The event was at another time.

    Parameters
    ----------
    animal, trial, leg, event : str
        Which event: AEP, PEP, TD or LO of a leg.
    time_s : float
        Where it stands now.
    to_s : float
        Where it belongs.
    """

    animal: str
    trial: str
    leg: str
    event: str
    time_s: float
    to_s: float


@dataclass(frozen=True, kw_only=True)
class DeleteEvent:
    """There was no such event; fields as those of :class:`MoveEvent`."""

    animal: str
    trial: str
    leg: str
    event: str
    time_s: float


@dataclass(frozen=True, kw_only=True)
class ExcludeStride:
    """A stride that shall not count.

    Parameters
    ----------
    animal, trial, leg : str
        Whose stride.
    start_s : float
        When it begins.
    reason : str
        Why; it stands in the table of what was dropped.
    """

    animal: str
    trial: str
    leg: str
    start_s: float
    reason: str


EventEdit: TypeAlias = MoveEvent | DeleteEvent | ExcludeStride
Entry: TypeAlias = EventEdit | Literal["undo", "redo"]
_KINDS: dict[str, type[EventEdit]] = {
    "move": MoveEvent, "delete": DeleteEvent, "exclude": ExcludeStride,
}  # fmt: skip
_NAMES = {cls: name for name, cls in _KINDS.items()}


class EventEditFile:
    """``event_edits.jsonl`` open for appending.

    Parameters
    ----------
    path : str or Path
        The file; it is made, with its folder, when the first line is appended.

    Attributes
    ----------
    entries : list
        What was read, in order.
    notes : list of str
        What a person should know: a half-written last line, for instance.

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
        entry : MoveEvent, DeleteEvent, ExcludeStride, "undo" or "redo"
            What was done.

        Raises
        ------
        InputError
            If the file was changed by somebody else since it was read, or cannot be written.
        """
        path = self.path
        if self._size_now() != self._size:
            raise InputError(
                f"{path}: changed by another window or program since it was opened here, so this "
                "correction was not made; open the analysis again and repeat it."
            )
        line = edit_to_line(entry) + "\n"
        if self._fragment:
            # what a crash left of a line becomes a whole one, written over itself
            line = json.dumps({"edit": _FRAGMENT, "text": self._fragment}) + "\n" + line
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("r+b" if path.exists() else "xb") as file:
                file.seek(self._size - len(self._fragment.encode()))
                file.write(line.encode())
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise InputError(
                f"{path}: cannot be written ({error.strerror}), so this correction was not made."
            ) from None
        self._fragment, self._size = "", self._size_now()

    def _size_now(self) -> int:
        """Return the size of the file in bytes, 0 where there is none."""
        return self.path.stat().st_size if self.path.exists() else 0


def edit_to_line(entry: Entry) -> str:
    """Write one entry as a line of JSON, without the end of line."""
    if isinstance(entry, str):
        return json.dumps({"edit": entry})
    return json.dumps({"edit": _NAMES[type(entry)], **dataclasses.asdict(entry)})


def edit_from_line(line: str, *, where: str = FILE_NAME) -> Entry | None:
    """Read one line; None for one that keeps what a crash left of another.

    Parameters
    ----------
    line : str
        The line.
    where : str
        File and line for the message.

    Returns
    -------
    MoveEvent, DeleteEvent, ExcludeStride, "undo", "redo" or None
        The entry.

    Raises
    ------
    InputError
        If the line is not JSON, of an unknown kind, or its fields are not those of its kind.
    """
    try:
        record = json.loads(line)
    except json.JSONDecodeError:
        record = None
    if not isinstance(record, dict):
        raise InputError(f"{where}: not a JSON object: {line.strip()[:60]!r}; mend or remove it.")
    kind = record.pop("edit", None)
    if kind == "undo" or kind == "redo":
        return kind
    if kind == _FRAGMENT:
        return None
    if kind not in _KINDS:
        known = [*_KINDS, "undo", "redo"]
        raise InputError(
            f"{where}: unknown kind of edit {kind!r}{did_you_mean(str(kind), known)}; "
            f"expected {', '.join(known)}."
        )
    fields = [field.name for field in dataclasses.fields(_KINDS[kind])]
    if set(record) != set(fields):
        raise InputError(
            f"{where}: a {kind} has {', '.join(fields)}; found {', '.join(record) or 'nothing'}."
        )
    for name, value in record.items():
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (
            (number and math.isfinite(value)) if name.endswith("_s") else isinstance(value, str)
        ):
            expected = "a number" if name.endswith("_s") else "text"
            raise InputError(f"{where}: {name} is {value!r}; expected {expected}.")
    return _KINDS[kind](**record)


def _read(path: Path) -> tuple[list[Entry], str, list[str]]:
    """Read the entries, what a crash left of the last line, and the notes."""
    if not path.exists():
        return [], "", []
    try:
        *lines, last = path.read_bytes().decode("utf-8").split("\n")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text ({error.reason}); is this {FILE_NAME}?") from None
    found = [
        edit_from_line(line, where=f"{path.name}, line {number}")
        for number, line in enumerate(lines, start=1)
        if line.strip()
    ]
    note = [f"{path.name}: the last line was only half written and is left out: {last[:80]!r}."]
    return [entry for entry in found if entry is not None], last, note if last else []
