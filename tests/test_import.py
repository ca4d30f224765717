"""``import pawnb`` is quick and quiet; layers import only downwards; the public names exist."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import pawnb

ROOT = Path(__file__).resolve().parents[1]

HEAVY = ("cv2", "av", "skimage", "matplotlib", "anywidget", "ipywidgets", "jupyterlab", "astropy")


def test_import_loads_nothing_heavy_and_writes_nothing(tmp_path):
    code = (
        f"import sys, pawnb\nprint([m for m in {HEAVY!r} if m in sys.modules], pawnb.__version__)"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=True,
    )
    assert done.stdout.strip() == f"[] {pawnb.__version__}"
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", pawnb.__all__)
def test_every_public_name_is_there(name):
    assert getattr(pawnb, name) is not None


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["io.movement.to_movement", "core.dlt.fit_dlt", "gait.regression", "schema.make_tracks"],
)
def test_rooms_of_the_house_need_no_import_of_their_own(name):
    # in a process of its own: any module that was imported before is there anyway
    code = f"import pawnb; pawnb.{name}; print(hasattr(pawnb.io, 'nothing'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_unknown_names_are_refused():
    with pytest.raises(AttributeError, match="no attribute 'trak'"):
        _ = pawnb.trak


def test_layers_import_only_downwards():
    from importlinter.cli import lint_imports

    assert lint_imports(config_filename=str(ROOT / ".importlinter")) == 0
