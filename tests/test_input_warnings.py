"""Warnings about what a user gave, and who hears them."""

import ast
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import pawnb
from pawnb.core.parallel import Threads
from pawnb.errors import InputWarning, QualityWarning
from pawnb.input_warnings import hearing_input_warnings, hide_warnings_of, warn_of_input

PACKAGE = Path(pawnb.__file__).parent


def test_a_warning_names_the_line_that_it_is_about():
    def reads(sentence):
        warn_of_input(sentence, QualityWarning, stacklevel=2)

    with pytest.warns(QualityWarning, match="cut short") as caught:
        reads("cut short")
    assert caught[0].filename == __file__


def test_a_block_that_keeps_its_warnings_hides_them_from_those_around_it():
    around, kept, inside = [], [], []
    with hearing_input_warnings(around.append, shown=True):
        with (
            hearing_input_warnings(kept.append, shown=False),
            hearing_input_warnings(inside.append, shown=True),
        ):
            warn_of_input("first")
        with pytest.warns(InputWarning, match="second"):
            warn_of_input("second")
    assert [str(one) for one in inside] == ["first"]
    assert [str(one) for one in kept] == ["first"]
    assert [str(one) for one in around] == ["second"]


def test_threads_of_a_run_are_heard_by_it():
    heard = []
    with Threads(1) as pool, hearing_input_warnings(heard.append, shown=False):
        pool.submit(warn_of_input, "cut short").result()
    assert [str(one) for one in heard] == ["cut short"]


def test_a_warning_is_shown_as_often_as_it_is_said():
    """One line of code: Python by itself would show it once."""
    code = (
        "from pawnb.input_warnings import warn_of_input\n"
        "for _ in range(3): warn_of_input('cut short')"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stderr.count("InputWarning: cut short") == 3


def test_warnings_of_a_library_are_hidden_and_no_others():
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        hide_warnings_of("PIL")
        for module in ("PIL.TiffImagePlugin", "PIL", "PILlow", "numpy"):
            warnings.warn_explicit("odd", UserWarning, "file.py", 1, module=module)
        warn_of_input("cut short")
    assert [str(one.message) for one in shown] == ["odd", "odd", "cut short"]


def test_warnings_that_begin_in_one_way_are_hidden_whoever_warns_or_of_one_module():
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        hide_warnings_of(saying="flock not supported")
        hide_warnings_of("pawnb.x", saying="Glyph .* missing from")
        for module in ("anybody", "pawnb.x"):
            for text in ("flock not supported here", "Glyph 7 missing from font", "odd"):
                warnings.warn_explicit(text, UserWarning, "file.py", 1, module=module)
    assert [str(one.message) for one in shown] == ["Glyph 7 missing from font", "odd", "odd"]


def test_filters_are_set_in_one_place():
    users = [
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if "warnings.filterwarnings(" in path.read_text(encoding="utf-8")
    ]
    assert users == ["input_warnings.py"]


def test_every_warning_is_said_where_a_run_hears_it():
    """And no block changes filters for a while: they are those of all threads."""
    asked = ("warnings.warn", "warnings.catch_warnings")
    written = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    users = [
        path.relative_to(PACKAGE).as_posix()
        for path, code in written.items()
        if any(name in code for name in asked)  # a hundred times faster than to parse all
        and any(
            isinstance(node, ast.Attribute) and ast.unparse(node) in asked
            for node in ast.walk(ast.parse(code))
        )
    ]
    assert users == ["input_warnings.py"]
