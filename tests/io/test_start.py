"""start.csv: what is read, and every way in which it can be wrong."""

from __future__ import annotations

import pandas as pd
import pytest

import pawnb
from pawnb.errors import InputError
from pawnb.io.start import (
    check_start,
    clicked_films,
    films_of_clicks,
    read_start,
    write_start,
)
from pawnb.schema import START_COLUMNS
from pawnb.trial import Animal, Trial, View

HEADER = "frame,view,point,u,v\n"
GOOD = "0,cam1,FR,10.5,20\n0,cam1,HR,30,40.25\n0,cam2,FR,5,6\n0,cam2,HR,7,8\n0,cam3,FL,100,50\n"


@pytest.fixture
def trial():
    """Two views of the right side, one of the left, frames 0 to 99."""
    views = (
        View(name="cam1", video="1.avi", points=("FR", "HR")),
        View(name="cam2", video="2.avi", points=("FR", "HR")),
        View(name="cam3", video="3.avi", points=("FL",)),
    )
    return Trial(
        kind="paws", name="t", fps=250.0, animal=Animal(id="m"), frames=(0, 100), views=views
    )


def read(tmp_path, trial, text):
    (tmp_path / "start.csv").write_text(text)
    return read_start(tmp_path / "start.csv", trial)


def test_clicks_are_read_with_their_types(tmp_path, trial):
    table = read(tmp_path, trial, HEADER + GOOD)
    assert list(table.columns) == ["frame", "view", "point", "u", "v"]
    assert table["frame"].dtype.kind == "i"
    assert table.iloc[1].tolist() == [0, "cam1", "HR", 30.0, 40.25]


def test_further_columns_order_and_blanks_do_not_matter(tmp_path, trial):
    text = "who, v ,u,point,view,frame\n" + "".join(
        f"me, {v}, {u}, {p} , {c} , {f}\n" for f, c, p, u, v in
        (line.split(",") for line in GOOD.splitlines())
    )  # fmt: skip
    pd.testing.assert_frame_equal(read(tmp_path, trial, text), read(tmp_path, trial, HEADER + GOOD))


def test_a_file_saved_by_a_spreadsheet_is_read(tmp_path, trial):
    (tmp_path / "start.csv").write_bytes(("\ufeff" + HEADER + GOOD).replace("\n", "\r\n").encode())
    assert len(read_start(tmp_path / "start.csv", trial)) == 5


def test_any_number_of_frames_has_any_of_the_points_each(tmp_path, trial):
    text = HEADER + GOOD.replace("0,cam2,HR,7,8\n", "").replace("0,cam3,FL", "40,cam3,FL")
    text += "1,cam1,FR,11,20\n75,cam2,HR,11,20\n"
    assert read(tmp_path, trial, text)["frame"].tolist() == [0, 0, 0, 40, 1, 75]


def test_what_is_written_is_read(tmp_path, trial):
    table = read(tmp_path, trial, HEADER + GOOD)
    table["u"] += 0.123456
    write_start(table.assign(note=1), tmp_path / "out.csv")
    again = read_start(tmp_path / "out.csv", trial)
    assert list(again.columns) == list(table.columns[:5])
    assert (again["u"] - table["u"]).abs().max() <= 5.1e-5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frame,view,point,x,v\n",
         "start.csv: column 'u' is missing; expected frame, view, point, u, v, found frame, view, "
         "point, x, v."),
        (HEADER, "start.csv: no clicks; click every point in at least one view."),
        (HEADER + GOOD + "0,cam4,FR,1,2\n",
         "start.csv: unknown view 'cam4' (did you mean 'cam3'?); the trial's views are cam1, cam2, "
         "cam3."),
        (HEADER + GOOD + "0,cam3,FLL,1,2\n",
         "start.csv: unknown point 'FLL' (did you mean 'FL'?); view 'cam3' tracks FL; "
         "to track it, add it to that view's points in trial.toml."),
        (HEADER + GOOD + "0,cam3,FR,1,2\n",
         "start.csv: point 'FR' is clicked in view 'cam3', which tracks FL; remove the click, or "
         "add the point to that view in trial.toml."),
        (HEADER + GOOD + "0,cam1,FR,a,2\n",
         "start.csv: line 7, column 'u' is 'a'; expected a number."),
        (HEADER + GOOD + "0,cam1,FR,,2\n",
         "start.csv: line 7, column 'u' is empty; expected a number."),
        (HEADER + GOOD + "0,cam1,FR,nan,2\n",
         "start.csv: line 7, column 'u' is 'nan'; expected a number."),
        (HEADER + GOOD + "0.5,cam1,FR,1,2\n",
         "start.csv: line 7, column 'frame' is '0.5'; expected a whole number."),
        (HEADER + GOOD + "0,cam1,FR,1,2\n",
         "start.csv: point FR is clicked twice in view cam1, frame 0; keep one of them."),
        (HEADER + GOOD + "7,cam1,FR,1,2\n40,cam1,FR,1,2\n100,cam1,FR,1,2\n",
         "start.csv: frame 100 is not in the trial's frames, [0, 100)."),
        (HEADER + GOOD.replace("0,cam", "100,cam"),
         "start.csv: frame 100 is not in the trial's frames, [0, 100)."),
        (HEADER + GOOD.replace("0,cam3,FL,100,50\n", ""),
         "start.csv: point 'FL' is clicked in no view; click it in at least one, or take it out of "
         "the views' points in trial.toml."),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_sentence(tmp_path, trial, text, message):
    with pytest.raises(InputError) as caught:
        read(tmp_path, trial, text)
    assert str(caught.value) == message


def test_a_missing_file_is_named(tmp_path, trial):
    with pytest.raises(
        InputError, match=r"start.csv: no such file; click the points with .* or write a csv table"
    ):
        read_start(tmp_path / "start.csv", trial)


def test_a_trial_without_lists_of_points_takes_any(tmp_path):
    trial = Trial(
        kind="paws", name="t", fps=1.0, animal=Animal(id="m"), views=(View(name="c", video="v"),)
    )
    assert len(read(tmp_path, trial, HEADER + "7,c,tail,1,2\n")) == 1
    with pytest.raises(InputError, match="a click in view 'c' has no point name"):
        read(tmp_path, trial, HEADER + "7,c,,1,2\n")
    with pytest.raises(InputError, match=r"frame -1 is not in the trial's frames, 0 and later"):
        read(tmp_path, trial, HEADER + "-1,c,tail,1,2\n")


SIZES = {"cam1": (640, 480), "cam2": (640, 480), "cam3": (320, 240)}


@pytest.mark.parametrize(
    ("u", "v", "inside"),
    [(-0.5, -0.5, True), (319.4, 239.4, True), (319.5, 10, False), (10, 239.5, False),
     (-0.6, 10, False), (10, -0.6, False)],
)  # fmt: skip
def test_a_click_outside_the_picture_is_refused(tmp_path, trial, u, v, inside):
    # pixel centres are whole numbers, so a picture 320 px wide reaches from -0.5 to 319.5
    start = read(tmp_path, trial, HEADER + GOOD)
    start.loc[4, ["u", "v"]] = [u, v]
    if inside:
        assert check_start(start, trial, SIZES) is start
        return
    with pytest.raises(InputError) as caught:
        check_start(start, trial, SIZES)
    assert str(caught.value) == (
        f"start clicks: view cam3, point FL is at u = {u:g}, v = {v:g}, outside the picture of "
        "320 × 240 px; click it again, or remove it where it is hidden."
    )


def test_clicks_from_a_widget_are_checked_like_a_file(tmp_path, trial):
    start = read(tmp_path, trial, HEADER + GOOD)
    with pytest.raises(InputError, match=r"^start clicks: point 'FL' is clicked in no view"):
        check_start(start[:4], trial, SIZES)
    start.loc[2, "u"] = float("nan")
    with pytest.raises(InputError, match=r"^start clicks: view cam2, point FR has u = nan, v = 6"):
        check_start(start, trial, SIZES)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        (
            "CollectedData_me.csv",
            "scorer,,,me,me\nbodyparts,,,FR,FR\ncoords,,,x,y\nlabeled-data,film,img05.png,3,4\n",
            r"points of another program \(collected\)",
        ),
        ("run_xypts.csv", "pt1_cam1_X,pt1_cam1_Y\n3,4\n", r"points of another program \(dltdv\)"),
        ("clicks.json", '[{"data": {"img": "f.png"}}]', "a JSON file, as COCO and Label Studio"),
    ],
)
def test_clicks_of_other_programs_are_refused_with_what_makes_them_clicks(
    tmp_path, trial, name, text, message
):
    """DeepLabCut's labels: 'column me is there twice; keep one of them'."""
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        read_start(tmp_path / name, trial)
    assert "the columns frame, view, point, u, v" in str(caught.value)
    if name.endswith("csv"):
        assert f"pawnb convert {name} start.csv --to csv --fps" in str(caught.value)


def test_what_convert_makes_of_labels_is_read_as_clicks(tmp_path):
    """The way that the refusal names, as it names it."""
    labels = tmp_path / "CollectedData_me.csv"
    labels.write_text(
        "scorer,,,me,me,me,me\nbodyparts,,,FR,FR,HR,HR\ncoords,,,x,y,x,y\n"
        "labeled-data,film,img05.png,3,4,5,6\n"
    )
    (made,) = pawnb.convert_tracks(labels, tmp_path / "start.csv", to="csv", fps=50.0)
    made.write_text(made.read_text().replace(",image,", ",side,"))
    views = (View(name="side", video="1.avi", points=("FR", "HR")),)
    trial = Trial(kind="paws", name="t", fps=50.0, animal=Animal(id="m"), views=views)
    clicks = read_start(made, trial)
    assert clicks["frame"].tolist() == [5, 5]
    assert clicks[["u", "v"]].to_numpy().tolist() == [[3, 4], [5, 6]]


def test_in_which_film_a_click_was_made_is_known_until_it_is_changed(tmp_path):
    """The codes are in a file of their own: columns of clicks are those that others read."""
    path = tmp_path / "start.csv"
    clicks = pd.DataFrame(
        [(3, "a", "FR", 1.5, 2.0), (3, "b", "FR", 4.0, 5.25)], columns=list(START_COLUMNS)
    )
    write_start(clicks.assign(film=["p1", ""]), path)
    assert path.read_text() == "frame,view,point,u,v\n3,a,FR,1.5,2.0\n3,b,FR,4.0,5.25\n"
    assert films_of_clicks(path) == {(3, "a", "FR", 1.5, 2.0): "p1"}
    assert clicked_films(path) == {"a": {"p1"}}
    write_start(clicks.assign(u=9.0), path)  # as another program does
    assert clicked_films(path) == {}
    (tmp_path / "start.films.json").write_bytes(b"\xffdamaged")
    assert clicked_films(path) == {}
