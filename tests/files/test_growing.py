"""Files that grow have what was added whole, or are as they were."""

from __future__ import annotations

import errno
from io import FileIO

import pytest

from pawnb.files import open_growing, write_at, write_new


class FullDisk(FileIO):
    """A file that takes three bytes and then has no room, until something shorter is written."""

    def write(self, data):
        if len(data) > 3:
            return super().write(data[:3])
        if len(data) > 1:
            raise OSError(errno.ENOSPC, "no space left")
        return super().write(data)


def test_what_is_added_replaces_what_is_not_known(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"known, and half of a rec")
    with open_growing(path) as file:
        write_at(file, 5, b"; whole", forced=True)
    assert path.read_bytes() == b"known; whole"


def test_a_full_disk_leaves_the_known_part_and_what_is_put_back(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"known-")
    with FullDisk(path, "r+") as file, pytest.raises(OSError, match="no space"):
        write_at(file, 5, b"longer", put_back=b"-")
    assert path.read_bytes() == b"known-"


def test_a_new_file_takes_the_place_of_none(tmp_path):
    path = write_new(tmp_path / "a.toml", b"one")
    with pytest.raises(FileExistsError):
        write_new(path, b"two")
    assert path.read_bytes() == b"one"
