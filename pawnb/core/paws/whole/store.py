"""Candidates kept while they are found, so that no frame is decoded twice.

A store holds the candidates of consecutive frames, in memory and, where it has a path, in
a file that grows frame by frame. Its key is a checksum of all that they depend on: what
was filmed, the first frame, how and where is searched, and the code that does it. A run
that asks with the same key goes on where the last one ended; any other key starts it anew.

The file is a first line, then one record a frame: the number of its bytes and their
CRC-32 (two uint32, little endian), the number of candidates of each view (uint16) and the
candidates (float32, 8 each). What follows a record that is not whole is dropped.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib.metadata
import importlib.resources
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from pawnb.core.closing import Closing
from pawnb.errors import InputError

_FIRST_LINE = "pawnb candidates 1 {key}\n"
_HEAD = struct.Struct("<II")
_COLUMNS = 8
_FLUSH_FRAMES = 50
_CODE = ("appearance.py", "candidates.py", "extract.py", "spots.py", "still.py")


class CandidateStore(Closing):
    """Candidates of consecutive frames; a context manager.

    Parameters
    ----------
    path : Path, optional
        The file. Without it candidates are kept in memory only.
    source : str
        What was filmed: changes whenever a picture of any view may.
    """

    def __init__(self, path: Path | None = None, *, source: str = "") -> None:
        self.path, self.source = path, source
        self._key = ""
        self._found: list[list[np.ndarray]] = []
        self._file: BinaryIO | None = None

    def begin(self, n_views: int, *depends_on: Any) -> list[list[np.ndarray]]:
        """Return the candidates that are there already, and get ready for more.

        Parameters
        ----------
        n_views : int
            Number of views.
        *depends_on
            All that the candidates depend on besides the source: numbers, text, arrays,
            and lists and dataclasses of these.

        Returns
        -------
        list of list of ndarray
            For each frame in turn, the candidates of each view.

        Raises
        ------
        InputError
            If the file cannot be read or written.
        """
        digest = hashlib.sha256()
        for item in (_code_checksum(), self.source, n_views, *depends_on):
            _feed(digest, item)
        key = digest.hexdigest()
        if key != self._key:
            self.close()
            self._key, self._found = key, []
            if self.path is not None:
                try:
                    self.path.parent.mkdir(parents=True, exist_ok=True)
                    self._open(self.path, n_views)
                except OSError as error:
                    raise InputError(
                        f"{self.path}: cannot keep candidates here ({error.strerror}); choose "
                        "another folder for the results."
                    ) from None
        return list(self._found)

    def add(self, candidates: Sequence[np.ndarray]) -> None:
        """Keep the candidates of the next frame."""
        self._found.append(list(candidates))
        if self.path is not None and self._file is None:
            self._file = self.path.open("ab")
        if self._file is not None:
            numbers = np.array([len(rows) for rows in candidates], "<u2")
            body = numbers.tobytes() + b"".join(
                np.ascontiguousarray(rows, "<f4").tobytes() for rows in candidates
            )
            self._file.write(_HEAD.pack(len(body), zlib.crc32(body)) + body)
            if len(self._found) % _FLUSH_FRAMES == 0:
                self._file.flush()

    def close(self) -> None:
        """Close the file; what is in memory can still be used."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self, path: Path, n_views: int) -> None:
        """Read the records of this key from the file, or start the file anew."""
        line = _FIRST_LINE.format(key=self._key).encode()
        data = path.read_bytes() if path.exists() else b""
        end = 0
        if data.startswith(line):
            end = len(line)
            while (record := _read_record(data, end, n_views)) is not None:
                self._found.append(record[0])
                end = record[1]
        if end != len(data) or not end:
            with path.open("r+b" if end else "wb") as file:
                file.truncate(end)
                if not end:
                    file.write(line)


def _read_record(data: bytes, at: int, n_views: int) -> tuple[list[np.ndarray], int] | None:
    """Return one frame's candidates and where its record ends; None if it is not whole."""
    if at + _HEAD.size > len(data):
        return None
    size, checksum = _HEAD.unpack_from(data, at)
    begin = at + _HEAD.size
    body = data[begin : begin + size]
    if len(body) < size or zlib.crc32(body) != checksum:
        return None
    numbers = np.frombuffer(body, "<u2", n_views)
    rows = np.frombuffer(body, "<f4", offset=numbers.nbytes).reshape(-1, _COLUMNS)
    return np.split(rows.astype(np.float32), np.cumsum(numbers)[:-1]), begin + size


@functools.cache
def _code_checksum() -> str:
    """Return the version and a checksum of the code that finds candidates."""
    digest = hashlib.sha256(importlib.metadata.version("pawnb").encode())
    folder = importlib.resources.files("pawnb.core.paws.whole")
    for name in _CODE:
        digest.update((folder / name).read_bytes())
    return digest.hexdigest()


def _feed(digest: hashlib._Hash, item: Any) -> None:
    """Feed a value to a checksum, with its kind and shape."""
    if dataclasses.is_dataclass(item):
        digest.update(type(item).__name__.encode())
        for field in dataclasses.fields(item):
            _feed(digest, getattr(item, field.name))
    elif isinstance(item, np.ndarray):
        digest.update(f"{item.dtype.str}{item.shape}".encode())
        digest.update(np.ascontiguousarray(item).tobytes())
    elif isinstance(item, (list, tuple)):
        digest.update(f"[{len(item)}".encode())
        for part in item:
            _feed(digest, part)
    else:
        digest.update(f"{item!r};".encode())
