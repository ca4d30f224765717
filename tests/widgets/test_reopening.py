"""Reviews opened again after a real tracker has tracked again: every correction is there."""

import json
import subprocess
import sys

import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.io.native import read_tracks
from pawnb.widgets import PoseReviewer, TrackReviewer
from pawnb.workflow.tracking.track import track

pytestmark = pytest.mark.slow

PAW_FRAMES = (0, 8)

OPENED_AGAIN = """
import json, sys
from pawnb.io.native import read_tracks
from pawnb.widgets import {name} as Reviewer
w = Reviewer(sys.argv[1], read_tracks(sys.argv[1] + "/results/tracks.nc"))
print(json.dumps(w.tracks["image_position"].fillna(-1).values.tolist()))
print(w.status)
"""


@pytest.fixture(scope="module")
def paws(rendered_trial, tmp_path_factory):
    """Track a few frames of the running mouse with the real tracker, once."""
    results = tmp_path_factory.mktemp("paws")
    track(rendered_trial, method="paper", frames=PAW_FRAMES, out=results, progress=_silent)
    return results / "tracks.nc"


@pytest.fixture(scope="module")
def poses(rendered_spider, tmp_path_factory):
    """Track the spider with the real tracker, once."""
    results = tmp_path_factory.mktemp("poses")
    track(rendered_spider, settings={"choose_path": False}, out=results, progress=_silent)
    return results / "tracks.nc"


def _silent(_done, _total):
    pass


def review_paws(folder, file):
    """Move a paw in frame 4 and track again; return where every point is then, and the status."""
    widget = TrackReviewer(folder, read_tracks(file))
    u, v = widget.session.position(4, "cam1", "FR")
    moved = {"frame": 4, "view": "cam1", "point": "FR", "u": u + 4, "v": v - 2}
    return tracked_again(widget, moved)


def review_poses(folder, file):
    """Drag a tip in frame 17 and track again; return where every point is then, and the status."""
    widget = PoseReviewer(folder, read_tracks(file), frame=17)
    u, v = widget.session.pose_at(17).places("L2")[-1]
    moved = {"frame": 17, "point": "L2", "u": u + 3, "v": v - 2, "whole": True}
    return tracked_again(widget, moved)


def tracked_again(widget, moved):
    before = widget.tracks["image_position"].to_numpy()
    widget.edit("moved", moved)
    widget.retrack(moved["frame"])
    widget._worker.join()
    assert widget.alarm == ""
    assert "2 corrections in edits.jsonl" in widget.status
    now = widget.tracks["image_position"].to_numpy()
    assert np.nanmax(np.abs(now - before)) > 1.0
    widget.close()
    return now


def opened_again(folder, file, kind):
    widget = kind(folder, read_tracks(file))
    now, said = widget.tracks["image_position"].to_numpy(), widget.status
    widget.close()
    return now, said


def test_a_review_of_points_opens_again_with_what_was_tracked_again(small_trial, paws):
    was = review_paws(small_trial, paws)
    now, said = opened_again(small_trial, paws, TrackReviewer)
    np.testing.assert_allclose(now, was, atol=1e-9)
    assert "2 corrections in edits.jsonl" in said


@pytest.mark.slow
def test_a_review_of_poses_opens_again_with_what_was_tracked_again(small_spider, poses):
    was = review_poses(small_spider, poses)
    now, said = opened_again(small_spider, poses, PoseReviewer)
    np.testing.assert_allclose(now, was, atol=1e-9)
    assert "2 corrections in edits.jsonl" in said


def test_what_cannot_be_tracked_again_on_opening_is_said_and_the_corrections_stay(
    small_trial, paws
):
    review_paws(small_trial, paws)
    file = small_trial / "results" / "edits.jsonl"
    kept = file.read_bytes()

    def fails(_trial, _tracks, _frame):
        raise OSError("the disk is gone.")

    with pytest.raises(InputError) as raised:
        TrackReviewer(small_trial, read_tracks(paws), retrack=fails)
    said = f"the corrections in {file} track again from frame 4, which could not be done: "
    assert str(raised.value) == said + "the disk is gone. No correction is lost."
    assert file.read_bytes() == kept


@pytest.mark.slow
@pytest.mark.parametrize("name", ["TrackReviewer", "PoseReviewer"])
def test_a_review_opens_again_in_another_process(name, request):
    """What a new kernel does: nothing of the first one is there but the files."""
    of_points = name == "TrackReviewer"
    folder = request.getfixturevalue("small_trial" if of_points else "small_spider")
    source = request.getfixturevalue("paws" if of_points else "poses")
    (folder / "results").mkdir(exist_ok=True)
    file = folder / "results" / "tracks.nc"
    file.write_bytes(source.read_bytes())
    was = (review_paws if of_points else review_poses)(folder, file)
    command = [sys.executable, "-c", OPENED_AGAIN.format(name=name), str(folder)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert ran.returncode == 0, ran.stderr
    points, said = ran.stdout.split("\n", 1)
    np.testing.assert_allclose(json.loads(points), np.nan_to_num(was, nan=-1), atol=1e-9)
    assert "2 corrections in edits.jsonl" in said
