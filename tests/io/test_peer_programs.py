"""What DLTdv and Argus themselves write is read, and what pawnb writes is what they open.

The layouts are those of their sources: DLTdv7.m (``sparseSave`` and the titles that it is given,
and the four files that "load points" opens together) and Argus 2.1's argus-click (``loadCSV``,
``loadPoints``). Where the programs are at hand (``$PAWNB_PEER_PROGRAMS``, see
benchmarks/format_programs.py), their own lines write and read.
"""

from __future__ import annotations

import importlib
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from peer_tracks import FPS

from pawnb import load_tracks
from pawnb.errors import InputError
from pawnb.io.formats import recognise_format, write_any_tracks
from pawnb.io.points import build_tracks

# two points in two cameras, of which the second is not digitised in frame 2
XY = np.array([[[10.0, 20.0], [30.0, 40.0]], [[11.0, 21.0], [31.0, 41.0]]])


def write_sparse(path: Path, title: str, values: np.ndarray) -> Path:
    """Write as ``sparseSave`` does: by columns, what is not 0, six decimals."""
    cells = [(i + 1, j + 1, values[i, j]) for j in range(values.shape[1])
             for i in range(len(values)) if values[i, j]]  # fmt: skip
    lines = [title, f"{values.shape[0]}\t{values.shape[1]}\t{len(cells)}"]
    path.write_text("\n".join([*lines, *(f"{i}\t{j}\t{v:.6f}" for i, j, v in cells)]) + "\n")
    return path


@pytest.fixture
def sparse(tmp_path):
    xy = np.array([[10.0, 20, 30, 40, 50, 60, 70, 80], [11.0, 21, 31, 41, 0, 0, 0, 0]])
    return write_sparse(tmp_path / "clip_xypts.tsv", "Sparse format camera coordinates file", xy)


def positions(tracks, name="image_position"):
    axis = "image_space" if name == "image_position" else "space"
    order = ("time", "keypoint", *(("view",) if name == "image_position" else ()), axis)
    return tracks[name].isel(individual=0).transpose(*order).to_numpy()


@pytest.mark.parametrize("kind", ["offsets", "xyzres", "xyzpts"])
def test_sparse_files_of_dltdv_have_a_title_and_no_names(sparse, tmp_path, kind):
    title, n = {"offsets": ("camera offsets", 2), "xyzres": ("3D triangulation residuals", 2),
                "xyzpts": ("3D coordinates", 6)}[kind]  # fmt: skip
    values = np.full((2, n), 3.5)
    other = write_sparse(tmp_path / f"clip_{kind}.tsv", f"Sparse format {title} file", values)
    assert recognise_format(sparse) == "dltdv"
    tracks = load_tracks(sparse, fps=FPS)
    assert tracks["keypoint"].to_numpy().tolist() == ["pt1", "pt2"]
    expected = np.array([[[[9, 19], [29, 39]], [[49, 59], [69, 79]]],
                         [[[10, 20], [30, 40]], np.full((2, 2), np.nan)]])  # fmt: skip
    np.testing.assert_array_equal(positions(tracks), expected)
    if kind == "xyzpts":
        assert recognise_format(other) == "dltdv-3d"
        space = load_tracks(other, fps=FPS)
        np.testing.assert_array_equal(positions(space, "position"), np.full((2, 2, 3), 3.5))


def test_a_point_of_a_sparse_file_that_lies_on_an_axis_is_there(tmp_path):
    values = np.array([[1.5, 2.5, 0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 4.0, 5.0, 6.0]])
    file = write_sparse(tmp_path / "c_xyzpts.tsv", "Sparse format 3D coordinates file", values)
    space = positions(load_tracks(file, fps=FPS), "position")
    np.testing.assert_array_equal(space[:, 0], [[1.5, 2.5, 0.0], [1.0, 0.0, 0.0]])
    # of the other one nothing is there in the first frame: it was not digitised
    np.testing.assert_array_equal(space[:, 1], [[np.nan] * 3, [4.0, 5.0, 6.0]])


def test_a_sparse_file_alone_does_not_say_its_cameras(sparse):
    with pytest.raises(InputError, match=r"put the clip_offsets\.tsv that DLTdv wrote with it"):
        load_tracks(sparse, fps=FPS)


@pytest.mark.parametrize("ending", ["csv", "tsv"])
def test_dltdv_opens_four_files_together(tmp_path, ending):
    """``dlmread`` and ``sparseRead`` fail where one of them is missing."""
    tracks = build_tracks(
        np.arange(2), XY[:, None, :, None], points=["FR", "HR"], fps=FPS, unit="px",
        program="pawnb", where="test", views=["cam1"],
    )  # fmt: skip
    path = tmp_path / f"clip_xypts.{ending}"
    kept = tmp_path / f"clip_xyzres.{ending}"
    kept.write_text("what DLTdv wrote")
    write_any_tracks(tracks, path)
    assert {p.name for p in tmp_path.iterdir()} == {
        f"clip_{kind}.{ending}" for kind in ("xypts", "xyzpts", "xyzres", "offsets")
    }
    assert kept.read_text() == "what DLTdv wrote"
    assert set(load_tracks(path, fps=FPS)["view_offset"].to_numpy().ravel()) == {0.0}
    n_rows = {"csv": "\nNaN", "tsv": "2\t6\t0"}[ending]
    assert n_rows in (tmp_path / f"clip_xyzpts.{ending}").read_text()


def test_argus_opens_columns_by_their_place_sorted_by_name(tmp_path):
    tracks = build_tracks(
        np.arange(2), XY[:, None, :, None], points=["hind_R", "fore_R"], fps=FPS, unit="px",
        program="pawnb", where="test", views=["cam1"],
    )  # fmt: skip
    (path,) = write_any_tracks(tracks, tmp_path / "clip-xypts.csv", heights_px=[100])
    table = pd.read_csv(path)
    # ``st.split('_')[0]`` is the name of a track, ``sorted(trackList).index(track)`` its columns
    assert list(table) == ["fore-R_cam_1_x", "fore-R_cam_1_y", "hind-R_cam_1_x", "hind-R_cam_1_y"]
    assert table.iloc[0].tolist() == [30.0, 60.0, 10.0, 80.0]
    alike = tracks.assign_coords(keypoint=["fore_R", "fore-R"])
    with pytest.raises(InputError, match="'fore_R', 'fore-R' are one name"):
        write_any_tracks(alike, tmp_path / "b-xypts.csv", heights_px=[100])


@pytest.mark.slow
@pytest.mark.parametrize("word", ["dltdv 7", "argus"])
def test_the_programs_themselves(tmp_path, monkeypatch, word):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "benchmarks"))
    formats = importlib.import_module("formats")
    programs = importlib.import_module("format_programs")
    if word == "dltdv 7" and shutil.which("octave-cli") is None:
        pytest.skip("Octave is not installed")
    n = 0
    for name, _, check in formats.ROWS:
        if not name.lower().startswith(word):
            continue
        n += 1
        (tmp_path / str(n)).mkdir()
        try:
            read, write = check(tmp_path / str(n))
        except programs.NoProgramError as missing:
            pytest.skip(f"{missing.name} is not in $PAWNB_PEER_PROGRAMS")
        assert float(read) < 1e-6, name  # six decimals
        # Argus keeps what it opens in half precision: a quarter of a pixel from 256 px on
        assert float(write.split()[0]) <= (0.125 if name == "Argus xypts" else 1e-6), name
    assert n >= 3
