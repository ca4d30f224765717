"""``pawnb evaluate``: the errors that were put in are the errors that come out."""

from __future__ import annotations

import dataclasses
import shutil

import numpy as np
import pandas as pd
import pytest

from pawnb.cli import main
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.io.native import read_tracks, write_tracks
from pawnb.io.track_tables import read_tracks_table
from pawnb.workflow.evaluation.evaluate import compare_events, evaluate

pytestmark = pytest.mark.slow


@pytest.fixture
def shifted(small_spider, tmp_path):
    """Return a trial and results that are the truth, 3 px to the right and 4 px down."""
    animal, poses = read_start_pose(small_spider / "truth" / "pose.csv", load_species("dolomedes"))
    poses = dataclasses.replace(poses, xy=poses.xy + np.array([3.0, 4.0]))
    out = tmp_path / "shifted"
    out.mkdir()
    tracks = tracks_from_poses(animal, plain_track(animal, poses), fps=125, view="top")
    write_tracks(tracks, out / "tracks.nc")
    return small_spider, out


def test_errors_of_a_pose_are_those_that_were_put_in(shifted, tmp_path):
    trial, results = shifted
    shutil.rmtree(tmp_path / "tables", ignore_errors=True)
    found = evaluate(results, trial / "truth", out=tmp_path / "tables")
    summary = found.tables["summary"].set_index("measure")["value"]
    assert summary["frames"] == 14
    assert summary["body error, RMS"] == pytest.approx(5.0, abs=1e-3)
    # the leg span of Table 3.1's longest leg, L4: 2 * (2.7 + 40.0) mm
    scale = pd.read_csv(trial / "truth" / "pose.csv")["scale"][0]
    assert summary["tip error, median"] == pytest.approx(5.0 / (2 * 42.7 * scale), rel=1e-2)
    assert summary["total leg angle error, RMS"] == pytest.approx(0.0, abs=1e-2)
    assert summary["leg swaps"] == 0
    assert "body error, RMS: 5" in found.text
    assert sorted(path.name for path in (tmp_path / "tables").iterdir()) == [
        "evaluation_legs.csv", "evaluation_summary.csv", "evaluation_swaps.csv",
    ]  # fmt: skip


def test_frames_with_a_hidden_tip_do_not_count(shifted):
    trial, results = shifted
    path = trial / "truth" / "tracks.csv"
    points = pd.read_csv(path)
    points.loc[(points["frame"] < 15) & (points["point"] == "R3"), "visible"] = 0
    points.loc[(points["frame"] > 20) & (points["point"] == "R3.CT"), "visible"] = 0  # no tip
    points.to_csv(path, index=False)
    summary = evaluate(results, trial / "truth").tables["summary"]
    assert summary.set_index("measure")["value"]["frames"] == 9
    points["visible"] = 0
    points.to_csv(path, index=False)
    with pytest.raises(InputError, match="never shows a tip"):
        evaluate(results, trial / "truth")


def test_legs_are_judged_one_by_one_where_no_frame_shows_every_tip(shifted):
    """Of 14 frames R3 is seen in 6 and L1 in 8, never both; L2, never seen, is 40 degrees off."""
    trial, results = shifted
    path = trial / "truth" / "tracks.csv"
    points = pd.read_csv(path)
    frames = np.sort(points["frame"].unique())
    early = points["frame"].isin(frames[:-6])
    points.loc[early & (points["point"] == "R3"), "visible"] = 0
    points.loc[~early & (points["point"] == "L1"), "visible"] = 0
    points.loc[points["point"] == "L2", "visible"] = 0
    points.to_csv(path, index=False)
    pose = trial / "truth" / "pose.csv"
    table = pd.read_csv(pose)
    table["L2_BC"] += 40.0
    table.to_csv(pose, index=False)
    found = evaluate(results, trial / "truth")
    legs = found.tables["legs"].set_index("leg")
    assert legs["n_frames"][["R3", "L1", "L2", "L4"]].tolist() == [6, 8, 0, 14]
    assert np.isnan(legs.loc["L2", "tip_px_median"])
    assert legs.loc["R3", "tip_px_median"] == pytest.approx(5.0, abs=0.01)
    summary = found.tables["summary"].set_index("measure")["value"]
    assert summary["joint angle error, RMS"] == pytest.approx(0.0, abs=1e-2)
    assert summary["leg swaps"] == 0
    assert "never visible: L2" in found.text.splitlines()[0]


def test_points_of_a_pose_can_be_evaluated_too(shifted, capsys):
    trial, results = shifted
    truth = str(trial / "truth" / "tracks.csv")
    assert main(["evaluate", str(results), truth, "--threshold", "4"]) == 0
    points = pd.read_csv(truth)
    n = points.loc[points["visible"] == 1, "point"].nunique()  # each is wrong to the end
    assert n > 50
    assert f"major errors {n} " in capsys.readouterr().out
    assert main(["evaluate", str(results), truth, "--threshold", "6"]) == 0
    assert "major errors 0 " in capsys.readouterr().out


def test_paws_against_their_truth(rendered_trial, tmp_path):
    truth = rendered_trial / "truth" / "tracks.csv"
    tracks = read_tracks_table(truth, fps=250)
    tracks["image_position"].to_numpy()[:5, 0, 0, 0] += 30  # one paw in cam1, five frames
    write_tracks(tracks, tmp_path / "tracks.nc")
    found = evaluate(tmp_path, rendered_trial / "truth" / "tracks.csv")
    assert len(found.tables["errors"]) == 1
    assert found.tables["errors"]["last_frame"].item() == 4
    summary = found.tables["summary"].set_index("measure")["value"]
    n = int((pd.read_csv(rendered_trial / "truth" / "tracks.csv")["visible"] == 1).sum())
    # one error of five labels, and the words say the same numbers
    assert summary["minor errors"] + summary["major errors"] == 1
    assert summary["visible labels"] == n
    assert summary["labels wrong"] == pytest.approx(5 / n, abs=1e-3)
    said = found.text.splitlines()
    assert said[0].startswith(f"{summary['frames']:g} frames of all views together, {n} visible")
    assert f"median distance {summary['distance, median']:.2f} px" in found.text


def test_what_the_tracks_lack_of_the_truth_is_said(rendered_trial, tmp_path):
    """Tracks of a film cut short were judged by what is left of it, as those of another trial."""
    truth = rendered_trial / "truth" / "tracks.csv"
    whole = read_tracks_table(truth, fps=250.0)
    write_tracks(whole, tmp_path / "tracks.nc")
    assert "the tracks lack" not in evaluate(tmp_path, truth).text
    few = whole.isel(time=slice(0, whole.sizes["time"] - 2), keypoint=slice(1, None))
    last = int(whole["frame"][-1])
    write_tracks(few, tmp_path / "few.nc")
    lost = str(whole["keypoint"].to_numpy()[0])
    said = evaluate(tmp_path / "few.nc", truth).text.splitlines()[-1]
    frames = f"2 of {whole.sizes['time']} frames ({last - 1} to {last})"
    assert said.startswith(f"the tracks lack {frames} and the point {lost} of the truth, which")


def test_the_results_of_a_trial_are_found_by_the_trial(rendered_trial, tmp_path):
    shutil.copytree(rendered_trial / "truth", tmp_path / "truth")
    shutil.copy(rendered_trial / "trial.toml", tmp_path / "trial.toml")
    (tmp_path / "results").mkdir()
    truth = tmp_path / "truth" / "tracks.csv"
    write_tracks(read_tracks_table(truth, fps=250), tmp_path / "results" / "tracks.nc")
    found = evaluate(tmp_path, truth)
    assert len(found.tables["errors"]) == 0


def test_a_missing_truth_is_named(shifted, tmp_path):
    with pytest.raises(InputError, match=r"pose\.csv: no such file"):
        evaluate(shifted[1], tmp_path)


def _events(leg, event, *frames):
    return pd.DataFrame({"leg": leg, "event": event, "time_s": np.array(frames) / 100})


def test_events_are_paired_with_the_nearest_of_their_kind():
    truth = pd.concat(
        [_events("L1", "AEP", 10, 30, 50, 70), _events("L1", "PEP", 20, 40, 60)], ignore_index=True
    )
    # 9.5 and 30.2 are found; 50 has two candidates; 70 is missed although others come later;
    # 63 is an extra one; and a PEP at 41 is off by one frame
    found = pd.concat(
        [_events("L1", "AEP", 9.5, 30.2, 50.1, 53, 63), _events("L1", "PEP", 41, 90)],
        ignore_index=True,
    )
    table = compare_events(found, truth, fps=100).set_index("event")
    aep, pep = table.loc["AEP"], table.loc["PEP"]
    assert (aep["n_true"], aep["n_found"], aep["missed"], aep["extra"]) == (4, 3, 1, 2)
    assert aep["median_frames"] == pytest.approx(0.2)
    assert aep["bias_frames"] == pytest.approx((-0.5 + 0.2 + 0.1) / 3)
    assert (pep["n_found"], pep["missed"], pep["extra"]) == (1, 2, 0)
    assert pep["median_frames"] == pytest.approx(1.0)


def test_a_leg_without_any_event_is_all_missed():
    truth = _events("L1", "AEP", 10, 30)
    found = _events("L2", "AEP", 5, 25, 45)
    (row,) = compare_events(found, truth, fps=100).to_dict("records")
    assert (row["n_found"], row["missed"], row["extra"]) == (0, 2, 0)
    assert np.isnan(row["median_frames"])


def test_the_limit_of_an_error_goes_with_the_width_of_the_pictures(shifted, tmp_path):
    """Off by 5 px: right in pictures 2048 px wide, wrong (above 4 px) in pictures of 410."""
    trial, results = shifted
    truth = trial / "truth" / "tracks.csv"
    assert "labels wrong: 0.0%" in evaluate(results, truth).text
    tracks = read_tracks(results / "tracks.nc")
    write_tracks(tracks.assign_attrs(pictures_px='{"top": [410, 300]}'), tmp_path / "small.nc")
    assert "labels wrong: 100.0%" in evaluate(tmp_path / "small.nc", truth).text


def test_an_animal_with_a_leg_missing_is_judged_by_the_legs_that_it_has(small_spider, tmp_path):
    """The truth has L4; these results, 5 px off, do not."""
    start = pd.read_csv(small_spider / "truth" / "pose.csv")
    missing = pd.Series(0.0, index=start.index, name="L4_scale")
    pd.concat([start, missing], axis=1).to_csv(tmp_path / "seven.csv", index=False)
    animal, poses = read_start_pose(tmp_path / "seven.csv", load_species("dolomedes"))
    assert "L4" not in animal.leg_names
    poses = dataclasses.replace(poses, xy=poses.xy + np.array([3.0, 4.0]))
    tracks = tracks_from_poses(animal, plain_track(animal, poses), fps=125, view="top")
    write_tracks(tracks, tmp_path / "tracks.nc")
    found = evaluate(tmp_path, small_spider / "truth")
    assert found.tables["legs"]["leg"].tolist() == ["L1", "L2", "L3", "R1", "R2", "R3", "R4"]
    summary = found.tables["summary"].set_index("measure")["value"]
    assert summary["body error, RMS"] == pytest.approx(5.0, abs=1e-3)
    assert summary["total leg angle error, RMS"] == pytest.approx(0.0, abs=1e-2)
    path = small_spider / "truth" / "pose.csv"
    path.write_text(path.read_text().replace("L4_BC", "L4_XX", 1))
    with pytest.raises(InputError, match="unknown column 'L4_XX'"):
        evaluate(tmp_path, small_spider / "truth")
