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
    REASONS,
    _assigned,
    changed_in_force,
    constants_of,
    defaults_of,
    parameters_of,
    parameters_set,
    read_parameters,
    reasons_of,
)
from pawnb.core.paws.offline.stride.parameters import STRIDE, StrideParameters
from pawnb.core.paws.tracker import trackers
from pawnb.errors import InputError

EVIDENCE = re.compile(
    r"[Mm]easured|set\s+by\s+hand|[Mm]athematics|definition|(19|20)\d\d|OpenCV", re.I
)
EVERY = [(t, stage) for k in ("paws", "pose") for t in trackers(k).values() for stage in t.stages]


def test_values_are_in_force_within_the_block_and_in_its_threads_only():
    usual = StrideParameters().due_sd
    with Threads(1) as pool:
        with parameters_set({"stride": {"due_sd": 9.0}}):
            assert STRIDE.due_sd == 9.0
            assert changed_in_force() == {"stride": StrideParameters(due_sd=9.0)}
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
    blocks = re.findall(r"^(\w[\w, ]*) : .*\n((?: +\S.*\n?|\n)*)", inspect.getdoc(own), re.M)
    assert {name for names, _ in blocks for name in names.split(", ")} == set(recorded)
    assert [names for names, words in blocks if not EVIDENCE.search(words)] == []


def test_constants_are_those_that_the_modules_assign():
    found = constants_of("pawnb.core.paws.offline")["stride.trajectory_kernels"]
    # read off the file: two steps by which it takes differences
    assert found == {"_H": 0.05, "_H_SHAPE": 0.02}


CORE = Path(pawnb.core.__path__[0])
PACKAGES = (
    "paws.offline", "paws.maghsoudi2019", "paws.start_proposal",
    "pose.fit", "pose.space", "pose.pullar2009", "pose.start_proposal",
)  # fmt: skip
ROOMS = tuple(CORE.joinpath(*package.split(".")) for package in PACKAGES)
"""What the trackers are made of, and what finds their starts."""


def modules():
    """Yield the files of the trackers that hold no parameters, and their code."""
    for path in sorted(path for room in ROOMS for path in room.rglob("*.py")):
        if not path.name.endswith(("parameters.py", "settings.py")):
            yield path, ast.parse(path.read_text("utf-8"))


def parsed_names(tree):
    """What a module assigns at its top level, by Python's own parser."""
    targets = [node.targets for node in tree.body if isinstance(node, ast.Assign)]
    targets += [[node.target] for node in tree.body if isinstance(node, ast.AnnAssign)]
    names = [one.id for some in targets for target in some for one in ast.walk(target)
             if isinstance(one, ast.Name)]  # fmt: skip
    return sorted({name for name in names if name.lstrip("_").isupper()})


@pytest.mark.slow
def test_names_that_a_module_assigns_are_read_off_its_lines():
    paths = sorted(path for room in ROOMS for path in room.rglob("*.py"))
    found = {path: _assigned(path.read_text("utf-8")) for path in paths}
    assert found == {path: parsed_names(ast.parse(path.read_text("utf-8"))) for path in paths}
    assert sum(map(len, found.values())) > 100
    text = "A, _B = 1, 2\n(C, D) = 3, 4\nE: dict[str, int] = {}\nF_2 += 1\nG == 2\n  H = 5\n"
    assert _assigned(text) == ["A", "C", "D", "E", "_B"]


@pytest.mark.slow
def test_a_named_number_beside_the_parameters_says_why_it_is_none():
    """Every other one is a parameter of its stage: ``pawnb.core.parameters.reasons_of``."""
    found = [reason for package in PACKAGES for reason in reasons_of(f"pawnb.core.{package}")]
    assert [one for one in found if one.kind not in REASONS] == []
    assert len(found) > 40


UNITS = {100, 255, 256, 180, 360, 90}
"""Per cent, grey values of a byte, degrees."""
PLAIN = {0, 1, 2, 3, 4, -1, -2, 0.5} | UNITS
BARE = {
    "links.py": ({12}, "variance of the slope of a line"),
    "classifier.py": ({6}, "first weights of Glorot & Bengio 2010"),
    "colour_quantisation.py": ({8}, "half the steps of a channel"),
    "detector_kernels.py": ({6, 9}, "padding of the filter of seven; mean of nine"),
    "paw_width.py": ({5}, "OpenCV's mask of its distance transform"),
    "scan.py": ({8}, "rounding up to a multiple of eight"),
    "swing_trajectory.py": ({6}, "unknowns of an arc"),
    "trajectory_kernels.py": ({6, 7, 10, 15}, "polynomials of Flash & Hogan 1985"),
    "body_equations.py": ({5}, "unknowns of a part"),
    "paint_kernels.py": ({0.25, 0.75, 64}, "the parabolic kernel; bits of a segment's number"),
    "picture_kernels.py": ({6, 9}, "coordinates of two and of three joints"),
    "places.py": ({1.5}, "middle of a band whose neighbour is the first"),
    "body_fit.py": ({5}, "OpenCV's mask of its distance transform"),
    "silhouette.py": ({5}, "OpenCV's mask of its distance transform"),
    "leg_lengths.py": ({8}, "neighbours of a pixel"),
    "likelihood.py": ({12}, "variance of rounding to whole numbers"),
}
"""What else stands in function bodies, and what it is: nothing that could be chosen otherwise."""
SHAPES = {
    "zeros", "empty", "ones", "full", "eye", "reshape", "range", "arange", "tile", "repeat",
}  # fmt: skip
"""Calls whose plain arguments say how something is laid out."""
BITS = (ast.LShift, ast.RShift, ast.BitAnd, ast.Mod, ast.FloorDiv)


def bare_numbers(node):
    """Yield numbers of an expression but for indices, sizes of arrays, bits and guards."""
    parts = list(ast.iter_child_nodes(node))
    if isinstance(node, ast.Subscript):
        parts = [node.value]
    elif isinstance(node, ast.BinOp) and isinstance(node.op, BITS):
        parts = [node.left]
    elif isinstance(node, ast.Call):
        called = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if called in SHAPES:
            parts = [x for x in parts if not isinstance(x, ast.Constant | ast.Tuple)]
    elif (
        isinstance(node, ast.Constant) and type(node.value) in (int, float)
        and node.value not in PLAIN and not 0 < abs(node.value) <= 1e-6
    ):  # fmt: skip
        yield node.value
    for part in parts:
        yield from bare_numbers(part)


@pytest.mark.slow
def test_no_function_of_the_trackers_holds_a_bare_tunable():
    """Whoever has to choose a number gives it a name, a unit and evidence."""
    found = set()
    for path, code in modules():
        for node in ast.walk(code):
            if isinstance(node, ast.FunctionDef):
                defaults = [x for x in (*node.args.defaults, *node.args.kw_defaults) if x]
                known, _ = BARE.get(path.name, ((), ""))
                found |= {
                    (path.name, node.name, number)
                    for part in (*node.body, *defaults)
                    for number in bare_numbers(part)
                    if number not in known
                }
    assert found == set()


@pytest.mark.slow
def test_threads_of_the_trackers_have_the_values_that_are_in_force():
    """A plain ThreadPoolExecutor would work with the defaults whatever is set."""
    plain = [p.name for p, code in modules() if "ThreadPoolExecutor" in ast.dump(code)]
    assert plain == []


def parameter_objects():
    """Yield the names by which modules read parameters, and their stages."""
    for path in Path(pawnb.core.__path__[0]).rglob("*parameters.py"):
        yield from re.findall(r'^(\w+) = in_force\("(\w+)"', path.read_text("utf-8"), re.M)


def with_aliases(code, objects):
    """Return the names of parameters, and those that functions give them: ``p = STRIDE``."""
    found = dict(objects)
    for node in ast.walk(code):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                pairs = [(target, node.value)]
                if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                    pairs = zip(target.elts, node.value.elts, strict=True)
                for name, value in pairs:
                    if getattr(value, "id", None) in objects and isinstance(name, ast.Name):
                        found[name.id] = objects[value.id]
    return found


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
    code = {path: ast.parse(path.read_text("utf-8")) for path in CORE.rglob("*.py")}
    found = {
        (path.name, called, known[name], attribute)
        for path, one in code.items()
        for known in [with_aliases(one, objects)]
        for called, name, attribute in reads(one, known)
    }
    attributes = {
        path: {node.attr for node in ast.walk(one) if isinstance(node, ast.Attribute)}
        for path, one in code.items()
    }
    assert {read for read in found if not read[1]} == set()
    by_name = {(stage, attribute) for _, _, stage, attribute in found}
    # some are handed on whole, as :func:`parameters_in_force` and :class:`MHTParameters` have them
    anywhere = {name for names in attributes.values() for name in names}
    by_name |= {(stage, name) for stage in HANDED_ON for name in anywhere}
    by_name |= {("gap_closing", f"mht_{name}") for name in anywhere}
    every = {
        (stage, field.name)
        for _, stage in EVERY
        for field in dataclasses.fields(type(defaults_of(stage)))
    }
    assert every - by_name == set()


HANDED_ON = (
    "scene",
    "motion",
    "correlation",
    "appearance",
    "association",
    "identity",
    "quality_limits",
)
