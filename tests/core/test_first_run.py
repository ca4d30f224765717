"""What a first run compiles is compiled side by side, and what is waited for is said."""

import subprocess
import sys
import threading
import time
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba import types

from pawnb.core import first_run
from pawnb.core.compiled import Compiled, compiled
from pawnb.core.video.parts import PartReader


class Pair(NamedTuple):
    near: np.ndarray
    far: float


class Alike(NamedTuple):
    near: np.ndarray
    far: np.ndarray


KINDS = [
    np.zeros((2, 3)),
    np.zeros((2, 3))[:, ::2],
    np.zeros(3, np.float32),
    np.zeros(3, bool),
    np.frombuffer(b"read only", np.uint8),
    3.0,
    7,
    True,
    (1, 2),
    (1, 2.0, np.zeros(2)),
    Pair(np.zeros(2), 1.0),
    Alike(np.zeros(2), np.zeros(2)),
    (Pair(np.zeros(2), 1.0), 2),
]


@pytest.mark.parametrize("value", KINDS, ids=lambda value: type(value).__name__)
def test_types_are_read_as_they_were_written(value):
    kind = numba.typeof(value)
    assert first_run.typed(first_run.spell(kind)) == kind


@pytest.mark.parametrize("kind", ["paws", "pose", "space", first_run.LATER])
def test_what_is_listed_can_be_compiled(kind):
    ways = first_run.listed(kind)
    assert ways
    for name, calls in ways.items():
        function = first_run._find(name)
        assert isinstance(function, Compiled)
        assert function.name == name
        names = function.__wrapped__.__code__.co_argcount
        for call in calls:
            assert len([first_run.typed(kind) for kind in call]) == names
            assert all(isinstance(first_run.typed(kind), types.Type) for kind in call)


@compiled
def first(x):
    return x + 1.0


@compiled
def second(x):
    return x + 2.0


@compiled
def third(x):
    return x + 3.0


class Helper:
    """Stands for a helper process: takes the first of the list, is slow, and lives for a while."""

    def __init__(self, folder, takes, lives_s):
        self.share = first_run._Share(folder, "mine")
        assert self.share.claim(takes)
        self.takes, self.until = takes, time.monotonic() + lives_s

    def poll(self):
        return None if time.monotonic() < self.until else 1

    def finish(self):
        self.share.compile(self.takes)

    def wait(self):
        return self.poll()


@pytest.fixture
def team(monkeypatch):
    """Begin with a helper that has claimed the first function; return its process."""
    functions = [first, second, third]
    for function in functions:
        monkeypatch.setattr(function, "is_called", False)
        function._called = numba.njit(function.__wrapped__)
        function.is_kept = True
    lists = {"mine": {function.name: [["float64"]] for function in functions}, "later": {}}
    monkeypatch.setattr(first_run, "listed", lambda kind: lists.get(kind, {}))
    monkeypatch.setenv(first_run.HELPERS, "1")
    helpers = []

    def start(folder, kind, lives_s=20.0):
        helpers.append(Helper(folder, first.name, lives_s))
        return helpers[-1]

    monkeypatch.setattr(first_run, "_start_helper", start)
    monkeypatch.setattr(Compiled, "every", functions)
    return helpers


def test_who_waits_for_a_helper_compiles_others_and_says_so(team):
    told, events = [], []

    def finish_when_others_are_compiled():
        while not (second.signatures and third.signatures):
            time.sleep(0.01)
        events.append("others")
        team[0].finish()

    with first_run.compiling_side_by_side("mine", told.append):
        assert len(team) == 1, "what is new was not seen"
        threading.Thread(target=finish_when_others_are_compiled, daemon=True).start()
        assert first(1.0) == 2.0
        events.append("called")
    assert events == ["others", "called"]
    assert told[0] is True
    assert told[-1] is False
    assert second(1.0) == 3.0


def test_a_helper_that_dies_is_not_waited_for(team, monkeypatch):
    with first_run.compiling_side_by_side("mine"):
        team[0].until = time.monotonic() + 0.2
        begun = time.monotonic()
        assert first(1.0) == 2.0
        assert 0.1 < time.monotonic() - begun < 10.0


def test_threads_that_call_the_same_do_not_wait_for_each_other(team):
    """The second thread took what the first had claimed for a helper's, and waited for ever."""
    with first_run.compiling_side_by_side("mine"):
        results = []
        threads = [
            threading.Thread(target=lambda: results.append(second(1.0)), daemon=True)
            for _ in range(4)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(10.0)
        assert results == [3.0] * 4


def test_in_one_of_several_processes_nobody_helps(team, monkeypatch):
    """Those of a batch fill the processors already."""
    monkeypatch.setattr("multiprocessing.parent_process", lambda: object())
    with first_run.compiling_side_by_side("mine"):
        assert second(1.0) == 3.0
    assert not team


def test_parts_of_pictures_are_left_to_ffmpeg_until_they_are_compiled(monkeypatch):
    class Packet:
        def __bytes__(self):
            raise AssertionError("it was read")

    monkeypatch.setattr("pawnb.core.video.parts.is_ready", lambda: False)
    assert PartReader().read(Packet(), None) is None
    monkeypatch.setattr("pawnb.core.video.parts.is_ready", lambda: True)
    with pytest.raises(AssertionError, match="it was read"):
        PartReader().read(Packet(), None)


MODULES = {
    "inner.py": "from pawnb.core.compiled import compiled\n\n\n"
    "@compiled\ndef one(x):\n    return x + {}\n",
    "outer.py": "from inner import one\n\nfrom pawnb.core.compiled import compiled\n\n\n"
    "@compiled\ndef both(x):\n    return one(x) * 2.0\n",
}


@pytest.mark.slow
def test_code_is_old_where_what_it_calls_has_changed(tmp_path):
    """Numba looks at the file of the function that Python calls only."""
    for number, expected in (("1.0", "8.0"), ("10.0", "26.0")):
        for name, text in MODULES.items():
            if name == "inner.py" or number == "1.0":
                (tmp_path / name).write_text(text.format(number), encoding="utf-8")
        command = [sys.executable, "-c", "import outer; print(outer.both(3.0))"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert done.stdout.strip() == expected


@pytest.mark.slow
def test_helpers_compile_what_is_listed(tmp_path, monkeypatch):
    """The real thing: a process that claims functions, and what it leaves on disk."""
    name = "pawnb.core.sorting_kernels:ascending"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    script = (
        "import sys; from pawnb.core import first_run\n"
        f"lists = {{'mine': {{{name!r}: [['float64[1C]']]}}}}\n"
        "first_run.listed = lambda kind: lists.get(kind, {})\n"
        "first_run._help(sys.argv[1], 'mine')"
    )
    (tmp_path / "share").mkdir()
    command = [sys.executable, "-c", script, str(tmp_path / "share")]
    subprocess.run(command, check=True)
    assert {path.name for path in (tmp_path / "share").iterdir()} == {"0", "0.done"}
    assert list((tmp_path / "kept").rglob("sorting_kernels.ascending-*.nbc"))


def test_helpers_run_this_module_also_where_it_is_run_by_itself(tmp_path, monkeypatch):
    # python -m pawnb.core.first_run calls itself "__main__", which no helper can be started by
    started = []
    monkeypatch.setattr(first_run.subprocess, "Popen", lambda command, **_: started.append(command))
    monkeypatch.setattr(first_run, "__name__", "__main__")
    first_run._start_helper(tmp_path, "paws")
    assert started[0][1:3] == ["-m", "pawnb.core.first_run"]
