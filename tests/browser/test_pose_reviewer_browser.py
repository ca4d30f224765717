"""PoseReviewer in a real browser: step, drag a leg, track again, and the correction is kept."""

import json

import numpy as np
import pytest
import small_pose_trial as scene

from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.poses import join_poses
from pawnb.core.pose.track_result import plain_track
from pawnb.io.native import write_tracks
from pawnb.schema import add_provenance

pytestmark = pytest.mark.browser


@pytest.fixture
def reviewing(notebook, tmp_path):
    """Open the review of four frames in which the spider stands still, leg R2 wrong in frame 4."""
    trial = scene.write_pose_trial(tmp_path / "trial")
    poses = join_poses([scene.truth()] * 4)
    poses.frames[:] = np.arange(scene.EMPTY, scene.N_FRAMES)
    poses.angles_deg[2, scene.SPECIES.joints.index("R2_BC")] += 25.0
    tracks = tracks_from_poses(
        scene.SPECIES, plain_track(scene.SPECIES, poses), fps=125.0, view="top",
        individual="s1", px_per_unit=scene.SCALE, unit="mm",
    )  # fmt: skip
    start = {"frame": scene.EMPTY}
    tracks = add_provenance(tracks, step="track", method="pawnb", settings={}, start=[start])
    file = write_tracks(tracks, tmp_path / "tracks.nc")
    notebook.show(f"""from pawnb.io.native import read_tracks
from pawnb.widgets import PoseReviewer
w = PoseReviewer({str(trial)!r}, read_tracks({str(file)!r}), edits={str(tmp_path / "e.jsonl")!r})
w""")
    return notebook, tmp_path / "e.jsonl"


def tip(notebook, leg="R2"):
    found = notebook.js(f"c.stages[0].stick.handles().find((h) => h.id === '{leg}')")
    return np.array([found["u"], found["v"]])


def test_a_leg_is_dragged_right_and_tracked_again(reviewing):
    notebook, file = reviewing
    right = tip(notebook)
    notebook.focus()
    for _ in range(2):
        notebook.press("ArrowRight")
        notebook.settle()
    notebook.wait("c.painted === 4")
    assert np.hypot(*(tip(notebook) - right)) > 8
    notebook.drag("top", tip(notebook), right)
    notebook.settle()
    np.testing.assert_allclose(tip(notebook), right, atol=1.5)
    (line,) = map(json.loads, file.read_text().splitlines())
    assert (line["edit"], line["frame"]) == ("pose", 4)
    notebook.press("r")
    # what was done is said once the new tracks were judged
    notebook.until("w.status.startswith('Tracked again from frame 4 on; now ')", True, seconds=90)
    notebook.settle()
    assert "2 corrections in e.jsonl" in notebook.page.locator(".pawnb-status").inner_text()
    for key in ("ArrowLeft", "ArrowRight", "ArrowRight"):  # frames 3, 4 and 5
        notebook.press(key)
        notebook.settle()
        assert np.hypot(*(tip(notebook) - right)) < 5
    # keys move the tip of the chosen leg, across the leg, which can follow
    was = tip(notebook)
    for _ in range(3):
        notebook.press("Alt+ArrowRight")
    notebook.until("len(w.corrected.corrections)", 3)
    notebook.settle()
    np.testing.assert_allclose(tip(notebook) - was, (3, 0), atol=0.3)
    notebook.press("Control+z")
    notebook.settle()
    np.testing.assert_allclose(tip(notebook), was, atol=0.01)
    # N interpolates, as in every timeline, and does not straighten the leg
    for key in ("i", "o", "n"):
        notebook.press(key)
    notebook.settle()
    assert "nothing to interpolate between" in notebook.page.locator(".pawnb-alarm").inner_text()
    np.testing.assert_allclose(tip(notebook), was, atol=0.01)
    assert notebook.py("w.effort()['minutes']") > 0  # keys and mouse were heard
    notebook.assert_no_errors()
