"""Bars of progress: where somebody sees them, and nowhere else."""

import contextlib
import io
import os
import re
import sys
from types import SimpleNamespace

import ipykernel  # noqa: F401  that both are imported does not make a notebook
import IPython  # noqa: F401
import numba
import numpy as np
import pytest

from pawnb.workflow import progress


def test_no_bar_where_nobody_looks(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False, raising=False)
    with progress.progress_bar("tracking") as update:
        assert update is None
    assert capsys.readouterr() == ("", "")


def read_all(terminal):
    """Read what was written to a pseudo-terminal that is closed now: it comes piece by piece."""
    pieces = []
    with contextlib.suppress(OSError):  # the end
        while piece := os.read(terminal, 10_000):
            pieces.append(piece)
    os.close(terminal)
    return b"".join(pieces).decode()


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("columns", [0, 60, 120])
def test_a_terminal_is_told_the_rate_and_the_time_left(monkeypatch, columns):
    """Pseudo-terminals of scripts and containers have no width until somebody gives them one."""
    import fcntl
    import pty
    import struct
    import termios
    from multiprocessing import resource_tracker

    # from Python 3.14 the lock of a first bar starts this process, and it keeps standard error open
    resource_tracker.ensure_running()
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    with os.fdopen(theirs, "w") as terminal:
        monkeypatch.setattr(sys, "stderr", terminal)
        with progress.progress_bar("tracking") as update:
            for done in range(1, 41):
                update(done, 80)
    said = read_all(ours)
    last = said.replace("\n", "\r").strip("\r").split("\r")[-1]
    # half is done: percent, frames, time gone and left, frames a second
    assert re.search(r"tracking: +50%.* 40/80 \[\d\d:\d\d<\d\d:\d\d, +[\d.]+frame/s\]", last), last
    assert len(last) <= (columns or 80)


def make_terminal(monkeypatch):
    monkeypatch.setattr(progress, "_in_notebook", lambda: False)
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    return terminal


def last_said(terminal):
    return terminal.getvalue().rstrip().split("\r")[-1].strip()


def test_what_comes_after_the_last_frame_is_said_while_it_lasts(monkeypatch):
    terminal = make_terminal(monkeypatch)
    with progress.progress_bar("tracking", then="deciding") as update:
        update(1, 2)
        assert "deciding" not in terminal.getvalue()
        update(2, 2)
        assert last_said(terminal) == "tracking, deciding, 2 of 2 frames"
        assert "100%" not in terminal.getvalue()
    assert last_said(terminal).startswith("tracking: 100%")


def slow_to_compile():
    return numba.njit(lambda x: np.sort(x)[::2].sum())


@pytest.mark.slow
def test_a_bar_says_that_it_is_compiled_not_how_much_is_done(monkeypatch):
    """It stood at 100 % for 40 s, in silence, while a first run compiled."""
    terminal = make_terminal(monkeypatch)
    with progress.tracking_progress(None, "tracking", kind=None, then="deciding") as update:
        update(1, 2)
        update(2, 2)
        wait = slow_to_compile()
        before = len(terminal.getvalue())
        wait(np.arange(9.0))
        said = terminal.getvalue()[before:]
        assert last_said(terminal) == "tracking, deciding, 2 of 2 frames"
    assert "tracking, deciding, compiling (first run only), 2 of 2 frames" in said
    assert "%" not in said


@pytest.mark.slow
def test_nothing_but_compiling_is_said_before_the_first_frame(monkeypatch):
    terminal = make_terminal(monkeypatch)
    with progress.tracking_progress(None, "tracking", kind=None):
        slow_to_compile()(np.arange(9.0))
        assert "tracking, compiling (first run only)" in terminal.getvalue()


@pytest.mark.slow
def test_a_caller_is_told_in_words_what_is_waited_for():
    told = []

    def callback(done, total, doing):
        told.append((done, total, doing))

    with progress.tracking_progress(callback, "tracking", kind=None, then="deciding") as update:
        update(1, 2)
        slow_to_compile()(np.arange(9.0))
        update(2, 2)
    assert told == [
        (1, 2, "tracking"),
        (1, 2, "compiling (first run only)"),
        (1, 2, "tracking"),
        (2, 2, "deciding"),
    ]


@pytest.mark.slow
def test_a_caller_that_takes_numbers_only_is_told_numbers_only():
    told = []

    def callback(done, total):
        told.append((done, total))

    with progress.tracking_progress(callback, "tracking", kind=None) as update:
        slow_to_compile()(np.arange(9.0))
        update(1, 2)
    assert told == [(1, 2)]


@pytest.mark.parametrize(("shell", "expected"), [(None, False), (SimpleNamespace(kernel=1), True)])
def test_a_notebook_is_where_a_kernel_runs(monkeypatch, shell, expected):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert progress._in_notebook() is expected
