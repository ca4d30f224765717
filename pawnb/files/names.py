"""Names that become files and folders: they never lead out of the folder they belong to."""

from __future__ import annotations

import hashlib
import os
import re
import shlex
from collections.abc import Collection
from pathlib import Path

from pawnb.errors import InputError

_MOST_SIGNS = 120
# names that Windows keeps for devices, with any ending
_DEVICES = {"con", "prn", "aux", "nul", *(f"{d}{n}" for d in ("com", "lpt") for n in range(1, 10))}
_FORBIDDEN = '/\\:*?"<>|'


def safe_name(name: str) -> str:
    """Return a name that every file system takes.

    Parameters
    ----------
    name : str
        Any name.

    Returns
    -------
    str
        With ``-`` for every sign but letters, digits, ``-`` and ``_``; of a name of more than 120
        signs the beginning and a checksum.
    """
    safe = "".join(c if c.isalnum() or c in "-_" else "-" for c in name)
    if len(safe.encode()) <= _MOST_SIGNS:
        return safe
    short = safe.encode()[: _MOST_SIGNS - 9].decode(errors="ignore")
    return f"{short}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def distinct_name(name: str, taken: Collection[str]) -> str:
    """Return a name that none of these is, also where capitals do not count.

    Parameters
    ----------
    name : str
        The name.
    taken : collection of str
        Names that are taken, as :func:`str.casefold` gives them.

    Returns
    -------
    str
        The name, or with ``-2``, ``-3`` ... behind it.
    """
    number, distinct = 1, name
    while distinct.casefold() in taken:
        number += 1
        distinct = f"{name}-{number}"
    return distinct


def child_folder(folder: str | Path, name: str, *, what: str) -> Path:
    """Return the folder of a name within a folder, refusing names that lead elsewhere.

    Parameters
    ----------
    folder : str or Path
        The folder; it need not exist.
    name : str
        Name of a folder directly in it.
    what : str
        What is called so, for the message: ``"the trial"``.

    Returns
    -------
    Path
        ``folder / name``.

    Raises
    ------
    InputError
        If the name is empty, is that of a device, holds signs that no file system takes
        everywhere, is ``.`` or ``..``, is absolute, or is a link that leads out of the folder.
    """
    folder = Path(folder)
    plain = bool(name.strip(". ")) and not any(c in _FORBIDDEN or ord(c) < 32 for c in name)
    plain = plain and name.split(".")[0].strip().lower() not in _DEVICES
    plain = plain and len(name.encode()) <= 255 and name == name.rstrip(". ")
    child = folder / name if plain else folder
    if not plain or os.path.normcase(child.resolve()) != os.path.normcase(folder.resolve() / name):
        where = f"; {child} leads to {child.resolve()}" if plain else ""
        raise InputError(
            f"{what} is called {name!r}, which cannot be the name of a folder in {folder}{where}; "
            "give it a plain name, such as m07-03."
        )
    return child


def as_word(path: str | Path) -> str:
    """Return a path as it is typed into a command, quoted where it holds blanks or the like.

    Parameters
    ----------
    path : str or Path
        The path.

    Returns
    -------
    str
        One word of a command of this system.
    """
    if os.name == "nt":  # cmd and PowerShell know double quotes only
        return f'"{path}"' if re.search(r"[\s&()]", str(path)) else str(path)
    return shlex.quote(str(path))
