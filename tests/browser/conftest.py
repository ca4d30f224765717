"""A Jupyter server and a browser for the tests that need real clicks and real keys."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

# the small trial is shared with the tests that need no browser
sys.path.append(str(Path(__file__).resolve().parents[1] / "widgets"))

from jupyter_page import ARGS, NotebookPage, find_browser, jupyter
from small_trial import write_trial


@pytest.fixture(scope="session")
def browser():
    """Start the installed browser, or skip with the reason why there is none."""
    path = find_browser()
    if path is None or not Path(path).exists():
        reason = (
            "no Chromium, Chrome or Edge was found; install one, or name its program in "
            "PAWNB_BROWSER"
        )
        if os.environ.get("PAWNB_REQUIRE_BROWSER") == "1":
            pytest.fail(reason)
        pytest.skip(reason)
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=path, args=ARGS)
        yield started
        started.close()


@pytest.fixture(scope="session", params=["lab", "notebook"])
def server(request, browser, tmp_path_factory):
    """Start JupyterLab, then Notebook 7; gives (folder, address, which)."""
    root = tmp_path_factory.mktemp("root")
    with jupyter(root, tmp_path_factory.mktemp("state"), request.param) as url:
        yield root, url, request.param


@pytest.fixture(scope="session")
def open_page(server, browser):
    """Open one notebook; its kernel serves all tests of this server, each with its own widget."""
    root, url, app = server
    page = browser.new_page(viewport={"width": 1500, "height": 1000})
    yield NotebookPage(page, url, app, root)
    page.evaluate("window.jupyterapp.shell.currentWidget.sessionContext.shutdown()")
    page.close()


@pytest.fixture
def notebook(open_page, server, request):
    """Give the notebook, and close the widget ``w`` after the test."""
    yield open_page
    if folder := os.environ.get("PAWNB_SCREENSHOTS"):
        name = f"{request.node.originalname}-{server[2]}.png"
        open_page.page.screenshot(path=str(Path(folder) / name))
    open_page.kernel_runs("w.close()")


@pytest.fixture(scope="session")
def rendered(tmp_path_factory):
    """Render the small trial once."""
    return write_trial(tmp_path_factory.mktemp("small") / "trial").parent


@pytest.fixture
def trial_file(rendered, tmp_path):
    """Give a copy of the small trial that a test may write into: the path of its trial.toml."""
    return Path(shutil.copytree(rendered, tmp_path / "trial")) / "trial.toml"


@pytest.fixture
def bare_videos(rendered, tmp_path):
    """Give two videos of the small trial in a folder without any trial."""
    (tmp_path / "bare").mkdir()
    names = ("cam1.avi", "cam2.avi")
    return [str(shutil.copy(rendered / name, tmp_path / "bare")) for name in names]
