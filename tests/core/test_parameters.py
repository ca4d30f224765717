"""Parameters of stages: set for a run and its threads, recorded whole, refused where wrong."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
from pathlib import Path

import pytest

import pawnb
from pawnb.core.parallel import Threads
from pawnb.core.parameters import (
    constants_of,
    defaults_of,
    parameters_of,
    parameters_set,
    read_parameters,
)
from pawnb.core.paws.offline.stride.parameters import STRIDE, StrideParameters
from pawnb.core.paws.tracker import trackers
from pawnb.errors import InputError

EVERY = [(t, stage) for k in ("paws", "pose") for t in trackers(k).values() for stage in t.stages]


def test_values_are_in_force_within_the_block_and_in_its_threads_only():
    usual = StrideParameters().due_sd
    with Threads(1) as pool:
        with parameters_set({"stride": {"due_sd": 9.0}}):
            assert STRIDE.due_sd == 9.0
            assert pool.submit(lambda: STRIDE.due_sd).result() == 9.0
            assert list(pool.map(lambda _: STRIDE.due_sd, range(2))) == [9.0, 9.0]
        assert STRIDE.due_sd == usual
        assert pool.submit(lambda: STRIDE.due_sd).result() == usual


def test_words_of_a_command_become_values_of_their_types():
    found = read_parameters({"stride.due_sd": "2"}, ("stride",), where="settings")
    assert found == {"stride": {"due_sd": 2.0}}
    assert isinstance(found["stride"]["due_sd"], float)


@pytest.mark.parametrize(
    ("word", "value", "said"),
    [
        ("strides.due_sd", 1, r"'strides.due_sd' is of no stage \(did you mean 'stride'\?\)"),
        ("stride.due", 1, "stride: unknown name 'due'"),
        ("stride.due_sd", "much", "due_sd is 'much'; expected a number"),
        ("stride.due_sd", float("nan"), "due_sd is nan; expected a number"),
    ],
)
def test_what_is_no_parameter_is_refused(word, value, said):
    with pytest.raises(InputError, match=said):
        read_parameters({word: value}, ("stride",), where="settings")


@pytest.mark.parametrize(("tracker", "stage"), EVERY)
def test_every_parameter_is_recorded_and_has_its_words(tracker, stage):
    recorded = parameters_of(tracker.stages)[stage]
    own = type(defaults_of(stage))
    assert set(recorded) == {field.name for field in dataclasses.fields(own)}
    named = re.findall(r"^(\w[\w, ]*) : ", inspect.getdoc(own), re.M)
    assert {name for line in named for name in line.split(", ")} == set(recorded)


def test_constants_are_those_that_the_modules_assign():
    found = constants_of("pawnb.core.paws.offline")["stride.trajectory_kernels"]
    # read off the file: two steps by which it takes differences
    assert found == {"_H": 0.05, "_H_SHAPE": 0.02}


ROOMS = (
    "detection/colour", "stride", "association/network_flow", "gap_closing", "smoothing",
    "landmarks", "treadmill",
)  # fmt: skip


def named_numbers(path):
    """Yield names in capitals of a module whose values hold numbers, and what follows each."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign):
            continue
        names = [n.id for n in ast.walk(node.targets[0]) if isinstance(n, ast.Name)]
        values = [n.value for n in ast.walk(node.value) if isinstance(n, ast.Constant)]
        if all(n.lstrip("_").isupper() for n in names) and any(
            isinstance(v, int | float) and not isinstance(v, bool) for v in values
        ):
            yield names, after


def test_a_named_number_beside_the_parameters_says_what_it_is():
    """What a loop is compiled with, or how something is laid out, stays in its module."""
    core = Path(pawnb.core.__path__[0])
    rooms = [core / "paws" / "offline" / room for room in ROOMS] + [core / "pose" / "fit"]
    found = {path: list(named_numbers(path)) for room in rooms for path in room.rglob("*.py")}
    bare = [
        (path.name, names)
        for path, own in found.items()
        for names, after in own
        if not (isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant))
    ]
    assert bare == []
    assert sum(map(len, found.values())) > 15


def parameter_objects():
    """Yield the names by which modules read parameters, and their stages."""
    for path in Path(pawnb.core.__path__[0]).rglob("*parameters.py"):
        yield from re.findall(r'^(\w+) = in_force\("(\w+)"', path.read_text("utf-8"), re.M)


def reads(node, objects, *, called=False):
    """Yield whether a call reads a parameter or the import does, its object, and its name."""
    if isinstance(node, ast.Attribute) and getattr(node.value, "id", None) in objects:
        yield called, node.value.id, node.attr
    for name, value in ast.iter_fields(node):
        # default arguments and decorators are read with the import
        inner = called or (name == "body" and isinstance(node, ast.FunctionDef | ast.Lambda))
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from reads(child, objects, called=inner)


@pytest.mark.slow
def test_parameters_are_read_when_they_are_needed_and_none_is_idle():
    """As a default argument one would be what it is by default, whatever is set."""
    objects = dict(parameter_objects())
    assert set(objects.values()) == {stage for _, stage in EVERY}
    found = {
        (path.name, *read)
        for path in Path(pawnb.core.__path__[0]).rglob("*.py")
        for read in reads(ast.parse(path.read_text("utf-8")), objects)
    }
    assert {read for read in found if not read[1]} == set()
    by_name = {(objects[name], attribute) for _, _, name, attribute in found}
    every = {
        (stage, field.name)
        for _, stage in EVERY
        # the others are handed on whole, as :func:`parameters_in_force` has them
        if stage in objects.values() and stage not in HANDED_ON
        for field in dataclasses.fields(type(defaults_of(stage)))
    }
    assert {one for one in every - by_name if not one[1].startswith("mht_")} == set()


HANDED_ON = ("scene", "motion", "correlation", "appearance", "association", "identity")
