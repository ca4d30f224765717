"""Folders whose files are replaced together: all of them, or none."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from pawnb.errors import InputError
from pawnb.files.refused import how_to_write
from pawnb.files.whole import (
    force_to_disk,
    move_over,
    remove_leftovers,
    sync_folder,
    write_whole,
)


@contextmanager
def staged(folder: Path, *, elsewhere: str) -> Iterator[Path]:
    """Give a place for files that shall be in a folder later; call it while that is locked.

    Parameters
    ----------
    folder : Path
        The folder; what killed runs have left there is removed.
    elsewhere : str
        Where a person can have them where nothing can be written there.

    Yields
    ------
    Path
        A folder within, removed when the block ends.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    remove_leftovers(folder)
    staging = folder / f".pawnb-{secrets.token_hex(6)}.part"
    try:
        staging.mkdir()
        yield staging
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written ({error.strerror or error}); "
            f"{how_to_write(error, elsewhere=elsewhere)}."
        ) from None
    except InputError as error:
        if str(staging) not in str(error):
            raise
        raise type(error)(str(error).replace(str(staging), str(folder))) from None
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def staged_files(staging: Path) -> list[str]:
    """Return the names of what was staged, relative to it, each file forced to disk."""
    files = sorted(path for path in staging.rglob("*") if path.is_file())
    for path in files:
        force_to_disk(path)
    return [path.relative_to(staging).as_posix() for path in files]


def check_replaceable(files: Iterable[Path]) -> None:
    """Refuse files that another program holds open so that nothing can take their place.

    Windows does not let a file be replaced that a spreadsheet shows; other systems do.

    Parameters
    ----------
    files : iterable of Path
        Files that will be replaced or removed; those that are not there are passed over.

    Raises
    ------
    InputError
        If one cannot be replaced.
    """
    for file in files:
        if not file.is_file():
            continue
        try:
            move_over(file, file)
        except OSError as error:
            raise InputError(
                f"{file}: cannot be replaced ({error.strerror or error}); close it in other "
                "programs, such as a spreadsheet, and try again."
            ) from None


class Listing:
    """A file that says what a folder holds: it is there only while that is true.

    Parameters
    ----------
    folder : Path
        The folder.
    name, aside : str
        Its name, and that under which the listing before stays while files are replaced.
    """

    def __init__(self, folder: Path, name: str, aside: str) -> None:
        self._folder, self._name, self._aside = folder, name, aside

    def replace(
        self,
        staging: Path,
        files: Iterable[str],
        *,
        gone: Iterable[str],
        listing: bytes,
        empty: bytes,
    ) -> None:
        """Put staged files in their places, and say last what is there.

        Parameters
        ----------
        staging : Path
            Where they are, see :func:`staged`.
        files, gone : iterable of str
            Their names, and those of files that are removed.
        listing, empty : bytes
            What the listing says then, and what that of an empty folder does.
        """
        folder, own, aside = self._folder, self._folder / self._name, self._folder / self._aside
        names, gone = list(files), list(gone)
        # before anything has changed
        check_replaceable(folder / name for name in [*names, *gone])
        # nothing that follows needs room on the disk
        write_whole(staging / self._name, listing)
        if own.exists():
            move_over(own, aside)
        elif not aside.exists():
            write_whole(aside, empty)
        sync_folder(folder)
        for name in names:
            move_over(staging / name, folder / name)
        for name in gone:
            (folder / name).unlink()
        for part in {(folder / name).parent for name in names} | {folder}:
            sync_folder(part)
        move_over(staging / self._name, own)
        sync_folder(folder)
        aside.unlink(missing_ok=True)
