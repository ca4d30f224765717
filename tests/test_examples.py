"""The everyday names have an example each, and every example gives what it says.

The example of a package is run first; those of its functions go on from what it has made.
"""

from __future__ import annotations

import doctest
import importlib

import pytest

import pawnb

PACKAGES = ("pawnb", "pawnb.io", "pawnb.gait", "pawnb.figures")
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE | doctest.FAIL_FAST

NEEDS = {"read_c3d": "c3d", "write_c3d": "c3d", "read_nwb": "pynwb", "write_nwb": "pynwb"}
"""Names whose library is an extra."""


def names_of(package):
    """Return the functions and classes that a package lists."""
    module = importlib.import_module(package)
    return [name for name in module.__all__ if callable(getattr(module, name))]


def examples_of(item, name):
    """Return the example in the docstring of one name, without those of its methods."""
    return doctest.DocTestParser().get_doctest(item.__doc__ or "", {}, name, None, None)


def run(test, names):
    """Run one example in the given names; what it makes stays in them."""
    test.globs = names
    said: list[str] = []
    doctest.DocTestRunner(optionflags=FLAGS).run(test, out=said.append, clear_globs=False)
    assert not said, "".join(said)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Names that the examples of packages make, each in a folder of its own."""
    import matplotlib as mpl

    mpl.use("Agg")
    return {}


@pytest.mark.parametrize("package", PACKAGES)
def test_every_everyday_name_has_an_example(package):
    module = importlib.import_module(package)
    without = [n for n in names_of(package) if not examples_of(getattr(module, n), n).examples]
    assert without == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("package", "name"), [(package, name) for package in PACKAGES for name in names_of(package)]
)
def test_example_gives_what_it_says(package, name, made, tmp_path_factory, monkeypatch):
    import matplotlib.pyplot as plt

    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    module = importlib.import_module(package)
    if package not in made:
        folder = tmp_path_factory.mktemp("examples")
        monkeypatch.chdir(folder)
        setup: dict[str, object] = {}
        run(examples_of(module, package), setup)
        made[package] = (folder, setup)
    folder, setup = made[package]
    monkeypatch.chdir(folder)
    run(examples_of(getattr(module, name), f"{package}.{name}"), dict(setup))
    plt.close("all")


def test_a_wrong_example_is_found():
    def wrong():
        """>>> 1 + 1
        3
        """

    with pytest.raises(AssertionError, match="Expected"):
        run(examples_of(wrong, "wrong"), {"pawnb": pawnb})
