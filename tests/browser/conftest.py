"""A Jupyter server and a browser for the tests that need real clicks and real keys."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from jupyter_page import ARGS, NotebookPage, find_browser, jupyter


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


@pytest.fixture
def open_notebook(server, browser, request):
    """Return a function that opens a notebook with these cells and runs them all."""
    root, url, app = server
    pages = []

    def opened(*cells):
        page = browser.new_page(viewport={"width": 1500, "height": 1000})
        pages.append(page)
        name = f"{request.node.originalname}-{len(pages)}.ipynb"
        return NotebookPage(page, url, app, root / name, cells)

    yield opened
    for page in pages:
        if folder := os.environ.get("PAWNB_SCREENSHOTS"):
            page.screenshot(path=f"{folder}/{request.node.originalname}-{app}.png")
        page.evaluate("window.jupyterapp?.shell?.currentWidget?.sessionContext?.shutdown()")
        page.close()
