"""The whole tracker on a small scene of discs with known paths."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.layout import make_layout, read_start
from pawnb.core.paws.maghsoudi2019.reacquisition import find_hidden
from pawnb.core.paws.maghsoudi2019.restart import prepare_again
from pawnb.core.paws.maghsoudi2019.run import Run
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.maghsoudi2019.tracker import track_maghsoudi2019
from pawnb.core.paws.request import TrackingRequest
from pawnb.errors import CalibrationError, InputError
from pawnb.schema import ORIGIN_CODE, check_tracks

# sub-images of 56 x 32 px; the discs cover 113 px
SETTINGS = Maghsoudi2019Settings(scale=0.4, min_paw_area_px=300)
MISSING, MEASURED, PREDICTED, EDITED = (
    ORIGIN_CODE[name] for name in ("missing", "measured", "predicted", "edited")
)


def track(scene, *, start=None, settings=SETTINGS, method="paper", learn_at=None, **options):
    asked = {"rig": scene.rig, "frames": (0, scene.n_frames), **options}
    task = TrackingRequest(fps=250.0, unit="mm", **asked)
    clicks = scene.clicks() if start is None else start
    return track_maghsoudi2019(
        scene, clicks, task, settings=settings, method=method, learn_at=learn_at
    )


def layout_of(scene, clicks, *, settings=SETTINGS):
    task = TrackingRequest(frames=(0, scene.n_frames), fps=250.0, rig=scene.rig)
    return make_layout(scene, clicks, task, settings=settings)


def image_error(tracks, scene):
    """Distance from the truth, (n_frames, V, P), over the rows of the tracks."""
    found = tracks["image_position"].isel(individual=0).to_numpy()  # time, view, uv, point
    true = scene.uv[tracks["frame"].to_numpy()]
    return np.linalg.norm(np.swapaxes(found, 2, 3) - true, axis=-1)


def space_error(tracks, scene):
    found = np.swapaxes(tracks["position"].isel(individual=0).to_numpy(), 1, 2)
    return np.linalg.norm(found - scene.xyz[tracks["frame"].to_numpy()], axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("grey", [False, True])
@pytest.mark.parametrize("affine", [False, True])
def test_two_views_follow_every_point_in_colour_and_grey(make_scene, grey, affine):
    scene = make_scene(grey=grey, affine=affine)
    tracks = check_tracks(track(scene))
    # discs of 6 px radius: the middle of a superpixel on the disc is about within it
    assert image_error(tracks, scene).max() < 7.0
    # 2 px are a millimetre; depth from rays 40 degrees apart is a few times worse
    assert np.median(space_error(tracks, scene)) < 2.0
    assert (tracks["image_origin"][0] == EDITED).all()
    assert (tracks["image_origin"][1:] == MEASURED).all()
    assert (tracks["origin"][0] == EDITED).all()
    assert (tracks["origin"][1:] == MEASURED).all()
    assert tracks["residual"].max() < 7.0
    assert tracks["image_confidence"].min() > 0.5
    assert tracks["image_confidence"][1:].max() <= 1.0
    np.testing.assert_allclose(tracks["confidence"], tracks["image_confidence"].mean("view"))
    assert tracks.attrs["units"] == "mm"
    np.testing.assert_allclose(tracks["time"], np.arange(scene.n_frames) / 250.0)


@pytest.mark.slow
def test_three_views_and_any_names(make_scene):
    scene = make_scene(("nose", "left ear", "X7"), angles=(-35, 0, 35))
    tracks = track(scene)
    assert tracks["keypoint"].to_numpy().tolist() == ["nose", "left ear", "X7"]
    assert tracks["view"].to_numpy().tolist() == ["cam1", "cam2", "cam3"]
    assert image_error(tracks, scene).max() < 7.0
    assert np.median(space_error(tracks, scene)) < 1.5


def test_one_view_without_calibration(make_scene):
    scene = make_scene(angles=(10,))
    tracks = track(scene, rig=None)
    assert image_error(tracks, scene).max() < 7.0
    assert tracks["space"].to_numpy().tolist() == ["x", "y"]
    assert tracks.attrs["units"] == "px"
    np.testing.assert_array_equal(tracks["position"], tracks["image_position"].isel(view=0))
    np.testing.assert_array_equal(tracks["origin"], tracks["image_origin"].isel(view=0))
    assert np.isnan(tracks["residual"]).all()


def test_without_calibration_the_position_is_of_one_view_only(make_scene):
    scene = make_scene()
    tracks = track(scene, rig=None, start=scene.clicks(leave_out=[("cam1", "HR")]))
    first, second = (tracks["image_position"].isel(view=v) for v in (0, 1))
    assert np.isnan(first.sel(keypoint="HR")).all()
    np.testing.assert_array_equal(tracks["position"].sel(keypoint="HR"), second.sel(keypoint="HR"))
    np.testing.assert_array_equal(tracks["position"].sel(keypoint="FR"), first.sel(keypoint="FR"))


@pytest.mark.slow
def test_each_view_tracks_its_own_points(make_scene):
    scene = make_scene(("FR", "HR", "FL", "HL"), angles=(-20, 20, -10, 10))
    own = {"cam1": ("FR", "HR"), "cam2": ("FR", "HR"), "cam3": ("FL", "HL"), "cam4": ("FL", "HL")}
    clicks = scene.clicks()
    clicks = clicks[[p in own[v] for v, p in zip(clicks["view"], clicks["point"], strict=True)]]
    tracks = track(scene, start=clicks, points_by_view=own)
    found = np.isfinite(tracks["image_position"].sel(image_space="u").isel(individual=0))
    for name, points in own.items():
        assert found.sel(view=name).all("time").to_numpy().tolist() == [
            p in points for p in tracks["keypoint"].to_numpy()
        ]
    assert np.median(space_error(tracks, scene)) < 3.0


def test_a_point_of_one_calibrated_view_is_tracked_there_and_has_no_place_in_space(make_scene):
    scene = make_scene()
    own = {"cam1": ("FR", "HR"), "cam2": ("FR",)}
    clicks = scene.clicks(leave_out=[("cam2", "HR")])
    tracks = track(scene, start=clicks, points_by_view=own)
    assert image_error(tracks, scene)[:, 0, 1].max() < 7.0
    assert np.isnan(tracks["position"].sel(keypoint="HR")).all()
    assert (tracks["origin"].sel(keypoint="HR") == MISSING).all()


@pytest.mark.slow
def test_calibration_carries_a_point_past_the_edge_of_one_view(make_scene):
    """FR leaves cam1 on the right and never comes back; cam2, from behind, keeps it."""
    scene = make_scene(("HR", "FR"), n_frames=50, speed=1.6, angles=(10, -60))
    outside = scene.uv[:, :, 1, 0] > 319.5
    assert outside[-10:].all(axis=0).tolist() == [True, False]
    tracks = track(scene)
    origin = tracks["image_origin"].sel(keypoint="FR").isel(individual=0).to_numpy()
    alone = (origin[:, 0] == MISSING) & (origin[:, 1] == MEASURED)
    assert alone.sum() >= 5
    # one view does not measure a position in space; the filter follows its line of sight
    fr = tracks.sel(keypoint="FR").isel(individual=0)
    assert (fr["origin"][alone] == PREDICTED).all()
    assert fr["confidence"][alone].max() == 0
    assert np.isnan(fr["residual"][alone]).all()
    assert image_error(tracks, scene)[alone, 1, 1].max() < 7.0
    assert np.isfinite(space_error(tracks, scene)[alone, 1]).all()


@pytest.mark.slow
def test_point_hidden_at_the_start_is_found_where_two_views_have_it(make_scene):
    scene = make_scene(angles=(-30, 0, 30))
    scene.hidden = {(i, "cam3", "HR") for i in range(8)}
    start = scene.clicks(leave_out=[("cam3", "HR")])
    tracks = track(scene, start=start)
    error = image_error(tracks, scene)[:, 2, 1]
    assert np.isnan(error[:8]).all()
    assert error[8:].max() < 7.0
    waiting = track(scene, start=start, settings=dataclasses.replace(SETTINGS, hidden="wait"))
    assert np.isnan(image_error(waiting, scene)[:, 2, 1]).all()


def test_point_seen_by_one_view_is_found_along_its_line_of_sight(make_scene):
    scene = make_scene(("FR", "HR", "HL"))
    scene.hidden = {(i, "cam2", "HR") for i in range(6)}
    tracks = track(scene, start=scene.clicks(leave_out=[("cam2", "HR")]))
    error = image_error(tracks, scene)[:, 1, 1]
    assert np.isnan(error[:6]).all()
    assert error[8:].max() < 7.0
    assert np.isnan(tracks["position"].sel(keypoint="HR")[:6]).all()
    assert np.median(space_error(tracks, scene)[8:, 1]) < 3.0


@pytest.mark.parametrize(("jump", "expected"), [(1, True), (12, False)])
def test_second_start_frame_gives_a_velocity_unless_it_is_a_jump(make_scene, jump, expected):
    """1.6 px a frame is a velocity; twelve times that, beyond half a half window, is not."""
    scene = make_scene()
    clicks = scene.clicks()
    layout = layout_of(scene, clicks)
    run = Run(layout)
    for i, frame in enumerate((0, jump)):
        placed = read_start(scene.clicks(frame), layout, (0, 25))[frame]
        run.step(scene.frame(frame), placed)
        np.testing.assert_allclose(run.space.position, scene.xyz[frame], atol=1e-6)
        if i == 0:
            assert not run.space.velocity.any()
    moved = scene.xyz[jump] - scene.xyz[0] if expected else np.zeros((2, 3))
    np.testing.assert_allclose(run.space.velocity, moved, atol=1e-6)
    np.testing.assert_allclose(
        run.image.velocity, np.diff(scene.uv[[0, jump]], axis=0)[0] if expected else 0, atol=1e-6
    )


def test_filters_are_taken_over_the_rows_before_a_corrected_frame(make_scene):
    scene = make_scene()
    clicks = scene.clicks()
    layout = layout_of(scene, clicks)
    first, second = Run(layout), Run(layout)
    for i in range(12):
        first.step(scene.frame(i), read_start(clicks, layout, (0, 25))[0] if i == 0 else [])
    prepare_again(second, scene, clicks.iloc[:0], tracks=track(scene), first=12)
    for one, other in ((first.space, second.space), (first.image, second.image)):
        np.testing.assert_allclose(other.mean, one.mean, atol=1e-6)
        np.testing.assert_allclose(other.covariance, one.covariance, atol=1e-6)


@pytest.mark.parametrize(
    ("reach_px", "other_known", "found"), [(60, False, True), (60, True, False), (20, False, False)]
)
def test_a_hidden_point_is_not_taken_for_its_neighbour(make_scene, reach_px, other_known, found):
    """HR is absent in cam3; FR, of the same colour, is drawn 15 px beside its place."""
    scene = make_scene(("HR", "FR"), angles=(-30, 0, 30))
    scene.uv[0, 2, 1] = scene.uv[0, 2, 0] + [15.0, 0.0]
    scene.hidden = {(0, "cam3", "HR")}
    settings = dataclasses.replace(SETTINGS, hidden_distance_px=reach_px)
    layout = layout_of(scene, scene.clicks(), settings=settings)
    run, pictures = Run(layout), scene.frame(0)
    run.learn(pictures, read_start(scene.clicks(), layout, (0, 1))[0])
    uv = scene.uv[0].copy()
    uv[2, 0] = np.nan
    if not other_known:
        uv[2, 1] = np.nan
    answer = find_hidden(layout, pictures, (2, 0), looks=[run.initial[0, 0]], uv=uv)
    assert (answer is not None) is found
    if answer is not None:
        superpixels, number, likeness = answer
        assert np.linalg.norm(superpixels.uv[number] - scene.uv[0, 2, 1]) < 7.0
        assert 0.9 < likeness <= 1.0


def test_second_start_frame_is_followed(make_scene):
    """At 13 px a frame the first prediction from one click alone is far off."""
    scene = make_scene(("FR",), n_frames=12, speed=6.5)
    assert np.abs(np.diff(scene.uv[:, :, 0, 0], axis=0)).max() > 11
    wide = dataclasses.replace(SETTINGS, window_u_px=80.0)
    tracks = track(scene, start=pd.concat([scene.clicks(0), scene.clicks(1)]), settings=wide)
    assert image_error(tracks, scene).max() < 7.0
    assert (tracks["image_origin"][:2] == EDITED).all()
    assert not (tracks["image_origin"][2:] == EDITED).any()


@pytest.mark.slow
def test_retracking_keeps_what_is_before_and_resets_what_follows(make_scene):
    scene = make_scene(n_frames=30)
    tracks = track(scene)
    broken = tracks.copy(deep=True)
    # as if the tracker had lost HR in frame 10 for good
    rows = broken["frame"] >= 10
    broken["image_position"].loc[{"keypoint": "HR", "time": rows}] = 20.0
    broken["position"].loc[{"keypoint": "HR", "time": rows}] = 5.0
    broken["image_origin"].loc[{"keypoint": "HR", "time": rows}] = MEASURED
    # ... and a person put it right in frame 14 only
    for v in range(2):
        broken["image_position"][14, v, :, 1, 0] = scene.uv[14, v, 1]
        broken["image_origin"][14, v, 1, 0] = EDITED
    scene.asked.clear()
    again = track(scene, tracks=broken, frames=(14, 30))
    assert scene.asked == list(range(14, 30))
    for name in ("position", "image_position", "origin", "image_confidence", "residual"):
        np.testing.assert_array_equal(again[name][:14], broken[name][:14])
    assert image_error(again, scene)[14:].max() < 7.0
    assert (again["image_origin"][14].sel(keypoint="HR") == EDITED).all()
    assert (again["image_origin"][15:] == MEASURED).all()
    assert again["frame"].to_numpy().tolist() == list(range(30))
    # what was wrong before stays: the repair is due to the reset, not to a new run
    assert image_error(again, scene)[10:14, :, 1].min() > 20.0


@pytest.mark.slow
def test_retracking_without_a_correction_changes_next_to_nothing(make_scene):
    """The filters are taken over the rows before, so that points left alone go on as before."""
    scene = make_scene(n_frames=30)
    tracks = track(scene)
    again = track(scene, tracks=tracks, frames=(15, 30))
    np.testing.assert_array_equal(again["image_position"][:16], tracks["image_position"][:16])
    apart = np.abs((again["image_position"] - tracks["image_position"]).to_numpy())
    assert np.median(apart) < 0.01
    assert apart.max() < 7.0


def test_retracking_learns_colours_where_points_were_last_placed_by_hand(make_scene):
    scene = make_scene(n_frames=20)
    scene.colours = scene.colours.copy()
    tracks = track(scene)
    learnt = []
    scene.frame = lambda i, whole=scene.frame: learnt.append(i) or whole(i)
    scene.frames = lambda a, b, partly=False: (
        (i, type(scene).frame(scene, i)) for i in range(a, b)
    )
    tracks["image_origin"][5, 0, 0, 0] = EDITED
    track(scene, tracks=tracks, frames=(12, 20))
    assert learnt == [0, 5]


@pytest.mark.slow
def test_retracking_holds_positions_placed_by_hand_later_on(make_scene):
    scene = make_scene()
    tracks = track(scene)
    tracks["image_position"][20, 0, :, 0, 0] = [100.0, 50.0]
    tracks["image_origin"][20, 0, 0, 0] = EDITED
    again = track(scene, tracks=tracks, frames=(10, 25))
    assert again["image_position"][20, 0, :, 0, 0].to_numpy().tolist() == [100.0, 50.0]
    assert again["image_origin"][20, 0, 0, 0] == EDITED
    assert again["image_origin"][19, 0, 0, 0] == MEASURED


@pytest.mark.slow
def test_stopping_keeps_what_is_done(make_scene):
    scene = make_scene()
    done = []
    tracks = track(scene, progress=lambda i, n: done.append((i, n)), stop=lambda: len(done) == 9)
    assert done == [(i, 25) for i in range(1, 10)]
    assert tracks["frame"].to_numpy().tolist() == list(range(9))
    assert image_error(tracks, scene).max() < 7.0
    whole = track(scene)
    done.clear()
    again = track(scene, tracks=whole, frames=(10, 25), stop=lambda: len(done) == 3,
                  progress=lambda i, n: done.append(i))  # fmt: skip
    assert again["frame"].to_numpy().tolist() == list(range(25))
    np.testing.assert_array_equal(again["image_position"][13:], whole["image_position"][13:])


def test_tracking_may_begin_and_end_within_the_recording(make_scene):
    scene = make_scene()
    tracks = track(scene, start=scene.clicks(6), frames=(4, 15))
    assert tracks["frame"].to_numpy().tolist() == list(range(4, 15))
    assert np.isnan(tracks["image_position"][:2]).all()
    assert image_error(tracks, scene)[2:].max() < 7.0


@pytest.mark.slow
def test_same_input_gives_the_same_tracks(make_scene):
    scene = make_scene()
    assert track(scene).identical(track(scene))


def test_weights_matter(make_scene):
    """The scene can fail: told to look for the corner only, the tracker leaves the discs."""
    scene = make_scene()
    corner = dataclasses.replace(
        SETTINGS, weights_front=(0, 0, 0, 0, 0, 0, 1, 0), weights_hind=(0, 0, 0, 0, 0, 0, 1, 0)
    )
    right = image_error(track(scene, settings=corner, facing={"cam1": 1, "cam2": 1}), scene)
    assert np.nanmax(right) > 20
    found = track(scene, settings=corner, facing={"cam1": -1, "cam2": -1}, frames=(0, 3))
    # frame 1: the sub-image is about the click, and the superpixel at its bottom left is taken
    step = found["image_position"][1] - found["image_position"][0]
    assert (step.sel(image_space="u") < -15).all()
    assert (step.sel(image_space="v") > 5).all()


def clicks_with(scene, **change):
    clicks = scene.clicks()
    for column, value in change.items():
        clicks.loc[0, column] = value
    return clicks


@pytest.mark.parametrize(
    ("start", "options", "message"),
    [
        (
            lambda s: s.clicks().query("point != 'HR'"),
            {"points_by_view": {"cam1": ("FR", "HR"), "cam2": ("FR", "HR")}},
            "point 'HR' is clicked in no view; click it in at least one view of a start frame.",
        ),
        (
            lambda s: s.clicks(3),
            {"frames": (5, 20)},
            "the start has point 'FR' in view 'cam1' in frame 3, but frames 5 to 19 are tracked; "
            "click in one of those or track others.",
        ),
        (
            lambda s: s.clicks(),
            {"frames": (0, 26)},
            "frames 0 to 25 are to be tracked, but the views have frames 0 to 24; choose a range "
            "within.",
        ),
        (
            lambda s: clicks_with(s, u=400.0),
            {},
            "the start has point 'FR' in view 'cam1' in frame 0 at (400.0, {v}), outside its "
            "picture of 320 x 160 px; click inside it.",
        ),
        (
            lambda s: clicks_with(s, view="cam3"),
            {},
            "the start has point 'FR' in view 'cam3' in frame 0, but there is no such view (did "
            "you mean 'cam2'?); the views are cam1, cam2.",
        ),
        (
            lambda s: s.clicks(),
            {"points_by_view": {"cam1": ("FR", "HR"), "cam2": ("FR",)}},
            "the start has point 'HR' in view 'cam2' in frame 0, but that view does not track it"
            "; it tracks FR.",
        ),
        (
            lambda s: pd.concat([s.clicks(), s.clicks()]),
            {},
            "the start has point 'FR' in view 'cam1' in frame 0 twice; keep one click.",
        ),
        (
            lambda s: s.clicks().drop(columns="u"),
            {},
            "the start points: column 'u' is missing; expected frame, view, point, u, v, found "
            "frame, view, point, v.",
        ),
        (
            lambda s: s.clicks(),
            {"points_by_view": {"cam9": ("FR",)}},
            "points are listed for view 'cam9' (did you mean 'cam2'?); the views are cam1, cam2.",
        ),
        (
            lambda s: s.clicks(),
            {"settings": Maghsoudi2019Settings(hind=("paw",))},
            "setting 'front' or 'hind' names 'paw'; the points are FR, HR.",
        ),
    ],
)
def test_bad_input_is_said_in_one_sentence(make_scene, start, options, message):
    scene = make_scene()
    clicks = start(scene)
    with pytest.raises(InputError) as error:
        track(scene, start=clicks, **options)
    assert str(error.value) == message.format(v=clicks.iloc[0].get("v"))


def test_rig_without_a_view_is_refused(make_scene):
    scene = make_scene()
    with pytest.raises(CalibrationError) as error:
        track(scene, rig=scene.rig.subset(["cam1"]))
    assert str(error.value) == (
        "the calibration has no view 'cam2' (did you mean 'cam1'?); it has cam1."
    )


def test_retracking_from_a_frame_without_tracks_is_refused(make_scene):
    scene = make_scene()
    tracks = track(scene, frames=(0, 10))
    with pytest.raises(InputError) as error:
        track(scene, tracks=tracks, frames=(12, 20))
    assert str(error.value) == (
        "the tracks have no frame 12 to go on from; they have frames 0 to 9."
    )


def test_three_best_superpixels_are_kept_best_first(make_scene):
    scene = make_scene()
    clicks = scene.clicks()
    layout = layout_of(scene, clicks)
    run = Run(layout)
    run.step(scene.frame(0), read_start(clicks, layout, (0, 1))[0])
    assert run.detections == {}
    result = run.step(scene.frame(1), [])
    assert sorted(run.detections) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    for key, found in run.detections.items():
        assert len(found.best) == 3
        assert (np.diff(found.scores) <= 0).all()
        np.testing.assert_array_equal(found.superpixels.uv[found.best[0]], result.uv[key])
        assert result.image_confidence[key] == found.scores[0]
