"""Tracks from one format to another: nothing changes on the way."""

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.io.native import read_tracks
from pawnb.schema import POINTS3D_COLUMNS, TRACKS_COLUMNS
from pawnb.workflow.convert import convert_tracks

DLC = """scorer,net,net,net
bodyparts,FR,FR,FR
coords,x,y,likelihood
0,10.5,20.25,0.9
1,11.5,21.25,0.8
"""
DLTDV = "FR_X,FR_Y,FR_Z\n1.0,2.0,3.0\n4.0,5.0,6.5\n"


def test_deeplabcut_to_netcdf_and_table(tmp_path):
    (tmp_path / "clip.csv").write_text(DLC)
    path = convert_tracks(tmp_path / "clip.csv", tmp_path / "tracks.nc", fps=50.0)
    tracks = read_tracks(path)
    assert tracks["position"].to_numpy()[:, :, 0, 0].tolist() == [[10.5, 20.25], [11.5, 21.25]]
    assert tracks.attrs["fps"] == 50.0
    table = pd.read_csv(convert_tracks(path, tmp_path / "tracks.csv"))
    assert tuple(table.columns) == TRACKS_COLUMNS
    np.testing.assert_allclose(table["u"], [10.5, 11.5])
    np.testing.assert_allclose(table["confidence"], [0.9, 0.8])
    with pytest.raises(InputError, match=r"holds no points in space; write tracks\.csv"):
        convert_tracks(path, tmp_path / "points3d.csv")


def test_points_in_space_to_table(tmp_path):
    (tmp_path / "clip_xyzpts.csv").write_text(DLTDV)
    source = tmp_path / "clip_xyzpts.csv"
    table = pd.read_csv(convert_tracks(source, tmp_path / "points3d.csv", fps=10.0))
    assert tuple(table.columns) == POINTS3D_COLUMNS
    assert table[["x", "y", "z"]].to_numpy().tolist() == [[1, 2, 3], [4, 5, 6.5]]
    with pytest.raises(InputError, match=r"no points in pictures; write points3d\.csv"):
        convert_tracks(source, tmp_path / "tracks.csv", fps=10.0)
    with pytest.raises(InputError, match=r"tracks\.mat: not a format that is written"):
        convert_tracks(source, tmp_path / "tracks.mat", fps=10.0)
