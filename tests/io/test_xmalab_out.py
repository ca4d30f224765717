"""Tracks and cameras for XMALab: read by the rules of its source, and back without a change."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pawnb.errors import CalibrationError, InputError
from pawnb.io.cameras import Camera, read_cameras
from pawnb.io.cameras_out import write_mayacam
from pawnb.io.formats import read_any_tracks, recognise_format, write_any_tracks
from pawnb.schema import make_tracks

NUMBERS = st.floats(-1e4, 1e4, allow_subnormal=False)


def pictures(place):
    """Tracks of places (frames, views, 2, points); NaN is missing."""
    views = [f"cam{i + 1}" for i in range(place.shape[1])]
    points = [f"toe {k}" for k in range(place.shape[3])]
    tracks = make_tracks(range(len(place)), points, fps=100.0, views=views)
    tracks["image_position"][..., 0] = place
    tracks["image_origin"][..., 0] = np.isfinite(place).all(axis=2)
    return tracks


def xmalab_loads(path, *, cameras, heights=None):
    """Trial::load2dPoints of XMALab's Trial.cpp, with a header row, without columns of offsets,
    counted from 1, with heights the y axis inverted: name to (frame, camera, x, y)."""
    names, found = [], {}
    frame = 0
    for line in path.read_text().split("\n")[:-1]:
        cells = line.split(",")
        if not names:
            n = len(cells) // 2 // cameras
            names = [cells[i * 2 * cameras].replace("_cam1_X", "").strip() for i in range(n)]
            continue
        for i, name in enumerate(names):
            for j in range(cameras):
                x, y = cells[i * cameras * 2 + 2 * j : i * cameras * 2 + 2 * j + 2]
                if "NaN" not in x and "NaN" not in y:
                    x, y = float(x) - 1, float(y) - 1
                    y = y if heights is None else heights[j] - y - 1
                    found.setdefault(name, []).append((frame, j, x, y))
        frame += 1
    return found


@pytest.mark.parametrize("heights", [None, [480, 600]])
def test_xmalab_shows_markers_where_they_are(tmp_path, heights):
    place = np.full((3, 2, 2, 2), np.nan)
    place[0, 0, :, 0], place[0, 1, :, 0], place[2, 1, :, 1] = (10.5, 20.25), (0.0, 3.0), (7.0, 8.0)
    (path,) = write_any_tracks(
        pictures(place), tmp_path / "markers.csv", program="xmalab", heights_px=heights
    )
    assert path.read_text().startswith("toe 0_cam1_X,toe 0_cam1_Y,toe 0_cam2_X,toe 0_cam2_Y,toe 1_")
    assert xmalab_loads(path, cameras=2, heights=heights) == {
        "toe 0": [(0, 0, 10.5, 20.25), (0, 1, 0.0, 3.0)], "toe 1": [(2, 1, 7.0, 8.0)],
    }  # fmt: skip
    assert [one.name for one in tmp_path.iterdir()] == ["markers.csv"]


@pytest.mark.slow
@given(arrays(float, (4, 2, 2, 3), elements=st.one_of(NUMBERS, st.just(np.nan))))
def test_markers_in_the_views_come_back(tmp_path_factory, place):
    place[np.isnan(place).any(axis=2).repeat(2, axis=1).reshape(place.shape)] = np.nan
    path = tmp_path_factory.mktemp("markers") / "markers.csv"
    write_any_tracks(pictures(place), path, program="xmalab")
    assert recognise_format(path) == "dltdv"
    found = read_any_tracks(path, fps=100.0, program="xmalab")
    np.testing.assert_allclose(found["image_position"][..., 0], place, rtol=1e-15, atol=2e-12)


@pytest.mark.slow
@given(arrays(float, (4, 3, 2), elements=NUMBERS), st.integers(0, 30))
def test_markers_in_space_come_back_with_their_frames(tmp_path_factory, place, first):
    tracks = make_tracks(range(first, first + 4), ["FR", "HR"], fps=100.0, space=("x", "y", "z"))
    tracks["position"][..., 0] = place
    tracks["origin"][:] = 1
    tracks["position"][2, :, 1] = np.nan
    tracks["origin"][2, 1] = 0
    path = tmp_path_factory.mktemp("markers") / "markers.csv"
    write_any_tracks(tracks, path, program="xmalab-3d")
    # Trial::save3dPoints of XMALab's Trial.cpp counts its frames from 1
    lines = path.read_text().split("\n")
    assert lines[0] == "Frame,FR_X,FR_Y,FR_Z,HR_X,HR_Y,HR_Z"
    assert lines[1].startswith(f"{first + 1},")
    assert lines[3].endswith(",NaN,NaN,NaN")
    found = read_any_tracks(path, fps=100.0)
    assert found["frame"].to_numpy().tolist() == list(range(first, first + 4))
    np.testing.assert_array_equal(found["position"], tracks["position"])


def test_a_comma_in_a_name_is_refused(tmp_path):
    tracks = pictures(np.zeros((2, 1, 2, 1))).assign_coords(keypoint=["toe, left"])
    with pytest.raises(InputError, match=r"m\.csv: XMALab takes no comma in a name.*'toe, left'"):
        write_any_tracks(tracks, tmp_path / "m.csv", program="xmalab")
    assert not list(tmp_path.iterdir())


def camera(**more):
    angle = 0.4
    rotation = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0],
                         [-np.sin(angle), 0, np.cos(angle)]])  # fmt: skip
    matrix = np.array([[900.0, 0.5, 310.1], [0.0, 905.0, 1 / 3], [0.0, 0.0, 1.0]])
    own = {"name": "left", "matrix": matrix, "distortion": (), "rotation": rotation,
           "translation": np.array([5.0, -1 / 3, 4e2]), "size": (640, 480)}  # fmt: skip
    return Camera(**(own | more))


def test_a_camera_stands_on_the_lines_that_autoscoper_counts(tmp_path):
    """Camera::loadMayaCam2 of Autoscoper's Camera.cpp takes its numbers by the number of the line;
    XMALab's saveMayaCamVersion2 writes them there, width before height."""
    one = camera()
    lines = write_mayacam(one, tmp_path / "left.txt").read_text().split("\n")
    assert lines[0] == "image size"
    assert lines[1] == "640,480"
    for first, head, values in ((4, "camera matrix", one.matrix), (9, "rotation", one.rotation)):
        assert lines[first - 1] == head
        rows = [[float(x) for x in line.split(",")] for line in lines[first : first + 3]]
        np.testing.assert_array_equal(rows, values)
    assert lines[13] == "translation"
    assert [float(x) for x in lines[14:17]] == one.translation.tolist()
    (again,) = read_cameras(tmp_path / "left.txt")
    for field in dataclasses.fields(Camera):
        np.testing.assert_array_equal(getattr(again, field.name), getattr(one, field.name))


def test_what_mayacam_cannot_hold_is_refused(tmp_path):
    with pytest.raises(CalibrationError, match="camera 'left': its lens bends the picture, which"):
        write_mayacam(camera(distortion=(0.1, 0.0, 0.0, 0.0)), tmp_path / "left.txt")
    with pytest.raises(CalibrationError, match="says the size of the picture, and this"):
        write_mayacam(camera(size=None), tmp_path / "left.txt")
    assert not list(tmp_path.iterdir())
