"""Tracks of other programs: written here in their layouts, and real files where they are."""

import h5py
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.io.deeplabcut import read_deeplabcut
from pawnb.io.dltdv import read_dltdv_points, read_dltdv_points3d
from pawnb.io.formats import read_any_tracks, recognise_format
from pawnb.io.native import write_tracks
from pawnb.io.wide import write_wide_table
from pawnb.schema import make_tracks

RNG = np.random.default_rng(5)
UV = RNG.uniform(0, 500, size=(6, 2, 2))  # frame, point, axis
SCORE = RNG.uniform(0.2, 1.0, size=(6, 2))
POINTS = ["Front Paw R", "Hind Paw R"]


def dlc_csv(path, *, individuals=False):
    rows = [["scorer"] + ["DLC_net"] * 6]
    if individuals:
        rows.append(["individuals"] + ["m1"] * 6)
    rows.append(["bodyparts"] + [p for p in POINTS for _ in range(3)])
    rows.append(["coords"] + ["x", "y", "likelihood"] * 2)
    for i in range(6):
        values = [v for k in range(2) for v in (*UV[i, k], SCORE[i, k])]
        rows.append([i, *values])
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    return path


@pytest.mark.parametrize("individuals", [False, True])
def test_deeplabcut_csv(tmp_path, individuals):
    path = dlc_csv(tmp_path / "clipDLC.csv", individuals=individuals)
    assert recognise_format(path) == "deeplabcut"
    tracks = read_any_tracks(path, fps=100.0)
    assert list(tracks["keypoint"].to_numpy()) == POINTS
    np.testing.assert_allclose(
        tracks["position"].transpose("time", "keypoint", "space", ...).to_numpy()[..., 0], UV
    )
    np.testing.assert_allclose(tracks["confidence"].to_numpy()[..., 0], SCORE)
    assert tracks["time"].to_numpy()[-1] == pytest.approx(0.05)


# columns as eks/singlecam_smoother.py and eks/multicam_smoother.py of paninski-lab/eks write them:
# release 4 in pictures and in space, and the releases before, whose likelihood is empty
SMOOTHED = {
    "eks_singlecam": "x y likelihood x_ens_median y_ens_median x_ens_var y_ens_var "
    "x_posterior_var y_posterior_var",
    "multicam_3d_results": "x y z x_posterior_var y_posterior_var z_posterior_var",
    "multicam_top_results": "x y likelihood x_var y_var zscore",
}


def smoothed_csv(path, labels, likelihood):
    columns = pd.MultiIndex.from_product(
        [["ensemble-kalman_tracker"], POINTS, labels.split()],
        names=["scorer", "bodyparts", "coords"],
    )
    table = pd.DataFrame(7.5, index=range(6), columns=columns)
    for k, point in enumerate(POINTS):
        for axis, label in enumerate(("x", "y")):
            table["ensemble-kalman_tracker", point, label] = UV[:, k, axis]
        if "likelihood" in labels:
            table["ensemble-kalman_tracker", point, "likelihood"] = likelihood
    table.to_csv(path)
    return path


@pytest.mark.parametrize("name", SMOOTHED)
def test_what_the_ensemble_kalman_smoother_writes(tmp_path, name):
    likelihood = np.nan if "zscore" in SMOOTHED[name] else 0.8
    path = smoothed_csv(tmp_path / f"{name}.csv", SMOOTHED[name], likelihood)
    assert recognise_format(path) == "lightning-pose"
    tracks = read_any_tracks(path, fps=100.0)
    assert tracks.attrs["source_software"] == "Ensemble Kalman Smoother"
    assert list(tracks["keypoint"].to_numpy()) == POINTS
    places = tracks["position"].transpose("time", "keypoint", "space", ...).to_numpy()[..., 0]
    np.testing.assert_allclose(places[..., :2], UV)
    assert places.shape[-1] == (3 if "z" in SMOOTHED[name].split() else 2)
    if name == "eks_singlecam":
        assert (tracks["confidence"].to_numpy() == 0.8).all()
    else:
        assert np.isnan(tracks["confidence"].to_numpy()).all()


def test_likelihoods_that_the_smoother_left_at_0_say_nothing(tmp_path):
    # as in EKS_IBL-paw_multicam_left.predictions.csv of movement's sample data
    path = smoothed_csv(tmp_path / "eks.csv", SMOOTHED["eks_singlecam"], 0.0)
    assert np.isnan(read_any_tracks(path, fps=100.0)["confidence"].to_numpy()).all()


@pytest.mark.parametrize("model", ["heatmap", "heatmap_mhcrnn", "regression"])
def test_tracks_of_lightning_pose_are_not_said_to_be_of_deeplabcut(tmp_path, model):
    path = dlc_csv(tmp_path / "clip.csv")
    path.write_text(path.read_text().replace("DLC_net", f"{model}_tracker"))
    assert recognise_format(path) == "lightning-pose"
    assert read_any_tracks(path, fps=100.0).attrs["source_software"] == "Lightning Pose"


def test_predictions_of_training_pictures_are_refused_in_words(tmp_path):
    # the table predictions.csv beside a model of Lightning Pose has a last column, set
    lines = dlc_csv(tmp_path / "clip.csv").read_text().splitlines()
    ends = ["set", "", "", *["train"] * 6]
    rows = [
        f"labeled-data/a/img{i:03d}.png,{row.partition(',')[2]}" for i, row in enumerate(lines[3:])
    ]
    path = tmp_path / "predictions.csv"
    path.write_text(
        "\n".join(f"{a},{b}" for a, b in zip([*lines[:3], *rows], ends, strict=True)) + "\n"
    )
    with pytest.raises(InputError, match=r"training pictures .*expected those of a video"):
        read_any_tracks(path, fps=100.0)


def test_sleap_analysis_file(tmp_path):
    # layout of SLEAP's analysis export: tracks (track, xy, node, frame)
    path = tmp_path / "clip.analysis.h5"
    with h5py.File(path, "w") as file:
        file["tracks"] = UV.transpose(2, 1, 0)[None]
        file["point_scores"] = SCORE.T[None]
        file["node_names"] = np.array([p.encode() for p in POINTS])
        file["track_names"] = np.array([b"mouse"])
    assert recognise_format(path) == "sleap"
    tracks = read_any_tracks(path, fps=50.0)
    np.testing.assert_allclose(
        tracks["position"].transpose("time", "keypoint", "space", ...).to_numpy()[..., 0], UV
    )
    assert list(tracks["individual"].to_numpy()) == ["mouse"]


def test_a_csv_of_sleap_io_with_several_videos_is_refused(tmp_path):
    # columns as sleap-io 0.9.5 writes them (format="instances"); the second video goes on where
    # the first one ends, so that its frames rise
    rows = [f"{i},{'a.mp4' if i < 3 else 'b.mp4'},m1,,1.0,{i}.5,2.5,0.9" for i in range(6)]
    head = "frame_idx,video_path,track,track_score,score,FR.x,FR.y,FR.score"
    path = tmp_path / "two.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    with pytest.raises(InputError, match=r"two\.csv: rows of 2 videos, a\.mp4, b\.mp4, whose fr"):
        read_any_tracks(path, fps=50.0)
    path.write_text("\n".join([head, *rows[:3]]) + "\n")
    assert read_any_tracks(path, fps=50.0).sizes["time"] == 3
    path.write_text("\n".join([head, rows[2], *rows[:2]]) + "\n")
    with pytest.raises(InputError, match=r"do not rise; sort .* or export a file of each video"):
        read_any_tracks(path, fps=50.0)


def test_anipose_csv(tmp_path):
    xyz = RNG.normal(size=(4, 3))
    table = pd.DataFrame(
        {
            "L1E_x": xyz[:, 0],
            "L1E_y": xyz[:, 1],
            "L1E_z": xyz[:, 2],
            "L1E_error": 0.5,
            "L1E_ncams": 3,
            "L1E_score": 0.9,
            **{f"M_{i}{j}": float(i == j) for i in range(3) for j in range(3)},
            **{f"center_{i}": 0.0 for i in range(3)},
            "fnum": range(4),
        }
    )
    path = tmp_path / "clip.csv"
    table.to_csv(path, index=False)
    assert recognise_format(path) == "anipose"
    tracks = read_any_tracks(path, fps=300.0, unit="cm")
    np.testing.assert_allclose(tracks["position"].to_numpy()[:, :, 0, 0], xyz)
    assert tracks.attrs["units"] == "cm"


def test_dltdv_files(tmp_path):
    space = tmp_path / "clip_xyzpts.csv"
    space.write_text("pt1_X,pt1_Y,pt1_Z,pt2_X,pt2_Y,pt2_Z\n1,2,3,NaN,NaN,NaN\n4,5,6,7,8,9\n")
    tracks = read_any_tracks(space, fps=10.0, unit="m")
    assert recognise_format(space) == "dltdv-3d"
    assert tracks["position"].sel(keypoint="pt2").to_numpy()[1, :, 0].tolist() == [7, 8, 9]
    assert np.isnan(tracks["position"].sel(keypoint="pt2").to_numpy()[0]).all()
    assert tracks["origin"].to_numpy()[0, :, 0].tolist() == [1, 0]
    views = tmp_path / "clip_xypts.csv"
    views.write_text("pt1_cam1_X,pt1_cam1_Y,pt1_cam2_X,pt1_cam2_Y\n11,21,NaN,NaN\n")
    assert recognise_format(views) == "dltdv"
    # v up, counted from 1 at the bottom: the lowest row of a picture 100 high is v = 99 down
    tracks = read_dltdv_points(views, fps=10.0, heights_px=(100, 100))
    assert tracks["image_position"].to_numpy()[0, 0, :, 0, 0].tolist() == [10.0, 79.0]
    tracks = read_dltdv_points(views, fps=10.0)
    assert tracks["image_position"].to_numpy()[0, 0, :, 0, 0].tolist() == [10.0, 20.0]
    with pytest.raises(InputError, match="2 cameras but 1 heights"):
        read_dltdv_points(views, fps=10.0, heights_px=(100,))
    with pytest.raises(InputError, match="no column of that kind"):
        read_dltdv_points3d(views, fps=10.0)


def test_our_own_files_and_strangers(tmp_path):
    tracks = make_tracks(range(3), ["FR"], fps=100.0, space=("x", "y"))
    write_tracks(tracks, tmp_path / "tracks.nc")
    assert recognise_format(tmp_path / "tracks.nc") == "pawnb"
    assert read_any_tracks(tmp_path / "tracks.nc").sizes["time"] == 3
    other = tmp_path / "notes.csv"
    other.write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match=r"notes\.csv: not tracks that are read here"):
        recognise_format(other)
    with pytest.raises(InputError, match="no such file"):
        recognise_format(tmp_path / "absent.csv")
    with pytest.raises(InputError, match="give fps"):
        read_any_tracks(dlc_csv(tmp_path / "clip.csv"))
    with pytest.raises(InputError, match=r"'deeplabcat' \(did you mean 'deeplabcut'"):
        read_any_tracks(other, fps=1.0, program="deeplabcat")
    broken = tmp_path / "broken.csv"
    broken.write_text("scorer,net\nbodyparts,a\n")
    with pytest.raises(InputError, match="expected the header lines scorer, ") as caught:
        read_deeplabcut(broken, fps=1.0)
    assert "\n" not in str(caught.value)


def test_csv_and_h5_of_one_real_clip_agree(real_data):
    # shared recording: DeepLabCut wrote both files of the same clip
    folder = real_data("mouse-openfield-dlc")
    one = read_any_tracks(folder / "raw_clip1DLC.csv", fps=60.0)
    two = read_any_tracks(folder / "raw_clip1DLC.h5", fps=60.0)
    assert one.sizes["time"] == 7200
    np.testing.assert_allclose(one["position"], two["position"], atol=1e-9)
    np.testing.assert_allclose(one["confidence"], two["confidence"], atol=1e-12)


def test_real_dltdv_files(real_data):
    folder = real_data("salticid-4cam-dlt")
    space = read_any_tracks(folder / "1864_1x_xyzpts.csv", fps=1000.0)
    assert space["frame"].to_numpy()[0] == 42  # first row of the file
    assert space["position"].to_numpy()[0, :, 0, 0].tolist() == [24.43962, -12.287519, 1.381808]
    image = read_any_tracks(folder / "1864_1x_xypts.csv", fps=1000.0)
    assert list(image["view"].to_numpy()) == ["cam1", "cam2", "cam3", "cam4"]


@pytest.mark.parametrize("axes", ["xy", "xyz"])
def test_a_plain_table_of_points(tmp_path, axes):
    rows = [
        "frame," + ",".join(f"{p}_{a}" for p in ("LF_Claw", "b") for a in axes) + ",note",
        "4," + ",".join(["1.5"] * len(axes) + [""] * len(axes)) + ",x",
        "5," + ",".join(["2.5"] * len(axes) + ["7"] * len(axes)) + ",y",
    ]
    path = tmp_path / "points.csv"
    path.write_text("\n".join(rows) + "\n")
    assert recognise_format(path) == "table"
    tracks = read_any_tracks(path, fps=10.0)
    assert list(tracks["keypoint"].to_numpy()) == ["LF_Claw", "b"]
    assert tracks["frame"].to_numpy().tolist() == [4, 5]
    assert tracks.attrs["units"] == ("px" if axes == "xy" else "mm")
    place = tracks["position"].isel(individual=0)
    assert place.sel(keypoint="LF_Claw").to_numpy().tolist() == [[1.5] * len(axes),
                                                                 [2.5] * len(axes)]  # fmt: skip
    assert np.isnan(place.sel(keypoint="b").to_numpy()[0]).all()
    # written, it has the same cells but for the column that is none of a point
    written = write_wide_table(tracks, tmp_path / "again.csv").read_text().splitlines()
    again = [line.replace(",7", ",7.0") for line in (rows[0], rows[2])]
    assert [written[0], written[2]] == [line.rpartition(",")[0] for line in again]
    path.write_text("frame,a_x,a_y,b_x\n0,1,2,3\n")
    with pytest.raises(InputError, match=r"^points\.csv: column 'b_y' is missing"):
        read_any_tracks(path, fps=10.0)


@pytest.mark.parametrize(
    ("first", "word"), [("frame", "likelihood"), ("", "p"), ("frame", "score")]
)
def test_a_plain_table_keeps_its_confidence(tmp_path, first, word):
    # SimBA's csv: a first column without a name, then x, y and p of every point
    path = tmp_path / "points.csv"
    path.write_text(f"{first},FR_x,FR_y,FR_{word},HR_x,HR_y\n3,1,2,0.25,5,6\n4,1,2,,5,6\n")
    assert recognise_format(path) == "table"
    tracks = read_any_tracks(path, fps=10.0)
    assert tracks["frame"].to_numpy().tolist() == [3, 4]
    told = tracks["confidence"].to_numpy()[..., 0]
    np.testing.assert_array_equal(told, [[0.25, np.nan], [np.nan, np.nan]])


def test_real_claws_of_a_fly_in_a_plain_table(real_data):
    tracks = read_any_tracks(real_data("fly-6leg-contact") / "fly1_pose_aligned.csv", fps=100.0)
    assert tracks.sizes["keypoint"] == 24
    assert tracks.sizes["time"] == 1000
    assert np.isfinite(tracks["position"].sel(keypoint="RH_Claw")).all()
