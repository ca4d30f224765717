"""``dir()`` of every public package is what Tab shows: its public names, all of them, no other."""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys

import pytest

import pawnb

# rooms of the engine: named by their modules, see the reference
_ENGINE = ("pawnb.core.jpeg", "pawnb.core.paws", "pawnb.core.pose", "pawnb.workflow.jupyter")


def packages():
    found = [m.name for m in pkgutil.walk_packages(pawnb.__path__, "pawnb.") if m.ispkg]
    return ["pawnb", *(name for name in found if not name.startswith(_ENGINE))]


@pytest.mark.parametrize("name", packages())
def test_dir_lists_the_public_names_and_nothing_else(name):
    package = importlib.import_module(name)
    assert dir(package) == sorted(package.__all__)
    assert len(set(package.__all__)) == len(package.__all__)
    for public in package.__all__:
        assert getattr(package, public) is not None, public


@pytest.mark.parametrize(
    ("name", "there", "absent"),
    [
        ("pawnb", {"load_trial", "track", "gait", "figures"}, {"annotations", "importlib", "Any"}),
        (
            "pawnb.gait",
            {"regression", "groups", "mixed", "residuals", "bootstrap", "circular"},
            {"feet", "scored", "grid"},
        ),
        ("pawnb.io", {"read_deeplabcut", "read_sleap", "read_anipose", "to_movement"}, {"hdf5"}),
        ("pawnb.widgets", {"TrackReviewer"}, {"Any", "annotations", "importlib"}),
    ],
)
def test_rooms_are_shown_and_inner_ones_are_not(name, there, absent):
    shown = set(dir(importlib.import_module(name)))
    assert there <= shown
    assert not absent & shown


def test_listing_names_imports_nothing_heavy():
    code = (
        "import sys, pawnb\n"
        "for room in ('io', 'widgets', 'workflow', 'core', 'synthetic'):\n"
        "    assert dir(getattr(pawnb, room))\n"
        "print([m for m in ('cv2', 'av', 'matplotlib', 'anywidget', 'h5py') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_module_of_gait_is_found_by_its_own_name_and_by_its_room():
    from pawnb.gait import scaling

    assert pawnb.gait.scaling is pawnb.gait.regression.scaling is scaling
    with pytest.raises(ModuleNotFoundError, match=r"is now pawnb\.gait\.regression\.scaling;"):
        importlib.import_module("pawnb.gait.scaling")
    with pytest.raises(ModuleNotFoundError, match="No module named"):
        importlib.import_module("pawnb.gait.scalings")
