"""The comparison of methods on a small rendered trial, and its tests between cameras."""

from __future__ import annotations

import time

import numba
import numpy as np
import pandas as pd
import pytest
from scipy import stats

from pawnb import cli
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.io.native import read_tracks
from pawnb.trial import load_trial
from pawnb.workflow.evaluation import compare
from pawnb.workflow.evaluation.compare import (
    COMPARISON_COLUMNS,
    REPROJECTION_COLUMNS,
    SUMMARY_COLUMNS,
    compare_methods,
)
from pawnb.workflow.evaluation.compare_cameras import TESTS_COLUMNS
from pawnb.workflow.evaluation.compared import settings_by_method
from pawnb.workflow.evaluation.errors import count_errors
from pawnb.workflow.tracking.track import track

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

FRAMES = (0, 10)


@pytest.fixture(scope="module")
def compared(rendered_trial, tmp_path_factory):
    out = tmp_path_factory.mktemp("comparison")
    made = compare_methods(
        [rendered_trial], methods=["slic-3d", "slic-2d"], frames=FRAMES, out=out,
        progress=lambda done, total: None,
    )  # fmt: skip
    return made, out


def test_files_and_columns(compared):
    made, out = compared
    for name, columns in (
        ("comparison", COMPARISON_COLUMNS),
        ("comparison_summary", SUMMARY_COLUMNS),
        ("reprojection", REPROJECTION_COLUMNS),
        ("reprojection_tests", TESTS_COLUMNS),
    ):
        assert tuple(pd.read_csv(out / f"{name}.csv").columns) == columns, name
    for ending in ("png", "pdf", "svg", "csv"):
        assert (out / f"compare_methods.{ending}").stat().st_size > 0
    assert made.trials["method"].tolist() == ["slic-3d", "slic-2d"]
    said = made.text()
    assert "slic-2d: 1 trials, 10 frames" in said
    # printed as well: errors by camera and paw, and the tests between cameras
    mean = made.reprojection.set_index(["method", "view", "point"])["mean_px"]
    assert f"  slic-3d, cam1: FR {mean['slic-3d', 'cam1', 'FR']:.2f}, HR " in said
    p = made.tests.iloc[0]
    assert f"{p['view_a']} and {p['view_b']}: frames t {p['t']:.2f}, p {p['p']:.2g}" in said


def test_the_default_method_has_reprojection_errors_too(rendered_trial):
    """Of what was found in each picture, from the projection of the smoothed position."""
    made = compare_methods(
        [rendered_trial], methods=["pawnb"], frames=FRAMES, corrections=False,
        progress=lambda done, total: None,
    )  # fmt: skip
    tracks = track(rendered_trial, frames=FRAMES, progress=lambda done, total: None)
    own = tracks["image_residual"].sel(view="cam1", keypoint="FR").isel(individual=0)
    row = made.reprojection.set_index(["view", "point"]).loc[("cam1", "FR")]
    assert row["n"] == np.isfinite(own).sum() > 5
    assert row["mean_px"] == pytest.approx(float(own.mean()))
    # root mean square over the views is what the tracks call residual
    each = tracks["image_residual"].sel(keypoint="FR").isel(individual=0)
    np.testing.assert_allclose(
        np.sqrt((each**2).mean("view")), tracks["residual"].sel(keypoint="FR").isel(individual=0)
    )
    # the same labels as of the other methods: cam1 tracks the right paws, and finds left ones, too
    assert np.isfinite(tracks["image_residual"].sel(view="cam1", keypoint="FL")).any()
    assert set(made.reprojection["point"][made.reprojection["view"] == "cam1"]) == {"FR", "HR"}
    # a fifth of the paper's pictures: errors of its order (5 to 8 px) would be 1 to 1.6 px
    assert 0.05 < row["mean_px"] < 1.6


def test_time_leaves_compiling_out(rendered_trial, monkeypatch):
    """Else the first trial would be as slow as a hundred others."""
    took = []

    def first_run(*arguments, **options):
        begun = time.perf_counter()
        numba.njit(lambda x: np.sort(x)[::2].sum())(np.arange(9.0))
        took.append(time.perf_counter() - begun)
        return track(*arguments, **options)

    monkeypatch.setattr(compare, "track", first_run)
    ask = {"methods": ["slic-2d"], "frames": (0, 2), "corrections": False}
    begun = time.perf_counter()
    row = compare_methods([rendered_trial], **ask, progress=lambda *_: None).trials.iloc[0]
    whole = time.perf_counter() - begun
    assert took[0] > 0.3
    assert row["time_s_per_1000"] / 1000 * 2 < whole - 0.8 * took[0]


def test_counts_come_with_their_limits(compared):
    made, _ = compared
    row = made.summary[made.summary["measure"] == "major_alone_per_1000"].iloc[0]
    assert row["count"] == made.trials.iloc[0]["major_alone"]
    assert row["limit"] > row["mean"]
    time = made.summary[made.summary["measure"] == "time_s_per_1000"].iloc[0]
    assert np.isnan(time["count"])


def test_rows_are_those_of_tracking_and_counting_by_hand(compared, rendered_trial):
    made, _ = compared
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    trial = load_trial(rendered_trial)
    tracks = track(trial, method="slic-2d", frames=FRAMES, progress=lambda done, total: None)
    # 20 px at 2048 px of width; these pictures are a fifth of that
    points = {view.name: view.points for view in trial.views}
    by_hand = count_errors(tracks, truth, points_by_view=points, threshold_px=20 * 410 / 2048)
    row = made.trials.iloc[1]
    assert row["n_frames"] == 10
    assert row["major_alone_per_1000"] == by_hand.major_per_1000
    assert row["minor_alone_per_1000"] == by_hand.minor_per_1000
    assert row["median_px"] == pytest.approx(by_hand.median_px)
    assert row["time_s_per_1000"] > 0


def test_reprojection_errors_are_distances_from_the_projected_position(rendered_trial, tmp_path):
    made = compare_methods(
        [rendered_trial], methods=["paper"], frames=FRAMES, corrections=False,
        progress=lambda done, total: None,
    )  # fmt: skip
    tracks = track(
        rendered_trial, frames=FRAMES, method="paper", out=tmp_path,
        progress=lambda done, total: None,
    )  # fmt: skip
    tracks = read_tracks(tmp_path / "tracks.nc")
    rig = load_rig(load_trial(rendered_trial))
    xyz = tracks["position"].sel(keypoint="FR").isel(individual=0).to_numpy()
    uv = tracks["image_position"].sel(view="cam1", keypoint="FR").isel(individual=0).to_numpy()
    away = np.linalg.norm(rig.project(xyz)[:, rig.index("cam1")] - uv, axis=-1)
    row = made.reprojection.set_index(["view", "point"]).loc[("cam1", "FR")]
    assert row["n"] == 10
    assert row["mean_px"] == pytest.approx(away.mean())
    assert row["sd_px"] == pytest.approx(away.std(ddof=1))
    assert made.trials["major_per_1000"].isna().all()


def test_cameras_are_compared_by_welchs_test(compared):
    """Its t from the means, SDs and numbers alone (scipy's other route to it)."""
    made, _ = compared
    errors = made.reprojection.set_index(["method", "view", "point"])
    row = made.tests[
        (made.tests["method"] == "slic-3d") & (made.tests["kind"] == "front")
        & (made.tests["view_a"] == "cam1") & (made.tests["view_b"] == "cam3")
    ].iloc[0]  # fmt: skip
    a, b = errors.loc[("slic-3d", "cam1", "FR")], errors.loc[("slic-3d", "cam3", "FL")]
    t, p = stats.ttest_ind_from_stats(
        a["mean_px"], a["sd_px"], a["n"], b["mean_px"], b["sd_px"], b["n"], equal_var=False
    )
    assert (row["t"], row["p"]) == pytest.approx((t, p))
    assert (row["n_trials_a"], row["n_trials_b"]) == (1, 1)
    assert np.isnan(row["p_trials"])
    # six pairs of four cameras, front and hind
    assert len(made.tests) == 2 * 2 * 6


def test_settings_go_to_the_methods_that_have_them_or_to_the_one_named():
    given = {
        "n_superpixels": "150", "slic-2d.n_superpixels": "90", "pawnb.noise": "0.1",
        "paper.adjust_weights": "false", "stride.due_sd": "1", "pawnb.colour.smooth_px": "1",
    }  # fmt: skip
    methods = ("pawnb", "paper", "slic-2d")
    assert settings_by_method(given, methods) == {
        "pawnb": {"noise": "0.1", "stride.due_sd": "1", "colour.smooth_px": "1"},
        "paper": {"n_superpixels": "150", "adjust_weights": "false"},
        "slic-2d": {"n_superpixels": "90"},
    }

    def refuse(name, methods=methods):
        with pytest.raises(InputError) as caught:
            settings_by_method({name: 1}, methods)
        return str(caught.value)

    assert refuse("slic-3d.scale").startswith(
        "setting 'slic-3d.scale' is for method 'slic-3d' (did you mean 'slic-2d'?), which is not "
        "compared; the methods are"
    )
    assert refuse("pawnb.n_superpixels").startswith("method pawnb has no setting 'n_superpixels'")
    assert refuse("scael") == (
        "none of the methods compared has a setting 'scael' (did you mean 'scale'?)."
    )


def test_bad_input_is_one_sentence(small_trial):
    with pytest.raises(InputError, match=r"unknown method 'slic-3' \(did you mean 'slic-3d'"):
        compare_methods([small_trial], methods=["slic-3"])
    with pytest.raises(InputError, match="two trials are named"):
        compare_methods([small_trial, small_trial])
    (small_trial / "truth" / "tracks.csv").unlink()
    with pytest.raises(InputError, match=r"has no truth/tracks\.csv; a comparison needs the truth"):
        compare_methods([small_trial])


def test_command(rendered_trial, tmp_path, capsys):
    out = tmp_path / "c"
    words = ["compare", str(rendered_trial), "--methods", "slic-2d", "--frames", "4"]
    assert cli.main([*words, "--no-corrections", "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "slic-2d: 1 trials, 4 frames" in said
    assert "No corrections were made: errors are those of the trackers alone." in said
    drawn = pd.read_csv(out / "compare_methods.csv").set_index("panel")["corrections"]
    assert set(drawn[["major", "minor"]]) == {"none"}
    assert len(pd.read_csv(out / "comparison.csv")) == 1
    assert cli.main([*words[:3], "x", "--out", str(out)]) == 2
