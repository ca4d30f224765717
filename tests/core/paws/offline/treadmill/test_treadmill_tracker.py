"""The whole-recording tracker on a short rendered scene with exact truth."""

import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.treadmill.tracker import track_treadmill
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import load_rig
from pawnb.core.video import open_views
from pawnb.errors import InputError, InputWarning
from pawnb.io.native import read_tracks, write_tracks
from pawnb.schema import ORIGIN_CODE, check_tracks
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import load_trial

NEW = ("image_separation", "passes_apart", "image_residual", "image_offset", "revision")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = render_mouse_trial(tmp_path_factory.mktemp("scene"), frames=24, scale=0.35, seed=2)
    trial = load_trial(path)
    truth = pd.read_csv(trial.folder / "truth" / "tracks.csv")
    return trial, pd.read_csv(trial.folder / "start.csv"), truth


def run(trial, start, **options):
    task = TrackingRequest(
        rig=load_rig(trial), points_by_view={view.name: view.points for view in trial.views},
        fps=trial.fps, unit="mm", **{"frames": (0, 24), **options},
    )  # fmt: skip
    with open_views(trial) as views:
        return track_treadmill(views, start, task, settings=OfflineSettings())


def distances(tracks, truth, trial):
    """Distance (px) of every visible label that a view tracks."""
    away = []
    for view in trial.views:
        for point in view.points:
            rows = truth[(truth["view"] == view.name) & (truth["point"] == point)]
            rows = rows[rows["frame"].isin(tracks["frame"].to_numpy()) & (rows["visible"] == 1)]
            uv = tracks["image_position"].sel(view=view.name, keypoint=point)[..., 0].to_numpy()
            uv = uv[rows["frame"].to_numpy() - int(tracks["frame"][0])]
            away.append(np.linalg.norm(uv - rows[["u", "v"]].to_numpy(), axis=1))
    return np.concatenate(away)


@pytest.mark.slow
def test_visible_paws_are_found_and_clicks_are_kept(scene, tmp_path):
    trial, start, truth = scene
    done = []
    tracks = run(trial, start, progress=lambda *step: done.append(step))
    check_tracks(tracks)
    assert done == [(i + 1, 24) for i in range(24)]
    away = distances(tracks, truth, trial)
    # 20 px in a picture 2048 px wide is the evaluation's limit of a wrong label
    assert np.mean(away < 20 * 0.35) > 0.95
    assert np.median(away) < 2.0
    for click in start.itertuples():
        here = tracks.sel(view=click.view, keypoint=click.point).isel(time=0, individual=0)
        np.testing.assert_allclose(here["image_position"].to_numpy(), [click.u, click.v])
        assert int(here["image_origin"]) == ORIGIN_CODE["edited"]
    assert np.isfinite(tracks["sd"].to_numpy()).all()
    # a detection that was taken is ahead of others or not; nothing is said where none was
    taken = tracks["image_origin"].to_numpy() == ORIGIN_CODE["measured"]
    association_log_odds = tracks["image_separation"].to_numpy()
    np.testing.assert_array_equal(np.isfinite(association_log_odds), taken)
    # paws lie clear of each other in most frames: odds of more than 7 to 1
    assert np.mean(association_log_odds[taken] > 2.0) > 0.7
    apart = tracks["passes_apart"].to_numpy()
    assert np.isfinite(apart[3:-3]).mean() > 0.9
    assert np.nanmedian(apart) < 2.0
    length = np.linalg.norm(tracks["image_offset"].to_numpy(), axis=2)
    np.testing.assert_allclose(length, tracks["image_residual"].to_numpy())
    again = read_tracks(write_tracks(tracks, tmp_path / "tracks.nc"))
    xr.testing.assert_identical(again[list(NEW)], tracks[list(NEW)])


@pytest.mark.slow
def test_tracking_again_keeps_earlier_rows_and_obeys_what_was_placed_by_hand(scene):
    trial, start, truth = scene
    tracks = run(trial, start)
    anchors = tracks.copy(deep=True)
    row = truth[(truth["frame"] == 10) & (truth["view"] == "cam1") & (truth["point"] == "HR")]
    uv = row[["u", "v"]].to_numpy()[0]
    anchors["image_position"].loc[{"view": "cam1", "keypoint": "HR"}][10, :, 0] = uv
    anchors["image_origin"].loc[{"view": "cam1", "keypoint": "HR"}][10, 0] = ORIGIN_CODE["edited"]
    nothing = start.iloc[:0]
    again = run(trial, nothing, frames=(10, 24), tracks=anchors)
    before = [again["position"][:10].to_numpy(), anchors["position"][:10].to_numpy()]
    np.testing.assert_array_equal(*before)
    np.testing.assert_array_equal(again["frame"].to_numpy(), np.arange(24))
    here = again.sel(view="cam1", keypoint="HR").isel(time=10, individual=0)
    np.testing.assert_allclose(here["image_position"].to_numpy(), uv)
    assert int(here["image_origin"]) == ORIGIN_CODE["edited"]
    assert np.median(distances(again.isel(time=slice(10, None)), truth, trial)) < 2.5


@pytest.mark.slow
def test_stopping_keeps_what_is_done_and_bad_input_is_refused(scene):
    trial, start, _ = scene
    asked = []

    def stop():
        asked.append(None)
        return len(asked) > 8

    assert len(run(trial, start, stop=stop)["frame"]) == 8
    with pytest.raises(InputError, match="frames 0 to 99 are to be tracked"):
        run(trial, start, frames=(0, 100))
    with pytest.raises(InputError, match="clicked in no view"):
        run(trial, start[start["point"] != "FR"])


@pytest.mark.slow
def test_paws_that_look_like_the_belt_are_told_of(scene, tmp_path):
    """A belt as brown as the paws in its light; on the usual one nothing is said."""
    brown = {"belt_rgb": (135.0, 105.0, 92.0), "light": 0.84, "fur_rgb": (53.0, 35.0, 50.0)}
    path = render_mouse_trial(
        tmp_path / "brown", frames=2, scale=0.35, seed=0, difficulty="hard", settings=brown
    )
    trial = load_trial(path)
    start = pd.read_csv(trial.folder / "start.csv")
    with pytest.warns(InputWarning, match="hardly differ from what is around the animal"):
        run(trial, start, frames=(0, 2))
    trial, start, _ = scene
    with warnings.catch_warnings():
        warnings.simplefilter("error", InputWarning)
        run(trial, start, frames=(0, 2))
