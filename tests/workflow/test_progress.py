"""Bars of progress: where somebody sees them, and nowhere else."""

import contextlib
import io
import os
import re
import sys
from types import SimpleNamespace

import ipykernel  # noqa: F401  that both are imported does not make a notebook
import IPython  # noqa: F401
import pytest

from pawnb.workflow import progress


def test_no_bar_where_nobody_looks(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False, raising=False)
    assert progress._make_bar("tracking", "frame") is None
    assert capsys.readouterr().out == ""


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


def test_what_comes_after_the_last_frame_is_said_while_it_lasts(monkeypatch):
    monkeypatch.setattr(progress, "_in_notebook", lambda: False)
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.progress_bar("tracking", then="deciding") as update:
        update(1, 2)
        assert "deciding" not in terminal.getvalue()
        update(2, 2)
        assert "tracking, deciding: 100%" in terminal.getvalue()
    assert terminal.getvalue().rstrip().split("\r")[-1].startswith("tracking: 100%")


@pytest.mark.parametrize(("shell", "expected"), [(None, False), (SimpleNamespace(kernel=1), True)])
def test_a_notebook_is_where_a_kernel_runs(monkeypatch, shell, expected):
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert progress._in_notebook() is expected
