"""Parameters of the stages of a tracker: their defaults, and the values that are in force.

Each stage has one frozen dataclass with its defaults; :func:`in_force` gives the object that the
stage reads its values from. A run that asks for other values has them for itself, in its own
threads too (:class:`pawnb.core.parallel.Threads`), inside ``with parameters_set(...)``.
"""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import functools
import importlib
import inspect
import itertools
import pkgutil
import re
from collections.abc import Iterator, Mapping, Sequence
from contextvars import ContextVar
from typing import Any, TypeVar, cast

from pawnb.errors import InputError, did_you_mean
from pawnb.schema import build_settings

T = TypeVar("T")

_STAGES: dict[str, _InForce] = {}


class _InForce:
    """Reads as the parameters of a stage: the defaults, or what the running call asked for."""

    __slots__ = ("default", "now")

    def __init__(self, stage: str, default: Any) -> None:
        self.default = default
        self.now: ContextVar[Any] = ContextVar(f"pawnb.{stage}", default=default)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.now.get(), name)


def in_force(stage: str, default: T) -> T:
    """Return what reads as the parameters of a stage, by the values that are in force.

    Parameters
    ----------
    stage : str
        Its name, under which values are set and recorded.
    default : dataclass
        The parameters.

    Returns
    -------
    dataclass
        Has the fields of ``default``.
    """
    _STAGES[stage] = _InForce(stage, default)
    return cast("T", _STAGES[stage])


def values_in_force(stage: T) -> T:
    """Return the parameters that an object of :func:`in_force` reads as now."""
    now: T = stage.now.get() if isinstance(stage, _InForce) else stage
    return now


def defaults_of(stage: str) -> Any:
    """Return the dataclass of a stage with its defaults."""
    return _STAGES[stage].default


def parameters_of(stages: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return the values in force.

    Parameters
    ----------
    stages : sequence of str
        Names of stages.

    Returns
    -------
    dict
        Stage to its parameters by name.
    """
    return {stage: dataclasses.asdict(_STAGES[stage].now.get()) for stage in stages}


def changed_in_force() -> dict[str, Any]:
    """Return the parameters in force of the stages of which any is not the default."""
    now = {stage: held.now.get() for stage, held in sorted(_STAGES.items())}
    return {stage: values for stage, values in now.items() if values != _STAGES[stage].default}


@contextlib.contextmanager
def parameters_set(values: Mapping[str, Mapping[str, Any]]) -> Iterator[None]:
    """Set parameters of stages while the block runs, for this call and the threads it starts.

    Parameters
    ----------
    values : mapping
        Stage to names and values.
    """
    changed = {
        _STAGES[stage]: dataclasses.replace(_STAGES[stage].now.get(), **own)
        for stage, own in values.items()
    }
    tokens = [(held, held.now.set(parameters)) for held, parameters in changed.items()]
    try:
        yield
    finally:
        for held, token in tokens:
            held.now.reset(token)


def read_parameters(
    values: Mapping[str, Any], stages: Sequence[str], *, where: str
) -> dict[str, dict[str, Any]]:
    """Check values that a person gave for parameters of stages.

    Parameters
    ----------
    values : mapping
        ``stage.name`` to values; text, as from ``--set``, is read as JSON where it can be.
    stages : sequence of str
        The stages of the tracker.
    where : str
        Where the values come from, for the message.

    Returns
    -------
    dict
        Stage to names and values, of their types.

    Raises
    ------
    InputError
        For an unknown stage or name, or a value of the wrong type.
    """
    by_stage: dict[str, dict[str, Any]] = {}
    for word, value in values.items():
        stage, _, name = word.partition(".")
        if stage not in stages:
            raise InputError(
                f"{where}: {word!r} is of no stage{did_you_mean(stage, stages)}; "
                f"stages are {', '.join(stages) or 'none'}."
            )
        by_stage.setdefault(stage, {})[name] = value
    found = {}
    for stage, own in by_stage.items():
        built = build_settings(type(defaults_of(stage)), own, where=f"{where}: {stage}")
        found[stage] = {name: getattr(built, name) for name in own}
    return found


_TARGETS = re.compile(r"^\(?([A-Z_][\w, ]*)\)? *(?::[^=\n]*)?=(?!=)", re.MULTILINE)
"""Layout: what stands before the equals sign of an assignment at the top level of a module."""


@functools.lru_cache
def constants_of(package: str) -> dict[str, dict[str, Any]]:
    """Return the named numbers of every module of a package that are not parameters of a stage.

    They belong to how things are laid out, to a published formula, or to arithmetic.

    Parameters
    ----------
    package : str
        Its full name.

    Returns
    -------
    dict
        Module, from the package on, to names and values, plain ones.
    """
    top = importlib.import_module(package)
    found = {}
    for info in pkgutil.walk_packages(top.__path__, f"{package}."):
        module = importlib.import_module(info.name)
        own = {
            name: value
            for name in _assigned(inspect.getsource(module))
            if name in vars(module) and (value := _plain(vars(module)[name])) is not None
        }
        if own:
            found[info.name.removeprefix(f"{package}.")] = own
    return found


REASONS = ("Definition", "Mathematics", "Layout", "Numerics", "Guard", "Resource")
"""Why a number beside the parameters is no parameter: the first word of what stands below it.

A convention or a table's kinds; what follows from a formula; how something is laid out; how exactly
it is solved; what keeps a logarithm or a division finite; how much time or memory is taken."""


@dataclasses.dataclass(frozen=True)
class Reason:
    """Why a named number is no parameter.

    Parameters
    ----------
    module : str
        Where it stands, from the package on.
    names : tuple of str
        Its name, or names that share a reason.
    kind, text : str
        The reason: one of :data:`REASONS`, and in words.
    """

    module: str
    names: tuple[str, ...]
    kind: str
    text: str


def reasons_of(package: str) -> list[Reason]:
    """Return why the named numbers of :func:`constants_of` are no parameters of a stage.

    Parameters
    ----------
    package : str
        Its full name.

    Returns
    -------
    list of Reason
        In the order of modules; kind and text are empty where nothing is said.
    """
    found = []
    for module, values in constants_of(package).items():
        body = ast.parse(inspect.getsource(importlib.import_module(f"{package}.{module}"))).body
        for node, after in itertools.zip_longest(body, body[1:]):
            names = tuple(name for name in _assigned(ast.unparse(node)) if name in values)
            if names:
                said = ""
                if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                    said = " ".join(str(after.value.value).split())
                kind, _, text = said.partition(": ")
                found.append(Reason(module, names, kind if text else "", text or said))
    return found


def _assigned(source: str) -> list[str]:
    """Return the names in capitals that a module's own text assigns at its top level.

    They begin lines; parsing the text of all modules took half a second of the first run.
    """
    found = (name.strip() for names in _TARGETS.findall(source) for name in names.split(","))
    return sorted({name for name in found if name.lstrip("_").isupper()})


def _plain(value: Any) -> Any:
    """Return a number, or numbers in tuples and arrays, as JSON has them; None for others."""
    if isinstance(value, bool | str | bytes):
        return None
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, int | float):
        return value
    if isinstance(value, tuple | list) and value:
        items = [_plain(item) for item in value]
        return None if None in items else items
    return None
