"""Fixtures shared by all tests; the folder of real data is looked up here only."""

from __future__ import annotations

import gc
import os
import shutil
from pathlib import Path

# a worker a core: libraries that start threads of their own would only be in each other's way
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import filelock  # noqa: E402
import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

# a property is right or wrong, however busy the machine is
settings.register_profile("pawnb", deadline=None)
settings.load_profile("pawnb")

ROOT = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(items):
    """Let notebooks go first: each takes minutes, and at the end one worker would wait for it."""
    items.sort(key=lambda item: "notebooks" not in item.path.parts)


def pytest_collection_finish():
    """Spare the garbage collector the millions of objects that stay until the end.

    Modules and collected tests are never garbage; to go through them again and again, as is done
    by default, takes a sixth of the time of the fast suite.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture(scope="session")
def real_data():
    """Return a function that gives a folder of real data, or skips the test, saying why."""
    home = Path(os.environ.get("PAWNB_TEST_DATA", ROOT.parent / "shared" / "data"))

    def find(name: str) -> Path:
        folder = home / name
        if not folder.exists():
            pytest.skip(f"real data {name!r} is not in {home} (set PAWNB_TEST_DATA)")
        return folder

    return find


def once(tmp_path_factory, name, render):
    """Return the folder of a trial that is rendered by the first worker to want it, for all."""
    home = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        home = home.parent
    folder = home / name
    with filelock.FileLock(home / f"{name}.lock"):
        if not (folder / "trial.toml").exists():  # it is written last
            render(folder)
    return folder


@pytest.fixture(scope="session")
def rendered_trial(tmp_path_factory):
    """Folder of a small synthetic trial: a mouse runs for 40 frames before four cameras.

    At 300 mm/s it makes about five strides a second, so 40 frames at 250 per second hold
    most of one stride of each leg. Do not write into it: copy it first.
    """
    from pawnb.synthetic import render_mouse_trial

    return once(
        tmp_path_factory,
        "rendered-mouse",
        lambda folder: render_mouse_trial(folder, frames=40, scale=0.2, seed=1),
    )


@pytest.fixture(scope="session")
def rendered_spider(tmp_path_factory):
    """Folder of a small synthetic trial: a spider holds still for 14 frames, after 10 empty ones.

    Do not write into it: copy it first.
    """
    from pawnb.synthetic import render_spider_trial

    return once(
        tmp_path_factory,
        "rendered-spider",
        lambda folder: render_spider_trial(folder, frames=24, scale=0.3, seed=1, motion="still"),
    )


@pytest.fixture
def small_spider(rendered_spider, tmp_path):
    """Return a copy of the small synthetic spider that the test may change."""
    return Path(shutil.copytree(rendered_spider, tmp_path / "spider"))


@pytest.fixture
def small_trial(rendered_trial, tmp_path):
    """Return a copy of the small synthetic trial that the test may change."""
    return Path(shutil.copytree(rendered_trial, tmp_path / "mouse"))
