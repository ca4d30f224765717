"""One writer at a time: processes, threads, and processes that died."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading

import pytest

from pawnb.errors import InputError
from pawnb.files import locked

_HOLD = """
import sys
from pawnb.files import locked
with locked(sys.argv[1], remedy="wait"):
    print("held", flush=True)
    sys.stdin.read()
"""

_WITHOUT_LOCKS = """
import errno, filelock._unix as unix
def flock(*_):
    raise OSError(errno.ENOSYS, "Function not implemented")
unix.fcntl.flock = flock
"""
_ENTER = """
import sys
from pawnb.files import locked
with locked(sys.argv[1], remedy="wait", wait_s=float(sys.argv[2])):
    print("entered")
"""


def names(folder):
    return [path.name for path in folder.iterdir()]


@pytest.fixture
def other(tmp_path):
    """Another process that holds the folder until its input is closed."""
    process = subprocess.Popen(
        [sys.executable, "-c", _HOLD, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout.readline() == "held\n"
    yield process
    process.communicate("")


def test_another_process_is_named_in_one_sentence(tmp_path, other):
    who = f"process {other.pid} of this machine is writing here; wait a little"
    with pytest.raises(InputError, match=who), locked(tmp_path, remedy="wait a little"):
        pass
    other.communicate("")
    with locked(tmp_path, remedy="wait"):
        pass
    assert names(tmp_path) == []


def test_a_process_that_was_killed_holds_nothing(tmp_path, other):
    other.kill()
    other.wait()
    with locked(tmp_path, remedy="wait"):
        assert (tmp_path / ".pawnb.lock").read_text() == f"{os.getpid()} {socket.gethostname()}\n"
    assert names(tmp_path) == []


def test_a_thread_may_enter_again_and_another_may_not(tmp_path):
    said = []

    def enter():
        try:
            with locked(tmp_path, remedy="wait"):
                said.append("entered")
        except InputError as error:
            said.append(str(error))

    with locked(tmp_path, remedy="wait"):
        with locked(tmp_path, remedy="wait"):
            pass
        thread = threading.Thread(target=enter)
        thread.start()
        thread.join()
    assert "(this one)" in said[0]
    enter()
    assert said[1] == "entered"


@pytest.mark.slow
def test_processes_take_turns(tmp_path):
    # each adds one to a number 100 times; without a lock some additions are lost
    code = """
import sys
from pathlib import Path
from pawnb.files import locked
path = Path(sys.argv[1])
for _ in range(100):
    with locked(path, remedy="wait", wait_s=60):
        path.write_text(str(int(path.read_text()) + 1))
"""
    path = tmp_path / "number.txt"
    path.write_text("0")
    started = [subprocess.Popen([sys.executable, "-c", code, str(path)]) for _ in range(3)]
    assert [process.wait() for process in started] == [0, 0, 0]
    assert path.read_text() == "300"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="flock is not of Windows")
def test_where_the_system_knows_no_locks_a_living_process_keeps_others_out(tmp_path):
    """A file does for a lock then: who waited for longer than 2 s broke it, and both wrote."""
    holder = subprocess.Popen(
        [sys.executable, "-c", _WITHOUT_LOCKS + _HOLD, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip

    def enter(wait_s):
        command = [sys.executable, "-c", _WITHOUT_LOCKS + _ENTER, str(tmp_path), str(wait_s)]
        return subprocess.run(command, capture_output=True, text=True)

    assert holder.stdout.readline() == "held\n"
    said = enter(4.0)
    assert said.stdout == ""
    assert f"process {holder.pid} of this machine is writing here" in said.stderr
    holder.kill()
    assert holder.communicate()[1] == ""  # nor is anybody told of the lock
    assert enter(0.0).stdout == "entered\n"
    assert names(tmp_path) == []
