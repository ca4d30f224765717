"""NWB: what a file says of the program that tracked is kept, as what counts follows from it."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from pawnb.gait.locomotion.foot_trajectories import least_confidence
from pawnb.io.nwb import read_nwb


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
