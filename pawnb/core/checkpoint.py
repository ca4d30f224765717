"""A file that grows record by record while work is done, so that no work is lost or done twice."""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import importlib.resources
import struct
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

from pawnb.core.closing import Closing
from pawnb.errors import InputError
from pawnb.files import check_file, how_to_write, open_growing, write_at

_RECORD_HEAD = struct.Struct("<II")


class RecordFile(Closing):
    """Records in a file, under a first line that says all they depend on.

    Where the file begins with the same line, its records are there already; any other file is
    replaced when the first record is added. A record is the number of its bytes and their CRC-32
    (two uint32, little endian), and the bytes. What follows a record that is not whole is dropped.

    Parameters
    ----------
    path : Path
        The file; its folder is made where it is absent.
    first_line : str
        One line of text.

    Attributes
    ----------
    other : str or None
        The first line of the file that is there, where it is another and records follow.

    Raises
    ------
    InputError
        If the file cannot be read or written.
    """

    def __init__(self, path: Path, first_line: str) -> None:
        self.path = path
        self.other: str | None = None
        self._line = first_line.encode() + b"\n"
        self._records: list[bytes] = []
        self._end = 0
        self._file: FileIO | None = None
        with self._refused():
            path.parent.mkdir(parents=True, exist_ok=True)
            self._read(check_file(path).read_bytes() if path.exists() else b"")

    def take_records(self) -> list[bytes]:
        """Return the records that were there already, and keep them in memory no longer."""
        records, self._records = self._records, []
        return records

    def append(self, record: bytes) -> None:
        """Add a record; it is in the file when this returns.

        Raises
        ------
        InputError
            If there is no room for it; the records before it stay.
        """
        if self._file is None:
            self._file = self._opened()
        data = _RECORD_HEAD.pack(len(record), zlib.crc32(record)) + record
        with self._refused():
            write_at(self._file, self._end, data)
        self._end += len(data)

    def close(self) -> None:
        """Close the file; a further record opens it again."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def remove(self) -> None:
        """Close the file and delete it."""
        self.close()
        self.path.unlink(missing_ok=True)

    def _read(self, data: bytes) -> None:
        """Read the records, and find where they end."""
        line, newline, _ = data.partition(b"\n")
        start = len(line) + len(newline)
        if line + newline != self._line:
            if _record_at(data, start) is not None:
                self.other = line.decode(errors="replace")
            return
        self._end = start
        while (record := _record_at(data, self._end)) is not None:
            self._records.append(record)
            self._end += _RECORD_HEAD.size + len(record)

    def _opened(self) -> FileIO:
        """Return the file, open where the next record belongs, without what is not of these."""
        with self._refused():
            file = open_growing(self.path)
            try:
                if not self._end:
                    write_at(file, 0, self._line)
                    self._end = len(self._line)
            except OSError:
                file.close()
                raise
            return file

    @contextmanager
    def _refused(self) -> Iterator[None]:
        """Say in one sentence that the file cannot be used."""
        try:
            yield
        except OSError as error:
            raise InputError(
                f"{self.path}: cannot keep here what is done ({error.strerror}); "
                f"{how_to_write(error, elsewhere='another folder for the results')}."
            ) from None


def _record_at(data: bytes, at: int) -> bytes | None:
    """Return the record that begins there; None if it is not whole."""
    if at + _RECORD_HEAD.size > len(data):
        return None
    size, checksum = _RECORD_HEAD.unpack_from(data, at)
    body = data[at + _RECORD_HEAD.size : at + _RECORD_HEAD.size + size]
    return body if len(body) == size and zlib.crc32(body) == checksum else None


@functools.cache
def code_checksum(package: str, names: Sequence[str] = ()) -> str:
    """Return a checksum of pawnb's version and of the code of a package.

    Parameters
    ----------
    package : str
        Its name, dotted.
    names : sequence of str
        Files of it; default every ``.py`` file, also of the packages within.

    Returns
    -------
    str
        SHA-256.
    """
    digest = hashlib.sha256(importlib.metadata.version("pawnb").encode())
    folder = Path(str(importlib.resources.files(package)))
    for file in [folder / name for name in names] or sorted(folder.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()
