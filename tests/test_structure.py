"""Every part is found by its name: limits of folders and files, and what each package says."""

from __future__ import annotations

import ast
import functools
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "pawnb"

FILES_IN_A_FOLDER = 15
"""In core, gait and workflow, the ``__init__`` among them."""
FILES_OF_A_STAGE = 12
"""At most a dozen in a folder of the default tracker of paws, beside the ``__init__``."""
LINES = 420
"""About 400. Compiled loops may take more where one thought needs them."""
LINES_OF_KERNELS = 600
LINES_OF_A_FUNCTION = 50
"""Of its body, the docstring not counted."""
ONE_THOUGHT = {
    "add_calibrate": "a table of options, read from top to bottom",
    "fit_pose": "compiled with loose arithmetic: cut, the compiler would order sums otherwise",
    "scan_units": "a compiled loop over bits: cut, it would call a function for each code",
}
"""Functions that are longer, and why."""
GROUPED = ("core", "gait", "workflow")
DATA = {"pawnb/core/pose/species"}
"""Folders of data, which hold no modules."""


@functools.cache
def parsed(path):
    """Read the code of a file once for all tests."""
    return ast.parse(path.read_text(encoding="utf-8"))


def folder_of(path):
    return path.parent.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("part", GROUPED)
def test_no_folder_is_too_full(part):
    counts = Counter(folder_of(path) for path in (PACKAGE / part).rglob("*.py"))
    assert {name: n for name, n in counts.items() if n > FILES_IN_A_FOLDER} == {}
    assert len(counts) > 5


def test_no_stage_of_the_default_tracker_has_more_than_a_dozen_files():
    files = (PACKAGE / "core" / "paws" / "offline").rglob("*.py")
    counts = Counter(folder_of(path) for path in files if path.stem != "__init__")
    assert {name: n for name, n in counts.items() if n > FILES_OF_A_STAGE} == {}
    assert len(counts) > 10


def test_no_file_is_too_long():
    long = {}
    for path in PACKAGE.rglob("*.py"):
        lines = path.read_text(encoding="utf-8").count("\n")
        if lines > (LINES_OF_KERNELS if path.stem.endswith("_kernels") else LINES):
            long[path.relative_to(ROOT).as_posix()] = lines
    assert long == {}


def lines_of_body(function):
    first = function.body[1 if ast.get_docstring(function) and len(function.body) > 1 else 0]
    return function.body[-1].end_lineno - first.lineno + 1


def test_no_function_is_too_long_but_those_named():
    long = {
        node.name
        for path in PACKAGE.rglob("*.py")
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.FunctionDef) and lines_of_body(node) > LINES_OF_A_FUNCTION
    }
    assert long == set(ONE_THOUGHT)


@pytest.mark.parametrize("part", GROUPED)
def test_every_package_says_what_comes_in_and_what_goes_out(part):
    packages = [path for path in (PACKAGE / part).rglob("__init__.py") if path.parent.name != part]
    silent = []
    for path in packages:
        said = ast.get_docstring(parsed(path)) or ""
        if folder_of(path) not in DATA and not ("Comes in:" in said and "Goes out:" in said):
            silent.append(folder_of(path))
    assert silent == []


def test_tests_lie_where_what_they_test_lies():
    folders = {folder_of(path) for path in PACKAGE.rglob("*.py")}
    beside = {"tests/benchmarks", "tests/browser", "tests/notebooks"}
    lost = {folder_of(path) for path in (ROOT / "tests").rglob("test_*.py")} - beside
    assert {name for name in lost if name.replace("tests", "pawnb", 1) not in folders} == set()


SHARED = {
    "_HOME": "where each package whose names load when they are asked for has them",
    "PUBLISHED_NAMES": "each method's own: what its paper calls a setting",
}
"""Names of constants that stand in several files, and why."""


def named_constants(code):
    """Yield the names in capitals that a module assigns at its top level."""
    for node in code.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        if isinstance(node, ast.AnnAssign):
            targets = [node.target]
        made_by = getattr(getattr(node, "value", None), "func", None)
        for target in () if getattr(made_by, "id", None) == "TypeVar" else targets:
            names = (x.id for x in ast.walk(target) if isinstance(x, ast.Name))
            yield from (name for name in names if name.lstrip("_").isupper())


def places_of_names(found_in):
    """Return each name to the files that define it, where several do."""
    places = {}
    for path in PACKAGE.rglob("*.py"):
        code = parsed(path)
        for name in found_in(code):
            places.setdefault(name, []).append(path.relative_to(ROOT).as_posix())
    assert len(places) > 500
    return {name: sorted(files) for name, files in places.items() if len(files) > 1}


def test_every_class_has_a_name_of_its_own():
    def classes(code):
        return (node.name for node in ast.walk(code) if isinstance(node, ast.ClassDef))

    assert places_of_names(classes) == {}


def test_a_constant_is_defined_once_and_its_name_means_one_thing():
    """In the engine, gait, the workflow and the widgets."""
    parts = ("core", "gait", "workflow", "widgets")
    found = {
        name: files
        for name, files in places_of_names(named_constants).items()
        if sum(file.split("/")[1] in parts for file in files) > 1
    }
    assert set(found) == set(SHARED), found


TYPED_PARTS = ("core", "io", "gait", "figures")
"""At whose public functions and methods, compiled ones left out, arrays say their kind; where
several are welcome, by the name ``AnyArray``."""


def bare_arrays(body):
    """Yield an annotation ``np.ndarray`` after another of public functions and methods."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from bare_arrays(node.body)
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            if any("compiled" in ast.unparse(one) for one in node.decorator_list):
                continue
            given = [x for x in ast.walk(node.args) if isinstance(x, ast.arg)]
            notes = [x for x in (*(one.annotation for one in given), node.returns) if x]
            for note in notes:
                yield from (x for x in ast.walk(note) if ast.unparse(x) == "np.ndarray")


@pytest.mark.parametrize("part", TYPED_PARTS)
def test_arrays_of_public_functions_say_their_kind(part):
    files = [path for path in (PACKAGE / part).rglob("*.py") if not path.stem.endswith("_kernels")]
    bare = {p: len(list(bare_arrays(parsed(p).body))) for p in files}
    assert {path: count for path, count in bare.items() if count} == {}
