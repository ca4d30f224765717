"""A file that two windows have open is written by one of them only."""

import os
import subprocess
import sys

import pytest

from pawnb.errors import InputError
from pawnb.files import GuardedFile

REFUSED = "this click was not made; open it again"


def write(guard, text):
    with guard.writing(refused=REFUSED):
        guard.path.write_text(text)


@pytest.mark.parametrize("before", [None, "frame\n0\n"])
def test_the_second_window_never_writes_over_the_first(tmp_path, before):
    path = tmp_path / "start.csv"
    if before is not None:
        path.write_text(before)
    first, second = GuardedFile(path), GuardedFile(path)
    write(first, "one")
    write(first, "one, two")
    with pytest.raises(InputError) as raised:
        write(second, "other")
    assert str(raised.value) == (
        f"{path}: changed by another window or program since it was opened here; {REFUSED}."
    )
    assert path.read_text() == "one, two"
    write(first, "one, two, three")  # the first goes on
    write(GuardedFile(path), "four")  # and so does who opens it again
    assert path.read_text() == "four"
    assert [file.name for file in tmp_path.iterdir()] == ["start.csv"]  # no lock is left


def test_a_file_that_is_taken_away_or_comes_back_is_noticed(tmp_path):
    path = tmp_path / "start.csv"
    path.write_text("one")
    guard = GuardedFile(path)
    path.unlink()
    with pytest.raises(InputError, match="changed by another window"):
        guard.check(refused=REFUSED)
    path.write_text("one")  # the same again: nothing would be lost
    guard.check(refused=REFUSED)


def test_nothing_is_written_where_a_folder_was_before_it_was_renamed(tmp_path):
    (tmp_path / "m07").mkdir()
    guard = GuardedFile(tmp_path / "m07" / "results" / "tracks.nc")
    (tmp_path / "m07").rename(tmp_path / "m08")
    with pytest.raises(InputError, match="m07: moved, renamed or deleted since"):
        write(guard, "one")
    assert [path.name for path in tmp_path.iterdir()] == ["m08"]


@pytest.mark.slow
def test_of_many_processes_that_write_at_once_one_wins(tmp_path):
    path = tmp_path / "start.csv"
    code = f"""
import sys
from pawnb.errors import InputError
from pawnb.files import GuardedFile
guard = GuardedFile({str(path)!r})
print("ready", flush=True)
sys.stdin.readline()
try:
    with guard.writing(refused="no"):
        guard.path.write_text(sys.argv[1])
    print("written")
except InputError:
    print("refused")
"""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    writers = [subprocess.Popen([sys.executable, "-c", code, str(k)], **pipes) for k in range(6)]
    for writer in writers:
        assert writer.stdout.readline() == "ready\n"
    for writer in writers:
        writer.stdin.write("\n")
        writer.stdin.flush()
    said = [writer.communicate(timeout=60)[0].strip() for writer in writers]
    assert sorted(said) == ["refused"] * 5 + ["written"]
    assert path.read_text() == str(said.index("written"))


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
def test_a_pipe_in_the_place_of_the_file_is_refused_at_once(tmp_path):
    path = tmp_path / "start.csv"
    os.mkfifo(path)
    with pytest.raises(InputError, match="a named pipe"):
        GuardedFile(path)
