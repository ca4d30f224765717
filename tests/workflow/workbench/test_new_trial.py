"""Bare videos become a trial: by questions, or by what a form takes; never written over."""

import io
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pawnb import InputError, check_trial, cli, load_trial
from pawnb.files import as_word
from pawnb.trial import Animal, Calibration, Trial, View
from pawnb.workflow.workbench.animals import ANIMALS, choose_animal
from pawnb.workflow.workbench.new_trial import new_trial, second_view, toml_of
from pawnb.workflow.workbench.questions import ask_new_trial

sys.path.append(str(Path(__file__).resolve().parents[2] / "widgets"))
import small_trial as scene


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bare") / "m07 runs"
    scene.write_trial(folder)
    (folder / "trial.toml").unlink()
    return folder


@pytest.fixture
def bare(rendered, tmp_path):
    """A folder with the three videos and their coefficients, and no trial."""
    folder = tmp_path / "m07 runs"
    folder.mkdir()
    for file in rendered.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    return folder


def videos(folder):
    return [str(folder / f"cam{k}.avi") for k in (1, 2, 3)]


def answer(*words):
    """Give answers in turn, then the end of the input."""
    left = list(words)

    def ask(_question):
        if not left:
            raise EOFError
        return left.pop(0)

    return ask


def test_questions_make_a_trial_that_is_read_as_it_was_meant(bare):
    said = []
    path = ask_new_trial(
        videos(bare),
        ask=answer(
            "run 3", "m07", "", "250", "", "", "350",  # name, id, mouse, fps, mm, DLT, belt
            "", "0, 100, 640, 360", "", "FR, HR",  # cam1
            "side", "", "y", "FR, HR",  # cam2
            "", "", "", "FR",  # cam3
            "2, 9",  # frames
        ),
        say=said.append,
    )  # fmt: skip
    assert path == bare / "trial.toml"
    assert load_trial(path) == Trial(
        kind="paws", name="run 3", fps=250.0, animal=Animal(id="m07", species="mouse"),
        belt_speed=350.0, folder=bare, frames=(2, 10),
        calibration=Calibration(dlt="DLTcoefs.csv", unit="mm"),
        views=(
            View(name="cam1", video="cam1.avi", crop=(0, 100, 640, 360), points=("FR", "HR")),
            View(name="side", video="cam2.avi", mirror=True, points=("FR", "HR")),
            View(name="cam3", video="cam3.avi", points=("FR",)),
        ),
    )  # fmt: skip
    # a person can read it, and nothing is wrong but what is still to be done
    assert "crop = [0, 100, 640, 360]\n" in path.read_text()
    assert [fault.split(":")[0] for fault in check_trial(bare).faults] == ["no start points"]
    assert any("cam1.avi, 640 x 360 px" in line for line in said)


def test_films_that_were_not_started_together_are_aligned_by_a_flash(bare):
    """The form asked for it; the terminal did not, and all offsets were 0."""
    said = []
    before = ["", "", "", "250", "", "", "", *[""] * 12, ""]  # all frames of the films as they are
    path = ask_new_trial(
        videos(bare), ask=answer(*before, "5 3", "5, 3, 99999", "5, 3, 3", "1, 6"), say=said.append
    )
    trial = load_trial(path)
    assert [view.offset for view in trial.views] == [2, 0, 0]
    assert trial.frames == (1, 7)
    again = " ".join(said)
    assert "expected a whole number for each of cam1, cam2, cam3" in again
    assert "cam3 has frames 0 to" in again
    assert "frames are counted from the first that all of them have" in again


def test_one_film_given_for_two_views_is_said_before_anything_is_asked(bare):
    (bare / "cam2.avi").write_bytes((bare / "cam1.avi").read_bytes())
    said = []
    with pytest.raises(InputError, match="no answer"):
        ask_new_trial(videos(bare), ask=answer(), say=said.append)
    assert "the films of views cam1 and cam2 begin with the same picture" in said[1]


def test_answers_that_make_no_sense_are_asked_again(bare):
    said = []
    path = ask_new_trial(
        videos(bare)[:1],
        ask=answer(
            "", "", "dragon", "8", "", "nose, tail", "fast", "0", "1e3", "cm", "4.8", "",
            "", "0 0 9000 10", "5 5 4 9", "", "maybe", "n", "5", "7 3", "0 99",
            f"0, {scene.N_FRAMES - 1}",
        ),
        say=said.append,
    )  # fmt: skip
    trial = load_trial(path)
    assert (trial.name, trial.animal.id, trial.fps) == ("m07 runs", "m07 runs", 1000.0)
    assert trial.views[0].points == ("nose", "tail")
    assert trial.frames is None
    assert (trial.calibration.px_per_unit, trial.calibration.unit) == (4.8, "cm")
    again = " ".join(said)
    for words in (
        "'dragon' is no animal of the list", "name at least one", "'fast' is no number above 0",
        "'0' is no number above 0", "the picture has 640 x 360 px only",
        "left must be less than right", "answer y or n", "expected two whole numbers",
        "frames 7 to 3 are to be used; expected two of frames 0 to",
    ):  # fmt: skip
        assert words in again, words


def test_answers_that_end_early_write_nothing(bare):
    with pytest.raises(InputError, match="no answer to 'Which animal', so nothing was written"):
        ask_new_trial(videos(bare), ask=answer("", ""), say=lambda _: None)
    assert not (bare / "trial.toml").exists()


def test_what_cannot_be_used_is_refused_before_anything_is_asked(bare, monkeypatch):
    whole = (bare / "cam1.avi").read_bytes()
    (bare / "cam1.avi").write_bytes(whole[: len(whole) * 2 // 3])
    said = []
    with pytest.raises(InputError, match="no answer to 'Name of the trial'"):
        ask_new_trial(videos(bare), ask=answer(), say=said.append)
    assert "is cut short" in said[1]  # known before the first answer
    (bare / "cam2.avi").write_bytes(b"")
    with pytest.raises(InputError, match=r"cam2\.avi: the file is empty"):
        ask_new_trial(videos(bare), ask=answer(), say=said.append)
    monkeypatch.setattr(os, "access", lambda *_: False)  # a shared folder of films
    with pytest.raises(InputError, match="nothing can be written in this folder; name another"):
        ask_new_trial(videos(bare), ask=answer(), say=said.append)


def test_a_trial_that_is_there_is_never_written_over(bare):
    made = new_trial(videos(bare))
    made.fps = 250.0
    (bare / "trial.toml").write_text("mine")
    with pytest.raises(InputError, match="there is a trial already, and it is left as it is"):
        made.write()
    with pytest.raises(InputError, match="there is a trial already"):
        new_trial(videos(bare))
    assert (bare / "trial.toml").read_text() == "mine"


def test_what_cannot_be_is_refused_before_anything_is_written(bare):
    made = new_trial(videos(bare))
    with pytest.raises(InputError, match="how many frames were filmed in a second"):
        made.write()
    made.fps = 250.0
    for wrong, words in (
        ({"animal": choose_animal("other")}, "no point to track is named"),
        ({"px_per_unit": 3.0}, "DLT coefficients or a scale, not both"),
        ({"px_per_unit": 3.0, "dlt": None}, "a scale in px is that of a single view"),
        ({"views": made.views[:2]}, "3"),  # three columns of coefficients, two views
        ({"views": [replace(made.views[0], points=("nose",))]}, "which is none of the points"),
        ({"views": [replace(made.views[0], crop=(0, 0, 10, 999))], "dlt": None}, "crop"),
    ):
        with pytest.raises(InputError, match=words):
            replace(made, **wrong).write()
    assert not (bare / "trial.toml").exists()
    with pytest.raises(InputError, match="no such video"):
        new_trial([bare / "none.avi"])


def test_views_are_called_after_their_files_and_each_otherwise(bare, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "cam1.avi").write_bytes((bare / "cam1.avi").read_bytes())
    made = new_trial([bare / "cam1.avi", other / "cam1.avi"])
    assert [view.name for view in made.views] == ["cam1", "cam1-2"]
    assert made.dlt == bare / "DLTcoefs.csv"
    made.fps, made.dlt = 250.0, None
    assert load_trial(made.write()).views[1].video == "../other/cam1.avi"
    assert second_view(made.views[0], ["cam1", "cam1-2"]).name == "cam1-3"


@pytest.mark.parametrize(
    "name", ["<img src=x onerror=alert(1)>", 'a "b" \\c', "\x7f", "שלום", "#x"]
)
def test_hostile_names_are_kept_as_they_are(bare, name):
    made = new_trial(videos(bare)[:1])
    made.fps, made.name, made.animal_id = 250.0, name, name
    made.animal, made.points = choose_animal("other"), (name, "b")
    trial = load_trial(made.write())
    assert (trial.name, trial.animal.id, trial.views[0].points) == (name, name, (name, "b"))


def test_every_animal_of_the_list_makes_a_trial_that_can_be_read(bare):
    for place, animal in enumerate(ANIMALS, start=1):
        assert choose_animal(str(place)) is choose_animal(animal.name.upper()) is animal
        made = replace(new_trial(videos(bare)[:1]), fps=250.0, animal=animal, points=("nose",))
        trial = load_trial(made.write())
        assert trial.kind == animal.kind
        assert trial.views[0].points == (
            animal.points or (("nose",) if trial.kind == "paws" else ())
        )
        (bare / "trial.toml").unlink()


def test_a_list_stands_on_one_line(bare):
    trial = load_trial(scene.describe_trial(bare))
    lines = toml_of(trial).splitlines()
    assert 'points = ["FR", "HR"]' in lines
    assert np.sum([line == "[[views]]" for line in lines]) == 3


def test_the_command_asks_and_says_what_comes_next(bare, capsys, monkeypatch):
    answers = ["", "", "", "250", *[""] * 16]
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(answers)))
    assert cli.main(["new", *videos(bare)]) == 0
    said = f"wrote {bare / 'trial.toml'}; next: pawnb open {as_word(bare)}"
    assert said in capsys.readouterr().out
    assert cli.main(["new", *videos(bare)]) == 2
    assert "there is a trial already" in capsys.readouterr().err
