"""NWB: what a file says of the program that tracked is kept, as what counts follows from it."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.gait.locomotion.foot_trajectories import least_confidence
from pawnb.io.formats import read_any_tracks
from pawnb.io.nwb import read_nwb

PLACE = np.random.default_rng(2).uniform(1.0, 90.0, (6, 3))
TIMES_S = np.arange(6) / 100.0


def write(path, *, place=PLACE, times=TIMES_S, start=None, **told):
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
            series["starting_time"].attrs["rate"] = 100.0
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
