"""Frame numbers of every format count: deleted rows are a gap in time, not a shorter recording."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from foreign_files import FPS, WRITERS, place, write_analysis_h5, write_dlc_csv, write_tracks_csv

from pawnb.errors import InputError
from pawnb.io.belt import read_belt_speed
from pawnb.io.formats import read_any_tracks
from pawnb.io.native import read_tracks, write_tracks
from pawnb.schema import ORIGIN_CODE, absent_frames, check_frames

FORMATS = sorted(WRITERS)
IN_ANY_ORDER = {"sleap slp"}
"""Labels are kept in the order in which a person made them."""


def written(kind, folder, frames):
    name, write = WRITERS[kind]
    return write(folder / name, list(frames))


@pytest.mark.parametrize("kind", FORMATS)
def test_deleted_rows_are_a_gap_at_the_right_times(tmp_path, kind):
    frames = [*range(7, 20), *range(26, 41)]
    tracks = read_any_tracks(written(kind, tmp_path, frames), fps=FPS)
    assert tracks["frame"].to_numpy().tolist() == list(range(7, 41))
    np.testing.assert_allclose(tracks["time"], np.arange(7, 41) / FPS)
    prefix = "image_" if "view" in tracks.dims else ""
    position = tracks[f"{prefix}position"].isel(individual=0)
    origin = tracks[f"{prefix}origin"].isel(individual=0)
    gap = (tracks["frame"] >= 20) & (tracks["frame"] < 26)
    assert np.isnan(position[gap]).all()
    assert (origin[gap] == ORIGIN_CODE["missing"]).all()
    assert (origin[~gap] == ORIGIN_CODE["measured"]).all()
    # a point tells by its place which frame it is of
    first = position.sel(keypoint=tracks["keypoint"][0].item())
    first = first.isel({dim: 0 for dim in ("view", "space", "image_space") if dim in first.dims})
    shift = 1.0 if kind == "dltdv views" else 0.0  # counted from pixel 1
    np.testing.assert_allclose(first[~gap], [place(i, 0, "x") - shift for i in frames])
    ((start, end, _),) = absent_frames(tracks)
    assert (start, end) == (20, 25)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_frame_given_twice_is_one_sentence(tmp_path, kind):
    path = written(kind, tmp_path, [0, 1, 2, 3, 3, 4])
    with pytest.raises(InputError, match=r"frame 3.* is there twice") as caught:
        read_any_tracks(path, fps=FPS)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", FORMATS)
def test_frames_out_of_order_are_one_sentence(tmp_path, kind):
    path = written(kind, tmp_path, [0, 1, 4, 3, 5])
    if kind in IN_ANY_ORDER:
        tracks = read_any_tracks(path, fps=FPS)
        np.testing.assert_allclose(
            tracks["position"].sel(keypoint="FR", space="x")[:, 0],
            [100.0, 101.0, np.nan, 103.0, 104.0, 105.0],
        )
        return
    with pytest.raises(InputError, match=r"frame 3 .*comes after .*; sort the rows by frame"):
        read_any_tracks(path, fps=FPS)


def test_a_table_of_points_may_be_sorted_by_point(tmp_path):
    lines = write_tracks_csv(tmp_path / "tracks.csv", range(4)).read_text().splitlines()
    (tmp_path / "by_point.csv").write_text(
        "\n".join([lines[0], *sorted(lines[1:], key=lambda x: x.split(",")[2])]) + "\n"
    )
    one = read_any_tracks(tmp_path / "tracks.csv", fps=FPS)
    two = read_any_tracks(tmp_path / "by_point.csv", fps=FPS)
    np.testing.assert_array_equal(one["position"], two["position"])


def test_every_second_frame_is_no_recording_full_of_gaps(tmp_path):
    tracks = read_any_tracks(write_dlc_csv(tmp_path / "c.csv", range(10, 30, 2)), fps=FPS)
    assert tracks["frame"].to_numpy().tolist() == list(range(10, 30, 2))
    assert absent_frames(tracks) == []


def test_rows_of_an_analysis_file_are_its_frames(tmp_path):
    # SLEAP writes a row for every frame of the video, empty where nothing was found
    frames = [0, 1, 2, 6, 7]
    tracks = read_any_tracks(write_analysis_h5(tmp_path / "a.h5", frames), fps=FPS)
    assert tracks["frame"].to_numpy().tolist() == list(range(8))
    seen = np.isfinite(tracks["position"].sel(keypoint="FR", space="x")[:, 0])
    assert np.flatnonzero(seen).tolist() == frames


def test_what_was_absent_is_known_after_a_journey_through_netcdf(tmp_path):
    tracks = read_any_tracks(write_dlc_csv(tmp_path / "c.csv", [0, 1, 4, 5]), fps=FPS)
    write_tracks(tracks, tmp_path / "tracks.nc")
    assert absent_frames(read_tracks(tmp_path / "tracks.nc")) == [(2, 3, "c.csv")]


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("9e18", "a whole number up to 1,000,000,000"),
        ("1.5", "a whole number"),
        ("", "a whole number"),
        ("nan", "a whole number"),
        ("one", "a whole number"),
        ("1e9", "2 rows span|3 rows span"),
    ],
)
@pytest.mark.parametrize("kind", ["deeplabcut csv", "wide table", "anipose", "tracks.csv"])
def test_a_frame_that_is_none_is_one_sentence(tmp_path, kind, cell, message):
    path = written(kind, tmp_path, [0, 1, 2])
    lines = path.read_text().splitlines()
    n = 2 if kind == "tracks.csv" else 1
    lines[-n:] = [",".join([cell, *line.split(",")[1:]]) for line in lines[-n:]]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=message):
        read_any_tracks(path, fps=FPS)


def test_frames_of_a_belt_are_no_million_years(tmp_path):
    (tmp_path / "belt.csv").write_text("frame,speed\n0,300\n9e18,300\n")
    with pytest.raises(InputError, match="line 3, column 'frame' is '9e18'; expected a whole"):
        read_belt_speed(tmp_path / "belt.csv")


def test_frames_of_a_sleap_file_are_checked_too(tmp_path):
    path = written("sleap slp", tmp_path, [0, 1, 2])
    with h5py.File(path, "a") as file:
        frames = file["frames"][()]
        frames["frame_idx"][2] = 2**62
        del file["frames"]
        file["frames"] = frames
    with pytest.raises(InputError, match="is of frame 4611686018427387904; expected a whole"):
        read_any_tracks(path, fps=FPS)


def test_numbers_are_counted_in_words():
    with pytest.raises(InputError, match=r"^f: frame 1 is there twice; keep one row a frame\.$"):
        check_frames([0, 1, 1], where="f")
    with pytest.raises(InputError, match=r"^f: frame 1 is there twice, and 2 more frames are"):
        check_frames([0, 1, 1, 2, 2, 3, 3], where="f")
    with pytest.raises(InputError, match=r"^f: no frames"):
        check_frames([], where="f")
    assert check_frames([-3, 0, 5], where="f").tolist() == [-3, 0, 5]
