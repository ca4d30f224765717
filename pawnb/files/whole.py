"""Files that are there whole or not at all, also after a crash or on a full disk."""

from __future__ import annotations

import os
import secrets
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pawnb.errors import InputError
from pawnb.files.refused import how_to_write

_LEFTOVER = ".pawnb-*.part*"

_WAITS_S = (0.05, 0.1, 0.2, 0.4, 0.8)
"""How long to wait for whoever holds a file open, time after time."""


def part_name(path: Path) -> Path:
    """Return a name beside a path that no other run takes; its ending stays."""
    # the name itself is left out: together they may be longer than a file system allows
    return path.with_name(f".pawnb-{secrets.token_hex(6)}.part{path.suffix}")


def move_over(source: Path, target: Path) -> None:
    """Give a file the name of another, which is gone then.

    On Windows that is refused while anyone has one of them open, and virus scanners and search
    indices open new files for a moment: then it is tried again for a second and a half.

    Parameters
    ----------
    source, target : Path
        The file, and its name from here on, in the same file system.

    Raises
    ------
    OSError
        If it cannot be done; both are then as they were.
    """
    for wait_s in _WAITS_S:
        try:
            source.replace(target)
        except PermissionError as error:
            if getattr(error, "winerror", None) is None:
                raise
            time.sleep(wait_s)
        else:
            return
    source.replace(target)


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Give a file its name only once it is whole and on disk.

    Parameters
    ----------
    path : str or Path
        The file; its folder must exist. What is there already stays until then.

    Yields
    ------
    Path
        Where to write: a name of its own in the same folder, with the same ending. It is removed
        where the block ends with an error.

    Raises
    ------
    InputError
        If the folder does not exist, or the file cannot be written (a full disk, for instance).
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path.parent}: no such folder; make it, or name another file.")
    part = part_name(path)
    try:
        with _said_in_a_sentence(path):
            yield part
            # what is written into something unfinished is forced to disk when that is finished
            lasts = not any(map(is_leftover, path.parents))
            if lasts:
                force_to_disk(part)
            move_over(part, path)
            if lasts:
                sync_folder(path.parent)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def write_whole(path: str | Path, data: bytes) -> Path:
    """Write a file whole or not at all.

    Parameters
    ----------
    path : str or Path
        The file; its folder must exist.
    data : bytes
        What it shall hold.

    Returns
    -------
    Path
        The file, forced to disk.

    Raises
    ------
    InputError
        As for :func:`whole_file`; the file is then as it was.
    """
    with whole_file(path) as part:
        part.write_bytes(data)
        if (written := part.stat().st_size) != len(data):
            raise InputError(f"{path}: {written} of {len(data)} bytes were written; try again.")
    return Path(path)


def keep_copy(path: Path, word: str) -> Path:
    """Keep what a file holds in a copy beside it; no earlier copy is written over.

    Parameters
    ----------
    path : Path
        The file.
    word : str
        What stands before the ending of the copy: ``"before"`` makes ``start.before.csv``, then
        ``start.before-2.csv`` ...

    Returns
    -------
    Path
        The copy; an earlier one where that holds the same.
    """
    data, number = path.read_bytes(), 1
    copy = path.with_name(f"{path.stem}.{word}{path.suffix}")
    while copy.exists() and copy.read_bytes() != data:
        number += 1
        copy = path.with_name(f"{path.stem}.{word}-{number}{path.suffix}")
    return copy if copy.exists() else write_whole(copy, data)


def is_copy(path: Path, word: str) -> bool:
    """Tell whether a file is called as a copy that :func:`keep_copy` has made with that word."""
    _, _, last = path.stem.rpartition(".")
    return last.partition("-")[0] == word and last != path.stem


def write_new(path: str | Path, data: bytes) -> Path:
    """Write a file that must not be there yet.

    Parameters
    ----------
    path : str or Path
        The file; its folder must exist.
    data : bytes
        What it shall hold.

    Returns
    -------
    Path
        The file, forced to disk.

    Raises
    ------
    FileExistsError
        If there is one already, which stays as it is.
    """
    path = Path(path)
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    return path


def force_to_disk(path: Path) -> None:
    """Force what a file holds to disk."""
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Force the names in a folder to disk, where the system can."""
    if os.name == "nt":  # folders cannot be opened there
        return
    with suppress(OSError):  # not every network file system can
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def is_leftover(path: Path) -> bool:
    """Say whether a name is that of something unfinished, as a killed run leaves it."""
    return path.match(_LEFTOVER)


def remove_leftovers(folder: Path) -> None:
    """Remove what killed runs left unfinished in a folder; call it only while it is locked."""
    for path in list(folder.glob(_LEFTOVER)):
        with suppress(OSError):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


@contextmanager
def _said_in_a_sentence(path: Path) -> Iterator[None]:
    """Say in one sentence that a file cannot be written."""
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{path}: cannot be written ({error.strerror or error}); {how_to_write(error)}."
        ) from None
