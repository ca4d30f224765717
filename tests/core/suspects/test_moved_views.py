"""Cameras that moved since they were calibrated, or are not in step, told by many points."""

import numpy as np
import pandas as pd
import pytest
from cage import read_cage

from pawnb.core import dlt
from pawnb.core.rig import Rig, load_rig
from pawnb.core.suspects.moved_views import LaggingView, MovedView, find_moved_views
from pawnb.io import authors2019
from pawnb.synthetic.camera import make_cameras
from pawnb.synthetic.scene import scene_settings
from pawnb.trial import load_trial

FRAMES, FPS = 120, 200.0


@pytest.fixture(scope="module")
def rig():
    """Four cameras of the rendered mouse."""
    cameras = make_cameras(scene_settings(changes={"scale": 0.5}))
    coefs = np.stack([camera.coefs for camera in cameras], axis=1)
    return Rig(tuple(f"cam{i + 1}" for i in range(4)), coefs)


def walking(rig, *, points=5, noise_px=0.5, clicked_px=1.0, early=0.0, view=0, seed=0, onward=0.0):
    """Where feet that go to and fro, mm onward a frame, are seen: (FRAMES, points, V, 2)."""
    rng = np.random.default_rng(seed)
    phase = np.arange(points) / points

    def places(at):
        x = 25.0 * np.sin(2 * np.pi * (at[:, None] / 40 + phase)) + onward * (at[:, None] - 60)
        z = 3.0 + 3.0 * np.cos(2 * np.pi * (at[:, None] / 40 + phase))
        y = np.broadcast_to(np.linspace(-15, 15, points), x.shape)
        return np.stack([x + np.linspace(-30, 30, points), y, z], axis=-1)

    at = np.arange(FRAMES, dtype=float)
    uv = rig.project(places(at))
    uv[:, :, view] = rig.project(places(at + early))[:, :, view]
    uv += noise_px * rng.standard_normal(uv.shape)
    return uv + clicked_px * rng.standard_normal(uv.shape[1:])


def found_in(uv, rig):
    return find_moved_views(uv, rig=rig, frames=np.arange(len(uv)), fps=FPS)


@pytest.mark.slow
def test_cameras_that_stand_where_they_were_calibrated_are_not_said(rig):
    """The same of many: 20 recordings by four cameras, and 20 by two."""
    for seed in range(20):
        assert found_in(walking(rig, seed=seed), rig) == []
        assert found_in(walking(rig, seed=seed)[:, :, :2], rig.subset(rig.names[:2])) == []


@pytest.mark.parametrize("view", range(4))
@pytest.mark.parametrize("offset", [(5.0, 0.0), (-3.0, 4.0), (0.0, 10.0)])
def test_a_view_that_lies_aside_is_named_with_its_px(rig, view, offset):
    uv = walking(rig, view=view)
    uv[:, :, view] += offset
    (moved,) = found_in(uv, rig)
    assert isinstance(moved, MovedView)
    assert moved.views == (rig.names[view],)
    assert moved.n_points == 5
    assert moved.offset_px == pytest.approx(np.hypot(*offset), abs=2.0)
    px = f"{moved.offset_px:.0f} px"
    assert moved.sentence.startswith(
        f"view {rig.names[view]} lies {px} from where the other views put all 5 points alike: it"
    )


def test_of_two_views_it_cannot_be_told_which_has_moved(rig):
    two = rig.subset(rig.names[:2])
    uv = walking(rig)[:, :, :2]
    uv[:, :, 1] += (0.0, 6.0)  # their epipolar lines are nearly level: both look from one side
    (moved,) = found_in(uv, two)
    assert moved.views == two.names
    assert "one of them has moved" in moved.sentence
    # points that are moved along their epipolar lines lie elsewhere in space, and nothing shows it
    ends = two.epipolar_line(two.names[0], uv[0, 0, 0], two.names[1], size=(1024, 350))
    along = ends[1] - ends[0]
    uv = walking(rig)[:, :, :2]
    uv[:, :, 1] += 6.0 * along / np.linalg.norm(along)
    assert found_in(uv, two) == []


def test_a_point_that_is_clicked_elsewhere_in_one_view_is_no_camera(rig):
    uv = walking(rig)
    uv[:, 2, 1] += (0.0, 25.0)
    assert found_in(uv, rig) == []


def test_points_of_one_side_are_enough_and_one_point_is_not(rig):
    uv = walking(rig, points=4)
    uv[:, :2, 2:] = np.nan  # the first two are seen by the cameras of one side, others by the rest
    uv[:, 2:, :2] = np.nan
    uv[:, :, 0] += (0.0, 12.0)
    (moved,) = found_in(uv, rig)
    assert moved.views == rig.names[:2]
    assert moved.n_points == 2
    uv[:, 1] = np.nan
    assert found_in(uv, rig) == []


@pytest.mark.parametrize("early", [0.5, -0.5])
def test_a_view_that_is_half_a_frame_before_or_after_the_others_is_said(rig, early):
    found = found_in(walking(rig, early=early, view=3), rig)
    (lagging,) = found
    assert isinstance(lagging, LaggingView)
    assert lagging.view == rig.names[3]
    assert lagging.lag_frames == pytest.approx(-early, abs=0.1)
    assert lagging.lag_ms == pytest.approx(-early / FPS * 1e3, abs=0.5)
    assert ("earlier" if early > 0 else "later") in lagging.sentence


@pytest.mark.parametrize("early", [0.5, -0.5])
def test_what_a_lag_puts_aside_in_an_animal_that_goes_on_is_no_moved_camera(rig, early):
    uv = walking(rig, early=early, view=1, onward=4.0)
    (lagging,) = found_in(uv, rig)
    assert isinstance(lagging, LaggingView)
    uv[:, :, 1] += (0.0, 8.0)
    moved, lagging = found_in(uv, rig)
    assert moved.views == (rig.names[1],)
    assert moved.offset_px == pytest.approx(8.0, abs=2.0)
    assert lagging.view == rig.names[1]


def test_what_cannot_be_told_is_not_said(rig):
    uv = walking(rig)
    assert found_in(np.full_like(uv, np.nan), rig) == []
    one = np.where(np.arange(4)[:, None] == 0, uv, np.nan)  # seen by one view only
    assert found_in(one, rig) == []
    assert found_in(uv[:1], rig) == []


# Real recordings. None was told to have a camera that is off, but the cage's first calibration,
# in which one camera is a copy of another (SOURCE.txt).


def of_table(table, rig):
    """Return image positions (n, P, V, 2) and frames of a table frame, view, point, u, v."""
    frames, points = np.unique(table["frame"]), list(dict.fromkeys(table["point"]))
    uv = np.full((len(frames), len(points), len(rig.names), 2), np.nan)
    for row in table.itertuples():
        at = np.searchsorted(frames, row.frame), points.index(row.point), rig.index(row.view)
        uv[at] = row.u, row.v
    return uv, frames


@pytest.mark.parametrize("clip", ["fly_ball_left", "mouse_wheel_two_views"])
@pytest.mark.parametrize("file", ["marks.csv", "start.csv"])
def test_real_clips_by_several_cameras_are_quiet(real_data, clip, file):
    folder = real_data("real-clips") / clip
    rig = load_rig(load_trial(folder))
    uv, frames = of_table(pd.read_csv(folder / file), rig)
    assert find_moved_views(uv, rig=rig, frames=frames, fps=FPS) == []
    uv[:, :, 0] += (0.0, 12.0) if clip == "fly_ball_left" else (12.0, 0.0)
    if file == "marks.csv":
        (moved,) = find_moved_views(uv, rig=rig, frames=frames, fps=FPS)
        assert rig.names[0] in moved.views


def test_the_cage_is_quiet_with_its_calibration_and_not_with_the_other(real_data):
    folder = real_data("mouse-4cam-cage")
    coefs, uv, _, _ = read_cage(folder)
    names = ("back", "mid", "side", "top")
    assert found_in(uv, Rig(names, coefs)) == []
    wrong = coefs.copy()
    wrong[:, 2] = coefs[:, 3]  # as in calibration.toml
    (moved,) = found_in(uv, Rig(names, wrong))
    assert moved.views == ("side",)
    assert moved.offset_px > 20.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["1864_1x", "1894_1.5x"])
def test_a_spider_by_four_cameras_is_quiet_until_one_is_moved(real_data, name):
    folder = real_data("salticid-4cam-dlt")
    coefs = np.loadtxt(folder / f"{name}_DLTcoefs.csv", delimiter=",")
    table = pd.read_csv(folder / f"{name}_xypts.csv")
    uv = table.iloc[:, 1:].to_numpy(float).reshape(len(table), -1, 4, 2)
    rig, frames = Rig(("cam1", "cam2", "cam3", "cam4"), coefs), table.iloc[:, 0].to_numpy(int)
    assert find_moved_views(uv, rig=rig, frames=frames, fps=FPS) == []
    for view in range(4):
        off = uv.copy()
        off[:, :, view] += (3.0, -4.0)
        (moved,) = find_moved_views(off, rig=rig, frames=frames, fps=FPS)
        assert rig.names[view] in moved.views


@pytest.mark.slow
def test_a_rat_by_two_cameras_a_side_is_quiet_until_one_is_moved(real_data):
    folder = real_data("rat-4cam-tracks")
    for stamp in authors2019.list_authors_trials(folder):
        (file,) = folder.glob(f"DLT*{stamp}.csv")
        tracks = authors2019.read_authors_trial(folder, stamp, fps=250.0).isel(individual=0)
        rig = Rig(authors2019.VIEWS, authors2019.read_authors_dlt(file))
        uv = tracks["image_position"].transpose("time", "keypoint", "view", "image_space")
        frames = tracks["frame"].to_numpy()
        assert find_moved_views(uv.to_numpy(), rig=rig, frames=frames, fps=250.0) == []
        off = uv.to_numpy().copy()
        off[:, :, 2] += (0.0, 6.0)
        (moved,) = find_moved_views(off, rig=rig, frames=frames, fps=250.0)
        assert moved.views == rig.names[2:]


def test_corners_of_a_board_by_two_cameras_are_quiet(real_data):
    folder = real_data("stereomorph-dlt")
    rig = Rig(("v1", "v2"), np.loadtxt(folder / "cal_coeffs.txt"))
    uv = np.stack([
        np.stack([np.loadtxt(folder / f"test_cal_a{a}_v{v}.txt") for v in (1, 2)], axis=1)
        for a in range(1, 12)
    ])  # fmt: skip
    assert dlt.triangulate(rig.coefs, uv).residual_px.max() < 5.0
    assert find_moved_views(uv, rig=rig, frames=np.arange(0, 110, 10), fps=FPS) == []
