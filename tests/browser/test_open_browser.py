"""`pawnb open VIDEO VIDEO`: from bare videos to tracks by clicks alone, counted, no file edited."""

import contextlib
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time

import pytest
import small_trial as scene

pytestmark = pytest.mark.browser

MOST_ACTIONS = 25
VIEWS = ("cam1", "cam2")


@pytest.fixture
def page(browser, rendered, tmp_path):
    """Open two bare videos with the command; gives the page and the folder."""
    folder = tmp_path / "mine"
    folder.mkdir()
    for name in VIEWS:
        shutil.copy(rendered / f"{name}.avi", folder)
    columns = [line.split(",")[:2] for line in (rendered / "DLTcoefs.csv").read_text().split()]
    (folder / "DLTcoefs.csv").write_text("\n".join(",".join(pair) for pair in columns) + "\n")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    videos = [str(folder / f"{name}.avi") for name in VIEWS]
    words = [sys.executable, "-m", "pawnb", "open", *videos, "--no-browser", "--port", str(port)]
    env = {**os.environ, "IPYTHONDIR": str(tmp_path / "ipython")}
    env |= {f"JUPYTER_{name}_DIR": str(tmp_path / name) for name in ("CONFIG", "DATA", "RUNTIME")}
    # settings and workspaces of whoever runs the tests stay as they are
    env |= {f"JUPYTERLAB_{n}_DIR": str(tmp_path / n) for n in ("SETTINGS", "WORKSPACES")}
    with (tmp_path / "log").open("w") as log:
        # in a session of its own: JupyterLab, which the command runs, ends with it
        server = subprocess.Popen(words, env=env, stdout=log, stderr=log, start_new_session=True)
        try:
            shown = browser.new_page(viewport={"width": 1366, "height": 768})
            go(shown, address(tmp_path / "log", server))
            yield shown, folder
            shown.close()
        finally:
            end(server)


def end(server):
    """End the command and JupyterLab below it."""
    if os.name == "nt":
        server.terminate()
    else:
        os.killpg(server.pid, signal.SIGTERM)
    server.wait(30)


def address(log, server):
    end = time.monotonic() + 120
    while not (found := re.search(r"http://127\.0\.0\.1:\d+/doc/\S+token=\w+", log.read_text())):
        assert server.poll() is None, log.read_text()
        assert time.monotonic() < end, log.read_text()
        time.sleep(0.2)
    return found.group(0)


def go(page, url):
    """Open the page; a busy machine says its address before it answers there."""
    from playwright.sync_api import Error

    for _ in range(100):
        with contextlib.suppress(Error):
            page.goto(url)
            return
        time.sleep(0.5)
    page.goto(url)


def asked(page):
    """Which view and point a click is asked for in."""
    return page.evaluate(
        """() => { const c = document.querySelector('.pawnb-root')._pawnb;
        if (c.pending) return 'wait';
        const stage = c.stages.find((s) => s.overlay.asks);
        return stage ? [stage.name, stage.overlay.asks] : null; }"""
    )


def click(page, view, u, v):
    x, y = page.evaluate(
        """([view, u, v]) => { const c = document.querySelector('.pawnb-root')._pawnb;
        const s = c.stages.find((stage) => stage.name === view);
        s.marks.scrollIntoView({block: 'nearest'});
        const [x, y] = s.toCanvas(u, v), box = s.marks.getBoundingClientRect();
        return [box.left + x * box.width / s.marks.width,
                box.top + y * box.height / s.marks.height];
        }""",
        [view, u, v],
    )
    page.mouse.click(x, y)


def test_two_bare_videos_are_tracked_in_25_actions_and_no_file_is_edited(page):
    page, folder = page
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    # no cell is written or run by hand: the form is there
    page.get_by_role("button", name="Make the trial").wait_for(timeout=120_000)
    actions = 0
    page.get_by_label("animal", exact=True).select_option(label="other: points that you name")
    page.get_by_placeholder("names with commas between").fill("FR, HR")
    page.get_by_placeholder("frames a second").fill(str(scene.FPS))
    page.get_by_role("button", name="Make the trial").click()
    actions += 4
    # once every point is placed the list above has such a button, too
    track = page.get_by_role("button", name="Track", exact=True).last
    track.wait_for(timeout=60_000)
    # the button of the form was at its end; what comes next is looked at from its beginning
    page.wait_for_function(
        "(el) => el.getBoundingClientRect().top > 80", arg=track.element_handle()
    )
    assert track.bounding_box()["y"] < 700
    page.wait_for_function("document.querySelector('.pawnb-root')?._pawnb?.painted === 0")
    while (place := asked(page)) is not None:
        if place == "wait":
            page.wait_for_timeout(50)
            continue
        view, point = place
        u, v = scene.seen(0)[list(scene.POINTS).index(view), ["FR", "HR"].index(point)]
        click(page, view, float(u), float(v))
        actions += 1
        assert actions <= MOST_ACTIONS
        page.wait_for_timeout(200)
    assert len((folder / "start.csv").read_text().split()) == 1 + 4
    track.click()
    actions += 1
    page.locator(".pawnb-lanes").wait_for(timeout=240_000)  # the review is open
    assert (folder / "results" / "tracks.nc").exists()
    print(f"own two-view clip to tracks: {actions} actions")
    assert actions <= MOST_ACTIONS
    # the cell of the page still names the videos: whoever comes back goes on with the trial
    page.goto("about:blank")
    page.go_back()
    page.get_by_text("go on with the next step").wait_for(timeout=120_000)
    assert page.get_by_role("button", name="Review", exact=True).is_visible()
    assert errors == []


def test_another_notebook_with_the_mark_of_the_page_is_not_run(page):
    """Somebody else's notebook may carry the mark: it runs only when a person runs it."""
    shown, folder = page
    sentinel = folder / "ran"
    document = json.loads((folder / "workbench.ipynb").read_text())
    document["cells"][0]["source"] = f"open({str(sentinel)!r}, 'w').close()"
    (folder / "sub").mkdir()
    (folder / "sub" / "workbench.ipynb").write_text(json.dumps(document))
    go(shown, shown.url.partition("/doc/")[0] + "/doc/tree/sub/workbench.ipynb")
    shown.locator(".jp-Notebook .jp-Cell").first.wait_for(timeout=60_000, state="attached")
    shown.wait_for_timeout(8000)  # a kernel starts, and would have run the cell
    assert not sentinel.exists()
