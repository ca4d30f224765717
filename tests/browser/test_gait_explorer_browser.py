"""GaitExplorer in a real browser: clicks and drags in the plots reach Python, and are kept."""

import os

import pytest

pytestmark = pytest.mark.browser

SOURCE = """from pathlib import Path
from pawnb import gait
from pawnb.synthetic.spider_study import simulate_spider_study
from pawnb.widgets import GaitExplorer
Path("event_edits.jsonl").unlink(missing_ok=True)
run = simulate_spider_study(animals=1, trials=1, seed=3).runs[0]
found = gait.analyse(run.tracks(noise_px=0.2), trial=run.trial)
w = GaitExplorer(found, "event_edits.jsonl")
w"""
AGAIN = """w.close()
w = GaitExplorer(found, "event_edits.jsonl")
w"""
FIRST = "w.tables.strides[w.tables.strides['leg'] == 'R2'].iloc[1]"


def place(notebook, ax, x, y):
    """Where a point of an axes is on the page, CSS px."""
    canvas = notebook.page.locator(".jupyter-matplotlib canvas").last
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    share = notebook.py(
        f"[float(v) for v in w._figure.transFigure.inverted().transform("
        f"w._panels.{ax}.transData.transform(({x!r}, {y!r})))]"
    )
    return box["x"] + share[0] * box["width"], box["y"] + (1 - share[1]) * box["height"]


def told(notebook, text):
    """Wait until the widget says something: it does when the plots are drawn.

    Its callbacks run in a thread of their own; what they change is not there at once.
    """
    notebook.until(f"{text!r} in w._told.value", True, seconds=30)


def shown(notebook, source):
    """Run the source and wait for the plots."""
    notebook.run(source)
    notebook.page.locator(".jupyter-matplotlib canvas").last.wait_for(timeout=60_000)
    notebook.wait_idle()


def pick_stride(notebook, start):
    """Click the second stride of R2 in the gait diagram."""
    row = notebook.py("w._panels.rows.index('R2')")
    notebook.page.mouse.click(*place(notebook, "diagram", start + 0.02, row))
    told(notebook, f"R2, stride 2: from {start:.3f} s")
    assert notebook.py("w.session.stride[1]") == pytest.approx(start)


def press_pep(notebook, time_s):
    """Press the button of the mouse on an end of stance; give where."""
    x, y = place(notebook, "signal", time_s, notebook.py("float(w._panels.signal.get_ylim()[1])"))
    y += 15  # extremes stand in the upper half
    notebook.page.mouse.move(x, y)
    notebook.page.mouse.down()
    told(notebook, f"PEP of R2 at {time_s:.3f} s")
    return x, y


def click(notebook, name):
    notebook.page.locator("button.jupyter-button", has_text=name).last.click()


def shot(notebook, name):
    """Keep a picture of the page, where one is asked for."""
    if folder := os.environ.get("PAWNB_SHOTS"):
        notebook.wait_idle()
        notebook.page.wait_for_timeout(1500)
        notebook.page.screenshot(path=f"{folder}/gait_explorer_{name}.png")


def test_strides_are_picked_and_corrections_made_undone_and_kept(notebook):
    shown(notebook, SOURCE)
    mouse = notebook.page.mouse
    start, stance = (notebook.py(f"float({FIRST}['{name}'])") for name in ("start_s", "stance_s"))
    n_strides = notebook.py("len(w.tables.strides)")
    notebook.page.get_by_label("phase of").select_option("R2 to R3")
    notebook.until("list(w.session.pair)", ["R2", "R3"], seconds=30)
    pick_stride(notebook, start)

    # an event is dragged: one line in the file, another duty factor
    x, y = press_pep(notebook, start + stance)
    mouse.move(x + 12, y, steps=4)
    shot(notebook, "drag")
    mouse.up()
    told(notebook, "1 correction;")
    # 12 px of the page, in seconds of the axis
    way = 12 / (place(notebook, "signal", 1.0, 0.0)[0] - place(notebook, "signal", 0.0, 0.0)[0])
    assert notebook.py(f"float({FIRST}['stance_s'])") == pytest.approx(stance + way, abs=0.002)
    assert notebook.py("len(open('event_edits.jsonl').read().splitlines())") == 1
    shot(notebook, "moved")
    click(notebook, "undo")
    told(notebook, "0 corrections;")
    assert notebook.py(f"float({FIRST}['stance_s'])") == pytest.approx(stance)
    click(notebook, "redo")
    told(notebook, "1 correction;")

    # an event is deleted: its stride is no more
    press_pep(notebook, notebook.py(f"float({FIRST}['start_s'] + {FIRST}['stance_s'])"))
    mouse.up()
    click(notebook, "delete event")
    told(notebook, "2 corrections")
    assert notebook.py("len(w.tables.strides)") == n_strides - 1
    shot(notebook, "deleted")
    click(notebook, "undo")
    told(notebook, "1 correction")
    assert notebook.py("len(w.tables.strides)") == n_strides

    # where there is none one is added by a key, moved and deleted by keys, and all that undone
    n_events = notebook.py("len(w.tables.events)")
    height = notebook.py("float(w._panels.signal.get_ylim()[1])")
    x, y = place(notebook, "signal", start + stance / 2, height)
    mouse.click(x, y + 15)
    told(notebook, "one can be added")
    notebook.page.keyboard.press("2")
    told(notebook, "2 corrections; PEP of R2 at")
    assert notebook.py("len(w.tables.events)") == n_events + 1
    notebook.page.keyboard.press("ArrowRight")
    told(notebook, "3 corrections; PEP of R2 at")
    notebook.page.keyboard.press("Delete")
    told(notebook, "4 corrections")
    assert notebook.py("len(w.tables.events)") == n_events
    for n in (3, 2, 1):
        notebook.page.keyboard.press("Control+z")
        told(notebook, f"{n} correction")
    assert notebook.py("len(w.tables.strides)") == n_strides
    notebook.page.keyboard.press("l")  # matplotlib's own key for a logarithmic axis

    # a stride is excluded, with a reason
    pick_stride(notebook, start)
    click(notebook, "exclude stride")
    told(notebook, "say why")
    assert notebook.py("w._panels.signal.get_yscale()") == "linear"
    notebook.page.get_by_placeholder("reason").last.fill("stumbled")
    click(notebook, "exclude stride")
    told(notebook, "2 corrections")
    assert notebook.py("len(w.tables.strides)") == n_strides - 1
    shot(notebook, "excluded")

    # what was done is there when the analysis is opened again
    shown(notebook, AGAIN)
    told(notebook, "2 corrections")
    assert notebook.py("len(w.tables.strides)") == n_strides - 1
    dropped = notebook.py("w.tables.dropped['why'].tolist()")
    assert dropped.count("excluded by hand: stumbled") == 1
    row = notebook.py("w._panels.rows.index('R2')")
    mouse.click(*place(notebook, "diagram", start + 0.02, row))
    told(notebook, "does not count: excluded by hand: stumbled")
    shot(notebook, "again")
    notebook.assert_no_errors()
