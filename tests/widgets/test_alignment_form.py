"""Films that were not started together: marked by a flash in the form, written as offsets."""

import json

import av
import numpy as np
import pytest
import small_trial as scene

import pawnb
from pawnb.core.video import open_views
from pawnb.widgets.trial_form import TrialForm

BEGINS = {"cam1": 0, "cam2": 5, "cam3": 2}
"""Frames of the scene that were over when each camera was started."""
FLASH = 9


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    """Three films of one scene that begin at other frames, without any trial."""
    folder = tmp_path_factory.mktemp("films")
    for k, (name, begin) in enumerate(BEGINS.items()):
        with av.open(str(folder / f"{name}.avi"), "w") as file:
            stream = file.add_stream("mjpeg", rate=25)
            stream.width, stream.height, stream.pix_fmt = scene.WIDTH, scene.HEIGHT, "yuvj420p"
            stream.options = {"qscale": "3"}
            for frame in range(begin, scene.N_FRAMES):
                picture = av.VideoFrame.from_ndarray(scene.picture(frame, k), "rgb24")
                file.mux(stream.encode(picture))
            file.mux(stream.encode())
    return folder


@pytest.fixture
def form(rendered, tmp_path):
    made = TrialForm([rendered / f"{name}.avi" for name in BEGINS], tmp_path)
    made.fps.value = "250"
    yield made
    made.close()


def scene_frames(views, frame):
    """Read the frame of the scene that each view shows from its bar code."""
    found = {}
    for name, shown in views.frame(frame).items():
        row = shown.image()[scene.SQUARE // 2, :, 0]
        bits = row[scene.SQUARE // 2 :: scene.SQUARE][: scene.BITS] > 128
        found[name] = int(np.dot(bits, 1 << np.arange(scene.BITS)))
    return found


def mark_flash(form):
    for row, begin in zip(form._rows, BEGINS.values(), strict=True):
        # the film shows the frames of its file until the flash is marked in all
        form._canvas.frame = FLASH - begin
        row._flash.take.click()


def test_a_flash_that_is_marked_in_each_film_aligns_them(form, tmp_path):
    assert "The films differ in length (frames: cam1 40, cam2 35, cam3 38)" in form._aligned.value
    form.first.value = "3"
    mark_flash(form)
    # all pictures show the flash now, and frames are counted anew
    assert set(scene_frames(form._canvas._own_views, form._canvas.frame).values()) == {FLASH}
    assert "frame 0 is frame 5 of cam1, frame 0 of cam2, frame 3 of cam3" in form._aligned.value
    assert form.first.value == ""
    assert form.write() == tmp_path / "trial.toml"
    trial = pawnb.load_trial(tmp_path)
    assert [view.offset for view in trial.views] == [5, 0, 3]
    with open_views(trial) as views:
        assert set(scene_frames(views, 7).values()) == {12}
        assert views.n_frames == scene.N_FRAMES - 5


def test_a_flash_that_lacks_in_a_film_is_asked_for(form):
    form._rows[0]._flash.field.value = "9"
    form._rows[2]._flash.field.value = "38"
    assert form.write() is None
    assert "the flash is in frame '38' of cam3; expected one of frames 0 to 37" in form._told.value
    form._rows[2]._flash.field.value = "7"
    assert form.write() is None
    assert "the flash is not marked in cam2 yet" in form._told.value
    form._rows[2]._flash.field.value = form._rows[0]._flash.field.value = ""
    assert form.write() is not None


def test_the_flash_is_there_again_when_the_form_is_opened_again(form, rendered, tmp_path):
    mark_flash(form)
    form._rows[0]._flash.field.value = "soon"
    draft = json.loads((tmp_path / ".trial-draft.json").read_text())
    assert [view["event"] for view in draft["more"]] == [9, 4, 7]
    again = TrialForm([rendered / f"{name}.avi" for name in BEGINS], tmp_path)
    assert [row._flash.field.value for row in again._rows] == ["9", "4", "7"]
    assert set(scene_frames(again._canvas._own_views, 0).values()) == {5}
    again.close()


def test_two_views_of_one_film_are_marked_once(form):
    form._add(form.made.views[1])
    assert [row._flash is None for row in form._rows] == [False, False, True, False]
    mark = form._rows[1]._flash.field
    mark.value = "4"
    assert [view.event for view in form.made.views] == [None, 4, 4, None]


@pytest.fixture
def described(form, tmp_path):
    """A trial of the films, taken to have been started together, and clicked."""
    form.first.value, form.last.value = "0", "34"
    assert form.write() is not None
    (tmp_path / "start.csv").write_text("frame,view,point,u,v\n0,cam1,FR,110,270\n")
    return tmp_path


def test_the_films_of_a_trial_are_aligned_and_clicked_again(described, opened):
    before = (described / "trial.toml").read_text()
    bench = opened(described)
    assert "align" in bench.session.states[0].steps
    bench.do("align", described)
    form = bench.tool.tool
    assert not form.write()
    assert "no flash is marked yet" in form._told.value
    for mark, begin in zip(form.marks, BEGINS.values(), strict=True):
        form.canvas.frame = FLASH - begin
        mark.take.click()
    assert "Frame 0 will be frame 5 of cam1, frame 0 of cam2, frame 3 of cam3" in form._told.value
    assert form.write()
    trial = pawnb.load_trial(described)
    assert [view.offset for view in trial.views] == [5, 0, 3]
    assert (described / "trial.toml").read_text().replace("offset = 5\n", "").replace(
        "offset = 3\n", ""
    ) == before
    # clicks are of the pictures as they were: they are kept, and made again
    assert "those of before are in start.before.csv" in bench._told.value
    assert not (described / "start.csv").exists()
    assert type(bench.tool.tool).__name__ == "ClickInitialiser"
    # what is marked then is the frame of the file, whatever the pictures are aligned by
    bench.do("align", described)
    form = bench.tool.tool
    form.canvas.frame = 4
    for mark in form.marks:
        mark.take.click()
    assert [mark.frame() for mark in form.marks] == [9, 4, 7]
    assert form.write()
    assert [view.offset for view in pawnb.load_trial(described).views] == [5, 0, 3]


def test_corrected_points_keep_their_pictures(described, opened):
    (described / "results").mkdir()
    line = {"edit": "accept", "frame": 3, "view": "cam1", "point": "FR", "u": 9.0, "v": 9.0}
    (described / "results" / "edits.jsonl").write_text(json.dumps(line) + "\n")
    bench = opened(described)
    bench.do("align", described)
    form = bench.tool.tool
    for mark, frame in zip(form.marks, "947", strict=True):
        mark.field.value = frame
    assert not form.write()
    assert "holds corrections of the pictures as they are aligned now" in form._told.value
    assert [view.offset for view in pawnb.load_trial(described).views] == [0, 0, 0]
    assert (described / "start.csv").exists()
