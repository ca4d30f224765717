"""One writer at a time, in whatever process, window or machine the others are.

The locks are those of the operating system (through filelock), which lets go of them when a
process dies in whatever way.
"""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pawnb.errors import BusyError, InputError
from pawnb.files.refused import how_to_write
from pawnb.input_warnings import hide_warnings_of

# what file systems without locks answer; filelock itself knows ENOSYS
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EINVAL)

# of filelock, where a file has to do for a lock; not within a block, as locks are taken on threads
hide_warnings_of(saying="flock not supported")


@contextmanager
def locked(path: str | Path, *, remedy: str, wait_s: float = 0.0) -> Iterator[None]:
    """Be the only one that writes to a file or folder.

    Parameters
    ----------
    path : str or Path
        A folder, or a file (which need not exist) in a folder that does. Its lock is a hidden
        file in that folder, removed afterwards.
    remedy : str
        What a person can do where another one writes there, as the end of a sentence.
    wait_s : float
        How long to wait for the other one, s.

    Yields
    ------
    None
        While the lock is held.

    Raises
    ------
    BusyError
        If another process or thread holds the lock, with who it is.
    InputError
        If there can be no lock.

    Notes
    -----
    The thread that holds a lock may enter it again. Where the system knows no locks at all
    (ENOSYS) filelock takes it that the lock's file is there for one. Other file systems without
    locks are used without: whoever writes there checks what it finds.
    """
    import filelock  # takes 30 ms, which readers need not wait for

    path = Path(path).resolve()
    file = path / ".pawnb.lock" if path.is_dir() else path.with_name(f".{path.name}.lock")
    lock = filelock.FileLock(str(file), is_singleton=True)
    try:
        lock.acquire(timeout=wait_s, poll_interval=0.005)
    except filelock.Timeout:
        raise BusyError(f"{path}: {_holder(file)} is writing here; {remedy}.") from None
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise InputError(
                f"{path}: cannot be written ({error.strerror or error}); {how_to_write(error)}."
            ) from None
    # a lock that is but a file says itself whose it is, and is broken where it says anything else
    first = lock.lock_counter == 1 and not isinstance(lock, filelock.SoftFileLock)
    try:
        if first:
            with suppress(OSError):  # on Windows a locked file takes no second writer
                file.write_text(f"{os.getpid()} {socket.gethostname()}\n", encoding="utf-8")
        yield
    finally:
        if first:
            # while it is held: who has opened it finds it gone, and makes another
            with suppress(OSError):
                file.unlink()
        if lock.is_locked:
            lock.release()


def _holder(file: Path) -> str:
    """Return in words who holds a lock."""
    try:
        process, host, *_ = file.read_text(encoding="utf-8").split()
    except (OSError, ValueError):
        return "another window or program"
    here = " of this machine" if host == socket.gethostname() else f" of the machine {host}"
    own = " (this one)" if here == " of this machine" and process == str(os.getpid()) else ""
    return f"process {process}{own}{here}"
