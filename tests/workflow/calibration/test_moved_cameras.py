"""What is said of cameras that have moved: after tracking, of others' tracks, and of clicks."""

import json
import warnings

import numpy as np
import pandas as pd
import pytest

from pawnb.core import dlt
from pawnb.core.rig import Rig, load_rig
from pawnb.errors import InputWarning
from pawnb.io.start import read_start
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.synthetic.camera import make_cameras
from pawnb.synthetic.scene import scene_settings
from pawnb.trial import load_trial
from pawnb.workflow.calibration.moved_cameras import tell_moved_clicks, tell_moved_views
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.conversion.file_pixels import triangulate_foreign
from pawnb.workflow.provenance.results import tracking_notes
from pawnb.workflow.reviewing.quality import assess_quality
from pawnb.workflow.tracking.track import track

POINTS = ("FR", "HR", "FL", "HL", "nose")


@pytest.fixture(scope="module")
def rig():
    """Four cameras of the rendered mouse."""
    cameras = make_cameras(scene_settings(changes={"scale": 0.5}))
    return Rig(("cam1", "cam2", "cam3", "cam4"), np.stack([c.coefs for c in cameras], axis=1))


def seen_tracks(rig, *, moved=(0.0, 0.0), n=60):
    """Tracks of feet that go to and fro; pictures of the second camera are moved, px."""
    rng = np.random.default_rng(1)
    at = np.arange(n)[:, None]
    x = 20.0 * np.sin(2 * np.pi * (at / 30 + np.arange(5) / 5)) + np.linspace(-30, 30, 5)
    xyz = np.stack([x, np.broadcast_to(np.linspace(-15, 15, 5), x.shape), 0 * x], axis=-1)
    uv = rig.project(xyz) + rng.standard_normal((n, 5, 4, 2))
    uv[:, :, 1] += moved
    tracks = make_tracks(range(n), POINTS, fps=100.0, views=rig.names)
    tracks["image_position"][..., 0] = uv.transpose(0, 2, 3, 1)
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"][:] = 1.0
    return tracks


def move_camera(folder, name, by):
    """Write the DLT of a camera whose picture lies so many px elsewhere."""
    trial = load_trial(folder)
    path = trial.path(trial.calibration.dlt)
    coefs = np.loadtxt(path, delimiter=",")
    at = [view.name for view in trial.views].index(name)
    H = np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]], [0.0, 0.0, 1.0]])
    coefs[:, at] = dlt.transform_image(coefs[:, at], H)
    np.savetxt(path, coefs, delimiter=",", fmt="%.17g")


def test_tracks_of_others_are_told_of_with_their_file(rig):
    with pytest.warns(InputWarning, match="^walk.csv: view cam2 lies 5 px from where the other"):
        tracks = triangulate_foreign(seen_tracks(rig, moved=(0.0, 5.0)), rig, where="walk.csv")
    assert any("view cam2 lies 5 px" in reason for reason in assess_quality(tracks).reasons)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        triangulate_foreign(seen_tracks(rig), rig, where="walk.csv")


def test_labels_that_are_not_sure_or_not_seen_do_not_count(rig):
    tracks = seen_tracks(rig)
    astray = {"view": 1, "time": slice(0, 40)}
    tracks["image_position"][{**astray}] += 30.0
    tracks["image_confidence"][{**astray, "keypoint": slice(0, 3)}] = 0.2
    tracks["image_origin"][{**astray, "keypoint": slice(3, 5)}] = ORIGIN_CODE["reprojected"]
    assert tell_moved_views(tracks, rig) is tracks


def test_points_digitised_in_a_few_frames_count_though_none_says_how_sure_it_is(rig):
    """As DLTdv has them: frames between are empty, and there is no confidence."""
    few = seen_tracks(rig, moved=(0.0, 5.0), n=8)
    tracks = make_tracks(range(3000), POINTS, fps=100.0, views=rig.names)
    at = 7 + 400 * np.arange(7)
    tracks["image_position"][at] = few["image_position"][:7].to_numpy()
    tracks["image_origin"][at] = ORIGIN_CODE["measured"]
    tracks["image_confidence"][at] = np.nan
    with pytest.warns(InputWarning, match="^view cam2 lies 5 px"):
        tell_moved_views(tracks, rig)


def test_what_was_found_in_a_picture_counts_where_positions_are_projections(rig):
    """A tracker that puts points in space first: labels are where its place in space is shown."""
    tracks = seen_tracks(rig, moved=(0.0, 5.0))
    seen = tracks["image_position"].copy()
    uv = seen[..., 0].transpose("time", "keypoint", "view", "image_space").to_numpy()
    shown = rig.project(rig.triangulate(uv, refine=True).xyz)
    tracks["image_position"][..., 0] = shown.transpose(0, 2, 3, 1)
    assert tell_moved_views(tracks, rig) is tracks
    tracks["image_offset"] = seen - tracks["image_position"]
    with pytest.warns(InputWarning, match="^view cam2 lies 5 px"):
        tell_moved_views(tracks, rig)


def test_tracks_without_views_or_a_rig_say_nothing(rig):
    tracks = seen_tracks(rig, moved=(0.0, 5.0))
    assert tell_moved_views(tracks, None) is tracks
    without = tracks.drop_dims(["view", "image_space"])
    assert tell_moved_views(without, rig) is without
    assert tell_moved_views(tracks.sel(view=["cam2"]), rig).attrs == tracks.attrs


def test_clicks_say_it_before_anything_is_tracked(rig):
    uv = seen_tracks(rig, moved=(0.0, 8.0)).isel(time=0, individual=0)["image_position"]
    clicks = pd.DataFrame(
        [
            (0, view, point, *uv.sel(view=view, keypoint=point).to_numpy())
            for view in rig.names for point in POINTS
        ],
        columns=["frame", "view", "point", "u", "v"],
    )  # fmt: skip
    (said,) = tell_moved_clicks(clicks, rig)
    assert said.startswith("start clicks: view cam2 lies 8 px from where the other views put all 5")


@pytest.mark.slow
def test_a_camera_that_has_moved_is_said_after_tracking_and_in_its_results(small_trial):
    """Its pictures lie a paw's length off; with the right calibration nothing is said."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        tracks = track(small_trial)
    assert not any("calibrate it again" in str(one.message) for one in told)
    clicks = read_start(small_trial / "start.csv", load_trial(small_trial))
    assert tell_moved_clicks(clicks, load_rig(load_trial(small_trial))) == []
    move_camera(small_trial, "cam2", (3.0, 8.0))
    with pytest.warns(InputWarning) as told:
        tracks = track(small_trial, out=small_trial / "results")
    said = [str(one.message) for one in told if "calibrate it again" in str(one.message)]
    assert said
    assert all("cam2" in text for text in said)
    assert any("cam2" in note.what for note in tracking_notes(tracks))
    quality = json.loads((small_trial / "results" / "quality.json").read_text())
    assert any("cam2" in reason for reason in quality["reasons"])
    doubts = check_trial(small_trial).doubts
    assert any("calibrate it again" in one and "cam2" in one for one in doubts)
