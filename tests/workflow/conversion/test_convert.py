"""Tracks from one format to another: nothing changes on the way."""

import numpy as np
import pandas as pd
import pytest

from pawnb import cli
from pawnb.cli.arguments import _FORMATS
from pawnb.errors import InputError
from pawnb.io.formats import FORMATS, WRITTEN, read_any_tracks, recognise_format
from pawnb.io.native import read_tracks, write_tracks
from pawnb.schema import POINTS3D_COLUMNS, TRACKS_COLUMNS, make_tracks
from pawnb.workflow.conversion.convert import convert_tracks

DLC = """scorer,net,net,net
bodyparts,FR,FR,FR
coords,x,y,likelihood
0,10.5,20.25,0.9
1,11.5,21.25,0.8
"""
DLTDV = "FR_X,FR_Y,FR_Z\n1.0,2.0,3.0\n4.0,5.0,6.5\n"


@pytest.mark.slow
def test_deeplabcut_to_netcdf_and_table(tmp_path):
    (tmp_path / "clip.csv").write_text(DLC)
    (path,) = convert_tracks(tmp_path / "clip.csv", tmp_path / "tracks.nc", fps=50.0)
    tracks = read_tracks(path)
    assert tracks["position"].to_numpy()[:, :, 0, 0].tolist() == [[10.5, 20.25], [11.5, 21.25]]
    assert tracks.attrs["fps"] == 50.0
    table = pd.read_csv(*convert_tracks(path, tmp_path / "tracks.csv"))
    assert tuple(table.columns) == TRACKS_COLUMNS
    np.testing.assert_allclose(table["u"], [10.5, 11.5])
    np.testing.assert_allclose(table["confidence"], [0.9, 0.8])
    with pytest.raises(InputError, match=r"holds no points in space; write tracks\.csv"):
        convert_tracks(path, tmp_path / "points3d.csv")


def test_points_in_space_to_table(tmp_path):
    (tmp_path / "clip_xyzpts.csv").write_text(DLTDV)
    source = tmp_path / "clip_xyzpts.csv"
    table = pd.read_csv(*convert_tracks(source, tmp_path / "points3d.csv", fps=10.0))
    assert tuple(table.columns) == POINTS3D_COLUMNS
    assert table[["x", "y", "z"]].to_numpy().tolist() == [[1, 2, 3], [4, 5, 6.5]]
    with pytest.raises(InputError, match=r"no points in pictures; write points3d\.csv"):
        convert_tracks(source, tmp_path / "tracks.csv", fps=10.0)
    with pytest.raises(InputError, match=r"tracks\.xyz: not a format that is written"):
        convert_tracks(source, tmp_path / "tracks.xyz", fps=10.0)


@pytest.mark.parametrize(
    ("target", "to", "message"),
    [
        (
            "clip.csv",
            "pawnb",
            r"^clip\.csv: pawnb tracks\.nc is written into \.nc; name the file so",
        ),
        ("clip.nc", "deeplabcut", r"^clip\.nc: DeepLabCut is written into \.csv or \.h5"),
        ("clip_xypts.csv", "anipose", r"^clip_xypts\.csv is what a file of DLTdv xypts is called"),
        ("CollectedData_me.csv", "deeplabcut", "is what a file of DeepLabCut CollectedData is cal"),
        (
            "clip.csv",
            "authors2019",
            r"^clip\.csv: the 2019 authors name a file cam1\.f\.<animal>\.<condition>\.<stamp>",
        ),
        ("clip.csv", "deeplabcat", r"^unknown format 'deeplabcat' \(did you mean 'deeplabcut'"),
        ("clip.h5", None, r"^clip\.h5: .* \.h5 may be of deeplabcut, collected, sleap: say which"),
        ("clip", None, r"^clip: not a format that is written by that name; expected --to and"),
    ],
)
def test_a_name_never_gets_another_formats_content(tmp_path, target, to, message):
    (tmp_path / "clip.csv").write_text(DLC)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match=message) as caught:
        convert_tracks(tmp_path / "clip.csv", tmp_path / target, to=to, fps=50.0)
    assert "\n" not in str(caught.value)
    assert sorted(tmp_path.iterdir()) == before
    assert (tmp_path / "clip.csv").read_text() == DLC


@pytest.mark.parametrize(
    ("target", "program"),
    [("clipDLC_x.csv", "deeplabcut"), ("clipDLC_x.h5", "deeplabcut"), ("a.analysis.h5", "sleap"),
     ("a_xypts.csv", "dltdv"), ("a_xypts.tsv", "dltdv"), ("CollectedData_me.h5", "collected"),
     ("tracks.csv", "csv"), ("any.csv", "csv"), ("any.nc", "pawnb")],
)  # fmt: skip
def test_a_name_that_says_its_format_gets_it(tmp_path, target, program):
    (tmp_path / "in.csv").write_text(DLC)
    (path,) = convert_tracks(tmp_path / "in.csv", tmp_path / target, fps=50.0)
    assert path == tmp_path / target
    assert recognise_format(path) == program


@pytest.mark.slow
def test_each_view_gets_a_file_where_a_format_holds_one(tmp_path, capsys):
    tracks = make_tracks(range(2), ["FR"], fps=50.0, views=["left", "right"])
    tracks["image_position"][:, 0] = 10.0
    tracks["image_position"][:, 1] = 20.0
    tracks["image_origin"][:] = 1
    write_tracks(tracks, tmp_path / "tracks.nc")
    words = [
        "convert",
        str(tmp_path / "tracks.nc"),
        str(tmp_path / "out.csv"),
        "--to",
        "deeplabcut",
    ]
    assert cli.main(words) == 0
    said = capsys.readouterr().out.splitlines()
    assert said == [f"wrote {tmp_path / name}" for name in ("out_left.csv", "out_right.csv")]
    for name, value in (("left", 10.0), ("right", 20.0)):
        own = read_any_tracks(tmp_path / f"out_{name}.csv", fps=50.0)
        assert (own["position"] == value).all()
    assert cli.main([*words, "--view", "right"]) == 0
    assert (read_any_tracks(tmp_path / "out.csv", fps=50.0)["position"] == 20.0).all()
    assert cli.main([*words, "--view", "top"]) == 2
    assert capsys.readouterr().err == (
        "pawnb: no view 'top' in these tracks; there are left, right.\n"
    )


@pytest.mark.slow
def test_one_animal_of_several(tmp_path):
    tracks = make_tracks(range(2), ["FR"], fps=50.0, space=("x", "y", "z"))
    tracks = tracks.isel(individual=[0, 0]).copy(deep=True).assign_coords(individual=["a", "b"])
    tracks["position"][..., 1] = 3.0
    tracks["origin"][..., 1] = 1
    write_tracks(tracks, tmp_path / "tracks.nc")
    with pytest.raises(InputError, match=r"Anipose holds one animal a file, .* a, b; choose one"):
        convert_tracks(tmp_path / "tracks.nc", tmp_path / "p.csv", to="anipose")
    (path,) = convert_tracks(tmp_path / "tracks.nc", tmp_path / "p.csv", to="anipose", animal="b")
    assert (read_any_tracks(path, fps=50.0)["position"] == 3.0).all()
    with pytest.raises(InputError, match="no animal 'c' in these tracks; there are a, b"):
        convert_tracks(tmp_path / "tracks.nc", tmp_path / "p.csv", to="anipose", animal="c")


def test_the_help_names_every_format():
    said = _FORMATS.replace("Formats: ", "").split(". A name")[0]
    both, _, read = said.partition(", and IN also ")
    assert set(both.split(", ")) == set(WRITTEN)
    assert {*both.split(", "), *read.split(", ")} == set(FORMATS)


def test_points_are_called_as_the_legs_they_are_from_here_on(tmp_path, capsys):
    (tmp_path / "clip.csv").write_text(DLC.replace("FR", "paw_3"))
    words = ["convert", str(tmp_path / "clip.csv"), str(tmp_path / "tracks.nc"), "--fps", "50"]
    assert cli.main([*words, "--legs", "HR=paw_3"]) == 0
    tracks = read_tracks(tmp_path / "tracks.nc")
    assert list(tracks["keypoint"].to_numpy()) == ["HR"]
    assert '"legs": {"HR": "paw_3"}' in tracks.attrs["provenance"]
    capsys.readouterr()
    assert cli.main([*words, "--legs", "HR=paw_4"]) == 2
    assert capsys.readouterr().err == (
        "pawnb: clip.csv: no point 'paw_4' (did you mean 'paw_3'?) for leg 'HR'; it has paw_3.\n"
    )
