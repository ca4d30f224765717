"""Points side by side, in the spellings of scripts and other programs."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb import load_tracks
from pawnb.errors import InputError, InputWarning
from pawnb.io import recognise_format

PLACE = np.random.default_rng(5).uniform(5.0, 90.0, (4, 2, 2))


def write(path, *, frame="frame", spelt="{point}_{axis}", told="likelihood", more=()):
    columns = {frame: np.arange(4)}
    for k, point in enumerate(("FR", "hind paw R")):
        for i, axis in enumerate("xy"):
            columns[spelt.format(point=point, axis=axis)] = PLACE[:, k, i]
        columns[spelt.format(point=point, axis=told)] = 0.9
    pd.DataFrame({**columns, **dict(more)}).to_csv(path, index=False)
    return path


@pytest.mark.parametrize(
    "layout",
    [
        {}, {"frame": "Frame"}, {"frame": "frame_idx"}, {"frame": "Frame Number"},
        {"frame": "Unnamed: 0"},
        {"spelt": "{point}.{axis}"}, {"spelt": "{point} {axis}"}, {"told": "visibility"},
        # what else a table holds is left out, also where it ends like a point
        {"more": [("speed X", 1.0), ("frame_number", 7)]},
    ],
)  # fmt: skip
def test_other_spellings_of_the_same_columns(tmp_path, layout):
    path = write(tmp_path / "points.csv", **layout)
    assert recognise_format(path) == "table"
    tracks = load_tracks(path, fps=100.0)
    assert tracks["keypoint"].to_numpy().tolist() == ["FR", "hind paw R"]
    assert tracks["frame"].to_numpy().tolist() == [0, 1, 2, 3]
    np.testing.assert_array_equal(
        tracks["position"].isel(individual=0).transpose("time", "keypoint", "space"), PLACE
    )
    assert (tracks["confidence"] == 0.9).all()


def test_capital_letters_are_no_file_of_dltdv_without_z(tmp_path):
    path = write(tmp_path / "points.csv", frame="Frame", spelt="{point}_{axis}")
    path.write_text(path.read_text().replace("_x", "_X").replace("_y", "_Y"))
    assert recognise_format(path) == "table"
    assert load_tracks(path, fps=100.0)["keypoint"].to_numpy().tolist() == ["FR", "hind paw R"]


def test_two_spellings_of_one_column_are_refused(tmp_path):
    path = write(tmp_path / "points.csv", spelt="{point}.{axis}", more=[("FR X", 1.0)])
    with pytest.raises(InputError, match=r"columns 'FR.x' and 'FR X' mean the same"):
        load_tracks(path, fps=100.0)


def test_parts_of_a_picture_are_no_pixels_and_that_is_said(tmp_path):
    # MediaPipe's landmarks: x / width and y / height
    path = write(tmp_path / "points.csv")
    table = pd.read_csv(path)
    places = [name for name in table if name.endswith(("_x", "_y"))]
    table[places] /= 100.0
    table.to_csv(path, index=False)
    with pytest.warns(InputWarning, match="all places lie between 0 and 1, as MediaPipe"):
        load_tracks(path, fps=100.0)


def test_parts_of_a_picture_are_told_beside_the_depth_of_mediapipe(tmp_path):
    # pose_landmarks of MediaPipe: x and y are parts of the picture, z a depth, and visibility
    table = pd.DataFrame({"frame": range(4), "left_heel_x": [0.2, 0.3, 0.4, 0.5]})
    table["left_heel_y"], table["left_heel_z"] = 0.6, -0.4
    path = tmp_path / "landmarks.csv"
    table.to_csv(path, index=False)
    load_tracks(path, fps=100.0)  # in metres, points may be as near as that
    table["left_heel_visibility"] = 0.99
    table.to_csv(path, index=False)
    with pytest.warns(InputWarning, match=r"all places lie between 0 and 1, as MediaPipe"):
        load_tracks(path, fps=100.0)


def test_confidences_in_percent_are_said(tmp_path):
    table = pd.DataFrame({"frame": [0, 1], "FR_x": [5.0, 6.0], "FR_y": 7.0})
    path = tmp_path / "points.csv"
    for top, said in ((98.5, True), (1.02, False)):
        table["FR_likelihood"] = [top, 0.4]
        table.to_csv(path, index=False)
        if said:
            with pytest.warns(
                InputWarning, match=r"up to 98.5, and parts of 1 .* divide them by 100"
            ):
                load_tracks(path, fps=100.0)
        else:
            load_tracks(path, fps=100.0)
