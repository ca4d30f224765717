"""Wherever a p is given, the number of animals stands beside it."""

from __future__ import annotations

import importlib
import pkgutil
import re

import pytest

import pawnb.figures
import pawnb.gait
from pawnb import schema

# points are species here, and pairs of measurements; the tables made of them count animals
COUNT_OTHER_THINGS = {
    "pawnb.figures.scaling.COLUMNS": "n",
    "pawnb.gait.repeatability.Agreement": "n",
}
_P = re.compile(r"p|p_.+|.+_p|.+_p_.+")


def columns_with_p():
    """Return every tuple of columns, in gait, figures and the schema, that holds a p."""
    found = {"schema.PHASE_SUMMARY_COLUMNS": schema.PHASE_SUMMARY_COLUMNS}
    for package in (pawnb.gait, pawnb.figures):
        for info in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            module = importlib.import_module(info.name)
            for name, value in vars(module).items():
                if name.endswith("COLUMNS") and isinstance(value, tuple):
                    found[f"{info.name}.{name}"] = value
    return {k: v for k, v in found.items() if any(_P.fullmatch(str(c)) for c in v)}


@pytest.mark.parametrize(("name", "columns"), sorted(columns_with_p().items()))
def test_tables_with_a_p_say_how_many_animals(name, columns):
    assert counts_animals(name, columns), name


def results_with_p():
    """Return every result of pawnb.gait that is a named tuple with a p."""
    found = {}
    for info in pkgutil.walk_packages(pawnb.gait.__path__, "pawnb.gait."):
        for name, value in vars(importlib.import_module(info.name)).items():
            fields = getattr(value, "_fields", ())
            if isinstance(value, type) and any(_P.fullmatch(f) for f in fields):
                found[f"{value.__module__}.{name}"] = fields
    return found


@pytest.mark.parametrize(("name", "fields"), sorted(results_with_p().items()))
def test_results_with_a_p_say_how_many_animals(name, fields):
    assert counts_animals(name, fields), name


def counts_animals(name, columns):
    """Say whether the numbers of animals are there; comparisons of two groups say both."""
    wanted = COUNT_OTHER_THINGS.get(name, "n_animals")
    return wanted in columns or {"n_animals_a", "n_animals_b"} <= set(columns)
