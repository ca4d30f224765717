"""Compiling side by side in a first run: helper processes compile what will be needed.

What tracking calls is compiled when it is first called, one function after the other, and kept
for the next run. Where nothing is kept yet, other processors compile meanwhile what comes later,
and put it where it is kept. What will be called, with what types of arguments, is listed in
``first_run.json``, the longest to compile first; ``python -m pawnb.workflow.first_run_list``
writes it, from runs. A function that is not listed, or is called otherwise, is compiled when it
is called.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from numba.core import event, types

from pawnb.core.compiled import Compiled

LIST = Path(__file__).with_suffix(".json")
HELPERS = "PAWNB_COMPILE_HELPERS"
"""Environment variable: how many processes help to compile; default one a processor but one."""
_MOST_HELPERS = 3
"""More would wait for the longest function."""
_WORKER_POLL_S = 0.02
LATER = "later"
_team: _Team | None = None
"""Who compiles now."""


@contextlib.contextmanager
def compiling_side_by_side(
    kind: str | None, tell: Callable[[bool], None] | None = None
) -> Iterator[None]:
    """Let helper processes compile, too, where anything has to be compiled in the block.

    Parameters
    ----------
    kind : str or None
        Which list: "paws", "pose", or "space"; None where there is none: then nobody helps.
    tell : callable, optional
        Told True when the block begins to wait for compiling, and False when it goes on.
    """
    global _team
    team = _Team(kind, tell or (lambda _: None))
    earlier, _team = _team, team
    before, Compiled.before_first_call = Compiled.before_first_call, team.before_first_call
    try:
        with event.install_listener("numba:compile", team):
            team.begin_if_new()
            yield
    finally:
        Compiled.before_first_call, _team = before, earlier
        team.close()


def is_ready() -> bool:
    """Return whether what is compiled later can be called; False while helpers will compile it."""
    return _team is None or _team.is_ready()


def compile_all(kinds: tuple[str, ...] = ("paws", "pose", "space")) -> None:
    """Compile all that is listed and not kept yet, on all processors, and wait for it.

    Parameters
    ----------
    kinds : tuple of str
        Which lists.
    """
    folder = Path(tempfile.mkdtemp(prefix="pawnb-compile-"))
    kind = ",".join(kinds)
    helpers = [_start_helper(folder, kind) for _ in range(_processors())]
    try:
        for helper in helpers:
            helper.wait()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def listed(kind: str) -> dict[str, list]:
    """Return the functions of a list, by name, and numba's types of their arguments.

    Parameters
    ----------
    kind : str
        Which list; or several, with commas.

    Returns
    -------
    dict
        Module and name of each function, and of each way to call it the types; none where
        there is no such list.
    """
    lists = json.loads(LIST.read_text(encoding="utf-8"))
    return {name: ways for part in kind.split(",") for name, ways in lists.get(part, {}).items()}


def spell(kind: Any) -> Any:
    """Write a numba type so that it can be kept in JSON; see :func:`typed`.

    Parameters
    ----------
    kind : numba.types.Type
        An array, number, tuple, or named tuple of these.

    Returns
    -------
    str, list or dict
        A name; a list of those of a tuple; a dict of one named tuple.
    """
    if isinstance(kind, types.BaseTuple):
        parts = [spell(part) for part in kind]  # type: ignore[attr-defined]
        cls = getattr(kind, "instance_class", tuple)
        return parts if cls is tuple else {f"{cls.__module__}:{cls.__qualname__}": parts}
    if isinstance(kind, types.Array):
        return f"{kind.dtype}[{kind.ndim}{kind.layout}{'' if kind.mutable else 'r'}]"
    return str(kind)


def typed(spelt: Any) -> Any:
    """Return the numba type that :func:`spell` wrote.

    Parameters
    ----------
    spelt : str, list or dict
        What it wrote.

    Returns
    -------
    numba.types.Type
        The type.
    """
    if isinstance(spelt, dict):
        [(name, parts)] = spelt.items()
        return _tuple_of(tuple(map(typed, parts)), _find(name))
    if isinstance(spelt, list):
        return _tuple_of(tuple(map(typed, spelt)), tuple)
    dtype, is_array, rest = spelt.partition("[")
    kind = types.boolean if dtype == "bool" else getattr(types, dtype)
    if not is_array:
        return kind
    readonly = rest.endswith("r]")
    shape = rest.rstrip("]").removesuffix("r")
    return types.Array(kind, int(shape[:-1]), shape[-1], readonly=readonly)


class _Share:
    """Whose turn it is: each function of a list is compiled by the process that claims it."""

    def __init__(self, folder: Path, kind: str) -> None:
        self._folder = folder
        first, later = listed(kind), listed(LATER)
        self.first, self.later = list(first), list(later)
        self.ways = first | later
        self._number = {name: str(k) for k, name in enumerate(self.ways)}

    def claim(self, name: str) -> bool:
        """Take a function, if no other process has; raises FileNotFoundError at the end."""
        try:
            with (self._folder / self._number[name]).open("x"):
                return True
        except FileExistsError:
            return False

    def leave_out(self, name: str) -> None:
        """Leave a function to this process, which has begun with it."""
        if self.claim(name):
            self._note_done(name)

    def compile(self, name: str) -> None:
        """Compile a function in every listed way, and note that it is done."""
        try:
            function = _find(name)
            if function.is_kept:
                for way in self.ways[name]:
                    function.compile_for(tuple(typed(kind) for kind in way))
        except Exception:  # noqa: BLE001, S110 - who calls it compiles it then, and shows why not
            pass
        finally:
            self._note_done(name)

    def is_done(self, name: str) -> bool:
        """Return whether the process that claimed a function has compiled it."""
        return (self._folder / f"{self._number[name]}.done").exists()

    def _note_done(self, name: str) -> None:
        with contextlib.suppress(FileNotFoundError):
            (self._folder / f"{self._number[name]}.done").touch()


class _Team(event.Listener):
    """A process and its helpers; they start when there is something to compile."""

    def __init__(self, kind: str | None, tell: Callable[[bool], None]) -> None:
        self._kind, self._tell = kind, tell
        self._share: _Share | None = None
        self._is_begun = False
        self._folder: Path | None = None
        self._helpers: list[subprocess.Popen] = []
        self._ours: set[str] = set()
        self._lock = threading.Lock()
        self._depth, self._collects = 0, True

    def on_start(self, event: Any) -> None:
        """Numba begins to compile a function."""
        del event
        self._begin()
        self._wait(1)

    def on_end(self, event: Any) -> None:
        """Numba has compiled it."""
        del event
        self._wait(-1)

    def begin_if_new(self) -> None:
        """Begin before anything is called, where it can be seen that there is no code."""
        ways = listed(self._kind) if self._kind else {}
        if any(own.name in ways and own.is_kept and not own.has_code() for own in Compiled.every):
            self._begin()

    def before_first_call(self, function: Compiled) -> None:
        """Wait for a function that a helper compiles, and compile others meanwhile."""
        share = self._share
        if share is None:
            self._ours.add(function.name)
        if share is None or function.name not in share.ways or self._claim(function.name):
            return  # a second thread may come here meanwhile: numba lets one compile
        shortest = share.first[::-1]
        self._wait(1)
        try:
            while not share.is_done(function.name) and self._is_helped():
                other = next((name for name in shortest if self._claim(name, anew=True)), None)
                if other is None:
                    time.sleep(_WORKER_POLL_S)
                else:
                    share.compile(other)
        finally:
            self._wait(-1)

    def _claim(self, name: str, *, anew: bool = False) -> bool:
        """Take a function; one that this process has already taken only if not ``anew``."""
        with self._lock:
            if name in self._ours:
                return not anew
            if self._share is None or not self._share.claim(name):
                return False
            self._ours.add(name)
            return True

    def is_ready(self) -> bool:
        """Return whether what is compiled later is, or will not be."""
        share = self._share
        return share is None or all(map(share.is_done, share.later)) or not self._is_helped()

    def close(self) -> None:
        """Send the helpers home: without the folder they find nothing to do."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
        for helper in self._helpers:
            threading.Thread(target=helper.wait, daemon=True).start()

    def _begin(self) -> None:
        if self._is_begun:
            return
        self._is_begun = True
        helpers = int(os.environ.get(HELPERS) or min(_processors() - 1, _MOST_HELPERS))
        if self._kind is None or helpers < 1 or multiprocessing.parent_process() is not None:
            return  # alone, or one of several that fill the processors
        self._folder = Path(tempfile.mkdtemp(prefix="pawnb-compile-"))
        self._share = _Share(self._folder, self._kind)
        for function in Compiled.every:
            if function.name in self._share.ways and (
                function.is_called or function.name in self._ours
            ):
                self._share.leave_out(function.name)
        self._helpers = [_start_helper(self._folder, self._kind) for _ in range(helpers)]

    def _is_helped(self) -> bool:
        return any(helper.poll() is None for helper in self._helpers)

    def _wait(self, more: int) -> None:
        """Begin or end to wait; waits may lie within each other."""
        self._depth += more
        if self._depth == max(more, 0):
            if more > 0:
                self._collects = gc.isenabled()
                gc.disable()  # cycles among numba's objects: looking for them takes a tenth
            elif self._collects:
                gc.enable()
            self._tell(more > 0)


def _tuple_of(parts: tuple, cls: type) -> Any:
    return types.BaseTuple.from_types(parts, cls)  # type: ignore[no-untyped-call]


def _find(name: str) -> Any:
    module, _, own = name.partition(":")
    return getattr(importlib.import_module(module), own)


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _start_helper(folder: Path, kind: str) -> subprocess.Popen:
    quiet: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    # not __name__: that is "__main__" where this module itself is run
    command = [sys.executable, "-m", "pawnb.core.first_run", str(folder), kind]
    return subprocess.Popen(command, **quiet)  # noqa: S603 - our own module


def _help(folder: str, kind: str) -> None:
    """Compile what is left of a list until nothing is, or the folder is gone."""
    gc.disable()
    share = _Share(Path(folder), kind)
    with contextlib.suppress(FileNotFoundError):
        for name in share.ways:
            if share.claim(name):
                share.compile(name)


if __name__ == "__main__":
    if sys.argv[1:]:
        _help(*sys.argv[1:])
    else:
        compile_all()
