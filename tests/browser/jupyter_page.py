"""JupyterLab or Notebook 7 on loopback, an installed browser, and one open notebook."""

from __future__ import annotations

import ast
import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome",
         "microsoft-edge", "microsoft-edge-stable", "msedge")  # fmt: skip
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    *(
        str(Path(os.environ.get(folder, "C:/Program Files")) / exe)
        for folder in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")
        for exe in ("Google/Chrome/Application/chrome.exe", "Microsoft/Edge/Application/msedge.exe")
    ),
)
ARGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
        "--disable-background-networking", "--disable-component-update"]  # fmt: skip
# Notebook 7.6 throws this one by itself, with or without a widget on the page
KNOWN_ERROR = "'schema'"


def find_browser():
    """Return the path of an installed Chromium, Chrome or Edge, or None."""
    own = os.environ.get("PAWNB_BROWSER")
    if own:
        return own
    found = (shutil.which(name) for name in NAMES)
    return next((path for path in found if path), None) or next(
        (place for place in PLACES if Path(place).exists()), None
    )


@contextlib.contextmanager
def jupyter(root, state, app):
    """Start ``app`` ("lab", "notebook" or "voila") with settings of its own; give its address.

    Voila shows the notebook ``root``; the others the folder.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    config = state / "config"
    (config / "labconfig").mkdir(parents=True)
    # the news toast covers the lower right corner and asks the network
    off = {"@jupyterlab/apputils-extension:announcements": True}
    (config / "labconfig" / "page_config.json").write_text(json.dumps({"disabledExtensions": off}))
    paths = [str(HERE.parent / "widgets"), os.environ.get("PYTHONPATH", "")]
    env = dict(
        os.environ,
        PATH=os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        PYTHONPATH=os.pathsep.join(path for path in paths if path),
        JUPYTER_CONFIG_DIR=str(config),
        JUPYTER_DATA_DIR=str(state / "data"),
        JUPYTER_RUNTIME_DIR=str(state / "run"),
        JUPYTERLAB_WORKSPACES_DIR=str(state / "ws"),
        JUPYTERLAB_SETTINGS_DIR=str(state / "set"),
        IPYTHONDIR=str(state / "ipy"),
        JUPYTER_PREFER_ENV_PATH="1",
    )
    url = f"http://127.0.0.1:{port}"
    if app == "voila":
        command = [sys.executable, "-m", "voila", root, "--no-browser", f"--port={port}"]
        up = "/voila/files/none"  # which it refuses; the page itself would run
    else:
        kind = {"lab": "LabApp", "notebook": "JupyterNotebookApp"}[app]
        command = [
            sys.executable, "-m", "jupyter", app, "--no-browser", "--allow-root",
            "--ip=127.0.0.1", f"--port={port}", f"--ServerApp.root_dir={root}",
            "--IdentityProvider.token=", "--ServerApp.password=",
            f"--{kind}.expose_app_in_browser=True",
        ]  # fmt: skip
        up = "/api/status"
    with (state / "server.log").open("w") as log:
        server = subprocess.Popen(command, env=env, stdout=log, stderr=log)
        try:
            end = time.monotonic() + 120
            while not _answers(url + up):
                text = (state / "server.log").read_text()[-3000:]
                assert server.poll() is None, text
                assert time.monotonic() < end, text
                time.sleep(0.2)
            yield url
        finally:
            server.terminate()
            server.wait(15)


def _answers(url):
    try:
        with urllib.request.urlopen(url, timeout=1):  # noqa: S310, our own loopback address
            return True
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False


class NotebookPage:
    """One notebook open in a page; ``py`` evaluates an expression in its kernel, without a cell."""

    def __init__(self, page, url, app, folder):
        cells = [
            {"cell_type": "code", "id": f"c{i}", "metadata": {}, "source": source, "outputs": [],
             "execution_count": None}
            for i, source in enumerate(["", "1 + 1"])
        ]  # fmt: skip
        kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
        document = {"nbformat": 4, "nbformat_minor": 5, "metadata": {"kernelspec": kernel}}
        (folder / "test.ipynb").write_text(json.dumps(document | {"cells": cells}))
        self.page, self.errors = page, []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.goto(url + ("/lab/tree/test.ipynb?reset" if app == "lab" else "/notebooks/test.ipynb"))
        self.wait_idle()

    def run(self, source):
        """Run the source in the first cell."""
        self.errors.clear()
        self.page.evaluate(
            """async (source) => {
            const app = window.jupyterapp, book = app.shell.currentWidget.content;
            document.querySelectorAll('.pawnb-root').forEach((root) => root.remove());
            book.activeCellIndex = 0;
            book.activeCell.model.sharedModel.setSource(source);
            await app.commands.execute('notebook:run-cell'); }""",
            source,
        )

    def show(self, source):
        """Run the source in the first cell and wait for the canvas ``w`` that it shows."""
        self.run(source)
        self.page.locator(".pawnb-root").first.wait_for(timeout=60_000)
        self.wait("!!c && c.painted !== undefined && c.painted !== null && c.stages[0].fitted")
        self.settle()

    def wait_idle(self):
        self.page.wait_for_function(
            "window.jupyterapp?.shell?.currentWidget?.sessionContext?.session?.kernel?.status"
            " === 'idle'",
            timeout=120_000,
        )

    def wait(self, condition, seconds=30):
        """Wait until a condition on the canvas ``c`` and its frames ``f`` holds."""
        self.page.wait_for_function(
            "(() => { const c = document.querySelector('.pawnb-root')?._pawnb, f = c?.frames;"
            f" return {condition}; }})()",
            timeout=seconds * 1000,
        )

    def js(self, expression):
        """Evaluate an expression of the canvas ``c`` and its frames ``f``."""
        return self.page.evaluate(
            "() => { const c = document.querySelector('.pawnb-root')._pawnb, f = c.frames;"
            f" return {expression}; }}"
        )

    def py(self, expression):
        """Evaluate a Python expression in the kernel."""
        out = self.page.evaluate(
            """async (e) => {
            const k = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
            const json = "__import__('json').dumps(" + e + ", default=float)";
            const r = await k.requestExecute(
                {code: '', store_history: false, user_expressions: {r: json}}).done;
            const v = r.content.user_expressions.r;
            return v.status === 'ok' ? v.data['text/plain'] : 'ERROR ' + v.evalue; }""",
            expression,
        )
        assert not out.startswith("ERROR"), out
        return json.loads(ast.literal_eval(out))

    def until(self, expression, expected, seconds=10):
        """Wait until a Python expression in the kernel has the expected value."""
        end = time.monotonic() + seconds
        while (value := self.py(expression)) != expected:
            assert time.monotonic() < end, f"{expression} is {value!r}, expected {expected!r}"
            time.sleep(0.03)

    def settle(self):
        """Wait until nothing is on its way and what is wanted is painted."""
        self.wait("c.pending === 0 && f.shown === f.want && c.painted === f.shown && !c.dirty")

    def n_cells(self):
        return self.page.evaluate("window.jupyterapp.shell.currentWidget.content.widgets.length")

    def kernel_runs(self, code):
        """Execute code in the kernel and wait for it."""
        self.page.evaluate(
            """async (code) => {
            const k = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
            await k.requestExecute({code, store_history: false}).done; }""",
            code,
        )

    # --- the canvas ---------------------------------------------------------------------

    def focus(self):
        self.page.locator(".pawnb-root").focus()

    def press(self, key):
        self.page.keyboard.press(key)

    def at(self, view, u, v):
        """Where image position (u, v) of a view is on the page, CSS px."""
        self.page.locator(f".pawnb-view[data-view={view}]").scroll_into_view_if_needed()
        return self.page.evaluate(
            """([view, u, v]) => {
            const c = document.querySelector('.pawnb-root')._pawnb;
            const s = c.stages.find((stage) => stage.name === view);
            const [x, y] = s.toCanvas(u, v), box = s.marks.getBoundingClientRect();
            return [box.left + x * box.width / s.marks.width,
                    box.top + y * box.height / s.marks.height]; }""",
            [view, u, v],
        )

    def under(self, view, x, y):
        """Which image position of a view is at (x, y) CSS px of the page."""
        u, v = (np.array(self.at(view, *uv)) for uv in ((1, 0), (0, 1)))
        origin = np.array(self.at(view, 0, 0))
        return (
            float((x - origin[0]) / (u - origin)[0]),
            float((y - origin[1]) / (v - origin)[1]),
        )

    def click(self, view, u, v, **options):
        self.page.mouse.click(*self.at(view, u, v), **options)

    def drag(self, view, start, end, *, release=True):
        mouse = self.page.mouse
        x1, y1 = self.at(view, *end)
        mouse.move(*self.at(view, *start))
        mouse.down()
        mouse.move(x1, y1, steps=6)
        if release:
            mouse.up()

    def bar_code(self, view, squares, size):
        """Read the frame number from the pixels on the screen."""
        bits = self.page.evaluate(
            """([view, squares, size]) => {
            const c = document.querySelector('.pawnb-root')._pawnb;
            const s = c.stages.find((stage) => stage.name === view), g = s.image.getContext('2d');
            return [...Array(squares).keys()].map((bit) => {
                const [x, y] = s.toCanvas((bit + 0.5) * size, size / 2);
                return g.getImageData(Math.round(x), Math.round(y), 1, 1).data[0]; }); }""",
            [view, squares, size],
        )
        assert all(value < 50 or value > 205 for value in bits), bits
        return sum((value > 128) << place for place, value in enumerate(bits))

    def assert_no_errors(self):
        unknown = [error for error in self.errors if KNOWN_ERROR not in error]
        assert not unknown, unknown
