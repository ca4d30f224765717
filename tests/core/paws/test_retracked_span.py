"""The stretch that a correction touches: to the next correction, or to where tracks meet."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.tracker import track_maghsoudi2019
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.retracked_span import MET_FRAMES, Stretch, keep_rows, keep_untouched
from pawnb.schema import ORIGIN_CODE, make_tracks

EDITED, MEASURED = ORIGIN_CODE["edited"], ORIGIN_CODE["measured"]
SETTINGS = Maghsoudi2019Settings(scale=0.4, min_paw_area_px=300)
VARIABLES = ("position", "image_position", "origin", "image_origin", "image_confidence", "residual")


def run(scene, *, learn_at=None, **options):
    asked = {"frames": (0, scene.n_frames), **options}
    task = TrackingRequest(fps=250.0, unit="mm", rig=scene.rig, **asked)
    return track_maghsoudi2019(scene, scene.clicks(), task, settings=SETTINGS, learn_at=learn_at)


def spoil(tracks, point, rows, uv=(20.0, 20.0)):
    """Put a point somewhere wrong in some rows, as a tracker that lost it."""
    spoilt = tracks.copy(deep=True)
    p = spoilt["keypoint"].to_numpy().tolist().index(point)
    spoilt["image_position"].values[rows, :, :, p, 0] = uv
    spoilt["position"].values[rows, :, p, 0] = 5.0
    return spoilt


def put_right(tracks, scene, point, frame, views=(0, 1)):
    p = tracks["keypoint"].to_numpy().tolist().index(point)
    for v in views:
        tracks["image_position"].values[frame, v, :, p, 0] = scene.uv[frame, v, p]
        tracks["image_origin"].values[frame, v, p, 0] = EDITED


def error(tracks, scene, point):
    p = tracks["keypoint"].to_numpy().tolist().index(point)
    found = tracks["image_position"].values[..., p, 0]
    return np.linalg.norm(found - scene.uv[:, :, p], axis=-1).max(axis=1)


@pytest.fixture
def scene(make_scene):
    return make_scene(n_frames=60)


@pytest.mark.slow
def test_only_the_corrected_point_is_tracked_again_until_it_meets_the_old_track(scene):
    tracks = run(scene)
    wrong = spoil(spoil(tracks, "HR", slice(10, 25)), "FR", slice(30, 60))
    put_right(wrong, scene, "HR", 14)
    scene.asked.clear()
    again = run(scene, tracks=wrong, frames=(14, 60))
    # HR was right from row 25 on: ten rows on it, and the frame that finds that all rest
    assert scene.asked[0] == 14
    assert 24 + MET_FRAMES <= scene.asked[-1] <= 26 + MET_FRAMES
    hr = {"keypoint": "HR"}
    assert error(again, scene, "HR")[14:].max() < 7.0
    for name in VARIABLES:
        # the other point, even where it is wrong, and the rows before
        np.testing.assert_array_equal(
            again[name].sel(keypoint="FR"), wrong[name].sel(keypoint="FR"), err_msg=name
        )
        np.testing.assert_array_equal(again[name].sel(hr)[:14], wrong[name].sel(hr)[:14])
        np.testing.assert_array_equal(again[name].sel(hr)[40:], wrong[name].sel(hr)[40:])


@pytest.mark.slow
def test_the_stretch_ends_at_the_next_correction_of_the_same_point_only(scene):
    wrong = spoil(run(scene), "HR", slice(10, 60))
    put_right(wrong, scene, "HR", 14)
    put_right(wrong, scene, "FR", 20)
    put_right(wrong, scene, "HR", 30, views=(1,))
    scene.asked.clear()
    again = run(scene, tracks=wrong, frames=(14, 60))
    assert scene.asked == list(range(14, 31))
    assert error(again, scene, "HR")[14:30].max() < 7.0
    # what follows the next correction waits until one goes on from there
    assert error(again, scene, "HR")[31:].min() > 20.0
    assert (again["image_origin"][14].sel(keypoint="HR") == EDITED).all()
    assert (again["image_origin"][15:30].sel(keypoint="HR") == MEASURED).all()


@pytest.mark.slow
def test_corrections_in_frames_that_follow_each_other_are_one(scene):
    wrong = spoil(run(scene), "HR", slice(10, 60))
    for frame in (14, 15):
        put_right(wrong, scene, "HR", frame)
    again = run(scene, tracks=wrong, frames=(14, 60))
    assert error(again, scene, "HR")[14:].max() < 7.0


@pytest.mark.slow
def test_the_initial_colour_is_that_of_the_start_unless_it_is_learnt_anew(make_scene):
    """From frame 12 on the paw is blue, and as pink a disc lies near its way."""
    scene = make_scene(("FR",), n_frames=40)
    blue, pink = (60, 90, 220), (225, 130, 150)
    draw = scene._draw

    def repaint(i, view):
        scene.colours = [blue if i >= 12 else pink]
        pixels = draw(i, view)
        u, v = scene.uv[12, view, 0].round().astype(int) + np.array([0, 24])
        pixels[v - 5 : v + 5, u - 5 : u + 5] = pink
        return pixels

    scene._draw = repaint
    tracks = run(scene)
    put_right(tracks, scene, "FR", 14)
    kept = run(scene, tracks=tracks, frames=(14, 40))
    learnt = run(scene, tracks=tracks, frames=(14, 40), learn_at={"FR": 14})
    assert error(learnt, scene, "FR")[14:].max() < 7.0
    assert error(kept, scene, "FR")[14:].max() > 10.0


def flat(paths, by_hand=()):
    """Tracks of one view and one point from u, with hand-made rows."""
    tracks = make_tracks(range(len(paths)), ["FR", "HR"], fps=100, views=["cam1"])
    tracks["image_position"][:, 0, 0, :, 0] = np.asarray(paths, dtype=float)[:, None]
    tracks["image_position"][:, 0, 1, :, 0] = 5.0
    tracks["image_origin"][:] = MEASURED
    for row in by_hand:
        tracks["image_origin"][row, 0, 0, 0] = EDITED
    return tracks


def test_rows_are_taken_by_frame_and_name_from_tracks_in_another_order():
    old = make_tracks([3, 4, 5], ["HR", "FR"], fps=100, views=["cam2", "cam1"])
    old["image_position"].loc[{"view": "cam1", "keypoint": "FR"}] = 7.0
    old["image_confidence"].loc[{"view": "cam1", "keypoint": "FR"}] = 0.5
    old = old.assign_coords(time=old["time"] + 0.001)
    new = make_tracks([4, 5, 6], ["FR", "HL"], fps=100, views=["cam1", "cam3"])
    for name in ("image_position", "image_confidence"):
        new[name][:] = 1.0
    new["image_origin"][:] = MEASURED
    kept = keep_rows(old, new, np.array([[True, True], [False, False], [True, True]]))
    uv = kept["image_position"].isel(individual=0, image_space=0).transpose("time", "view", ...)
    # frame 6 is not among the old ones; of HL and cam3 these say nothing
    nothing = [[7.0, np.nan], [np.nan, np.nan]]
    np.testing.assert_array_equal(uv, [nothing, np.ones((2, 2)), np.ones((2, 2))])
    sure = kept["image_confidence"].isel(individual=0).transpose("time", "view", "keypoint")
    np.testing.assert_array_equal(sure[0], [[0.5, 0.0], [0.0, 0.0]])
    assert (kept["image_origin"].isel(time=1) == MEASURED).all()
    np.testing.assert_allclose(kept["time"], [0.041, 0.051, 0.06])


def test_other_methods_results_are_cut_to_the_stretch_as_well():
    """The new track is on the old one from row 20 on: kept to the tenth row there."""
    old = flat(np.where(np.arange(50) < 20, 100.0, 50.0), by_hand=[5])
    new = flat(np.full(50, 50.5))
    new["image_position"][:, :, :, 1] = 77.0
    cut = keep_untouched(old, new, 5, tolerance_px={"cam1": 1.0})
    u = cut["image_position"].to_numpy()[:, 0, 0, :, 0]
    expected = np.where(np.arange(50) < 5, 100.0, np.where(np.arange(50) < 30, 50.5, 50.0))
    np.testing.assert_array_equal(u[:, 0], expected)
    assert (u[:, 1] == 50.0).sum() + (u[:, 1] == 100.0).sum() == 50  # as in the old ones
    nowhere = keep_untouched(flat(np.zeros(9)), flat(np.ones(9)), 4, tolerance_px={"cam1": 9.0})
    np.testing.assert_array_equal(
        nowhere["image_position"].to_numpy()[:, 0, 0, 0, 0], np.repeat([0, 1], [4, 5])
    )


def test_meeting_needs_rows_in_succession_and_every_view():
    uv = np.zeros((40, 2, 1, 2))
    by_hand = np.zeros((40, 2, 1), dtype=bool)
    by_hand[0, 0, 0] = True
    stretch = Stretch(uv, by_hand, 0, tolerance_px=np.array([1.0, 1.0]))
    for row in range(30):
        stretch.enter(row)
        if stretch.is_over:
            break
        here = uv[row].copy()
        if row == 5:
            here[1] += 3.0  # one view is off once
        if row == 7:
            here[1] = np.nan
        stretch.leave(row, here)
    assert row == 8 + MET_FRAMES
    assert stretch.until.tolist() == [8 + MET_FRAMES]


@pytest.mark.parametrize(("back", "until"), [(60, 50), (32, 41)])
def test_decided_together_a_point_that_made_way_is_taken_anew_where_it_did(back, until):
    """HR sat on FR's paw in rows 20 to 30 and 45 to 59; FR, put right, is there now.

    Where FR is back on its old track in row 32, what HR does in rows 45 to 59 is not touched.
    """
    rows = np.arange(60)
    swapped = ((rows >= 20) & (rows <= 30)) | (rows >= 45)
    astray = np.where((rows > 5) & (rows < back), 500.0, 0.0)
    old, new = flat(astray, by_hand=[5]), flat(np.zeros(60))
    old["image_position"][:, 0, 0, 1, 0] = np.where(swapped, 0.0, 100.0)
    old["image_origin"][50, 0, 1, 0] = EDITED
    moved = np.full(60, 100.5)
    moved[10] = 300.0  # moved as well, but from where no corrected point is
    new["image_position"][:, 0, 0, 1, 0] = moved
    apart = keep_untouched(old, new.copy(deep=True), 5, tolerance_px={"cam1": 1.0})
    np.testing.assert_array_equal(
        apart["image_position"][:, 0, 0, 1, 0], old["image_position"][:, 0, 0, 1, 0]
    )
    both = keep_untouched(old, new, 5, tolerance_px={"cam1": 1.0}, joint=True)
    # ten rows about each swap, but not from where a person has placed HR
    fresh = (rows >= 10) & (rows < until)
    np.testing.assert_array_equal(
        both["image_position"][:, 0, 0, 1, 0],
        np.where(fresh, moved, old["image_position"][:, 0, 0, 1, 0]),
    )


def test_a_point_does_not_make_way_to_where_another_stays():
    """HR and HL were exchanged by hand; the tracker sees HR at HL's place, and FR passes by HR."""
    rows = np.arange(60)
    old = make_tracks(rows, ["FR", "HR", "HL"], fps=100, views=["cam1"])
    new = old.copy(deep=True)
    for tracks, places in ((old, (300.0, 100.0, 500.0)), (new, (301.0, 500.0, 500.0))):
        tracks["image_position"][:, 0, :, :, 0] = np.array(places)
        tracks["image_origin"][:] = MEASURED
    new["image_position"][21:24, 0, :, 0, 0] = 100.0
    old["image_origin"][5, 0, 0, 0] = EDITED
    both = keep_untouched(old, new, 5, tolerance_px={"cam1": 1.0}, joint=True)
    for point in ("HR", "HL"):
        own = {"keypoint": point}
        np.testing.assert_array_equal(
            both["image_position"].sel(own), old["image_position"].sel(own)
        )
