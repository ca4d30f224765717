"""The public API is walked: docstrings in numpydoc, options keyword-only, few positionals."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

from numpydoc.docscrape import FunctionDoc

import pawnb

MAX_POSITIONAL = 3
# the sides of a region, and a position in a picture, are one piece of data each
ONE_PIECE = ({"u0", "v0", "u1", "v1"}, {"u", "v"})


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


PROTOCOLS = [item for item in EVERYTHING.values() if getattr(item, "_is_protocol", False)]


def members(owner):
    """Return its names, with the fields that it inherits."""
    return {*dir(owner), *(n for c in owner.__mro__ for n in vars(c).get("__annotations__", {}))}


def is_said_by_a_protocol(name):
    """Say whether this is a method of a class that a protocol describes, as every such class."""
    owner, _, method = name.rpartition(".")
    if owner not in EVERYTHING:
        return False
    public = members(EVERYTHING[owner])
    return any(
        EVERYTHING[owner] is not protocol
        and {member for member in members(protocol) if not member.startswith("_")} <= public
        and FunctionDoc(getattr(protocol, method))["Parameters"] != []
        for protocol in PROTOCOLS
        if inspect.isfunction(vars(protocol).get(method))
    )


def parameters(function):
    found = list(inspect.signature(function).parameters.values())
    return found[1:] if found and found[0].name == "self" else found


def test_every_public_name_has_a_docstring():
    assert [n for n, item in EVERYTHING.items() if not (inspect.getdoc(item) or "").strip()] == []
    assert len(EVERYTHING) > 200


def test_documented_parameters_are_those_of_the_signature():
    """A docstring that lists parameters lists every one, by its right name."""
    wrong = {}
    for name, function in FUNCTIONS.items():
        documented = [n.strip().lstrip("*") for p in FunctionDoc(function)["Parameters"]
                      for n in p.name.split(",")]  # fmt: skip
        actual = [p.name for p in parameters(function)]
        if documented and sorted(documented) != sorted(actual):
            wrong[name] = (documented, actual)
    assert wrong == {}


def test_functions_of_three_or_more_arguments_say_what_they_take_and_return():
    without = []
    for name, function in FUNCTIONS.items():
        if len(parameters(function)) < 3 or is_said_by_a_protocol(name):
            continue
        doc = FunctionDoc(function)
        returned = inspect.signature(function).return_annotation
        gives = returned not in ("None", None, inspect.Signature.empty, "NoReturn")
        if not doc["Parameters"] or (gives and not (doc["Returns"] or doc["Yields"])):
            without.append(name)
    assert without == []


def test_options_are_keyword_only():
    wrong = {}
    for name, function in FUNCTIONS.items():
        positional = {p.name for p in parameters(function) if p.kind is p.POSITIONAL_OR_KEYWORD}
        for piece in ONE_PIECE:
            if piece <= positional:
                positional = positional - piece | {"".join(sorted(piece))}
        if len(positional) > MAX_POSITIONAL:
            wrong[name] = sorted(positional)
    assert wrong == {}
