"""Point masses of Tracker, laid out as its source and the examples that come with it have them."""

import shutil

import numpy as np
import pytest

from pawnb.errors import InputError, InputWarning
from pawnb.io import read_any_tracks, read_osp_tracker, recognise_format
from pawnb.workflow.gait.sources import read_source

N = 12
FEET = {
    "FR": np.column_stack([300 + 3.5 * np.arange(N), 200 - 2.0 * (np.arange(N) % 4)]),
    "HR": np.column_stack([250 + 4.0 * np.arange(N), 205 - 1.5 * (np.arange(N) % 3)]),
}
UNSEEN = 5
"""A frame in which HR was not marked."""
CLASS = "org.opensourcephysics.cabrillo.tracker"


def trk(path, *, names=tuple(FEET), delta_t=5.0):
    """As PointMass.java writes it: between the axes and a tape, whose framedata is no point's."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f'<object class="{CLASS}.TrackerPanel">',
             '<property name="clipcontrol" type="object">',
             '<object class="org.opensourcephysics.media.core.StepperClipControl">',
             f'<property name="delta_t" type="double">{delta_t}</property>', "</object>",
             "</property>", '<property name="tracks" type="collection">',
             '<property name="item" type="object">', f'<object class="{CLASS}.TapeMeasure">',
             '<property name="name" type="string">tape A</property>',
             '<property name="framedata" type="array"><property name="[0]" type="object">',
             '<object><property name="x1" type="double">9.0</property></object></property>',
             "</property></object></property>"]  # fmt: skip
    for name, place in zip(names, FEET.values(), strict=True):
        lines += ['<property name="item" type="object">', f'<object class="{CLASS}.PointMass">',
                  '<property name="mass" type="double">1.0</property>',
                  f'<property name="name" type="string">{name}</property>',
                  '<property name="framedata" type="array">']  # fmt: skip
        for i, (x, y) in enumerate(place):
            if place is FEET["HR"] and i == UNSEEN:
                continue
            lines += [f'<property name="[{i + 40}]" type="object">',
                      f'<object class="{CLASS}.PointMass$FrameData">',
                      f'<property name="x" type="double">{x + 0.5}</property>',
                      f'<property name="y" type="double">{y + 0.5}</property>',
                      "</object></property>"]  # fmt: skip
        lines += ["</property>", '<property name="keyFrames" type="array" class="[I">',
                  '<property name="array" type="string">{40}</property>', "</property>",
                  "</object></property>"]  # fmt: skip
    path.write_text("\n".join([*lines, "</property>", "</object>"]) + "\n")
    return path


def number(value, decimal="."):
    """As Java's pattern 0.000000E0 writes it, in the export at full precision."""
    mantissa, exponent = f"{value:.6E}".split("E")
    return f"{mantissa}E{int(exponent)}".replace(".", decimal)


def table(
    path, *, names=tuple(FEET), columns=("frame", "x", "y", "pixelx", "pixely"), mark="\t",
    decimal=".", rate=200, feet=tuple(FEET),
):  # fmt: skip
    """As ExportDataDialog.java writes it: a row for every frame, empty where nothing is marked."""
    lines = ["#multi:"] if len(names) > 1 else []
    lines += [mark + "".join(name + mark * len(columns) for name in names),
              "t" + mark + mark.join([*columns] * len(names)) + mark]  # fmt: skip
    for i in range(N):
        cells = [number(i / rate, decimal)]
        for name in feet:
            x, y = FEET[name][i]
            row = {"frame": i + 40, "x": x / 100, "y": -y / 100, "pixelx": x + 0.5,
                   "pixely": y + 0.5}  # fmt: skip
            empty = name == "HR" and i == UNSEEN
            cells += ["" if empty else number(row[column], decimal) for column in columns]
        lines.append(mark.join(cells))
    path.write_text("\n".join(lines) + "\n")
    return path


def check(tracks, *, scale=1.0, first=40):
    assert tracks["keypoint"].values.tolist() == ["FR", "HR"]
    assert tracks["frame"].values.tolist() == list(range(first, first + N))
    place = tracks["position"].to_numpy()[..., 0]
    seen = np.arange(N) != UNSEEN
    np.testing.assert_allclose(place[:, :, 0], FEET["FR"] * scale, atol=2e-3)
    np.testing.assert_allclose(place[seen, :, 1], FEET["HR"][seen] * scale, atol=2e-3)
    assert np.isnan(place[~seen, :, 1]).all()


def test_a_trk_is_read_in_pixels_with_the_frames_of_the_film(tmp_path):
    path = trk(tmp_path / "m1.trk")
    assert recognise_format(path) == "tracker"
    tracks = read_any_tracks(path, fps=200.0, unit="mm")
    check(tracks)
    assert tracks.attrs["units"] == "px"


def test_a_table_without_rows_is_refused(tmp_path):
    path = tmp_path / "m1.txt"
    path.write_text("\tFR\t\t\nt\tx\ty\t\n")
    with pytest.raises(InputError, match=r"m1.txt: a row without a time, or no row"):
        read_osp_tracker(path, fps=200.0)


def test_the_rate_of_a_project_that_was_never_told_it_is_said(tmp_path):
    with pytest.warns(InputWarning, match=r"says 30 frames per second, and fps is given as 200"):
        read_osp_tracker(trk(tmp_path / "m1.trk", delta_t=1000 / 30), fps=200.0)


@pytest.mark.parametrize(("mark", "decimal"), [("\t", "."), (",", "."), (";", ","), ("\t", ",")])
def test_a_table_is_read_in_pixels_where_it_has_them(tmp_path, mark, decimal):
    path = table(tmp_path / "m1.txt", mark=mark, decimal=decimal)
    assert recognise_format(path) == "tracker"
    check(read_any_tracks(path, fps=200.0))


def test_a_table_is_read_in_its_own_unit_where_that_is_told(tmp_path):
    tracks = read_osp_tracker(table(tmp_path / "m1.txt"), fps=200.0, unit="m")
    check(tracks, scale=0.01)
    assert tracks.attrs["units"] == "m"


def test_a_table_without_pixels_and_frames_says_what_is_taken(tmp_path):
    path = table(tmp_path / "m1.txt", columns=("x", "y"))
    with pytest.warns(InputWarning, match=r"it says no unit, .* px, with y upwards, as Tracker"):
        check(read_osp_tracker(path, fps=200.0), scale=0.01, first=0)


def test_another_rate_than_that_of_a_table_is_said(tmp_path):
    with pytest.warns(InputWarning, match=r"says 30 frames per second, and fps is .* 200") as told:
        read_osp_tracker(table(tmp_path / "m1.txt", rate=30), fps=200.0)
    assert len(told) == 1


def test_times_of_a_film_that_plays_slowed_down_are_said_once(tmp_path):
    path = table(tmp_path / "m1.txt", columns=("x", "y"), rate=30)
    with pytest.warns(InputWarning, match=r"steps of 0.03333, .*slowed down") as told:
        check(read_osp_tracker(path, fps=200.0, unit="m"), scale=0.01, first=0)
    assert len(told) == 1


@pytest.mark.parametrize("names", [("mass A", "mass A"), ("mass A", "mass B"), ("FR", "HR")])
def test_a_folder_with_a_file_for_each_foot_is_read(tmp_path, names):
    folder = tmp_path / "m1"
    folder.mkdir()
    for foot, name in zip(FEET, names, strict=True):
        file = f"{foot}.csv" if name.startswith("mass") else f"run1_{foot}.csv"
        table(folder / file, names=(name,), feet=(foot,), mark=",")
    assert recognise_format(folder) == "tracker"
    check(read_any_tracks(folder, fps=200.0))
    source = read_source(folder, fps=200.0)
    assert source.trial.name == "m1"
    check(source.tracks)


def test_a_folder_with_anything_else_is_no_trial(tmp_path):
    table(tmp_path / "FR.csv", names=("FR",), feet=("FR",))
    (tmp_path / "notes.txt").write_text("sunny\n")
    with pytest.raises(InputError, match=r"neither a trial nor results; .* tables of Tracker"):
        read_source(tmp_path, fps=200.0)
    with pytest.raises(InputError, match="not a folder with tables of Tracker only"):
        read_osp_tracker(tmp_path, fps=200.0)


def test_files_of_a_folder_have_the_same_columns(tmp_path):
    table(tmp_path / "FR.csv", names=("FR",), feet=("FR",))
    table(tmp_path / "HR.csv", names=("HR",), feet=("HR",), columns=("x", "y"))
    with pytest.raises(InputError, match="some of its tables have pixelx"):
        read_osp_tracker(tmp_path, fps=200.0)
    shutil.copy(tmp_path / "FR.csv", tmp_path / "HR.csv")
    tracks = read_osp_tracker(tmp_path, fps=200.0)  # both name FR: the files tell
    assert tracks["keypoint"].values.tolist() == ["FR", "HR"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name="x"', 'name="z"', r"FR, \[40\]: ''; expected a number"),
        ('"[41]"', '"[one]"', r"FR, \[one\]: 'one'; expected a number"),
        (">HR<", ">FR<", "two point masses are called 'FR'"),
        (".PointMass", ".Vector", "no point mass in it"),
        ("</property>\n</object>\n", "", "damaged XML"),
    ],
)
def test_what_is_wrong_with_a_trk_is_one_sentence(tmp_path, old, new, message):
    path = trk(tmp_path / "m1.trk")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=rf"^m1.trk: .*{message}"):
        read_osp_tracker(path, fps=200.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\tHR\t", "\tFR\t", "two point masses are called 'FR'"),
        ("4.000000E1", "4.050000E1", "40.5 is no number of a frame"),
        ("4.000000E1", "forty", "line 4: 'forty'; expected a number"),
        ("\n0.000000E0\t", "\n\t", "a row without a time"),
    ],
)
def test_what_is_wrong_with_a_table_is_one_sentence(tmp_path, old, new, message):
    path = table(tmp_path / "m1.txt")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=rf"^m1.txt: .*{message}"):
        read_osp_tracker(path, fps=200.0)
