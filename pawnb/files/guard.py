"""Files that several windows may have open: none writes over what another has written since."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pawnb.errors import InputError
from pawnb.files.lock import locked
from pawnb.files.reading import check_file

_WAIT_S = 5.0
"""How long to wait for another window that is writing: each of them needs some milliseconds."""


class GuardedFile:
    """A file as this window knows it: as it was opened here, or as this window wrote it last.

    Make it before the file is read: what changes between the two is then noticed, too.

    Parameters
    ----------
    path : str or Path
        The file; it need not exist yet.

    Attributes
    ----------
    path : Path
        The file.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path).absolute()  # a notebook may go to another folder meanwhile
        self._folder = find_standing_folder(self.path)
        self._known = _checksum(self.path)

    @contextmanager
    def writing(self, *, refused: str) -> Iterator[None]:
        """Write the file inside this block, alone, and remember it as it is afterwards.

        Parameters
        ----------
        refused : str
            What was not done where the file has changed, and what to do then, as the end of a
            sentence.

        Raises
        ------
        InputError
            If the file is no longer as this window knows it, another one is writing it, or its
            folder was moved.
        """
        if not self._folder.is_dir():
            raise InputError(f"{say_moved(self._folder, self.path)}; {refused}.")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with locked(self.path, remedy=refused, wait_s=_WAIT_S):
            self.check(refused=refused)
            yield
            self._known = _checksum(self.path)

    def check(self, *, refused: str) -> None:
        """Raise InputError if the file is no longer as this window knows it."""
        if _checksum(self.path) != self._known:
            raise InputError(
                f"{self.path}: changed by another window or program since it was opened here; "
                f"{refused}."
            )


def find_standing_folder(path: Path) -> Path:
    """Return the nearest folder above a file that is there: what is missing may be made in it."""
    return next((folder for folder in path.parents if folder.is_dir()), path.parent)


def say_moved(folder: Path, path: Path) -> str:
    """Say that the folder of a file is there no more: nothing is written where it was."""
    return f"{folder}: moved, renamed or deleted since {path.name} was opened in it"


def _checksum(path: Path) -> bytes | None:
    """Return the SHA-256 of a file; None where there is none."""
    if not path.exists():
        return None
    check_file(path, expected="a file that can be written anew")  # a pipe would be waited for
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").digest()
    except (FileNotFoundError, NotADirectoryError):
        return None
