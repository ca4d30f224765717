"""What a person can do where the system refuses to write."""

from __future__ import annotations

import errno

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_NOT_ALLOWED = (errno.EACCES, errno.EPERM)


def how_to_write(error: OSError, *, elsewhere: str = "another place") -> str:
    """Return how to mend it that a file cannot be written.

    Parameters
    ----------
    error : OSError
        What the system said.
    elsewhere : str
        Where else it could go.

    Returns
    -------
    str
        The end of a sentence, without a full stop.
    """
    if error.errno in _FULL:
        return f"free some space or choose {elsewhere}"
    if error.errno == errno.EROFS:
        return f"this drive can only be read, so choose {elsewhere}"
    if error.errno in _NOT_ALLOWED:
        return (
            "close it in other programs, such as a spreadsheet, or get the right to write there, "
            f"or choose {elsewhere}"
        )
    if error.errno == errno.ENAMETOOLONG:
        return f"give it a shorter name, or choose {elsewhere}"
    return f"see that the drive is there, or choose {elsewhere}"
