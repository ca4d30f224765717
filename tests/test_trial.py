"""Trials: what is read is what was written, and typing errors are named."""

from __future__ import annotations

from pathlib import Path, PureWindowsPath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.trial import Animal, Calibration, Trial, View, load_trial, save_trial

TEXT = """
[trial]
kind = "paws"
name = "m07-35cms-03"
fps = 250
frames = [0, 1000]
[animal]
id = "m07"
group = "control"
mass_g = 21.5
body = ["tail", "nose"]
[treadmill]
belt_speed = 350
[[views]]
name = "cam1"
video = "cam1.avi"
crop = [0, 0, 2048, 700]
bayer = "rggb"
points = ["FR", "HR"]
[[views]]
name = "cam2"
video = "cam2.avi"
mirror = true
facing = -1
offset = 3
[calibration]
dlt = "DLTcoefs.csv"
unit = "cm"
forward = [0, 2, 0]
[start]
points = "start.csv"
[tracking]
median_px = 3
"""


def write(folder: Path, old: str = "", new: str = "") -> Path:
    assert old in TEXT
    path = folder / "trial.toml"
    path.write_text(TEXT.replace(old, new) if old else TEXT)
    return path


def test_every_field_arrives(tmp_path):
    trial = load_trial(write(tmp_path))
    assert trial == Trial(
        kind="paws",
        name="m07-35cms-03",
        fps=250.0,
        frames=(0, 1000),
        animal=Animal(id="m07", group="control", body=("tail", "nose"), extra={"mass_g": 21.5}),
        folder=tmp_path,
        belt_speed=350.0,
        views=(
            View(
                name="cam1",
                video="cam1.avi",
                crop=(0, 0, 2048, 700),
                bayer="rggb",
                points=("FR", "HR"),
            ),
            View(name="cam2", video="cam2.avi", mirror=True, facing=-1, offset=3),
        ),
        # a direction of any length is made a unit vector
        calibration=Calibration(dlt="DLTcoefs.csv", unit="cm", forward=(0.0, 1.0, 0.0)),
        start_points="start.csv",
        tracking={"median_px": 3},
    )


def test_the_folder_will_do(tmp_path):
    assert load_trial(tmp_path if write(tmp_path) else "") == load_trial(tmp_path / "trial.toml")


def test_name_defaults_to_the_folder(tmp_path):
    trial = load_trial(write(tmp_path, 'name = "m07-35cms-03"', ""))
    assert trial.name == tmp_path.name


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "fps = 250",
            "",
            "[trial] fps is missing; give the frame rate of the recording in frames per second, "
            "for instance fps = 250.0.",
        ),
        ("fps = 250", "fps = 0", "[trial] fps is 0.0; expected a number above 0."),
        ("fps = 250", 'fps = "fast"', "[trial]: fps is 'fast'; expected a number."),
        ("fps = 250", 'fps = "250"', "[trial]: fps is '250'; expected a number."),
        ("fps = 250", "fps = inf", "[trial]: fps is inf; expected a number."),
        ("belt_speed = 350", "belt_speed = nan", "belt_speed is nan; expected a number or text."),
        (
            'points = ["FR", "HR"]',
            'points = ["FR", "HR", "FR"]',
            "[[views]] number 1: points of view 'cam1': the name 'FR' is there twice; give each "
            "its own.",
        ),
        (
            "frames = [0, 1000]",
            "frames = [10, 10]",
            "[trial] frames is [10, 10]; expected first and one past last, for instance [0, 1000].",
        ),
        (
            'kind = "paws"',
            'kind = "paw"',
            "[trial]: kind is 'paw'; expected one of 'paws', 'pose', 'tracks'.",
        ),
        (
            "[animal]",
            "[animl]",
            "unknown section [animl] (did you mean 'animal'?); expected trial, treadmill, start, "
            "tracks, animal, views, calibration, tracking, gait.",
        ),
        (
            "belt_speed",
            "belt_sped",
            "[treadmill] has an unknown field 'belt_sped' (did you mean 'belt_speed'?); "
            "known are belt_speed.",
        ),
        (
            "crop = [0, 0, 2048, 700]",
            "crop = [9, 0, 9, 700]",
            "[[views]] number 1: crop is [9, 0, 9, 700]; expected u0, v0, u1, v1 with u0 < u1 and "
            "v0 < v1, half open; if 9 and 700 are its width and height, write [9, 0, 18, 700].",
        ),
        (
            '"rggb"',
            '"rgb"',
            "[[views]] number 1: bayer is 'rgb'; expected one of 'rggb', 'bggr', 'grbg', 'gbrg'.",
        ),
        (
            "facing = -1",
            "facing = 2",
            "[[views]] number 2: facing is 2; expected 1 (right) or -1 (left).",
        ),
        (
            'name = "cam2"',
            'name = "cam1"',
            "views: the name 'cam1' is there twice; give each its own.",
        ),
        (
            'video = "cam2.avi"',
            "",
            '[[views]] number 2: video is missing; add video = "...".',
        ),
        (
            "forward = [0, 2, 0]",
            "forward = [0, 0, 0]",
            "[calibration]: forward is [0.0, 0.0, 0.0]; expected a direction that is not zero.",
        ),
        (
            "forward = [0, 2, 0]",
            "px_per_unit = 4.8",
            "[calibration]: has both dlt and px_per_unit; keep the one that is meant.",
        ),
        (
            'dlt = "DLTcoefs.csv"',
            'dlt = "calibration.toml"',
            "[calibration]: dlt names calibration.toml; expected a csv of 11 rows. A calibration "
            'of another program is named by anipose = "calibration.toml" instead of dlt and lens.',
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path, old, new, message):
    path = write(tmp_path, old, new)
    with pytest.raises(InputError) as caught:
        load_trial(path)
    assert str(caught.value) == f"{path}: {message}"


def test_missing_file_and_text_that_is_no_toml(tmp_path):
    with pytest.raises(InputError, match=r"no such file; expected a trial\.toml or the folder"):
        load_trial(tmp_path / "nowhere")
    (tmp_path / "trial.toml").write_text("[trial\n")
    with pytest.raises(InputError, match=r"not a TOML file .*mend that line"):
        load_trial(tmp_path)


@pytest.mark.parametrize("name", ["run 1.mp4", "RUN.AVI"])
def test_a_video_given_for_a_trial_says_how_to_make_one(tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00\x00\x00\x18ftypisom\xff\xfe")
    with pytest.raises(InputError) as caught:
        load_trial(tmp_path / name)
    assert str(caught.value) == (
        f"{tmp_path / name}: a video, not a trial; expected a trial.toml or the folder that holds "
        "one: make one of videos by `pawnb new VIDEO ...`, or by clicks with `pawnb open VIDEO "
        "...`."
    )


def test_a_trial_without_views_or_tracks_is_refused(tmp_path):
    path = tmp_path / "trial.toml"
    path.write_text("[trial]\nfps = 100\n")
    with pytest.raises(InputError, match=r"no \[\[views\]\]; a trial of kind 'paws'"):
        load_trial(path)
    path.write_text('[trial]\nkind = "tracks"\nfps = 100\n')
    with pytest.raises(InputError, match=r"\[tracks\] file is missing"):
        load_trial(path)


def test_asking_for_an_unknown_view_suggests_the_near_one(tmp_path):
    trial = load_trial(write(tmp_path))
    assert trial.view("cam2").mirror
    with pytest.raises(InputError, match=r"has no view 'cam3' \(did you mean 'cam"):
        trial.view("cam3")


names = st.text("abcdef_-", min_size=1, max_size=8)
views = st.builds(
    View,
    name=names,
    video=names,
    crop=st.none() | st.tuples(st.integers(0, 5), st.integers(0, 5), *[st.integers(6, 99)] * 2),
    mirror=st.booleans(),
    bayer=st.sampled_from([None, "rggb", "gbrg"]),
    offset=st.integers(-9, 9),
    facing=st.sampled_from([None, 1, -1]),
    points=st.lists(names, max_size=3, unique=True).map(tuple),
)


@pytest.mark.slow
@given(
    views=st.lists(views, min_size=1, max_size=3, unique_by=lambda v: v.name).map(tuple),
    fps=st.floats(0.1, 1e4),
    belt=st.none() | st.floats(0, 1e3) | names,
    frames=st.none() | st.tuples(st.integers(0, 9), st.integers(10, 99)),
    legs=st.dictionaries(names, names, max_size=2),
)
def test_what_is_saved_is_what_is_loaded(tmp_path_factory, views, fps, belt, frames, legs):
    folder = tmp_path_factory.mktemp("trial")
    trial = Trial(
        kind="paws",
        name="t",
        fps=fps,
        animal=Animal(id="a", extra={"mass_g": 3}),
        folder=folder,
        belt_speed=belt,
        frames=frames,
        views=views,
        tracks_file="x.csv",
        tracks_legs=legs,
    )
    save_trial(trial, folder / "trial.toml")
    assert load_trial(folder) == trial


@pytest.mark.parametrize("name", ["tracking", "calibration", "treadmill", "animal"])
def test_a_value_where_a_section_belongs_is_said(tmp_path, name):
    path = tmp_path / "trial.toml"
    path.write_text(
        f'{name} = 5\n[trial]\nfps = 250\n[[views]]\nname = "cam1"\nvideo = "cam1.avi"\n'
    )
    with pytest.raises(InputError, match=rf"\[{name}\] is 5; expected a section with "):
        load_trial(path)


def test_across_names_two_points(tmp_path):
    two = load_trial(write(tmp_path, 'id = "m07"', 'id = "m07"\nacross = ["ear_L", "ear_R"]'))
    assert two.animal.across == ("ear_L", "ear_R")
    with pytest.raises(
        InputError, match=r"\[animal\]: across names 1 points; expected two, at the"
    ):
        load_trial(write(tmp_path, 'id = "m07"', 'id = "m07"\nacross = ["ear_L"]'))


def made(**fields):
    return Trial(**{"kind": "paws", "name": "t", "fps": 250, "animal": Animal(id="a"), **fields})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"kind": "paw"}, "trial kind is 'paw'; expected one of 'paws', 'pose', 'tracks'."),
        ({"fps": "250"}, "trial fps is '250'; expected a number."),
        ({"fps": True}, "trial fps is True; expected a number."),
        ({"fps": 0}, "[trial] fps is 0.0; expected a number above 0."),
        ({"fps": float("nan")}, "trial fps is nan; expected a number."),
        ({"fps": 10**400}, "expected a number."),
        ({"frames": (10, 10)}, "[trial] frames is [10, 10]; expected first and one past last"),
        ({"frames": "ab"}, "trial frames is 'ab'; expected a list of 2, each a whole number."),
        ({"belt_speed": float("inf")}, "trial belt_speed is inf; expected a number or text."),
        ({"animal": "m07"}, "trial animal is 'm07'; expected Animal."),
        ({"views": View(name="a", video="a")}, "trial views is View("),
        ({"views": (View(name="a", video="a"),) * 2}, "views: the name 'a' is there twice"),
        ({"tracking": []}, "trial tracking is []; expected Mapping."),
        ({"start_points": 3}, "trial start_points is 3; expected text."),
        ({"name": None}, "trial name is None; expected text."),
    ],
)
def test_a_trial_made_in_python_is_checked_as_one_from_a_file(fields, message):
    with pytest.raises(InputError) as caught:
        made(**fields)
    assert message in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    ("part", "fields"),
    [
        (View, {"name": "a", "video": "a", "crop": (5, 5, 5, 9)}),
        (View, {"name": "a", "video": "a", "crop": (0, 0, 5)}),
        (View, {"name": "a", "video": "a", "points": "FR"}),
        (View, {"name": "a", "video": "a", "mirror": "no"}),
        (View, {"name": "a", "video": "a", "offset": 0.5}),
        (View, {"name": "a", "video": "a", "bayer": "rgb"}),
        (View, {"name": "a", "video": "a", "background_frames": (8, 0)}),
        (View, {"name": "", "video": "a"}),
        (Calibration, {"px_per_unit": float("inf")}),
        (Calibration, {"px_per_unit": -1}),
        (Calibration, {"up": (0, 0)}),
        (Calibration, {"forward": (0, float("nan"), 0)}),
        (Animal, {"id": 7}),
        (Animal, {"id": "a", "body": ("nose", "nose")}),
        (Animal, {"id": "a", "across": ("ear",)}),
    ],
)
def test_parts_made_in_python_are_checked(part, fields):
    with pytest.raises(InputError):
        part(**fields)


def test_what_is_meant_is_taken(tmp_path):
    """Paths for text, lists for tuples and whole numbers for numbers change nothing.

    A path of Windows is written as every system reads it.
    """
    view = View(name="a", video=PureWindowsPath("b") / "c.avi", crop=[0, 0, 5, 5])
    trial = made(folder=str(tmp_path), views=[view], frames=[0, 5])
    assert trial == made(
        folder=tmp_path,
        views=(View(name="a", video="b/c.avi", crop=(0, 0, 5, 5)),),
        frames=(0, 5),
        fps=250.0,
    )


DETECTIONS = "[tracking]\nmedian_px = 3"


@pytest.mark.parametrize(
    "given",
    [
        'detections = ["", "b.csv"]',
        'detections = { cam2 = "b.csv" }',
        'detections = { cam1 = "", cam2 = "b.csv" }',
    ],
)
def test_predictions_are_no_settings_of_the_tracker(tmp_path, given):
    points = '[tracking.detections_points]\npaw_FR = "FR"'
    trial = load_trial(write(tmp_path, DETECTIONS, f"{DETECTIONS}\n{given}\n{points}"))
    assert trial.tracking == {"median_px": 3}
    assert trial.detections == {"cam2": "b.csv"}
    assert trial.detections_points == {"paw_FR": "FR"}
    save_trial(trial, tmp_path / "copy.toml")
    assert load_trial(tmp_path / "copy.toml") == trial


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            'detections = ["a.csv"]',
            "[tracking] detections has 1 file and the trial has 2 views; expected one a view, in "
            'their order, "" for a view without.',
        ),
        (
            'detections = ["a.csv", "b.csv", "c.csv"]',
            "[tracking] detections has 3 files and the trial has 2 views; expected one a view, in "
            'their order, "" for a view without.',
        ),
        (
            'detections = { cam3 = "a.csv" }',
            "[tracking] detections: there is no view 'cam3' (did you mean 'cam2'?); the views are "
            "cam1, cam2.",
        ),
        (
            "detections = 3",
            '[tracking] detections is 3; expected ["cam1DLC.h5"], one file a view, or '
            '{ cam1 = "cam1DLC.h5" }.',
        ),
        (
            "detections_points = 3",
            '[tracking.detections_points] is 3; expected lines as paw_FR = "FR".',
        ),
        (
            'detections_points = { a = "FR", b = "FR" }',
            "[tracking.detections_points]: 'a' and 'b' are both 'FR'; keep one of them.",
        ),
    ],
)
def test_predictions_that_fit_no_view_are_one_sentence(tmp_path, given, message):
    with pytest.raises(InputError) as error:
        load_trial(write(tmp_path, DETECTIONS, f"{DETECTIONS}\n{given}"))
    assert str(error.value).split(": ", 1)[1] == message


@pytest.mark.parametrize(
    ("given", "named"),
    [('detections = ["a.csv", ""]', "detections"), ('point_tracker = "a.pt"', "point_tracker")],
)
def test_evidence_that_is_named_belongs_to_a_trial_of_paws(tmp_path, given, named):
    path = write(tmp_path, DETECTIONS, f"{DETECTIONS}\n{given}")
    path.write_text(path.read_text().replace('kind = "paws"', 'kind = "pose"'))
    with pytest.raises(InputError, match=f"{named} is for a trial of kind 'paws'"):
        load_trial(path)


def test_a_network_that_follows_points_is_no_setting_of_the_tracker(tmp_path):
    trial = load_trial(write(tmp_path, DETECTIONS, f'{DETECTIONS}\npoint_tracker = "a.pt"'))
    assert trial.tracking == {"median_px": 3}
    assert trial.point_tracker == "a.pt"
    save_trial(trial, tmp_path / "copy.toml")
    assert load_trial(tmp_path / "copy.toml") == trial


def test_a_network_that_is_no_file_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"point_tracker is 3; expected the file of the weights"):
        load_trial(write(tmp_path, DETECTIONS, f"{DETECTIONS}\npoint_tracker = 3"))


def test_tracks_in_the_place_of_a_trial_are_told_where_they_go(tmp_path):
    for name, content in (("m01DLC.csv", b"scorer,net\n"), ("poses.nc", b"\x89HDF\r\n\x1a\n\xff")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=r"this is no trial\.toml; .* gait \(pawnb gait, "):
            load_trial(tmp_path / name)
