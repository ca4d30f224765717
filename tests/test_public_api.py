"""The public API is walked: docstrings in numpydoc, options keyword-only, few positionals."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import pytest
from numpydoc.docscrape import FunctionDoc

import pawnb

MAX_POSITIONAL = 4  # self or three pieces of data


def modules():
    names = ["pawnb"]
    names += [m.name for m in pkgutil.walk_packages(pawnb.__path__, "pawnb.")]
    return [importlib.import_module(name) for name in names if not name.endswith("__main__")]


def public():
    """Yield every public function, class and method that pawnb defines, with its full name."""
    for module in modules():
        for name, item in vars(module).items():
            if name.startswith("_") or getattr(item, "__module__", None) != module.__name__:
                continue
            if inspect.isfunction(item) or inspect.isclass(item):
                yield f"{module.__name__}.{name}", item
            if inspect.isclass(item):
                for inner, method in vars(item).items():
                    if not inner.startswith("_") and inspect.isfunction(method):
                        yield f"{module.__name__}.{name}.{inner}", method


EVERYTHING = dict(public())
FUNCTIONS = {name: item for name, item in EVERYTHING.items() if inspect.isfunction(item)}


@pytest.mark.parametrize("name", EVERYTHING)
def test_every_public_name_has_a_docstring(name):
    assert (inspect.getdoc(EVERYTHING[name]) or "").strip(), name


@pytest.mark.parametrize("name", FUNCTIONS)
def test_documented_parameters_are_those_of_the_signature(name):
    """A docstring that lists parameters lists every one, by its right name."""
    function = FUNCTIONS[name]
    documented = [n.strip().lstrip("*") for p in FunctionDoc(function)["Parameters"]
                  for n in p.name.split(",")]  # fmt: skip
    if not documented:
        return
    actual = [p for p in inspect.signature(function).parameters if p not in ("self", "cls")]
    assert sorted(documented) == sorted(actual)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_options_are_keyword_only(name):
    parameters = inspect.signature(FUNCTIONS[name]).parameters.values()
    positional = [p for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD]
    assert len(positional) <= MAX_POSITIONAL, [p.name for p in positional]
