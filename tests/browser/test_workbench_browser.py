"""The workbench in a real browser: hostile names run nothing, nothing overflows in any theme."""

import json

import pytest
from test_small_screen_browser import set_theme

pytestmark = pytest.mark.browser

HOSTILE = ["<img src=x onerror=window.hurt=1>", "a" * 200, "\u05e9\u05dc\u05d5\u05dd", "$x^2$"]


@pytest.fixture
def folder(trial_file, tmp_path):
    """Four trials with hostile names; the last cannot be read."""
    text = trial_file.read_text()
    for k, name in enumerate(HOSTILE):
        place = tmp_path / "bench" / f"t{k}"
        place.mkdir(parents=True)
        toml = text.replace('name = "small"', f"name = {json.dumps(name)}")
        (place / "trial.toml").write_text(toml if k < 3 else '[trial]\n"<b onclick=x>" = 1\n')
    return tmp_path / "bench"


@pytest.mark.parametrize(("width", "height"), [(1366, 768), (1920, 1200)])
@pytest.mark.parametrize("theme", ["Light", "Dark"])
def test_hostile_names_run_nothing_and_nothing_overflows(notebook, folder, width, height, theme):
    page = notebook.page
    page.set_viewport_size({"width": width, "height": height})
    set_theme(notebook, theme)
    try:
        notebook.run(f"import pawnb\nw = pawnb.Workbench({str(folder)!r})\nw")
        button = page.get_by_role("button", name="Click the start")
        button.first.wait_for(timeout=60_000)
        mend = page.get_by_role("button", name="What to mend")
        mend.wait_for(timeout=60_000)
        assert button.count() == 3
        assert page.get_by_text(HOSTILE[0], exact=True).is_visible()
        assert page.evaluate("window.hurt") is None
        area = page.locator(".jp-OutputArea-output").last.bounding_box()
        controls = ".jp-OutputArea button, .jp-OutputArea select"
        visible = "[...document.querySelectorAll(s)].filter((e) => e.offsetParent).length > 6"
        page.wait_for_function(f"(s) => {visible}", arg=controls)
        shown = page.locator(controls).all()
        boxes = [box for one in shown if (box := one.bounding_box()) is not None]
        assert len(boxes) > 6
        for box in boxes:
            assert box["x"] + box["width"] <= area["x"] + area["width"] + 1
        # what is wrong is said in words, and the one step there is says what to mend
        mend.click()
        page.get_by_text("has an unknown field").first.wait_for(timeout=20_000)
        assert page.evaluate("window.hurt") is None
        notebook.assert_no_errors()
    finally:
        set_theme(notebook, "Light")
        page.set_viewport_size({"width": 1500, "height": 1000})
