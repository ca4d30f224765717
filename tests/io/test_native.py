"""tracks.nc without loss, csv exports and back, the belt's speed."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pawnb.errors import InputError, InputWarning
from pawnb.io import native, track_tables
from pawnb.io.belt import read_belt_speed
from pawnb.schema import (
    ORIGIN_CODE,
    ORIGINS,
    POINTS3D_COLUMNS,
    TRACKS_COLUMNS,
    add_provenance,
    make_tracks,
)


def example(n=6, *, individuals=("m07",), seed=0):
    """Two views; FR in cam1 only, FL in cam2 only, nose in both; frame 3 of nose is missing."""
    rng = np.random.default_rng(seed)
    tracks = make_tracks(
        np.arange(10, 10 + n), ["FR", "FL", "nose"], fps=250.0, views=["cam1", "cam2"], unit="mm"
    )
    if len(individuals) > 1:
        tracks = tracks.isel(individual=[0] * len(individuals)).copy(deep=True)
    tracks = tracks.assign_coords(individual=list(individuals))
    seen = np.array([[1, 0, 1], [0, 1, 1]])  # view, point
    shape = tracks["image_origin"].shape
    code = np.broadcast_to(seen[None, :, :, None], shape).copy()
    code[1] *= ORIGIN_CODE["predicted"]
    code[3, :, 2] = ORIGIN_CODE["missing"]
    tracks["image_origin"].to_numpy()[:] = code
    uv = rng.uniform(0, 700, tracks["image_position"].shape)
    uv[np.broadcast_to((code == 0)[:, :, None], uv.shape)] = np.nan
    tracks["image_position"].to_numpy()[:] = uv
    tracks["image_confidence"].to_numpy()[:] = np.where(code > 0, rng.random(shape), 0)
    xyz = rng.normal(0, 100, tracks["position"].shape)
    xyz[3, :, 2] = np.nan
    tracks["position"].to_numpy()[:] = xyz
    known = np.isfinite(xyz).all(axis=1)
    tracks["origin"].to_numpy()[:] = known
    tracks["confidence"].to_numpy()[:] = known * 0.75
    tracks["residual"].to_numpy()[:] = np.where(known, 1.25, np.nan)
    return add_provenance(tracks, step="track", method="paper", settings={"a": [1, 2.5]})


# --- netCDF ------------------------------------------------------------------------------------


def test_tracks_that_were_read_are_written_as_the_same_bytes(tmp_path):
    """As those of a review: joints, which come last, stood behind their coordinates."""
    tracks = example().assign_coords(joint=["L1_BC", "L1_CF"])
    angles = ("time", "joint", "individual"), np.ones((6, 2, 1))
    tracks = tracks.assign(joint_angle=angles)
    path = native.write_tracks(tracks, tmp_path / "tracks.nc")
    again = native.write_tracks(native.read_tracks(path), tmp_path / "again.nc")
    assert again.read_bytes() == path.read_bytes()


def assert_same(found, given):
    """Identical values, coordinates, attributes, and types of all of them."""
    xr.testing.assert_identical(found, given)
    for name in given.variables:
        assert found[name].dtype == given[name].dtype, name
        for key, value in given[name].attrs.items():
            assert type(found[name].attrs[key]) is type(value), (name, key)
            assert np.asarray(found[name].attrs[key]).dtype == np.asarray(value).dtype
    assert {k: type(v) for k, v in found.attrs.items()} == {
        k: type(v) for k, v in given.attrs.items()
    }


def test_netcdf_round_trip_loses_nothing(tmp_path):
    tracks = example()
    tracks["sd"] = tracks["position"].astype(np.float32) / 3
    tracks["position"].to_numpy()[0, 0, 0, 0] = np.nextafter(1.0, 2.0)
    tracks["position"].to_numpy()[0, 1, 0, 0] = np.inf
    path = native.write_tracks(tracks, tmp_path / "tracks.nc")
    found = native.read_tracks(path)
    assert_same(found, tracks)
    np.testing.assert_array_equal(found["origin"].attrs["flag_values"], np.arange(6, dtype=np.int8))
    assert found["origin"].attrs["flag_meanings"].split() == list(ORIGINS)
    # perturbed twin: the last bit is noticed
    other = tracks.copy(deep=True)
    other["position"].to_numpy()[0, 0, 0, 0] = 1.0
    with pytest.raises(AssertionError):
        assert_same(found, other)


@pytest.mark.slow
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    names=st.lists(st.text(min_size=1, max_size=8).filter(lambda s: "\x00" not in s and
                   s.isprintable() and s.strip() == s), min_size=1, max_size=4, unique=True),
    n=st.integers(1, 5),
    views=st.booleans(),
)  # fmt: skip
def test_netcdf_round_trip_of_any_names(tmp_path, names, n, views):
    tracks = make_tracks(
        np.arange(n) * 3, names, fps=33.3, views=("cam é", "2") if views else (),
        space=("x", "y"), time_s=np.cumsum(np.arange(1.0, n + 1)) / 7,
    )  # fmt: skip
    assert_same(native.read_tracks(native.write_tracks(tracks, tmp_path / "t.nc")), tracks)


@pytest.mark.slow
def test_the_file_is_whole_closed_and_always_the_same(tmp_path):
    tracks = example()
    path = native.write_tracks(tracks, tmp_path / "tracks.nc")
    first = path.read_bytes()
    native.read_tracks(path)
    native.write_tracks(tracks, path)  # would fail or differ were it still open
    assert path.read_bytes() == first
    assert [p.name for p in tmp_path.iterdir()] == ["tracks.nc"]


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = native.write_tracks(example(), tmp_path / "tracks.nc")
    before = path.read_bytes()
    bad = example()
    bad["extra"] = ("time", np.array([object()] * 6))
    with pytest.raises((TypeError, ValueError)):
        native.write_tracks(bad, path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["tracks.nc"]


def test_what_cannot_be_stored_is_named(tmp_path):
    with pytest.raises(InputError, match=r"^attribute 'who' of the tracks is None; netCDF stores"):
        native.write_tracks(example().assign_attrs(who=None), tmp_path / "t.nc")
    with pytest.raises(InputError, match="no such folder; make it"):
        native.write_tracks(example(), tmp_path / "nowhere" / "t.nc")
    with pytest.raises(InputError, match="not Tracks as pawnb writes them"):
        native.write_tracks(example().drop_vars("origin"), tmp_path / "t.nc")


def test_reading_checks_what_is_there(tmp_path):
    with pytest.raises(InputError, match=r"t.nc: no such file; expected tracks.nc"):
        native.read_tracks(tmp_path / "t.nc")
    with pytest.raises(InputError, match=r"a folder; expected tracks\.nc"):
        native.read_tracks(tmp_path)
    (tmp_path / "t.nc").write_text("frame,view\n")
    with pytest.raises(InputError, match=r"^t.nc: not a netCDF file; expected tracks.nc"):
        native.read_tracks(tmp_path / "t.nc")
    whole = native.write_tracks(example(), tmp_path / "whole.nc").read_bytes()
    (tmp_path / "t.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"^t.nc: damaged or of another kind"):
        native.read_tracks(tmp_path / "t.nc")
    example().drop_vars("confidence").to_netcdf(tmp_path / "t.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"^t.nc: not Tracks.*no variable 'confidence'"):
        native.read_tracks(tmp_path / "t.nc")


# --- csv exports -------------------------------------------------------------------------------


def test_tracks_of_a_run_that_was_stopped_before_its_first_frame_say_so(tmp_path):
    none = make_tracks([], ["FR"], fps=25.0, views=["side"])
    path = native.write_tracks(none, tmp_path / "tracks.nc")
    with pytest.raises(InputError, match=r"no frames: tracking was stopped .* track the trial aga"):
        native.read_tracks(path)


def test_tracks_table_has_a_row_for_every_frame_view_and_point_tracked():
    tracks = example()
    table = native.tracks_table(tracks)
    assert tuple(table.columns) == TRACKS_COLUMNS
    assert len(table) == 6 * 4  # FR and nose in cam1, FL and nose in cam2
    first = table[table["frame"] == 10]
    assert list(zip(first["view"], first["point"], strict=True)) == [
        ("cam1", "FR"), ("cam1", "nose"), ("cam2", "FL"), ("cam2", "nose"),
    ]  # fmt: skip
    for row in table.itertuples():
        cell = tracks.sel(view=row.view, keypoint=row.point).isel(time=row.frame - 10, individual=0)
        np.testing.assert_array_equal([row.u, row.v], cell["image_position"])
        assert row.confidence == cell["image_confidence"].item()
        assert row.origin == ORIGINS[cell["image_origin"].item()]
    hidden = table[(table["frame"] == 13) & (table["point"] == "nose")]
    assert hidden["origin"].tolist() == ["missing", "missing"]
    assert hidden[["u", "v"]].isna().all(axis=None)


def test_points3d_table_has_a_row_for_every_frame_and_point():
    tracks = example()
    table = native.points3d_table(tracks)
    assert tuple(table.columns) == POINTS3D_COLUMNS
    assert len(table) == 6 * 3
    for row in table.itertuples():
        cell = tracks.sel(keypoint=row.point).isel(time=row.frame - 10, individual=0)
        np.testing.assert_array_equal([row.x, row.y, row.z], cell["position"])
    assert table["origin"].value_counts().to_dict() == {"measured": 17, "missing": 1}
    flat = make_tracks([0], ["a"], fps=1.0, space=("x", "y"))
    with pytest.raises(InputError, match="these tracks have no z"):
        native.points3d_table(flat)


def test_several_individuals_get_a_column_on_the_right():
    tracks = example(individuals=("a", "b"))
    table, space = native.tracks_table(tracks), native.points3d_table(tracks)
    assert tuple(table.columns) == (*TRACKS_COLUMNS, "individual")
    assert tuple(space.columns) == (*POINTS3D_COLUMNS, "individual")
    b = table[(table["individual"] == "b") & (table["view"] == "cam2") & (table["point"] == "FL")]
    np.testing.assert_array_equal(
        b["u"],
        tracks["image_position"].sel(view="cam2", image_space="u", keypoint="FL", individual="b"),
    )
    b = space[(space["individual"] == "b") & (space["point"] == "FL")]
    np.testing.assert_array_equal(
        b["y"], tracks["position"].sel(space="y", keypoint="FL", individual="b")
    )


def test_tracks_in_px_without_views_are_those_of_one_view():
    tracks = make_tracks([0, 1], ["tail"], fps=60.0, space=("x", "y"))
    tracks["position"].to_numpy()[0, :, 0, 0] = [4.5, 7.25]
    tracks["origin"].to_numpy()[0] = ORIGIN_CODE["measured"]
    table = native.tracks_table(tracks)
    assert table["view"].unique().tolist() == ["image"]
    assert table.loc[0, ["u", "v"]].tolist() == [4.5, 7.25]
    assert native.tracks_table(make_tracks([0], ["a"], fps=1.0)).empty


def test_csv_round_trip(tmp_path):
    tracks = example()
    native.write_table(native.tracks_table(tracks), tmp_path / "tracks.csv")
    native.write_table(native.points3d_table(tracks), tmp_path / "points3d.csv")
    found = track_tables.read_tracks_table(
        tmp_path / "tracks.csv", fps=250.0, points3d=tmp_path / "points3d.csv", unit="mm",
        individual="m07",
    )  # fmt: skip
    found = found.sel(keypoint=["FR", "FL", "nose"])
    tolerance = {"image_position": 5.1e-5, "position": 5.1e-7, "image_confidence": 5.1e-5}
    for name in ("image_position", "position", "image_confidence", "residual", "time", "frame"):
        np.testing.assert_allclose(found[name], tracks[name], atol=tolerance.get(name, 0), rtol=0)
    for name in ("image_origin", "origin"):
        np.testing.assert_array_equal(found[name], tracks[name])
    assert (found.attrs["units"], found.attrs["fps"]) == ("mm", 250.0)
    # perturbed twin: 0.0001 px is noticed
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(
            found["image_position"] + 1e-4, tracks["image_position"], atol=5.1e-5, rtol=0
        )


def test_csv_of_one_view_gives_positions_in_px(tmp_path):
    (tmp_path / "t.csv").write_text(
        "frame,view,point,u,v,confidence,origin\n"
        "4,cam1,FR,1.5,2.5,0.9,edited\n6,cam1,FR,,,0,missing\n"
    )
    tracks = track_tables.read_tracks_table(tmp_path / "t.csv", fps=100.0)
    assert tracks["frame"].to_numpy().tolist() == [4, 5, 6]
    assert tracks["position"].to_numpy()[:, :, 0, 0].tolist()[0] == [1.5, 2.5]
    assert np.isnan(tracks["position"].to_numpy()[1:]).all()
    assert tracks["origin"].to_numpy().ravel().tolist() == [ORIGIN_CODE["edited"], 0, 0]
    assert tracks.attrs["units"] == "px"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frame,view,point,x,v,confidence,origin\n",
         "^t.csv: column 'u' is missing.*expected frame, view, point, u, v, confidence, origin"),
        ("frame,view,point,u,v,confidence,origin\n0.5,c,FR,1,2,1,measured\n",
         "^t.csv: line 2, column 'frame' is '0.5'; expected a whole number"),
        ("frame,view,point,u,v,confidence,origin\n0,c,FR,one,2,1,measured\n",
         "^t.csv: line 2, column 'u' is 'one'; expected a number"),
        ("frame,view,point,u,v,confidence,origin\n0,c,FR,1,2,1,measrued\n",
         r"^t.csv: line 2, origin is 'measrued' \(did you mean 'measured'\?\); expected missing"),
        ("frame,view,point,u,v,confidence,origin\n" + "0,c,FR,1,2,1,edited\n" * 2,
         "^t.csv: frame 0, view c, point FR is there twice"),
        ("frame,view,point,u,v,confidence,origin\n", "^t.csv: no rows"),
        ("", "^t.csv: not a csv table; expected the columns frame, view"),
    ],
)  # fmt: skip
def test_bad_tracks_csv_is_refused(tmp_path, text, message):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        track_tables.read_tracks_table(tmp_path / "t.csv", fps=100.0)


def test_write_table_is_the_same_everywhere(tmp_path):
    table = pd.DataFrame(
        {"u": [1.00004, -1e-9, np.nan], "x": [0.1234567, 1e-9, 2.0], "period_s": [1 / 3, 0.1, 1.0]}
    )
    path = native.write_table(table, tmp_path / "t.csv")
    assert path.read_bytes() == (
        b"u,x,period_s\n1.0,0.123457,0.3333333333333333\n0.0,0.0,0.1\n,2.0,1.0\n"
    )
    assert [p.name for p in tmp_path.iterdir()] == ["t.csv"]
    assert table["u"][0] == 1.00004  # the table given is not changed
    with pytest.raises(InputError, match="no such folder"):
        native.write_table(table, tmp_path / "no" / "t.csv")


# --- belt -----------------------------------------------------------------------------------------


def test_belt_speed_is_read_in_the_order_of_the_frames(tmp_path):
    (tmp_path / "b.csv").write_text("speed, frame ,note\n300,2,a\n350.5,0,\n")
    table = read_belt_speed(tmp_path / "b.csv")
    assert table.to_dict("list") == {"frame": [0, 2], "speed": [350.5, 300.0]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frame,velocity\n0,1\n", "^b.csv: column 'speed' is missing"),
        ("frame,speed\n0,fast\n", "^b.csv: line 2, column 'speed' is 'fast'; expected a number"),
        ("frame,speed\n0,\n", "^b.csv: line 2, column 'speed' is empty"),
        ("frame,speed\n0,1\n0,2\n", "^b.csv: frame 0 is there twice"),
        ("frame,speed\n", "^b.csv: no rows"),
    ],
)
def test_bad_belt_speed_is_refused(tmp_path, text, message):
    (tmp_path / "b.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        read_belt_speed(tmp_path / "b.csv")
    with pytest.raises(InputError, match="no such file"):
        read_belt_speed(tmp_path / "c.csv")


def test_units_of_the_first_files_are_found_under_their_old_name(tmp_path):
    old = make_tracks([0, 1], ["FR"], fps=250.0).assign_attrs(unit="cm")
    del old.attrs["units"]
    native.write_tracks(old, tmp_path / "tracks.nc")
    found = native.read_tracks(tmp_path / "tracks.nc")
    assert found.attrs["units"] == "cm"
    assert "unit" not in found.attrs


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_a_full_disk_while_tracks_are_written_is_a_sentence(tmp_path):
    """In a process that may write 100 kB a file: HDF5 itself crashes it when it is closed."""
    path = native.write_tracks(make_tracks(range(2), ["FR"], fps=250.0), tmp_path / "tracks.nc")
    before = path.read_bytes()
    code = (
        "import resource, sys\n"
        "from pawnb.errors import InputError\n"
        "from pawnb.io.native import write_tracks\n"
        "from pawnb.schema import make_tracks\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))\n"
        "tracks = make_tracks(range(20_000), ['FR'], fps=250.0)\n"
        "try:\n    write_tracks(tracks, sys.argv[1])\n"
        "except InputError as error:\n    sys.exit(str(error))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "tracks.nc: cannot be written (File too large); free some space" in done.stderr
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["tracks.nc"]


def test_another_frame_rate_than_that_of_the_file_is_said(tmp_path):
    path = native.write_tracks(example(), tmp_path / "tracks.nc")
    with pytest.warns(InputWarning, match=r"^tracks\.nc says 250 .* and not the fps of 500"):
        assert native.read_tracks(path, fps=500.0).attrs["fps"] == 250.0
    native.read_tracks(path, fps=250.0)
