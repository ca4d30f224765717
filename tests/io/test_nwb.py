"""NWB: what a file says of the program that tracked is kept, as what counts follows from it."""

from __future__ import annotations

import importlib

import h5py
import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.gait.locomotion.foot_trajectories import least_confidence
from pawnb.io.formats import read_any_tracks
from pawnb.io.nwb import read_nwb

PLACE = np.random.default_rng(2).uniform(1.0, 90.0, (6, 3))
TIMES_S = np.arange(6) / 100.0


def write(path, *, place=PLACE, times=TIMES_S, start=None, rate=100.0, **told):
    """The layout of ndx-pose: one point, attributes of its data as told."""
    with h5py.File(path, "w") as file:
        file.attrs["nwb_version"] = "2.8.0"
        pose = file.create_group("processing/behavior/PoseEstimation")
        pose.attrs["neurodata_type"] = "PoseEstimation"
        series = pose.create_group("FR")
        series.attrs["neurodata_type"] = "PoseEstimationSeries"
        series["data"] = place
        series["data"].attrs.update(told)
        if start is None:
            series["timestamps"] = times
        else:
            series["starting_time"] = start
            series["starting_time"].attrs["rate"] = rate
    return path


@pytest.mark.parametrize(
    ("told", "wanted", "unit", "factor"),
    [
        ({"unit": "meters"}, None, "m", 1.0), ({"unit": "meters"}, "mm", "mm", 1000.0),
        # NWB: data * conversion + offset is in the unit
        ({"unit": "meters", "conversion": 0.001}, "mm", "mm", 1.0),
        ({"unit": "meters", "conversion": 0.001}, None, "m", 0.001),
        ({"unit": "Micrometers"}, "mm", "mm", 0.001), ({"unit": "cm"}, "mm", "mm", 10.0),
        ({"unit": "BL"}, None, "BL", 1.0),
    ],
)  # fmt: skip
def test_lengths_are_those_of_the_file_in_the_unit_asked_for(tmp_path, told, wanted, unit, factor):
    tracks = read_any_tracks(write(tmp_path / "m.nwb", **told), unit=wanted)
    assert tracks.attrs["units"] == unit
    np.testing.assert_allclose(tracks["position"].to_numpy()[:, :, 0, 0], factor * PLACE)


def test_an_unknown_unit_is_not_put_on_other_lengths(tmp_path):
    with pytest.raises(InputError, match="positions are in 'BL', and 'mm' is asked for"):
        read_nwb(write(tmp_path / "m.nwb", unit="BL"), unit="mm")


def test_poses_of_two_cameras_come_to_a_file_each_by_movement(tmp_path):
    path = write(tmp_path / "two.nwb", place=PLACE[:, :2], unit="pixels")
    with h5py.File(path, "a") as file:
        file.copy("processing/behavior/PoseEstimation", "processing/behavior/side")
    with pytest.raises(
        InputError, match=r'behavior/side\); .*\(FILE, pose_estimation_key="side"\)'
    ):
        read_nwb(path)


@pytest.mark.parametrize("wanted", [None, "cm"])
def test_places_in_space_in_pixels_are_said(tmp_path, wanted):
    # movement writes "pixels" whatever the number of axes
    with pytest.warns(
        InputWarning, match=f"in pixels: lengths are taken to be in {wanted or 'mm'}"
    ):
        tracks = read_nwb(write(tmp_path / "m.nwb", unit="pixels"), unit=wanted)
    assert tracks.attrs["units"] == (wanted or "mm")
    flat = read_nwb(write(tmp_path / "m.nwb", place=PLACE[:, :2], unit="pixels"), unit=wanted)
    assert flat.attrs["units"] == "px"


@pytest.mark.parametrize(
    ("told", "first"),
    [({"start": 12.345}, 0), ({"start": 0.5}, 50), ({"times": np.arange(6) / 100.0 + 987.654}, 0),
     ({"times": np.arange(6) / 100.0 + [0, 1e-3, -8e-4, 5e-4, 0, 0]}, 0)],
)  # fmt: skip
def test_the_clock_of_a_session_may_begin_anywhere_and_jitter(tmp_path, told, first):
    tracks = read_nwb(write(tmp_path / "m.nwb", unit="mm", **told))
    assert tracks["frame"].to_numpy().tolist() == list(range(first, first + 6))
    assert tracks.attrs["fps"] == pytest.approx(100.0)


def test_frames_that_are_left_out_and_another_rate(tmp_path):
    path = write(tmp_path / "m.nwb", unit="mm", times=np.array([0, 1, 2, 5, 6, 7]) / 100.0)
    assert read_nwb(path).sizes["time"] == 8
    with pytest.warns(InputWarning, match="says 100 frames per second, and fps is given as 200"):
        assert read_nwb(path, fps=200.0)["frame"].to_numpy()[-1] == 14
    with pytest.raises(InputError, match="times fall between frames at 250 frames per second"):
        read_nwb(path, fps=250.0)


@pytest.mark.parametrize(
    ("said", "program", "least"), [("DeepLabCut", "DeepLabCut", 0.6), (None, "NWB", 0.0)]
)
def test_the_program_behind_the_file_is_kept(tmp_path, said, program, least):
    """DeepLabCut gives a place in every frame: those of low confidence are none, in NWB as well."""
    with h5py.File(tmp_path / "m.nwb", "w") as file:
        file.attrs["nwb_version"] = "2.8.0"
        pose = file.create_group("processing/behavior/PoseEstimation")
        pose.attrs["neurodata_type"] = "PoseEstimation"
        if said is not None:
            pose["source_software"] = said
        series = pose.create_group("FR")
        series.attrs["neurodata_type"] = "PoseEstimationSeries"
        series["data"] = np.ones((4, 2))
        series["confidence"] = np.full(4, 0.3)
        series["timestamps"] = np.arange(4) / 100.0
    tracks = read_nwb(tmp_path / "m.nwb")
    assert tracks.attrs["source_software"] == program
    assert least_confidence(tracks, None) == least


@pytest.mark.parametrize("told", [{"start": 0.0, "rate": 1.0}, {"times": np.arange(6.0)}])
def test_times_a_second_apart_count_frames(tmp_path, told):
    # movement 0.15: save_poses.to_nwb_file of a dataset without fps writes rate=1.0
    path = write(tmp_path / "m.nwb", unit="mm", **told)
    with pytest.raises(InputError, match=r"time stamps are 1 s apart, as sleap-io .* give fps"):
        read_nwb(path)
    tracks = read_nwb(path, fps=200.0)
    assert tracks["frame"].to_numpy().tolist() == [0, 1, 2, 3, 4, 5]
    assert tracks.attrs["fps"] == 200.0


def test_a_rate_that_is_said_counts_the_frames_also_where_another_one_is_right(tmp_path):
    # a film at 250 frames a second that plays with 30
    path = write(tmp_path / "m.nwb", unit="mm", start=0.0, rate=30.0)
    with pytest.warns(InputWarning, match="says 30 frames per second, and fps is given as 250"):
        tracks = read_nwb(path, fps=250.0)
    assert tracks["frame"].to_numpy().tolist() == [0, 1, 2, 3, 4, 5]
    np.testing.assert_allclose(tracks["position"].to_numpy()[:, :, 0, 0], PLACE)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # of the libraries
@pytest.mark.parametrize(("animals", "told"), [(0, None), (1, None), (2, None), (1, 250.0)])
def test_predictions_that_sleap_io_wrote(tmp_path, animals, told):
    """It leaves out the rows in which a point was not seen, and has poses for each track.

    Told a rate, it takes it for the period (0.9.5): stamps of 0, 250, 500 s, rates of 0.
    """
    sio = pytest.importorskip("sleap_io")
    pytest.importorskip("ndx_pose")
    names = ["FR", "HR", "snout"]
    places = np.random.default_rng(4).uniform(5.0, 90.0, (8, 3, 2))
    places[3:5, 1] = np.nan  # in the middle: its times are stamps, those of the others a rate
    places[0, 2] = np.nan
    skeleton = sio.Skeleton(nodes=list(names), name="mouse")
    shape = {"backend_metadata": {"shape": (8, 100, 100, 1)}}
    video = sio.Video(filename="clip.mp4", **shape)
    tracks = [sio.Track(f"m{k}") for k in range(animals)]
    labels = sio.Labels(
        [
            sio.LabeledFrame(
                video=video,
                frame_idx=i,
                instances=[
                    sio.PredictedInstance.from_numpy(
                        row + k, skeleton=skeleton, point_scores=np.full(3, 0.5 + 0.01 * i),
                        score=0.9, track=track,
                    )
                    for k, track in enumerate(tracks or [None])
                ],
            )
            for i, row in enumerate(places)
        ]
    )  # fmt: skip
    path = str(tmp_path / "clip.nwb")
    if told is None:
        sio.save_nwb(labels, path, nwb_format="predictions")
    else:
        predictions = importlib.import_module("sleap_io.io.nwb_predictions")
        predictions.write_nwb(labels, path, {}, {"video_sample_rate": told})
    read = read_any_tracks(tmp_path / "clip.nwb", fps=250.0)
    assert read["keypoint"].to_numpy().tolist() == names
    assert read["individual"].to_numpy().tolist() == ([t.name for t in tracks] or ["animal"])
    for k in range(animals or 1):
        own = read["position"].isel(individual=k).transpose("time", "keypoint", "space")
        np.testing.assert_allclose(own.to_numpy(), places + k)
    seen = np.isfinite(places[..., 0])
    said = np.where(seen, 0.5 + 0.01 * np.arange(8)[:, None], 0.0)
    np.testing.assert_allclose(read["confidence"].isel(individual=0).to_numpy(), said)
