"""``pawnb.track`` on a jointed animal: what it writes, what it refuses."""

from __future__ import annotations

import contextlib
import dataclasses
import json
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.pose.as_tracks import animal_of
from pawnb.core.pose.pose_table import pose_names
from pawnb.core.video import open_views
from pawnb.errors import InputError, InputWarning
from pawnb.io.native import read_tracks
from pawnb.io.pose import read_pose
from pawnb.schema import ORIGIN_CODE, SUSPECTS_COLUMNS, TRACKS_COLUMNS
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial
from pawnb.workflow.provenance.manifest import run_alone
from pawnb.workflow.provenance.results import RESULT_FILES
from pawnb.workflow.reviewing.quality import assess_quality
from pawnb.workflow.start.propose_pose import trial_background
from pawnb.workflow.tracking.track import retrack, track

pytestmark = pytest.mark.slow  # scenes are rendered and tracked


@pytest.fixture(scope="module")
def tracked(rendered_spider, tmp_path_factory):
    out = tmp_path_factory.mktemp("results")
    tracks = track(rendered_spider, out=out, command=["pawnb", "track", str(rendered_spider)])
    return tracks, out


def test_files_and_columns_are_those_of_the_contract(tracked):
    tracks, out = tracked
    assert sorted(path.name for path in out.iterdir()) == sorted([*RESULT_FILES, "pose.csv"])
    table = pd.read_csv(out / "tracks.csv")
    assert tuple(table.columns) == TRACKS_COLUMNS
    assert {"body", "L1", "R4.MT"} < set(table["point"])
    assert tuple(pd.read_csv(out / "suspects.csv").columns) == SUSPECTS_COLUMNS
    pose = read_pose(out / "pose.csv", names=pose_names(animal_of(tracks)))
    assert pose["frame"].tolist() == list(range(10, 24))
    assert read_tracks(out / "tracks.nc").identical(tracks)


def test_poses_are_those_of_the_truth(tracked, rendered_spider):
    """A still animal of 145 px leg span: body within 1 px, tips within 3 px of the truth."""
    tracks, out = tracked
    truth = pd.read_csv(rendered_spider / "truth" / "pose.csv").set_index("frame")
    pose = pd.read_csv(out / "pose.csv").set_index("frame")
    off = np.hypot(pose["x"] - truth["x"], pose["y"] - truth["y"])
    assert len(off) == 14
    assert off.max() < 1.0
    tips = ["L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4"]
    points = pd.read_csv(rendered_spider / "truth" / "tracks.csv")
    found = pd.read_csv(out / "tracks.csv")
    both = points[points["point"].isin(tips)].merge(found, on=["frame", "point"])
    assert len(both) == 14 * 8
    assert np.median(np.hypot(both["u_x"] - both["u_y"], both["v_x"] - both["v_y"])) < 3.0
    # 4.84 px a mm at full size; u is to the right, and so is x
    position = tracks["position"].sel(keypoint="body", space="x").to_numpy()[0, 0]
    assert tracks.attrs["units"] == "mm"
    assert position * 4.84 * 0.3 == pytest.approx(pose["x"].iloc[0], rel=1e-3)


def test_the_record_names_everything_that_shaped_the_result(tracked, rendered_spider):
    _, out = tracked
    (step,) = json.loads((out / "provenance.json").read_text())["steps"]
    assert step["command"] == f"pawnb track {rendered_spider.name}"
    assert sorted(step["inputs"]) == ["spider.avi", "start_pose.csv"]
    assert step["method"] == "pawnb"
    assert step["complete"] is True
    assert step["frames"] == [0, 24]
    assert step["background"] == "frames 0 to 9"
    assert step["settings"]["choose_path"] is True
    assert step["start"][0]["frame"] == 10


def test_a_pose_handed_over_stands_in_the_record(rendered_spider):
    start = pd.read_csv(rendered_spider / "start_pose.csv").assign(frame=12)
    tracks = track(rendered_spider, start=start, frames=(11, 14), settings={"candidates": "1"})
    assert tracks["frame"].to_numpy().tolist() == [11, 12, 13]
    (step,) = json.loads(tracks.attrs["provenance"])["steps"]
    assert sorted(step["inputs"]) == ["spider.avi"]
    assert step["settings"]["candidates"] == 1


def test_the_published_method_follows_the_frames_that_show_the_animal(rendered_spider, tmp_path):
    tracks = track(rendered_spider, method="paper", out=tmp_path)
    assert tracks["frame"].to_numpy().tolist() == list(range(10, 24))
    (step,) = json.loads((tmp_path / "provenance.json").read_text())["steps"]
    assert step["method"] == "paper"
    assert step["frames"] == [10, 24]
    truth = pd.read_csv(rendered_spider / "truth" / "pose.csv")
    pose = pd.read_csv(tmp_path / "pose.csv")
    assert np.hypot(pose["x"] - truth["x"], pose["y"] - truth["y"]).max() < 3.0


def test_poses_in_a_film_that_stands_still_are_not_measured(tmp_path):
    """A walking spider whose film shows one picture for 12 frames was tracked as *good*."""
    render_spider_trial(tmp_path, frames=110, scale=0.3, seed=1)
    here = int(pd.read_csv(tmp_path / "start_pose.csv")["frame"].iloc[0])
    first, stop = here + 10, here + 22
    with open_views(load_trial(tmp_path)) as views:
        pictures = [views.frame(i)["top"].image() for i in range(110)]
    (tmp_path / "frozen").mkdir()
    for i in range(110):
        shown = pictures[first - 1] if first <= i < stop else pictures[i]
        cv2.imwrite(str(tmp_path / "frozen" / f"{i:03d}.png"), shown)
    change(tmp_path, "trial.toml", 'video = "spider.avi"', 'video = "frozen"')
    trial, span = load_trial(tmp_path), (here, here + 30)
    with pytest.warns(InputWarning, match=f"stands still in frames {first} to {stop - 1}"):
        tracks = track(trial, frames=span, settings={"choose_path": False})
    held = np.isin(tracks["frame"], range(first, stop))
    seen = ORIGIN_CODE["measured"]
    assert (tracks["origin"].to_numpy()[held] == ORIGIN_CODE["predicted"]).all()
    assert (tracks["confidence"].to_numpy()[held] == 0.0).all()
    assert (tracks["origin"].sel(keypoint="body").to_numpy()[~held] == seen).all()
    quality = assess_quality(tracks)
    assert quality.verdict == "look"
    # nothing is right in 12 of 30 frames
    assert all(point.expected_right <= 18 / 30 for point in quality.points)
    # to track again measures nothing there either
    again = retrack(trial, tracks, here + 8, progress=lambda _done, _total: None)
    assert (again["origin"].to_numpy()[held] == ORIGIN_CODE["predicted"]).all()


def test_stopping_keeps_what_is_done_and_says_so(rendered_spider, tmp_path):
    asked = []

    def stop():
        asked.append(True)
        return len(asked) > 12

    tracks = track(rendered_spider, out=tmp_path, stop=stop)
    assert 0 < tracks.sizes["time"] <= 14
    (step,) = json.loads((tmp_path / "provenance.json").read_text())["steps"]
    assert step["complete"] is False


def change(folder, file, old, new):
    path = folder / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('species = "dolomedes"', 'species = "dolomede"', "did you mean 'dolomedes'"),
        ('species = "dolomedes"', "", "names no species"),
        ("[start]", "[tracking]\nblur = 1\n[start]", "unknown name 'blur'"),
        ("fps = 125.0", "fps = 125.0\nframes = [0, 9]", "start pose is of frame 10, outside"),
        ("fps = 125.0", "fps = 125.0\nframes = [0, 90]", "has no frame 89; it has 24 frames"),
        ('pose = "start_pose.csv"', 'pose = "pose.csv"', "pose.csv: no such file"),
    ],
)
def test_faults_of_the_trial_are_named(small_spider, old, new, match):
    change(small_spider, "trial.toml", old, new)
    with pytest.raises(InputError, match=match):
        track(small_spider)


def test_a_start_pose_off_the_picture_and_a_missing_one_are_refused(small_spider):
    start = pd.read_csv(small_spider / "start_pose.csv")
    with pytest.raises(InputError, match="outside the picture of 384 x 307 px"):
        track(small_spider, start=start.assign(x=900.0))
    with pytest.raises(InputError, match="unknown method 'slic-2d'; expected pawnb"):
        track(small_spider, method="slic-2d")
    (small_spider / "start_pose.csv").unlink()
    change(small_spider, "trial.toml", 'pose = "start_pose.csv"', "")
    with pytest.raises(InputError, match="has no start pose"):
        track(small_spider)


def test_a_recording_without_empty_frames_is_doubted(small_spider):
    # only the frames in which the spider is there, and it holds still: nothing tells it apart
    (small_spider / "pictures").mkdir()
    with open_views(load_trial(small_spider)) as views:
        for i in range(10, 24):
            picture = views.frame(i)["top"].image()
            cv2.imwrite(str(small_spider / "pictures" / f"{i:03d}.png"), picture)
    change(small_spider, "trial.toml", "background_frames = [\n    0,\n    10,\n]", "")
    change(small_spider, "trial.toml", 'video = "spider.avi"', 'video = "pictures"')
    trial = load_trial(small_spider)
    with open_views(trial) as views, pytest.warns(InputWarning, match="background_frames"):
        trial_background(trial, views)


@pytest.mark.slow
def test_a_scale_that_is_off_by_ten_is_said_in_tracking(small_spider):
    """Lengths and speeds were ten times too small, and the verdict *good*."""
    change(small_spider, "trial.toml", "px_per_unit = 1.452", "px_per_unit = 14.52")
    with pytest.warns(InputWarning, match="0.085 times as large as its species file says"):
        track(small_spider, frames=(10, 12), settings={"choose_path": False})


def test_an_offset_is_refused(small_spider):
    change(small_spider, "trial.toml", "background_frames = [\n    0,\n    10,\n]", "offset = 10")
    with pytest.raises(InputError, match="offset is 10; a pose is tracked in the first view"):
        track(load_trial(small_spider))


@pytest.mark.parametrize("method", ["pawnb", "paper"])
def test_a_second_animal_and_the_edge_are_said(small_spider, method):
    """The spider twice in the picture, side by side; and a view that cuts two of its legs off."""
    still = {"pawnb": {"choose_path": False}, "paper": {"combinations": 2, "max_rounds": 1}}
    run = {"method": method, "settings": still[method], "frames": (10, 12)}
    trial = load_trial(small_spider)
    with open_views(trial) as views:
        pictures = [views.frame(i)["top"].image().astype(int) for i in range(13)]
    folder = small_spider / "twice"
    folder.mkdir()
    for i, picture in enumerate(pictures):
        beside = np.minimum(np.roll(picture - pictures[0], 130, axis=1), 0) if i >= 10 else 0
        cv2.imwrite(str(folder / f"{i:03d}.png"), np.clip(picture + beside, 0, 255))
    twice = dataclasses.replace(trial.views[0], video="twice")
    with pytest.warns(InputWarning, match="perhaps a second animal; crop the view to one"):
        track(dataclasses.replace(trial, views=(twice,)), **run)
    tips = pd.read_csv(small_spider / "truth" / "tracks.csv").query("frame == 10")
    tips = tips[tips["point"].str.len() == 2]["u"]
    cut = int(np.sort(tips)[1]) + 2
    width, height = pictures[0].shape[1], pictures[0].shape[0]
    crop = dataclasses.replace(trial.views[0], crop=(cut, 0, width, height))
    start = pd.read_csv(small_spider / "start_pose.csv").assign(x=lambda table: table["x"] - cut)
    # the method of the thesis cannot go on without a leg, and says so too
    refused = pytest.raises(InputError, match="L1 reaches outside the picture")
    with (
        pytest.warns(InputWarning, match="touches the edge of the picture in frame 10"),
        refused if method == "paper" else contextlib.nullcontext(),
    ):
        track(dataclasses.replace(trial, views=(crop,)), start=start, **run)


@pytest.mark.parametrize("kind", ["pose", "paws"])
def test_a_second_run_is_refused_at_once(kind, rendered_spider, rendered_trial, tmp_path):
    """Two runs would write the same candidates and delete each other's files."""
    with ThreadPoolExecutor(1) as other:
        first = contextlib.ExitStack()
        other.submit(first.enter_context, run_alone(tmp_path)).result()
        with pytest.raises(InputError, match=r"is writing here; wait until it has ended"):
            track(rendered_spider if kind == "pose" else rendered_trial, out=tmp_path)
        other.submit(first.close).result()
    assert list(tmp_path.iterdir()) == []
