"""What a pose tracker has found, kept frame by frame, so that an interrupted run goes on.

A record is a dict of plain values, arrays, and lists and dicts of these. In the file it is the
number of bytes of a JSON text (uint32, little endian), the text, and the bytes of the arrays in
the order in which the text names them.
"""

from __future__ import annotations

import json
import struct
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pawnb.core.checkpoint import RecordFile
from pawnb.core.closing import Closing

_RECORD_SIZE = struct.Struct("<I")
_ARRAY = "ndarray"

Record = Mapping[str, Any]


class KeptFrames(Closing):
    """Records by the way on which a frame was come to, and its number.

    Parameters
    ----------
    path : Path, optional
        The file; without it nothing is kept.
    depends_on : str
        One line: all that the records depend on. Those of another run are dropped when the first
        new one is kept.

    Attributes
    ----------
    other : str or None
        What the records of another run depend on that the file holds.

    Raises
    ------
    InputError
        If the file cannot be read or written.
    """

    def __init__(self, path: Path | None = None, *, depends_on: str = "") -> None:
        self._file = None if path is None else RecordFile(path, depends_on)
        self._known: dict[tuple[str, int], bytes] = {}
        self._writing = threading.Lock()
        self.other = None if self._file is None else self._file.other
        if self._file is not None:
            for data in self._file.take_records():
                record = _unpacked(data)
                self._known[record["way"], record["frame"]] = data

    @property
    def frames(self) -> set[int]:
        """The frames of which there was a record when the file was opened."""
        return {frame for _, frame in self._known}

    def recall(self, way: str, frame: int) -> Record | None:
        """Return what was found in a frame on that way; None where there is no record."""
        data = self._known.get((way, frame))
        return None if data is None else _unpacked(data)["found"]

    def keep(self, way: str, frame: int, found: Record) -> None:
        """Keep what was found in a frame on that way; any thread may.

        Parameters
        ----------
        way : str
            The way through the recording.
        frame : int
            The frame.
        found : mapping
            What was found.
        """
        if self._file is not None:
            data = _packed({"way": way, "frame": frame, "found": found})
            with self._writing:
                self._file.append(data)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def remove(self) -> None:
        """Delete the file: all is done."""
        if self._file is not None:
            self._file.remove()


def _packed(record: Record) -> bytes:
    """Return a record as bytes."""
    arrays: list[bytes] = []

    def named(value: Any) -> dict[str, Any]:
        if not isinstance(value, np.ndarray):
            raise TypeError(f"{value!r} is neither a plain value nor an array")
        arrays.append(np.ascontiguousarray(value).tobytes())
        return {_ARRAY: [value.dtype.str, *value.shape]}

    text = json.dumps(record, default=named).encode()
    return _RECORD_SIZE.pack(len(text)) + text + b"".join(arrays)


def _unpacked(data: bytes) -> dict[str, Any]:
    """Return the record that :func:`_packed` made."""
    (size,) = _RECORD_SIZE.unpack_from(data)
    at = _RECORD_SIZE.size + size

    def filled(value: dict[str, Any]) -> Any:
        nonlocal at
        if list(value) != [_ARRAY]:
            return value
        kind, *shape = value[_ARRAY]
        flat = np.frombuffer(data, kind, int(np.prod(shape)), at)
        at += flat.nbytes
        return flat.reshape(shape).copy()

    record: dict[str, Any] = json.loads(
        data[_RECORD_SIZE.size : _RECORD_SIZE.size + size], object_hook=filled
    )
    return record
