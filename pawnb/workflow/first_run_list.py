"""The list of what tracking compiles in its first run: ``python -m pawnb.workflow.first_run_list``.

Run it with an empty cache, ``NUMBA_CACHE_DIR`` in the environment naming a new folder: what takes
longest to compile comes first.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numba.core import event

from pawnb.core.compiled import Compiled
from pawnb.core.first_run import HELPERS, LATER, LIST, spell
from pawnb.core.paws.tracker import DEFAULT
from pawnb.io.tables import write_text
from pawnb.trial import load_trial
from pawnb.workflow.tracking.methods import trial_tracker
from pawnb.workflow.tracking.track import track

_PARTS_OF_CODE = {"pawnb.core.pose.space.": "space", "pawnb.core.jpeg.": LATER}
"""What only trials of two views of an animal call, and what can wait: FFmpeg decodes, too."""


def called_functions() -> dict[str, list]:
    """Return the functions that this process has called, and the types of their arguments.

    Returns
    -------
    dict
        Module and name of each, and a list of types for each way in which it was called; see
        :func:`pawnb.core.first_run.spell`.
    """
    return {
        function.name: sorted(
            ([spell(kind) for kind in way] for way in function.signatures), key=json.dumps
        )
        for function in Compiled.every
        if function.is_called and function.__module__.startswith("pawnb.")
    }


class _Seconds(event.Listener):
    """How long each function took to compile, with those that it calls."""

    def __init__(self) -> None:
        self.of: dict[str, float] = {}
        self._begun: list[float] = []

    def on_start(self, event: Any) -> None:
        del event
        self._begun.append(time.thread_time())

    def on_end(self, event: Any) -> None:
        took = time.thread_time() - self._begun.pop()
        function = event.data["dispatcher"].py_func
        name = f"{function.__module__}:{function.__qualname__}"
        if not self._begun:
            self.of[name] = self.of.get(name, 0.0) + took


def make_list(trials: Sequence[str | Path]) -> dict[str, dict[str, list]]:
    """Track trials, and list by kind of trial what was called.

    Parameters
    ----------
    trials : sequence of str or Path
        One or more of each kind.

    Returns
    -------
    dict
        Of each kind its functions, the longest to compile first, and how they were called.
    """
    kinds: dict[str, dict[str, list]] = {}
    seconds = _Seconds()
    with event.install_listener("numba:compile", seconds):
        for trial in map(load_trial, trials):
            for function in Compiled.every:
                function.is_called = False
            track(trial, progress=lambda *_: None)
            for name, ways in called_functions().items():
                part = next(
                    (part for begin, part in _PARTS_OF_CODE.items() if name.startswith(begin)),
                    trial_tracker(trial, DEFAULT).kind,
                )
                own = kinds.setdefault(part, {}).setdefault(name, [])
                own.extend(way for way in ways if way not in own)
    return {
        kind: dict(sorted(own.items(), key=lambda item: -seconds.of.get(item[0], 0.0)))
        for kind, own in kinds.items()
    }


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        Words of the command; default those of the command line.

    Returns
    -------
    int
        Exit status: 0.
    """
    parser = argparse.ArgumentParser(
        prog="python -m pawnb.workflow.first_run_list",
        description="List what tracking compiles in its first run, from trials of each kind.",
    )
    parser.add_argument("trials", nargs="+", metavar="TRIAL", help="trial.toml, or its folder")
    parser.add_argument("-o", "--out", default=LIST, type=Path, metavar="FILE")
    options = parser.parse_args(argv)
    os.environ[HELPERS] = "0"  # what others compile is not timed
    kinds = make_list(options.trials)
    # a function a line: two lists are merged line by line
    lists = [
        f"{json.dumps(kind)}: {{\n"
        + ",\n".join(f"{json.dumps(name)}: {json.dumps(ways)}" for name, ways in own.items())
        + "\n}"
        for kind, own in kinds.items()
    ]
    write_text("{" + ",\n".join(lists) + "}\n", options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
