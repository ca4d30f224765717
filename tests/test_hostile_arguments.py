"""Public functions given None, a number, text or an empty list: one sentence, never a traceback."""

from __future__ import annotations

import importlib
import inspect
import types
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest

import pawnb
from pawnb.errors import InputError, InputWarning, PawnbError
from pawnb.input_warnings import warn_of_input
from pawnb.schema.arguments import checked_arguments

PACKAGES = ("pawnb", "pawnb.gait", "pawnb.figures", "pawnb.io")

NO_ARGUMENT_IS_NEEDED = {"pawnb.sample_trial", "pawnb.selfcheck"}


def everyday_functions():
    """Yield the functions that the packages list, by name."""
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            if inspect.isfunction(getattr(module, name)):
                yield f"{package}.{name}", getattr(module, name)


def table_functions():
    """Yield the functions of the listed modules of gait that take a table or tracks."""
    gait = importlib.import_module("pawnb.gait")
    for name in gait.__all__:
        module = getattr(gait, name)
        if isinstance(module, types.ModuleType):
            for inner, item in vars(module).items():
                is_own = inspect.isfunction(item) and item.__module__.startswith(module.__name__)
                if is_own and not inner.startswith("_"):
                    first = next(iter(inspect.signature(item).parameters.values()), None)
                    if first is not None and first.annotation in {"pd.DataFrame", "Tracks"}:
                        yield f"{module.__name__}.{inner}", item


def needed(function):
    """Return the parameters without a default."""
    kinds = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    found = inspect.signature(function).parameters.values()
    return [p for p in found if p.default is p.empty and p.kind not in kinds]


FUNCTIONS = {
    name: function
    for name, function in [*everyday_functions(), *table_functions()]
    if needed(function) and name not in NO_ARGUMENT_IS_NEEDED
}


@pytest.mark.parametrize("given", [None, 3.5], ids=["None", "number"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_no_table_and_no_file_is_refused_in_a_sentence(name, given, tmp_path, monkeypatch):
    """As where a cell of a notebook was not run: its name is None, or the table of another."""
    monkeypatch.chdir(tmp_path)
    function = FUNCTIONS[name]
    keyword_only = {p.name: given for p in needed(function) if p.kind is p.KEYWORD_ONLY}
    others = [given for p in needed(function) if p.kind is not p.KEYWORD_ONLY]
    with pytest.raises(PawnbError) as caught:
        function(*others, **keyword_only)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@checked_arguments
def measure(
    table: pd.DataFrame,
    *,
    level: float = 0.95,
    n: int = 3,
    path: str | Path | None = None,
    legs: Sequence[str] | Mapping[str, str] = ("FR",),
    kind: Literal["a", "b"] = "a",
    is_paired: bool = False,
    values: np.ndarray | None = None,
    then: Callable[[int], int] | None = None,
) -> float:
    """Return the level of a table."""
    return level


TABLE = pd.DataFrame({"period_s": [0.2, 0.3]})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"table": None}, r"^table is None; expected a table \(pandas\.DataFrame\)\.$"),
        ({"table": pawnb}, r"^table is <module .*; expected a table"),
        ({"level": "0.9"}, r"^level is '0\.9'; expected a number\.$"),
        ({"level": True}, r"^level is True; expected a number\.$"),
        ({"n": np.inf}, r"^n is inf; expected a whole number\.$"),
        ({"level": None}, r"^level is None; expected a number\.$"),
        ({"n": 2.5}, r"^n is 2\.5; expected a whole number\.$"),
        ({"n": True}, r"^n is True; expected a whole number\.$"),
        ({"path": 3}, r"^path is 3; expected a path\.$"),
        ({"legs": "FR"}, r"^legs is 'FR'; expected a list of names or names and values"),
        ({"legs": [None]}, r"^legs holds None; expected a list of names\.$"),
        ({"legs": TABLE}, r"^legs is of type DataFrame; expected a list of names"),
        ({"kind": None}, r"^kind is None; expected one of 'a', 'b'\.$"),
        ({"is_paired": "no"}, r"^is_paired is 'no'; expected True or False\.$"),
        ({"values": "1 2"}, r"^values is '1 2'; expected numbers, as an array\.$"),
        ({"table": TABLE.assign(period_s=[0.2, np.inf])},
         r"^table: column 'period_s' is infinite in row 2; expected finite numbers"),
    ],
)  # fmt: skip
def test_an_argument_of_another_type_is_said(given, message):
    with pytest.raises(InputError, match=message):
        measure(**{"table": TABLE, **given})


@pytest.mark.parametrize(
    "given",
    [
        {"level": np.float32(0.5)}, {"level": np.array(0.5)}, {"level": 1}, {"n": np.int64(2)},
        {"level": np.inf},
        {"n": 2.0}, {"path": None}, {"path": Path("x")}, {"path": "x"}, {"legs": {"FR": "a"}},
        {"legs": [1, 2]}, {"legs": pd.Index(["FR"])}, {"is_paired": 1}, {"is_paired": np.True_},
        {"values": [1.0, 2.0]}, {"values": pd.Series([1.0])}, {"then": abs},
        {"table": TABLE.assign(own=np.inf)}, {"table": TABLE.assign(period_s=[0.2, np.nan])},
    ],
)  # fmt: skip
def test_what_can_be_meant_is_taken(given):
    """Numbers of numpy, animals called 1 and 2, missing values, and columns of one's own."""
    measure(**{"table": TABLE, **given})


def test_a_checked_function_is_the_function_that_it_was():
    assert measure.__name__ == "measure"
    assert list(inspect.signature(measure).parameters)[:2] == ["table", "level"]
    untyped: Any = measure
    with pytest.raises(TypeError, match="unexpected keyword argument 'levle'"):
        untyped(TABLE, levle=0.9)


def test_a_warning_of_a_checked_function_names_the_line_that_calls_it():
    @checked_arguments
    def doubtful(level: float) -> float:
        warn_of_input("level is odd.", stacklevel=2)
        return level

    with pytest.warns(InputWarning, match="level is odd") as told:
        doubtful(0.5)
    assert told[0].filename == __file__


def test_symmetry_of_infinite_strides_is_refused():
    """Infinite means gave an index of NaN, and a ratio of inf, in silence."""
    strides = pd.DataFrame(
        {"animal": "a", "leg": ["FL", "FR"], "stance_s": [0.1, np.inf], "duty_factor": 0.5}
    )
    with pytest.raises(InputError, match="column 'stance_s' is infinite in row 2"):
        pawnb.gait.symmetry.symmetry_table(strides, measures=["stance_s"])
    text = strides.assign(stance_s=["0.1", "0.2"])
    with pytest.raises(InputError, match=r"column 'stance_s' holds '0\.1'; expected numbers"):
        pawnb.gait.symmetry.symmetry_table(text, measures=["stance_s"])


@pytest.mark.parametrize(
    ("call", "missing"),
    [
        (lambda t: pawnb.gait.durations.stride_duration_by_leg(t), "animal"),
        (lambda t: pawnb.gait.support.support_shares(t), "animal"),
        (lambda t: pawnb.gait.support.support_table(t, strides=t), "animal"),
        (lambda t: pawnb.gait.coupling.alternation_rule(t), "animal"),
        (lambda t: pawnb.gait.selection.steadiness(t), "animal"),
    ],
)
def test_a_missing_column_is_named(call, missing):
    """It was a KeyError from within."""
    with pytest.raises(InputError, match=f"column '{missing}' is missing"):
        call(TABLE)
