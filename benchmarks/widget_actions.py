"""How many things a person does for a task in the widgets: each press, drag and key is counted.

Run it from the project's root; it drives Chromium in JupyterLab:

    python benchmarks/widget_actions.py
    python benchmarks/widget_actions.py --json

*swap*: two points exchanged over 40 frames. *wrong stretch*: a point that is 60 px off over five
frames is put right. What was done is checked in the kernel, not only counted. From bare videos to
tracks is counted by `tests/browser/test_open_browser.py`.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS / "browser"), str(TESTS / "widgets")]

AIMS = {"swap": 4, "wrong stretch": 2}


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

    trial = scene.write_trial(folder / "trial")
    for name in ("root", "state"):
        (folder / name).mkdir()
    with sync_playwright() as driver, jupyter(folder / "root", folder / "state", "lab") as url:
        browser = driver.chromium.launch(executable_path=find_browser(), args=ARGS)
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        notebook = NotebookPage(page, url, "lab", folder / "root")
        counts = {
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
