"""A page without Python in a real browser: it is looked through, and nothing is fetched."""

import numpy as np
import pytest
import small_trial as scene
from jupyter_page import NotebookPage

from pawnb.widgets import TrackReviewer

pytestmark = pytest.mark.browser


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_page_is_looked_through_without_a_kernel(browser, rendered, tmp_path, theme):
    evil = "<img src=x onerror=window.ran=1>"
    widget = TrackReviewer(
        rendered / "trial.toml", scene.true_tracks(), edits=tmp_path / "edits.jsonl"
    )
    path = widget.export_page(tmp_path / "page.html", frames=range(8, 14), title=evil)
    widget.close()
    page = browser.new_page(viewport={"width": 1366, "height": 768}, color_scheme=theme)
    asked, errors = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(path.as_uri())
    shown = NotebookPage.__new__(NotebookPage)
    shown.page, shown.errors = page, errors
    shown.wait("!!c && c.painted === 8 && c.stages[0].fitted")
    assert shown.bar_code("cam2", scene.BITS, scene.SQUARE) == 8
    shown.focus()
    shown.press("ArrowRight")
    shown.wait("c.painted === 9 && !c.dirty")
    assert shown.bar_code("cam2", scene.BITS, scene.SQUARE) == 9
    point = shown.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
    np.testing.assert_allclose((point["u"], point["v"]), scene.seen(9)[0, 0], atol=0.01)
    # what is dragged is not changed, and that is said
    shown.drag("cam1", scene.seen(9)[0, 0], (300, 150))
    shown.settle()
    assert "Nothing was changed" in page.locator(".pawnb-alarm").inner_text()
    point = shown.js("c.stages[0].overlay.points.find((p) => p.id === 'FR')")
    np.testing.assert_allclose((point["u"], point["v"]), scene.seen(9)[0, 0], atol=0.01)
    shown.press("End")
    shown.wait("c.painted === 13 && !c.dirty && c.timeline.bytes !== null")
    assert page.evaluate("window.ran") is None
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert errors == []
    page.screenshot(path=str(tmp_path / f"page-{theme}.png"))
    page.close()
