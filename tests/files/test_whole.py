"""Whole files: killed, refused and out of space, what was there stays."""

from __future__ import annotations

import errno
import os
import subprocess
import sys

import pytest

from pawnb.errors import InputError
from pawnb.files import is_copy, keep_copy, remove_leftovers, whole_file, write_whole

# a subprocess that may write files of 1000 bytes only: the limit stands for a full disk
_SMALL_DISK = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
"""


def names(folder):
    return [path.name for path in folder.iterdir()]


def _fill_up(part):
    part.write_bytes(b"half")
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


posix = pytest.mark.skipif(os.name == "nt", reason="limits and signals of POSIX")


def test_writes_what_it_is_given_and_leaves_nothing_else(tmp_path):
    path = tmp_path / "a.csv"
    assert write_whole(path, b"old") == path
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"
    assert names(tmp_path) == ["a.csv"]


@posix
def test_a_new_file_may_be_read_by_whom_the_mask_allows(tmp_path):
    before = os.umask(0o027)
    try:
        path = write_whole(tmp_path / "a.csv", b"1")
    finally:
        os.umask(before)
    assert path.stat().st_mode & 0o777 == 0o640


def test_two_writers_of_one_file_have_names_of_their_own(tmp_path):
    path = tmp_path / "a.csv"
    with whole_file(path) as one:
        one.write_bytes(b"one")
        with whole_file(path) as two:
            two.write_bytes(b"two")
        assert path.read_bytes() == b"two"
    assert path.read_bytes() == b"one"
    assert names(tmp_path) == ["a.csv"]


def test_an_error_while_writing_leaves_the_file_as_it_was(tmp_path):
    path = write_whole(tmp_path / "a.csv", b"old")
    with pytest.raises(InputError, match="No space left"), whole_file(path) as part:
        _fill_up(part)
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a.csv"]


def test_refusals_are_one_sentence(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        write_whole(tmp_path / "none" / "a.csv", b"")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="folder: cannot be written"):
        write_whole(tmp_path / "folder", b"")
    assert names(tmp_path) == ["folder"]


@posix
def test_a_full_disk_is_a_sentence_and_the_file_stays(tmp_path):
    path = write_whole(tmp_path / "a.csv", b"old")
    code = _SMALL_DISK + (
        "from pawnb.files import write_whole\n"
        "from pawnb.errors import InputError\n"
        "try:\n    write_whole(sys.argv[1], b'x' * 5000)\n"
        "except InputError as error:\n    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    assert "a.csv: cannot be written (File too large)" in done.stdout
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a.csv"]


def test_copies_are_never_written_over(tmp_path):
    path = tmp_path / "start.csv"
    for text in ("one", "two", "three", "two"):
        path.write_text(text)
        assert keep_copy(path, "before").read_text() == text
    assert sorted(names(tmp_path)) == [
        "start.before-2.csv", "start.before-3.csv", "start.before.csv", "start.csv",
    ]  # fmt: skip
    assert (tmp_path / "start.before.csv").read_text() == "one"
    called = {name: is_copy(tmp_path / name, "before") for name in [*names(tmp_path), "before.csv"]}
    assert [name for name, so in called.items() if not so] == ["start.csv", "before.csv"]


@posix
def test_leftovers_of_a_killed_process_are_told_and_removed(tmp_path):
    path = write_whole(tmp_path / "a.csv", b"old")
    code = (
        "import os, signal, sys\nfrom pawnb.files import whole_file\n"
        "with whole_file(sys.argv[1]) as part:\n"
        "    part.write_bytes(b'half')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], check=False)
    assert done.returncode != 0
    assert path.read_bytes() == b"old"
    assert len(names(tmp_path)) == 2
    remove_leftovers(tmp_path)
    assert names(tmp_path) == ["a.csv"]


def held_for(times, monkeypatch, *, winerror):
    """Let a file be held open by a virus scanner for the first attempts to replace it."""
    replace, left = os.replace, iter(range(times))

    def refuse(source, target):
        if next(left, None) is not None:
            error = PermissionError(errno.EACCES, "Access is denied")
            if winerror:
                error.winerror = 5
            raise error
        replace(source, target)

    monkeypatch.setattr("os.replace", refuse)


@pytest.mark.skipif(os.name == "nt", reason="there winerror is part of every error")
@pytest.mark.slow
def test_who_holds_a_file_for_a_moment_is_waited_for_on_windows(tmp_path, monkeypatch):
    path = write_whole(tmp_path / "a.csv", b"old")
    with monkeypatch.context() as patch:
        held_for(3, patch, winerror=True)
        write_whole(path, b"new")
    assert path.read_bytes() == b"new"
    said = "close it in other programs, such as a spreadsheet"
    for times, winerror in ((100, True), (1, False)):  # elsewhere it does not pass by itself
        with monkeypatch.context() as patch:
            held_for(times, patch, winerror=winerror)
            with pytest.raises(InputError, match=said):
                write_whole(path, b"newer")
    assert path.read_bytes() == b"new"
    assert names(tmp_path) == ["a.csv"]
