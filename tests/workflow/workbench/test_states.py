"""How far a trial is, by what lies beside its trial.toml, and the page that shows it."""

import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from pawnb import InputError, load_trial
from pawnb.core.edits.log import replay
from pawnb.core.rig import load_rig
from pawnb.io.native import write_tracks
from pawnb.workflow.lab import lab_command
from pawnb.workflow.provenance.manifest import writing_results
from pawnb.workflow.workbench.films import find_videos
from pawnb.workflow.workbench.page import PAGE, page_command, write_page
from pawnb.workflow.workbench.states import (
    find_states,
    state_of,
    what_is_wrong,
)

sys.path.append(str(Path(__file__).resolve().parents[2] / "widgets"))
import small_trial as scene


@pytest.fixture
def folder(tmp_path):
    """A trial of three views, described only; its videos are there by name."""
    scene.describe_trial(tmp_path / "b")
    for name in scene.POINTS:
        (tmp_path / "b" / f"{name}.avi").write_bytes(b"")
    return tmp_path / "b"


def click(folder, points=scene.POINTS):
    """Write a start with these points of each view clicked."""
    rows = [f"0,{view},{point},9,9\n" for view, own in points.items() for point in own]
    (folder / "start.csv").write_text("frame,view,point,u,v\n" + "".join(rows))


@pytest.mark.slow
def test_each_step_of_the_work_is_seen_and_the_next_is_named(folder):
    def seen():
        state = state_of(folder)
        return state.done - {"described", "calibrated"}, state.next_step

    assert state_of(folder).done == {"described", "calibrated"}
    assert seen() == (set(), "start")
    click(folder, {"cam1": ["FR"]})  # half done: there is more to click
    assert seen() == (set(), "start")
    click(folder)
    assert seen() == ({"started"}, "track")
    results = folder / "results"
    results.mkdir()
    write_tracks(scene.true_tracks(), results / "tracks.nc")
    assert seen() == ({"started", "tracked"}, "review")
    accept = '{"edit": "accept", "frame": 1, "view": "cam1", "point": "FR"}\n'
    (results / "edits.jsonl").write_text(accept)
    assert seen() == ({"started", "tracked", "reviewed"}, "gait")
    with writing_results(results, run="gait", steps=[{"step": "gait"}]) as staging:
        (staging / "events.csv").write_text("x\n")
    assert seen() == ({"started", "tracked", "reviewed", "analysed"}, "look")
    assert state_of(folder / "trial.toml").steps[0] == "look"
    (results / "events.csv").unlink()  # no longer whole
    assert seen()[1] == "gait"


@pytest.mark.slow
def test_corrections_that_are_not_saved_are_said_and_come_next(folder):
    click(folder)
    results = folder / "results"
    results.mkdir()
    write_tracks(scene.true_tracks(), results / "tracks.nc")
    with writing_results(results, run="gait", steps=[{"step": "gait"}]) as staging:
        (staging / "events.csv").write_text("x\n")
    assert "analysed" in state_of(folder).done
    hidden = '{"edit": "hide", "frame": %d, "view": "cam1", "point": "FR"}\n'
    (results / "edits.jsonl").write_text(hidden % 1 + hidden % 2)
    state = state_of(folder)
    said = "2 corrections are not in the tracks; open the review and press Save tracks."
    assert (state.wrong, state.next_step, state.is_unsaved) == (said, "review", True)
    assert not state.done & {"reviewed", "analysed"}
    rig = load_rig(load_trial(folder))
    saved = replay(scene.true_tracks(), results / "edits.jsonl", rig=rig)
    write_tracks(saved, results / "tracks.nc")
    assert state_of(folder).wrong == ""
    assert "reviewed" in state_of(folder).done


def test_what_is_wrong_is_said_in_words(folder):
    (folder / "cam2.avi").unlink()
    assert "cam2.avi: no such video" in state_of(folder).wrong
    (folder / "DLTcoefs.csv").unlink()
    assert "calibrated" not in state_of(folder).done
    (folder / "trial.toml").write_text("[trial]\nfsp = 250\n")
    state = state_of(folder)
    assert (state.next_step, state.steps) == ("mend", ("mend",))
    assert "did you mean 'fps'" in state.wrong
    assert what_is_wrong(state) == [state.wrong]


def test_trials_are_found_in_a_folder_and_three_below(folder, tmp_path):
    for place in ("a", "c/d", "c/e/f", "g/h/i/too deep"):
        shutil.copytree(folder, tmp_path / place)
    states = find_states(tmp_path)
    assert [str(s.folder.relative_to(tmp_path)) for s in states] == ["a", "b", "c/d", "c/e/f"]
    assert [s.folder for s in find_states(folder)] == [folder]
    assert [(s.next_step, "described" in s.done) for s in states] == [("start", True)] * 4
    with pytest.raises(InputError, match="no such folder"):
        find_states(tmp_path / "none")
    assert [v.name for v in find_videos(folder)] == ["cam1.avi", "cam2.avi", "cam3.avi"]


def source(page):
    return json.loads(page.read_text())["cells"][0]["source"]


def test_a_page_is_written_for_a_folder_a_trial_or_videos(folder, tmp_path):
    assert write_page([tmp_path]) == tmp_path / PAGE
    assert source(tmp_path / PAGE) == 'import pawnb\npawnb.Workbench(".")'
    assert write_page([folder / "trial.toml"]) == folder / PAGE
    page = write_page([folder / "cam1.avi", folder / "cam2.avi"])
    assert source(page).endswith("pawnb.Workbench(\".\", videos=['cam1.avi', 'cam2.avi'])")
    for paths, words in (
        ([tmp_path / "none"], "no such folder, trial or video"),
        ([folder, tmp_path], "no video; name one folder, one trial, or the videos"),
        ([folder / "DLTcoefs.csv"], "no video"),
    ):
        with pytest.raises(InputError, match=words):
            write_page(paths)


def test_a_page_of_videos_on_several_drives_names_them_whole(folder, monkeypatch):
    def other_drive(path, start):
        raise ValueError("path is on mount 'E:', start on mount 'D:'")

    monkeypatch.setattr(os.path, "relpath", other_drive)
    video = folder / "cam1.avi"
    page = write_page([video])
    assert source(page).endswith(f"videos=[{video.resolve().as_posix()!r}])")


def test_a_notebook_of_somebody_else_is_left_as_it_is(tmp_path):
    (tmp_path / PAGE).write_text('{"cells": [], "metadata": {}}')
    with pytest.raises(InputError, match="another notebook has the name of the page"):
        write_page([tmp_path])
    assert (tmp_path / PAGE).read_text() == '{"cells": [], "metadata": {}}'


def test_the_page_opens_alone_and_its_cell_is_run_by_our_extension(tmp_path):
    words = page_command([tmp_path], browser=False, port=8899)
    assert f"--LabApp.default_url=/doc/tree/{PAGE}" in words
    assert {"--port=8899", "--no-browser"} <= set(words)
    (place,) = (word.split("=", 1)[1] for word in words if "extra_labextensions_path" in word)
    package = json.loads((Path(place) / "pawnb-open" / "package.json").read_text())
    assert (Path(place) / "pawnb-open" / package["jupyterlab"]["_build"]["load"]).is_file()
    # without that, it is what pawnb lab does
    plain = lab_command(tmp_path / PAGE, browser=False, port=8899)
    assert [word.replace("/lab/tree/", "/doc/tree/") for word in plain] == words[:-1]


def test_tracks_made_elsewhere_are_reviewed_once_a_review_has_saved_them(tmp_path):
    text = (
        '[trial]\nkind = "tracks"\nname = "m1"\nfps = 100\n[animal]\nid = "m1"\n'
        '[tracks]\nfile = "{}"\n'
    )
    for file, told in (("m1DLC.csv", False), ("corrected_m1DLC.csv", True)):
        (tmp_path / "trial.toml").write_text(text.format(file))
        state = state_of(tmp_path)
        assert "tracked" in state.done
        assert ("reviewed" in state.done) is told
        assert state.next_step == "gait"
