"""Files that somebody named: read only where they are regular files of a bearable size.

A name may be that of a folder, of a named pipe at which a reader waits for ever, of a device
that never ends, or of a file that fills the memory. All that opens a file by a name from
outside looks at it here first.
"""

from __future__ import annotations

import itertools
import re
import stat
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pawnb.errors import InputError, did_you_mean

MOST_TEXT_BYTES = 2**20
"""Size of a settings file (trial, species, lenses): the largest known has 20 kB."""

MOST_TABLE_BYTES = 2**30
"""Size of a table: 1 GiB holds some 20 million rows of tracks."""

_MOST_DEPTH = 16
"""Depth of nested values in a settings file; those of pawnb have 4."""

_KEY = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_LONG_KEY = re.compile(rf"(?<![\w-])(?:{_KEY}[ \t]*\.[ \t]*){{{_MOST_DEPTH}}}")
"""A dotted key so deep that parsing it takes memory by the square of its length."""

_MOST_NEIGHBOURS = 1000

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def check_file(
    path: str | Path,
    *,
    expected: str = "a file",
    most_bytes: int | None = None,
    error: type[InputError] = InputError,
) -> Path:
    """Refuse what is not a regular file, or is too large, without opening it.

    Parameters
    ----------
    path : str or Path
        A name from outside.
    expected : str
        What the file should be, for the message ("a csv of start clicks").
    most_bytes : int, optional
        Its largest size; default any.
    error : type
        Kind of InputError to raise.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        Of the kind asked for: if it is missing, a folder, a pipe, a device, out of reach or
        too large.
    """
    path = Path(path)
    shown, mend = _as_typed(path)
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        if path.is_symlink():
            raise error(
                f"{path}: a link to {path.readlink()}, which is not there; expected {expected}."
            ) from None
        near = did_you_mean(path.name, _neighbours(path))
        raise error(f"{shown}: no such file{near}; expected {expected}{mend}.") from None
    except (OSError, ValueError, RuntimeError) as reason:  # no access, a loop, a name that is none
        said = getattr(reason, "strerror", None) or reason
        raise error(f"{str(path)!r}: cannot be read ({said}); expected {expected}{mend}.") from None
    if not stat.S_ISREG(found.st_mode):
        kind = next((word for test, word in _KINDS if test(found.st_mode)), "no regular file")
        raise error(f"{path}: {kind}; expected {expected}.")
    if most_bytes is not None and found.st_size > most_bytes:
        raise error(
            f"{path}: {_size(found.st_size)} large; expected {expected}, of at most "
            f"{_size(most_bytes)}."
        )
    return path


def read_bytes(
    path: str | Path,
    *,
    expected: str = "a file",
    most_bytes: int = MOST_TABLE_BYTES,
    error: type[InputError] = InputError,
) -> bytes:
    """Read a regular file of bearable size; parameters and errors as :func:`check_file`.

    Parameters
    ----------
    path : str or Path
        The file.
    expected : str
        What it should be, for messages.
    most_bytes : int
        A larger file is refused.
    error : type
        Kind of :class:`~pawnb.errors.InputError` to raise.

    Returns
    -------
    bytes
        What it holds.
    """
    path = check_file(path, expected=expected, most_bytes=most_bytes, error=error)
    try:
        with path.open("rb") as file:
            # some files of the system are endless though they say that they are empty
            data = file.read(most_bytes + 1)
    except OSError as reason:
        said = reason.strerror or reason
        raise error(f"{path}: cannot be read ({said}); expected {expected}.") from None
    if len(data) > most_bytes:
        raise error(
            f"{path}: larger than {_size(most_bytes)}; expected {expected}, of at most that."
        )
    return data


def read_text(
    path: str | Path,
    *,
    expected: str = "text",
    most_bytes: int = MOST_TABLE_BYTES,
    error: type[InputError] = InputError,
) -> str:
    r"""Read a text file in UTF-8, with or without a byte order mark; else as :func:`read_bytes`.

    Line ends come back as ``\n``.

    Parameters
    ----------
    path : str or Path
        The file.
    expected : str
        What it should be, for messages.
    most_bytes : int
        A larger file is refused.
    error : type
        Kind of :class:`~pawnb.errors.InputError` to raise.

    Returns
    -------
    str
        What it holds.
    """
    data = read_bytes(path, expected=expected, most_bytes=most_bytes, error=error)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as reason:
        line = data.count(b"\n", 0, reason.start) + 1
        raise error(
            f"{path}: line {line} is not text in UTF-8; expected {expected}: save it as UTF-8."
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_toml(
    path: str | Path, *, expected: str = "a TOML file", error: type[InputError] = InputError
) -> dict[str, Any]:
    """Read a settings file.

    Parameters
    ----------
    path : str or Path
        A name from outside.
    expected, error
        As for :func:`check_file`.

    Returns
    -------
    dict
        Sections of plain values.

    Raises
    ------
    InputError
        As :func:`read_text`, and as :func:`parse_toml`.
    """
    text = read_text(path, expected=expected, most_bytes=MOST_TEXT_BYTES, error=error)
    return parse_toml(text, where=str(path), error=error)


def parse_toml(text: str, *, where: str, error: type[InputError] = InputError) -> dict[str, Any]:
    """Take the text of a settings file apart.

    Parameters
    ----------
    text : str
        The text.
    where : str
        How messages name the file.
    error : type
        Kind of InputError to raise.

    Returns
    -------
    dict
        Sections of plain values.

    Raises
    ------
    InputError
        Of the kind asked for: if it is not TOML, or nested deeper than settings ever are.
    """
    deep = _LONG_KEY.search(text)
    if deep is not None:
        line = text.count("\n", 0, deep.start()) + 1
        raise error(f"{where}: line {line} is nested too deeply; expected plain settings.")
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise error(f"{where}: nested too deeply; expected plain settings.") from None
    except ValueError as reason:  # TOMLDecodeError, or a number of thousands of digits
        at = re.search(r"at line (\d+)", str(reason))
        bad = "".join(text.splitlines()[int(at[1]) - 1 : int(at[1])]) if at else ""
        mend = " (in paths write / for \\)" if "\\" in bad else ""
        raise error(f"{where}: not a TOML file ({reason}); mend that line{mend}.") from None
    _check_values(document, where, error)
    return document


def _check_values(document: dict[str, Any], where: str, error: type[InputError]) -> None:
    """Refuse what is nested too deeply, and whole numbers beyond the 64 bits of TOML."""
    level: list[Any] = [document]
    for _ in range(_MOST_DEPTH + 1):
        items = [v for x in level for v in (x.values() if isinstance(x, dict) else x)]
        if any(isinstance(v, int) and not -(2**63) <= v < 2**63 for v in items):
            raise error(f"{where}: holds a whole number of more than 19 digits; mend it.")
        level = [v for v in items if isinstance(v, dict | list)]
        if not level:
            return
    raise error(f"{where}: nested too deeply; expected plain settings.")


def _as_typed(path: Path) -> tuple[str, str]:
    r"""Return a path as a message shows it, and how to mend one that was written on Windows.

    There a backslash never stands in a name; within quotes, as in a trial.toml, ``\t`` is a tab
    and ``\n`` a line break.
    """
    shown = "".join(c if ord(c) >= 32 else c.encode("unicode_escape").decode() for c in str(path))
    if shown != str(path):
        return shown, (
            ": a backslash in quotes does not stand for itself; write / for \\ in paths, which "
            "every system understands"
        )
    if "\\" in path.name:
        return shown, ": write / for \\ in paths, which every system understands"
    return shown, ""


def _neighbours(path: Path) -> Iterator[str]:
    """Yield names in the folder where a file was expected."""
    try:
        yield from (p.name for p in itertools.islice(path.parent.iterdir(), _MOST_NEIGHBOURS))
    except (OSError, ValueError):
        return


def _size(n_bytes: int) -> str:
    """Write a number of bytes as a person reads it."""
    for unit, size in (("TB", 2**40), ("GB", 2**30), ("MB", 2**20)):
        if n_bytes >= size:
            return f"{n_bytes / size:.3g} {unit}"
    return f"{n_bytes / 1024:.3g} kB"
