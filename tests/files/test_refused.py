"""What is said where the system refuses to write; its errors are those of POSIX (errno.h)."""

import errno
import os

import pytest

from pawnb.files import how_to_write


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (errno.ENOSPC, "free some space or choose another folder"),
        (errno.EDQUOT, "free some space or choose another folder"),
        (errno.EROFS, "this drive can only be read, so choose another folder"),
        (errno.EACCES, "close it in other programs, such as a spreadsheet, or get the right"),
        (errno.ENAMETOOLONG, "give it a shorter name, or choose another folder"),
        (errno.EIO, "see that the drive is there, or choose another folder"),
    ],
)
def test_what_to_do_fits_why_it_was_refused(code, said):
    error = OSError(code, os.strerror(code))
    assert how_to_write(error, elsewhere="another folder").startswith(said)
