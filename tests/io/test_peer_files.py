"""Files of other programs' own libraries, read, and written so that they read them again.

The folder peer-files holds one recording of known formulas, written by pandas (as DeepLabCut
does), sleap-io, movement, pynwb, aniposelib and ezc3d; others are in the layouts of DLTdv 8 and
Argus.
"""

from __future__ import annotations

import importlib
import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from peer_tracks import FPS, LOST, POINTS, N, largest_error, places, true_uv
from scipy.io import loadmat

from pawnb import load_tracks
from pawnb.errors import InputError
from pawnb.io.formats import recognise_format, write_any_tracks
from pawnb.schema import ORIGIN_CODE

IN_PX = {
    "dlc_single.csv": ("deeplabcut", 1),
    "dlc_single.h5": ("deeplabcut", 1),
    "dlc_multi.csv": ("deeplabcut", 2),
    "dlc_multi.h5": ("deeplabcut", 2),
    "sleap.slp": ("sleap", 2),
    "sleap.analysis.h5": ("sleap", 2),
    "sleap.csv": ("sleap", 2),
    "movement_0.nwb": ("nwb", 1),
}


@pytest.fixture
def peers(real_data):
    return real_data("peer-files")


@pytest.mark.parametrize("name", IN_PX)
def test_every_file_holds_the_one_recording(peers, name):
    program, n_animals = IN_PX[name]
    assert recognise_format(peers / name) == program
    tracks = load_tracks(peers / name, fps=FPS)
    assert tracks.sizes["individual"] == n_animals
    found = places(tracks)
    for animal in range(n_animals):
        # SLEAP keeps double precision in its files, and so does every other
        assert largest_error(found[:, :, animal], true_uv(animal)) < 1e-9


@pytest.mark.parametrize("name", IN_PX)
@pytest.mark.parametrize(
    ("program", "target"),
    [
        ("deeplabcut", "out.csv"),
        ("deeplabcut", "out.h5"),
        ("sleap", "out.csv"),
        ("sleap", "out.h5"),
        ("movement", "out.nc"),
        ("pawnb", "out.nc"),
        ("csv", "tracks.csv"),
        ("table", "out.csv"),
    ],
)
def test_what_a_format_can_hold_comes_back_unchanged(peers, tmp_path, name, program, target):
    tracks = load_tracks(peers / name, fps=FPS)
    if program in ("csv", "table") and tracks.sizes["individual"] > 1:
        return  # of one animal
    (path,) = write_any_tracks(tracks, tmp_path / target, program=program)
    assert recognise_format(path) == program
    again = load_tracks(path, fps=FPS)
    # tracks.csv is rounded; a plain table has no confidence
    for variable in ("position", "origin", "confidence")[: 2 if program == "table" else 3]:
        off = 1e-4 if program == "csv" else 0
        np.testing.assert_allclose(again[variable], tracks[variable], rtol=0, atol=off)
    assert list(again["keypoint"].to_numpy()) == list(tracks["keypoint"].to_numpy())
    if tracks.sizes["individual"] > 1:
        assert list(again["individual"].to_numpy()) == list(tracks["individual"].to_numpy())


def known_only(frame):
    """A DataFrame of DeepLabCut without the likelihood of points that have no place."""
    frame = frame.copy()
    levels = list(range(frame.columns.nlevels - 1))
    frame[frame.isna().T.groupby(level=levels).transform("any").T] = np.nan
    return frame


@pytest.mark.parametrize("kind", ["single", "multi"])
def test_pandas_reads_our_h5_as_it_reads_that_of_deeplabcut(peers, tmp_path, kind):
    pytest.importorskip("tables")
    theirs = peers / f"dlc_{kind}.h5"
    (ours,) = write_any_tracks(load_tracks(theirs, fps=FPS), tmp_path / "clipDLC.h5")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found, expected = (pd.read_hdf(path, key="df_with_missing") for path in (ours, theirs))
    pd.testing.assert_frame_equal(found, known_only(expected), check_freq=False)


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_labels_for_training_come_back_unchanged(tmp_path, ending):
    pytest.importorskip("tables")
    columns = pd.MultiIndex.from_product(
        [["ann"], ["FR", "HR"], ["x", "y"]], names=["scorer", "bodyparts", "coords"]
    )
    rows = pd.MultiIndex.from_tuples(
        [("labeled-data", "clip", f"img{k:04d}.png") for k in (3, 17, 250)]
    )
    values = np.random.default_rng(2).uniform(0, 300, (3, 4))
    values[1, 2:] = np.nan
    table = pd.DataFrame(values, columns=columns, index=rows)
    path = tmp_path / f"CollectedData_ann{ending}"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if ending == ".csv":
            table.to_csv(path)
        else:
            table.to_hdf(path, key="df_with_missing", mode="w")
    assert recognise_format(path) == "collected"
    tracks = load_tracks(path, fps=FPS)
    known = (tracks["origin"] == ORIGIN_CODE["measured"]).any(["keypoint", "individual"])
    assert tracks["frame"].to_numpy()[known].tolist() == [3, 17, 250]
    (tmp_path / "out").mkdir()
    (again,) = write_any_tracks(tracks, tmp_path / "out" / path.name)
    if ending == ".csv":
        assert again.read_text() == path.read_text()
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pd.testing.assert_frame_equal(pd.read_hdf(again), table)


def test_labels_are_not_taken_for_predictions(tmp_path):
    path = tmp_path / "labels.csv"
    path.write_text("scorer,a,a\nbodyparts,FR,FR\ncoords,x,y\nlabeled-data/a/img1.png,1,2\n"
                    "labeled-data/b/img1.png,1,2\n")  # fmt: skip
    assert recognise_format(path) == "collected"
    with pytest.raises(InputError, match=r"labels of labeled-data/a, labeled-data/b; expected"):
        load_tracks(path, fps=FPS)


@pytest.mark.slow
def test_sleap_io_reads_what_we_write(peers, tmp_path):
    sio = pytest.importorskip("sleap_io")
    tracks = load_tracks(peers / "sleap.slp", fps=FPS)
    for ending in (".slp", ".analysis.h5", ".csv"):
        (path,) = write_any_tracks(tracks, tmp_path / f"clip{ending}", program="sleap")
        labels = sio.load_file(str(path)) if ending != ".csv" else sio.load_csv(str(path))
        names = [node.name for node in labels.skeleton.nodes]
        found = labels.numpy()[:, :, [names.index(point) for point in POINTS]]
        for animal in range(2):
            # labels.numpy() is in single precision
            assert largest_error(found[:, animal], true_uv(animal)) < 5e-5


@pytest.mark.slow
def test_the_video_and_the_skeleton_of_a_slp_are_written_back(tmp_path):
    sio = pytest.importorskip("sleap_io")
    skeleton = sio.Skeleton(nodes=["FR", "tail", "nose"], edges=[("nose", "tail"), ("tail", "FR")])
    video = sio.Video(filename="films/clip.mp4", open_backend=False)
    instance = sio.PredictedInstance.from_numpy(
        np.array([[5.0, 6.0], [1.0, 2.0], [3.0, 4.0]]), skeleton=skeleton, score=0.5
    )
    frame = sio.LabeledFrame(video=video, frame_idx=7, instances=[instance])
    sio.save_slp(sio.Labels([frame]), str(tmp_path / "a.slp"), embed=False, verbose=False)
    tracks = load_tracks(tmp_path / "a.slp", fps=FPS)
    (path,) = write_any_tracks(tracks, tmp_path / "b.slp", program="sleap")
    labels = sio.load_slp(str(path), open_videos=False)
    assert labels.video.filename == "films/clip.mp4"
    edges = [(edge.source.name, edge.destination.name) for edge in labels.skeleton.edges]
    assert edges == [("nose", "tail"), ("tail", "FR")]
    assert labels[0].frame_idx == 7


def test_points_of_movement_have_the_names_that_a_person_gave(peers):
    """What sleap-io read into movement says Node(name='FR'); its values stay."""
    tracks = load_tracks(peers / "movement.nc")
    assert list(tracks["keypoint"].to_numpy()) == list(POINTS)
    assert largest_error(places(tracks)[:, :, 0], true_uv(0)) < 1e-9


def test_movement_reads_and_exports_what_we_write(peers, tmp_path):
    pytest.importorskip("movement")
    dataset = xr.load_dataset(peers / "movement.nc", engine="h5netcdf")
    (path,) = write_any_tracks(
        load_tracks(peers / "movement.nc"), tmp_path / "clip.nc", program="movement"
    )
    own = xr.load_dataset(path, engine="h5netcdf")
    assert own["position"].dims == dataset["position"].dims
    np.testing.assert_array_equal(own["position"], dataset["position"])
    np.testing.assert_array_equal(own["time"], dataset["time"])
    assert float(own.attrs["fps"]) == FPS
    assert own.attrs["ds_type"] == "poses"


@pytest.mark.slow
def test_nwb_comes_back_with_subject_rate_and_provenance(peers, tmp_path):
    pynwb = pytest.importorskip("pynwb")
    pytest.importorskip("ndx_pose")
    tracks = load_tracks(peers / "movement_0.nwb")
    assert tracks.attrs["fps"] == FPS
    tracks.attrs["provenance"] = '{"steps": [{"step": "track"}]}'
    (path,) = write_any_tracks(tracks, tmp_path / "clip.nwb")
    again = load_tracks(path)
    np.testing.assert_array_equal(again["position"], tracks["position"])
    np.testing.assert_array_equal(again["confidence"], tracks["confidence"])
    assert again.attrs == tracks.attrs
    with pynwb.NWBHDF5IO(str(path), "r") as io:
        nwb = io.read()
        assert nwb.subject.subject_id == "a"
        pose = nwb.processing["behavior"]["PoseEstimation"]
        assert list(pose.skeleton.nodes[:]) == list(POINTS)
        np.testing.assert_array_equal(pose["FL"].data[:], places(tracks)[:, 2, 0])


def test_anipose_keeps_errors_cameras_and_scores(peers, tmp_path):
    tracks = load_tracks(peers / "anipose_3d.csv", fps=FPS)
    assert list(tracks["keypoint"].to_numpy()) == list(POINTS)  # not Node(name='FR')
    xyz = np.concatenate([true_uv() / 10, np.full((N, 4, 1), 5.0)], axis=-1)
    assert largest_error(places(tracks)[:, :, 0], xyz) < 1e-12
    assert set(tracks["residual"].to_numpy().ravel()) == {0.4}
    assert set(tracks["n_views"].to_numpy().ravel()) == {3.0}
    (path,) = write_any_tracks(tracks, tmp_path / "pose.csv", program="anipose")
    xr.testing.assert_identical(load_tracks(path, fps=FPS), tracks)
    theirs, ours = pd.read_csv(peers / "anipose_3d.csv"), pd.read_csv(path)
    theirs.columns = theirs.columns.str.replace(r"Node\(name='(..)'\)", r"\1", regex=True)
    # half a place is none, and what has no place has no score
    theirs.loc[LOST.start : LOST.stop - 1, ["HR_z", "HR_score"]] = np.nan
    pd.testing.assert_frame_equal(ours, theirs, check_dtype=False)


@pytest.mark.parametrize("ending", [".csv", ".tsv"])
def test_dltdv_points_full_and_sparse(peers, tmp_path, ending):
    full = load_tracks(peers / "dv8_xypts.csv", fps=FPS)
    sparse = load_tracks(peers / "dv8_sparse_xypts.tsv", fps=FPS)
    assert recognise_format(peers / "dv8_sparse_xypts.tsv") == "dltdv"
    # the sparse file has six decimals
    np.testing.assert_allclose(sparse["image_position"], full["image_position"], atol=6e-7)
    assert sparse["image_origin"].equals(full["image_origin"])
    (path,) = write_any_tracks(full, tmp_path / f"clip_xypts{ending}")
    again = load_tracks(path, fps=FPS)
    np.testing.assert_allclose(again["image_position"], full["image_position"], atol=1e-12)
    space = load_tracks(peers / "dv8_xyzpts.csv", fps=FPS)
    xyz = np.concatenate([(true_uv() - 300) / 10, np.zeros((N, 4, 1))], axis=-1)
    assert largest_error(places(space, [f"pt{k}" for k in range(1, 5)])[:, :, 0], xyz) < 1e-12
    (path,) = write_any_tracks(space, tmp_path / f"clip_xyzpts{ending}")
    np.testing.assert_array_equal(load_tracks(path, fps=FPS)["position"], space["position"])


def test_dltdv_7_counts_upwards_and_argus_from_another_corner(peers, tmp_path):
    down = load_tracks(peers / "dv8_xypts.csv", fps=FPS)
    argus = load_tracks(peers / "argus-xypts.csv", fps=FPS, heights_px=[1024])
    # the same points in the two layouts (README.md of peer-files)
    np.testing.assert_allclose(argus["image_position"], down["image_position"], atol=1e-9)
    (path,) = write_any_tracks(argus, tmp_path / "clip-xypts.csv", heights_px=[1024])
    assert recognise_format(path) == "argus"
    pd.testing.assert_frame_equal(
        pd.read_csv(path), pd.read_csv(peers / "argus-xypts.csv"), rtol=0, atol=1e-9
    )
    (path,) = write_any_tracks(down, tmp_path / "old_xypts.csv", heights_px=[1024])
    again = load_tracks(path, fps=FPS, heights_px=[1024, 1024])
    np.testing.assert_allclose(again["image_position"], down["image_position"], atol=1e-9)
    assert not np.allclose(
        load_tracks(path, fps=FPS)["image_position"], down["image_position"], equal_nan=True
    )
    with pytest.raises(InputError, match=r"Argus counts v upwards .* give the height"):
        load_tracks(peers / "argus-xypts.csv", fps=FPS)


def test_markers_of_xmalab_keep_their_frames(tmp_path):
    """As Trial::save3dPoints of XMALab's source writes frames 11 to 13, counted from 1."""
    text = "Frame,FR_X,FR_Y,FR_Z,HR_X,HR_Y,HR_Z\n11,1.25,2,3,4,5,6\n12,NaN,NaN,NaN,4,5,6.5\n"
    (tmp_path / "markers.csv").write_text(text + "13,1.5,2,3,4,5,7\n")
    tracks = load_tracks(tmp_path / "markers.csv", fps=FPS)
    assert tracks["frame"].to_numpy().tolist() == [10, 11, 12]
    assert tracks["keypoint"].to_numpy().tolist() == ["FR", "HR"]
    x = tracks["position"].sel(keypoint="FR", space="x").to_numpy()[:, 0]
    np.testing.assert_array_equal(x, [1.25, np.nan, 1.5])


@pytest.mark.slow
def test_offsets_and_residuals_of_dltdv_travel_with_the_points(real_data, tmp_path):
    folder = real_data("salticid-4cam-dlt")
    space = load_tracks(folder / "1864_1x_xyzpts.csv", fps=FPS)
    theirs = pd.read_csv(folder / "1864_1x_xyzres.csv").to_numpy()[:, 1:]
    has_row = np.isin(space["frame"], pd.read_csv(folder / "1864_1x_xyzpts.csv")["frame0"])
    np.testing.assert_array_equal(space["dltres"].to_numpy()[has_row, :, 0], theirs)
    write_any_tracks(space, tmp_path / "clip_xyzpts.csv")
    again = load_tracks(tmp_path / "clip_xyzpts.csv", fps=FPS).isel(time=space["frame"].to_numpy())
    for name in ("position", "dltres"):
        np.testing.assert_array_equal(again[name], space[name])
    image = load_tracks(folder / "1864_1x_xypts.csv", fps=FPS)
    image["view_offset"][:, 1] = 7.0
    write_any_tracks(image, tmp_path / "clip_xypts.csv")
    offsets = pd.read_csv(tmp_path / "clip_offsets.csv")
    assert offsets.iloc[42].tolist() == [0.0, 7.0, 0.0, 0.0]


def test_locomouse_holds_paws_in_two_views(real_data):
    folder = real_data("mouse-locomouse")
    path = next(folder.glob("*.mat"))
    assert recognise_format(path) == "locomouse"
    tracks = load_tracks(path, fps=400.0)
    table = pd.read_csv(folder / "tracks.csv")  # the same numbers, counted from 1
    for point in ("FR", "HR", "FL", "HL", "snout"):
        for view, axis, column in (
            ("bottom", "u", "x"), ("bottom", "v", "y_bottom"), ("side", "v", "z_side"),
        ):  # fmt: skip
            own = tracks["image_position"].sel(keypoint=point, view=view, image_space=axis)
            expected = table[f"{point}_{column}"].to_numpy() - 1
            known = np.isfinite(own.to_numpy()[:, 0])
            np.testing.assert_array_equal(own.to_numpy()[known, 0], expected[known])
            assert known.sum() > 0.8 * np.isfinite(expected).sum()


def test_locomouse_both_ways(real_data, tmp_path):
    theirs = next(real_data("mouse-locomouse").glob("*.mat"))
    tracks = load_tracks(theirs, fps=400.0)
    (path,) = write_any_tracks(tracks, tmp_path / "clip.mat")
    assert recognise_format(path) == "locomouse"
    for name in ("image_position", "image_origin"):
        xr.testing.assert_equal(load_tracks(path, fps=400.0)[name], tracks[name])
    # MATLAB's own arrays, as scipy reads them; x of a point that no view has is nobody's
    before, after = (loadmat(p, variable_names=["final_tracks"]) for p in (theirs, path))
    old, new = before["final_tracks"], after["final_tracks"]
    lost = np.isnan(old).any(axis=0)
    np.testing.assert_array_equal(new[:, ~lost], old[:, ~lost])
    write_any_tracks(tracks, tmp_path / "again.mat")
    assert (tmp_path / "again.mat").read_bytes() == path.read_bytes()
    apart = tracks.copy(deep=True)
    apart["image_position"].loc[{"view": "side", "image_space": "u"}] += 2.0
    with pytest.raises(InputError, match="share x, and here they are up to 2 px apart"):
        write_any_tracks(apart, tmp_path / "b.mat")
    called = tracks.assign_coords(view=["bottom", "left"])
    with pytest.raises(InputError, match="has the views bottom and side, and these tracks have"):
        write_any_tracks(called, tmp_path / "b.mat")
    points = ["ear" if p == "snout" else str(p) for p in tracks["keypoint"].to_numpy()]
    with pytest.raises(InputError, match="LocoMouse has no point 'ear'"):
        write_any_tracks(tracks.assign_coords(keypoint=points), tmp_path / "b.mat")


def test_c3d_both_ways(peers, tmp_path):
    assert recognise_format(peers / "pts.c3d") == "c3d"
    pytest.importorskip("c3d")
    tracks = load_tracks(peers / "pts.c3d")
    assert (tracks.attrs["fps"], tracks.attrs["units"]) == (FPS, "mm")
    xyz = np.concatenate([(true_uv() - 300) / 10, np.zeros((N, 4, 1))], axis=-1)
    assert largest_error(places(tracks)[:, :, 0], xyz) < 1e-5  # single precision
    (path,) = write_any_tracks(tracks, tmp_path / "clip.c3d")
    xr.testing.assert_identical(load_tracks(path), tracks)


def test_whoever_lacks_a_library_is_told_its_name(tmp_path, monkeypatch, peers):
    real = importlib.import_module

    def without(name, *more):
        if name.split(".")[0] in ("sleap_io", "pynwb", "c3d"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return real(name, *more)

    monkeypatch.setattr(importlib, "import_module", without)
    tracks = load_tracks(peers / "dlc_single.csv", fps=FPS)
    for ending, extra in ((".slp", "sleap"), (".nwb", "nwb")):
        with pytest.raises(InputError, match=rf'pip install "pawnb\[{extra}\]"'):
            write_any_tracks(tracks, tmp_path / f"clip{ending}")
    with pytest.raises(InputError, match=r"c3d is needed to read pts.c3d and is not installed"):
        load_tracks(peers / "pts.c3d")


def test_a_trial_of_the_2019_authors_is_found_by_one_of_its_files(real_data):
    folder = real_data("rat-4cam-tracks")
    path = next(folder.glob("cam1.f.*2018-06-08_13_29_13.csv"))
    assert recognise_format(path) == "authors2019"
    tracks = load_tracks(path, fps=250.0)
    assert list(tracks["view"].to_numpy()) == ["cam1", "cam2", "cam3", "cam4"]
    assert tracks.sizes["keypoint"] == 16
