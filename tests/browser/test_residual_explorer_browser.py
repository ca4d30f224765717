"""ResidualExplorer in a real browser: the slider and the dragged line reach Python."""

import os

import pytest

pytestmark = pytest.mark.browser


def test_slider_and_line_move_the_cutoff(notebook):
    notebook.run("""import numpy as np, pandas as pd
from pawnb.widgets import ResidualExplorer
t = np.arange(400) / 100.0
rng = np.random.default_rng(3)
signals = pd.DataFrame({"a": 10 * np.sin(4 * np.pi * t) + 0.3 * rng.standard_normal(400)})
w = ResidualExplorer(signals, fs_hz=100.0, unit="mm")
w""")
    page = notebook.page
    page.locator(".jupyter-matplotlib canvas").first.wait_for(timeout=30_000)
    # what is in the hand is what was found, not the nearest step of the slider
    notebook.wait_idle()
    page.wait_for_timeout(1000)
    found = notebook.py("w.session.chosen()['residual'][0]")
    assert notebook.py("[w.cutoff_hz, w.session.cutoff_hz]") == [found, found]
    page.locator("input[type=number]").last.fill("12.3456")
    page.keyboard.press("Enter")
    notebook.until("w.cutoff_hz", 12.3456, seconds=30)
    page.locator("button.jupyter-button", has_text="residual analysis").last.click()
    notebook.until("w.cutoff_hz", found, seconds=30)
    before = found
    track = page.locator(".widget-slider .noUi-base").first
    track.scroll_into_view_if_needed()
    box = track.bounding_box()
    page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + box["height"] / 2)
    notebook.until(f"w.cutoff_hz > {before!r}", True, seconds=30)
    before = notebook.py("w.cutoff_hz")
    # press and drag in the residual curve, the left third of the picture
    page.locator(".jupyter-matplotlib canvas").last.scroll_into_view_if_needed()
    box = page.locator(".jupyter-matplotlib canvas").last.bounding_box()
    x, y = box["x"] + 0.3 * box["width"], box["y"] + 0.4 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y, steps=5)
    page.mouse.up()
    notebook.until(f"w.cutoff_hz > {before!r}", True, seconds=30)
    if "PAWNB_SHOTS" in os.environ:
        page.screenshot(path=os.environ["PAWNB_SHOTS"] + "/residual_explorer.png")
