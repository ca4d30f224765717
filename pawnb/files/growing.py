"""Files that grow: what is added is in them whole, or they are as they were."""

from __future__ import annotations

import os
from contextlib import suppress
from io import FileIO
from pathlib import Path


def open_growing(path: Path) -> FileIO:
    """Open a file to read it and to add to its end; it is made where it is absent."""
    # unbuffered: what could not be written is not tried again when the file is closed
    return path.open("a+b", buffering=0)


def write_at(
    file: FileIO, end: int, data: bytes, *, forced: bool = False, put_back: bytes = b""
) -> None:
    """Put bytes behind the part of a file that is known, in place of whatever stands there.

    Parameters
    ----------
    file : FileIO
        A file of :func:`open_growing`.
    end : int
        How many of its bytes stay.
    data : bytes
        What follows them.
    forced : bool
        Whether to force it to disk.
    put_back : bytes
        What follows them where the data cannot be written.

    Raises
    ------
    OSError
        If it cannot be written, on a full disk for instance.
    """
    try:
        file.truncate(end)
        file.seek(end)
        write_all(file, data)
        if forced:
            os.fsync(file.fileno())
    except OSError:
        with suppress(OSError):
            file.truncate(end)
            file.seek(end)
            write_all(file, put_back)
        raise


def write_all(file: FileIO, data: bytes) -> None:
    """Write to the end of the data; a disk that fills up may take a part without a word."""
    while data:
        data = data[file.write(data) :]
