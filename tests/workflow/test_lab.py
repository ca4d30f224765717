"""JupyterLab does not go on when the command that started it is asked to end."""

import os
import signal
import subprocess
import sys
import time

import pytest


def _is_there(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGTERM that can be heard")
def test_the_server_ends_with_the_command(tmp_path):
    """A stand-in that writes its number and sleeps: the real server takes seconds to start."""
    note = tmp_path / "number"
    server = f"import os, pathlib, time; p = pathlib.Path({str(note)!r}); t = p.with_suffix('.t'); t.write_text(str(os.getpid())); t.rename(p); time.sleep(60)"  # fmt: skip # noqa: E501
    command = f"import sys; from pawnb.workflow.lab import run_lab; run_lab([sys.executable, '-c', {server!r}])"  # fmt: skip # noqa: E501
    with subprocess.Popen([sys.executable, "-c", command]) as started:
        end = time.monotonic() + 60
        while not note.exists():
            assert time.monotonic() < end
            time.sleep(0.05)
        number = int(note.read_text())
        assert _is_there(number)
        started.send_signal(signal.SIGTERM)
        assert started.wait(30) == 0
    assert not _is_there(number)
