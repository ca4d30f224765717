"""A notebook as a page of Voila: widgets work, and what is clicked reaches the kernel."""

import json

import numpy as np
import pytest
import small_trial as scene
from jupyter_page import NotebookPage, jupyter

pytestmark = pytest.mark.browser

SOURCE = """import small_trial as scene
from pawnb.widgets import TrackReviewer

w = TrackReviewer({trial!r}, scene.true_tracks(), edits={edits!r})
w.frame = 8
w"""


def test_a_widget_works_in_voila(browser, trial_file, tmp_path):
    pytest.importorskip("voila", reason="voila is not installed: pip install voila")
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    edits = tmp_path / "edits.jsonl"
    source = SOURCE.format(trial=str(trial_file), edits=str(edits))
    cell = {"cell_type": "code", "id": "c0", "metadata": {}, "source": source, "outputs": [],
            "execution_count": None}  # fmt: skip
    document = {"nbformat": 4, "nbformat_minor": 5, "metadata": {"kernelspec": kernel}}
    file = tmp_path / "page.ipynb"
    file.write_text(json.dumps(document | {"cells": [cell]}))
    shown = NotebookPage.__new__(NotebookPage)
    shown.errors = []
    with jupyter(file, tmp_path / "state", "voila") as url:
        shown.page = page = browser.new_page(viewport={"width": 1366, "height": 900})
        page.on("pageerror", lambda error: shown.errors.append(str(error)))
        # its template asks for scripts of a network that need not be there
        page.route(lambda asked: not asked.startswith(url), lambda route: route.abort())
        page.goto(url)
        page.locator(".pawnb-root").first.wait_for(timeout=60_000)
        shown.wait("!!c && c.painted === 8 && c.stages[0].fitted")
        assert shown.bar_code("cam2", scene.BITS, scene.SQUARE) == 8
        shown.focus()
        shown.drag("cam1", scene.seen(8)[0, 0], (300, 150))
        shown.settle()
        point = shown.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
        np.testing.assert_allclose((point["u"], point["v"]), (300, 150), atol=1.1)
        # the kernel wrote it down
        line = json.loads(edits.read_text().splitlines()[-1])
        assert (line["frame"], line["view"], line["point"]) == (8, "cam1", "FR")
        assert (line["u"], line["v"]) == (point["u"], point["v"])
        page.close()
    assert shown.errors == []
