"""Gait of other programs' tracks in the workbench: alone, beside trials, whose files they are."""

import csv
import shutil

import av
import ipywidgets as widgets
import numpy as np
import pytest
import small_trial as scene

from pawnb import load_tracks, load_trial
from pawnb.widgets.workbench_session import WorkbenchSession

FL_TO_FR = ("FL", "FR")


@pytest.fixture
def described(tmp_path):
    """A trial of three views, started, in the folder itself."""
    scene.describe_trial(tmp_path / "m1")
    (tmp_path / "m1" / "start.csv").write_text("frame,view,point,u,v\n0,cam1,FR,1,1\n")
    return tmp_path / "m1"


def open_form(bench, name="Gait of the tracks here"):
    buttons = {getattr(child, "description", ""): child for child in bench._head.children}
    buttons[name].click()
    return bench.tool


def film(path, n_frames=300):
    """Write a grey film: what is looked at is where the tracks are drawn."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("mjpeg", rate=25)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuvj420p"
        frame = av.VideoFrame.from_ndarray(np.full((64, 96, 3), 90, np.uint8), format="rgb24")
        for _ in range(n_frames):
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
    return path


def press(tool, text):
    """Press the button above a tool."""
    buttons = {button.description: button for button in tool.children[0].children}
    buttons[text].click()


def correct(bench, frame, u, v):
    """Put FR elsewhere in a frame of the review that is open."""
    review = bench.tool.tool
    view = review.session.views[0]
    review.edit("moved", {"frame": frame, "view": view, "point": "FR", "u": u, "v": v})


@pytest.mark.parametrize("name", ["dlc_single.csv", "sleap.analysis.h5"])
@pytest.mark.slow
def test_tracks_of_other_programs_lead_to_their_gait(real_data, tmp_path, opened, name):
    """Phases of the file's formula: FL is 3 rad before FR in a cycle."""
    shutil.copy(real_data("peer-files") / name, tmp_path)
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    bench = opened(tmp_path)
    bench._head.children[1].click()
    form = bench.tool
    assert [label for label, _ in form.files.options] == [name]
    form.analyse()
    assert "expected a number, such as 200" in form.told.value
    form.fps.value = "100"
    form.analyse()
    bench.work.wait(120)
    shown = [line.value for line in bench.tool.tool.children if isinstance(line, widgets.Label)]
    assert "strides of" in shown[0]
    assert any("told from the swing of its feet" in line for line in shown)
    with (tmp_path / "results" / "phases.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if (row["leg"], row["reference"]) == FL_TO_FR]
    assert rows
    for row in rows:
        assert float(row["phase"]) == pytest.approx(1 - 3 / (2 * np.pi), abs=0.01)


@pytest.mark.slow
def test_tracks_of_other_programs_are_offered_beside_trials(real_data, described, opened):
    """Those that the trial names, and its clicks, are its own."""
    for name in ("dlc_single.csv", "sleap.csv"):
        shutil.copy(real_data("peer-files") / name, described)
    bench = opened(described)
    assert [path.name for path in bench.session.track_files()] == ["dlc_single.csv", "sleap.csv"]
    (described / "results").mkdir()
    (described / "results" / "events.csv").write_text("those of the trial")
    open_form(bench)
    bench.tool.files.value = [str(described / "dlc_single.csv")]
    bench.tool.fps.value = "100"
    bench.tool.analyse()
    bench.work.wait(120)
    assert "strides of" in bench.tool.tool.children[0].value
    assert (described / "results" / "events.csv").read_text() == "those of the trial"
    assert (described / "results_of_tracks" / "events.csv").exists()
    (described / "trial.toml").write_text(
        '[trial]\nkind = "tracks"\nname = "d"\nfps = 100\n[animal]\nid = "d"\nspecies = "mouse"\n'
        '[tracks]\nfile = "dlc_single.csv"\n'
    )
    bench.look_again()
    assert [path.name for path in bench.session.track_files()] == ["sleap.csv"]


@pytest.mark.slow
def test_files_of_one_animal_and_legs_by_other_names_are_told(real_data, tmp_path, opened):
    for name in ("a.csv", "b.csv", "c.csv"):
        text = (real_data("peer-files") / "dlc_single.csv").read_text()
        (tmp_path / name).write_text(text.replace("FR", "paw 1").replace("HL", "paw 2"))
    bench = opened(tmp_path)
    form = open_form(bench)
    form.fps.value = "100"
    form.legs.value = "FR="
    form.analyse()
    assert "expected LEG=POINT" in form.told.value
    form.legs.value, form.animals.value = "FR=paw 1, HL=paw 2, HR, FL", "m1, m1"
    form.analyse()
    bench.work.wait(60)
    assert "3" in bench._told.value
    assert "animals" in bench._told.value
    assert bench.tool is form  # what was typed stays
    form.animals.value, form.groups.value = "m1, m1, m2", "old, old, young"
    form.analyse()
    bench.work.wait(120)
    with (tmp_path / "results" / "strides.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["animal"], row["group"]) for row in rows} == {("m1", "old"), ("m2", "young")}
    assert {row["leg"] for row in rows} == {"FR", "HL"}


def test_files_of_every_format_are_found(tmp_path):
    """Those of OpenSim, Kinovea, Tracker and ImageJ were not looked at for their endings."""
    table = "\tFR\t\t\nt\tx\ty\t\n0.0\t1.0\t2.0\t\n"
    for name, text in {
        "a.trc": "PathFileType\t4\t(X/Y/Z)\ta.trc\n",
        "b.kva": '<?xml version="1.0"?>\n<KinoveaVideoAnalysis>\n</KinoveaVideoAnalysis>',
        "c.txt": table,
        "d.mdf": "MTrackJ 1.5.1 Data File\n",
        "notes.txt": "sunny\n",
    }.items():
        (tmp_path / name).write_text(text)
    found = [path.name for path in WorkbenchSession(tmp_path).track_files()]
    assert found == ["a.trc", "b.kva", "c.txt", "d.mdf"]


def test_one_file_of_each_recording_is_chosen(real_data, tmp_path, opened):
    peers = real_data("peer-files")
    for source, name in (
        ("dlc_single.csv", "m1DLC_x.csv"), ("dlc_single.h5", "m1DLC_x.h5"),
        ("dlc_single.csv", "m1DLC_x_filtered.csv"), ("sleap.slp", "m2.slp"),
        ("sleap.analysis.h5", "m2.analysis.h5"), ("anipose_3d.csv", "m3.csv"),
    ):  # fmt: skip
        shutil.copy(peers / source, tmp_path / name)
    form = open_form(opened(tmp_path))
    assert len(form.files.options) == 6
    assert [name.rpartition("/")[2] for name in form.files.value] == [
        "m1DLC_x.csv", "m2.analysis.h5", "m3.csv",
    ]  # fmt: skip


@pytest.mark.slow
def test_tracks_of_other_programs_are_corrected_on_their_film_before_the_gait(
    real_data, tmp_path, opened
):
    path = tmp_path / "m1DLC_net.csv"
    shutil.copy(real_data("peer-files") / "dlc_single.csv", path)
    film(tmp_path / "m1.avi")
    film(tmp_path / "m10.avi", 2)
    bench = opened(tmp_path)
    form = open_form(bench, "Look at the tracks here, and their gait")
    assert form.film.value == (str(tmp_path / "m1.avi"),)  # not m10
    form.film.value = ()
    form.review()
    assert "choose one file of tracks, and its film" in form.told.value
    form.film.value = (str(tmp_path / "m1.avi"),)
    form.review()
    assert "expected a number, such as 200" in form.told.value
    form.fps.value = "100"
    form.review()
    correct(bench, 7, 33.0, 44.0)
    press(bench.tool, "Save, and analyse the gait")
    bench.work.wait(120)
    shown = [line.value for line in bench.tool.tool.children if isinstance(line, widgets.Label)]
    assert "strides of" in shown[0]
    saved = load_tracks(tmp_path / "corrected_m1DLC_net.csv", fps=100.0)
    assert saved["position"].sel(keypoint="FR").to_numpy()[7, :, 0].tolist() == [33.0, 44.0]
    with (tmp_path / "results" / "strides.csv").open() as file:
        assert {row["trial"] for row in csv.DictReader(file)} == {"m1"}
    assert "corrected_m1DLC_net.csv" in (tmp_path / "results" / "provenance.json").read_text()
    # the corrected file stands for the recording, and its review goes on where it was
    bench.look_again()
    form = open_form(bench, "Look at the tracks here, and their gait")
    assert [name.rpartition("/")[2] for name in form.files.value] == ["corrected_m1DLC_net.csv"]
    form.fps.value = "100"
    form.review()
    assert len(bench.tool.tool.corrected.corrections) == 1
    assert not (tmp_path / "corrected_corrected_m1DLC_net.csv").exists()


TRIAL_OF_TRACKS = """[trial]
kind = "tracks"
name = "m1"
fps = 100
[animal]
id = "m1"
species = "mouse"
{views}[tracks]
file = "m1DLC_net.csv"  # of the network
"""
VIEWS = '[[views]]\nname = "side"\nvideo = "{}"\n'


@pytest.mark.parametrize("views", ["", VIEWS.format("film.avi")])
@pytest.mark.slow
def test_a_trial_of_tracks_is_reviewed_on_its_film_and_goes_on_with_the_corrected_file(
    real_data, tmp_path, opened, views
):
    shutil.copy(real_data("peer-files") / "dlc_single.csv", tmp_path / "m1DLC_net.csv")
    (tmp_path / "trial.toml").write_text(TRIAL_OF_TRACKS.format(views=views))
    bench = opened(tmp_path)
    assert "review" not in bench.session.states[0].steps  # there is no film yet
    film(tmp_path / ("film.avi" if views else "m1.avi"))
    bench.look_again()
    state = bench.session.states[0]
    assert state.next_step == "gait"
    assert "review" in state.steps
    bench.do("review", state.folder)
    correct(bench, 7, 33.0, 44.0)
    press(bench.tool, "Save, and analyse the gait")
    bench.work.wait(120)
    text = (tmp_path / "trial.toml").read_text()
    assert 'file = "corrected_m1DLC_net.csv"  # of the network' in text
    assert load_trial(tmp_path).tracks_file == "corrected_m1DLC_net.csv"
    state = bench.session.states[0]
    assert state.next_step == "look"
    bench.do("review", state.folder)
    assert len(bench.tool.tool.corrected.corrections) == 1
