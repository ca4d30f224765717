"""How many things a person does for a task in the widgets: each press, drag and key is counted.

Run it from the project's root; it drives Chromium in JupyterLab:

    python benchmarks/widget_actions.py
    python benchmarks/widget_actions.py --json

*gait diagram*: from the workbench on a trial that is started to its gait diagram. *start*: four
paws placed in the two views of four that are to show each, without zooming. *swap*: two points
exchanged over 40 frames. *wrong stretch*: a point that is 60 px off over five frames is put right.
What was done is checked in the kernel or on the page, not only counted. From bare videos to tracks
is counted by `tests/browser/test_open_browser.py`.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS / "browser"), str(TESTS / "widgets")]

AIMS = {"gait diagram": 8, "start": 8, "swap": 4, "wrong stretch": 2}


class Person:
    """Does things in a reviewer, and counts them."""

    def __init__(self, notebook: Any) -> None:
        self.notebook, self.actions = notebook, 0

    def drag_lane(self, lane: int, first: int, last: int) -> None:
        """Drag along a lane of the timeline."""
        self.notebook.page.locator(".pawnb-lanes").scroll_into_view_if_needed()
        box = self.notebook.page.locator(".pawnb-lanes").bounding_box()
        x0, x1, y = self.notebook.js(
            "(() => { const t = c.timeline; return "
            f"[t.x({first} + 0.5), t.x({last} + 0.5), 20 + ({lane} + 0.5) * t.laneHeight]; }})()"
        )
        mouse = self.notebook.page.mouse
        mouse.move(box["x"] + x0, box["y"] + y)
        mouse.down()
        mouse.move(box["x"] + x1, box["y"] + y, steps=8)
        mouse.up()
        self.notebook.settle()
        self.actions += 1

    def press(self, key: str) -> None:
        """Press a key."""
        self.notebook.press(key)
        self.notebook.settle()
        self.actions += 1

    def click(self, name: str) -> None:
        """Click a button."""
        self.notebook.page.get_by_role("button", name=name).click()
        self.notebook.settle()
        self.actions += 1


def main() -> None:
    """Count and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        counts = count(Path(temporary))
    if options.json:
        print(json.dumps(counts))
        return
    for name, n in counts.items():
        print(f"{name:14s} {n:3d}   aim {AIMS[name]}")


def count(folder: Path) -> dict[str, int]:
    """Do each task in the browser; return its number of actions."""
    import small_trial as scene
    from jupyter_page import ARGS, NotebookPage, find_browser, jupyter
    from playwright.sync_api import sync_playwright

    from pawnb.synthetic import render_mouse_trial

    trial = scene.write_trial(folder / "trial")
    render_mouse_trial(folder / "mouse", frames=150, scale=0.25, seed=7, difficulty="easy")
    for name in ("root", "state"):
        (folder / name).mkdir()
    with sync_playwright() as driver, jupyter(folder / "root", folder / "state", "lab") as url:
        browser = driver.chromium.launch(executable_path=find_browser(), args=ARGS)
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        notebook = NotebookPage(page, url, "lab", folder / "root")
        counts = {
            "start": start(notebook, folder),
            "gait diagram": gait_diagram(notebook, folder),
            "swap": swap(notebook, trial, folder),
            "wrong stretch": mend(notebook, trial, folder),
        }
        browser.close()
    return counts


def review(notebook: Any, trial: Path, edits: Path, change: str = "") -> Person:
    """Open a review of the small trial."""
    notebook.show(f"""import small_trial as scene
from pawnb.widgets import TrackReviewer
tracks = scene.true_tracks()
{change}
w = TrackReviewer({str(trial)!r}, tracks, edits={str(edits)!r})
w""")
    notebook.wait("c.timeline.bytes !== null")
    return Person(notebook)


def start(notebook: Any, folder: Path) -> int:
    """Place every paw of the mouse in the views that are to show it."""
    trial = Path(shutil.copytree(folder / "mouse", folder / "unstarted"))
    truth = pd.read_csv(trial / "start.csv").set_index(["view", "point"])
    (trial / "start.csv").unlink()
    notebook.show(f"""from pawnb.widgets import ClickInitialiser
w = ClickInitialiser({str(trial)!r})
w""")
    person = Person(notebook)
    asked = "((s) => s ? [s.name, s.overlay.asks] : null)(c.stages.find((one) => one.overlay.asks))"
    while (place := notebook.js(asked)) is not None:
        u, v = truth.loc[tuple(place), ["u", "v"]]
        notebook.click(place[0], float(u), float(v))
        notebook.settle()
        person.actions += 1
    placed = pd.read_csv(trial / "start.csv").set_index(["view", "point"])
    off = np.hypot(*(placed[["u", "v"]] - truth[["u", "v"]]).dropna().to_numpy().T)
    if len(off) != 8 or off.max() > 1.5:
        raise SystemExit(f"{len(off)} points are placed, up to {off.max():.1f} px off")
    return person.actions


def gait_diagram(notebook: Any, folder: Path) -> int:
    """Go from the list of trials to the gait diagram of one that is started."""
    notebook.run(f"import pawnb\nw = pawnb.Workbench({str(folder / 'mouse')!r})\nw")
    page, person = notebook.page, Person(notebook)
    for name in ("Track", "Save, and analyse the gait"):
        button = page.get_by_role("button", name=name, exact=True)
        button.wait_for(timeout=300_000)
        button.click()
        person.actions += 1
    menu = page.get_by_label("figure", exact=True)
    menu.wait_for(timeout=300_000)
    figures = menu.locator("option").all_inner_texts()
    wanted = next(name for name in figures if "gait_diagram" in name)
    if menu.input_value() != wanted:
        menu.select_option(label=wanted)
        person.actions += 1
    page.locator(".jp-OutputArea img:visible").first.wait_for()
    return person.actions


def swap(notebook: Any, trial: Path, folder: Path) -> int:
    """Exchange two points over all 40 frames."""
    import small_trial as scene

    person = review(notebook, trial, folder / "swap.jsonl")
    person.drag_lane(0, 0, scene.N_FRAMES - 1)
    person.click("Swap with HR")
    for frame in (0, scene.N_FRAMES - 1):
        found = notebook.py(f"w.session.position({frame}, 'cam1', 'HR')")
        if found != list(scene.seen(frame)[0, 0]):
            raise SystemExit(f"frame {frame} is not exchanged: {found}")
    return person.actions


def mend(notebook: Any, trial: Path, folder: Path) -> int:
    """Put right a point that is off over five frames."""
    import small_trial as scene

    wrong = "tracks['image_position'].values[10:15, 0, :, 0, 0] += 60.0"
    person = review(notebook, trial, folder / "mend.jsonl", wrong)
    person.drag_lane(0, 10, 14)
    person.press("n")
    found = [notebook.py(f"w.session.position({f}, 'cam1', 'FR')") for f in range(10, 15)]
    off = np.abs(np.array(found) - [scene.seen(f)[0, 0] for f in range(10, 15)]).max()
    if off > 1.0:
        raise SystemExit(f"still {off:.1f} px off")
    return person.actions


if __name__ == "__main__":
    main()
