"""Records kept while work is done: a disk that fills up costs what did not fit, and no more."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from pawnb.core.checkpoint import RecordFile

_FULL = """
import resource, sys
from pathlib import Path
from pawnb.core.checkpoint import RecordFile
from pawnb.errors import InputError
with RecordFile(Path(sys.argv[1]), "first line") as file:
    for number in range(40):
        soft = 1000 if number < 30 else resource.RLIM_INFINITY
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, resource.RLIM_INFINITY))
        try:
            file.append(bytes([number]) * 60)
            print(number)
        except InputError as error:
            print(error, file=sys.stderr)
"""


@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_what_was_kept_before_a_disk_was_full_stays_and_more_can_follow(tmp_path):
    path = tmp_path / "kept.bin"
    done = subprocess.run(
        [sys.executable, "-c", _FULL, str(path)], capture_output=True, text=True, check=True
    )
    kept = [int(line) for line in done.stdout.split()]
    assert kept[-10:] == list(range(30, 40))
    assert len(kept) > 20
    said = done.stderr.splitlines()
    assert len(said) == 40 - len(kept)
    assert all("kept.bin: cannot keep here what is done (File too large); free" in s for s in said)
    with RecordFile(path, "first line") as file:
        assert [record[0] for record in file.take_records()] == kept
