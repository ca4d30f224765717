"""Other programs' files are corrected over their videos and written back; the rest is untouched."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import small_trial as scene

from pawnb import load_tracks
from pawnb.errors import InputError
from pawnb.io.formats import recognise_format
from pawnb.widgets import TrackReviewer
from pawnb.workflow.reviewing.foreign import open_foreign

sys.path.append(str(Path(__file__).resolve().parents[1] / "io"))
import foreign_files

FRAMES = 12
FILES = {
    "clipDLC_net.csv": (foreign_files.write_dlc_csv, "deeplabcut", 1),
    "clipDLC_net.h5": (foreign_files.write_dlc_h5, "deeplabcut", 1),
    "clip.slp": (foreign_files.write_slp, "sleap", 1),
    "clip.analysis.h5": (foreign_files.write_analysis_h5, "sleap", 1),
    "clipxypts.csv": (foreign_files.write_dltdv_views, "dltdv", 2),
}


@pytest.fixture(scope="module")
def videos(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small") / "trial"
    scene.write_trial(folder)
    return [folder / "cam1.avi", folder / "cam2.avi"]


@pytest.fixture
def odd_places(monkeypatch):
    """Positions with every bit of their mantissa, which rounding would show."""
    rng = np.random.default_rng(1)
    monkeypatch.setattr(foreign_files, "place", lambda *_: float(rng.uniform(20, 300)))


def uv_of(tracks, view):
    """Return (frames, points, 2) of one view, whatever the format calls it."""
    if "image_position" in tracks:
        return np.moveaxis(tracks["image_position"].to_numpy()[:, view, ..., 0], 1, 2)
    return np.moveaxis(tracks["position"].to_numpy()[..., 0], 1, 2)


def do(widget, action, point, stretch, **more):
    message = {"type": "edit", "who": "a", "n": 1, "what": "stretch", "frame": 0}
    widget._receive(
        widget, message | {"action": action, "point": point, "stretch": stretch} | more, []
    )
    assert widget.alarm == ""


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_what_was_corrected_is_written_back_and_nothing_else(name, videos, odd_places, tmp_path):
    write, program, n_views = FILES[name]
    path = write(tmp_path / name, range(FRAMES))
    before = path.read_bytes()
    widget = TrackReviewer.of_file(path, videos[:n_views], fps=100.0)
    view = widget.session.views[0]
    points = widget.session.points
    message = {"frame": 3, "view": view, "point": points[0], "u": 50.25, "v": 60.5}
    widget.edit("moved", message)
    do(widget, "swap", points[0], (5, 6), other=points[1])
    do(widget, "delete", points[1], (9, 9))
    widget.edit("action", {"action": "save", "frame": 0})
    widget.close()
    assert path.read_bytes() == before
    saved = tmp_path / f"corrected_{name}"
    assert recognise_format(saved) == program
    was, now = (load_tracks(file, fps=100.0) for file in (path, saved))
    assert list(now["keypoint"].to_numpy()) == list(was["keypoint"].to_numpy())
    for v in range(n_views):
        expected = uv_of(was, v).copy()
        if v == 0:
            expected[3, 0] = (50.25, 60.5)
        expected[5:7] = expected[5:7, ::-1]
        expected[9, 1] = np.nan
        np.testing.assert_array_equal(uv_of(now, v), expected)  # to the last bit
    # opened again, the corrections are there
    again = TrackReviewer.of_file(path, videos[:n_views], fps=100.0)
    assert len(again.session.corrections) == 3
    assert again.session.position(3, view, points[0]) == (50.25, 60.5)
    again.close()


@pytest.mark.parametrize("name", FILES)
def test_a_point_that_the_program_did_not_find_is_kept_where_a_person_puts_it(
    name, videos, tmp_path
):
    """It was left out of what was saved, without a word, in every format."""
    write, _, n_views = FILES[name]
    path = write(tmp_path / name, range(FRAMES))
    lacking = TrackReviewer.of_file(path, videos[:n_views], fps=100.0)
    view, points = lacking.session.views[0], lacking.session.points
    for point in points:  # in frame 8 nothing is left
        do(lacking, "delete", point, (8, 9))
    lacking.edit("action", {"action": "save", "frame": 0})
    lacking.close()
    saved = tmp_path / f"corrected_{name}"
    assert np.isnan(uv_of(load_tracks(saved, fps=100.0), 0)[8]).all()
    widget = TrackReviewer.of_file(saved, videos[:n_views], fps=100.0)
    for frame in (8, 9):
        widget.edit("moved", {"frame": frame, "view": view, "point": points[0], "u": 7.5, "v": 9.0})
    widget.edit("action", {"action": "save", "frame": 0})
    widget.close()
    now = uv_of(load_tracks(tmp_path / f"corrected_{saved.name}", fps=100.0), 0)
    assert now[8:10, 0].tolist() == [[7.5, 9.0], [7.5, 9.0]]
    assert np.isnan(now[8:10, 1]).all()


def test_nothing_is_tracked_again_in_tracks_of_another_program(videos, tmp_path):
    path = foreign_files.write_dlc_csv(tmp_path / "clipDLC.csv", range(FRAMES))
    widget = TrackReviewer.of_file(path, videos[0], fps=100.0)
    assert "retrack" not in widget.lanes_do
    assert not {"retrack", "learn"} & {action["id"] for action in widget.actions}
    assert widget.span == [0, FRAMES - 1]
    widget.close()


def test_tracks_that_do_not_fit_the_film_are_said_as_they_are_opened(tmp_path):
    """They were shown, cut to its frames and off its pictures, without a word."""
    film = tmp_path / "clip.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), 100, (160, 120))
    for i in range(FRAMES):
        writer.write(np.full((120, 160, 3), i, np.uint8))
    writer.release()

    def status(name, frames, zoom=1.0):
        places = [f"{i},{zoom * 50:.1f},{zoom * 60:.1f},0.9" for i in frames]
        head = ["scorer,net,net,net", "bodyparts,FR,FR,FR", "coords,x,y,likelihood"]
        (tmp_path / name).write_text("\n".join([*head, *places]) + "\n")
        widget = TrackReviewer.of_file(tmp_path / name, film, fps=100.0)
        widget.close()
        return widget.status

    assert "Note" not in status("fits.csv", range(FRAMES))
    said = status("long.csv", range(2 * FRAMES))
    assert said.startswith("Note: long.csv: frames up to 23, and the film of view 'view' has 12")
    assert "Where only one picture in 2 was tracked" in status("half.csv", range(FRAMES // 2))
    with pytest.raises(
        InputError, match=r"begin with frame 40, and the film has 12, from 0 to 11:"
    ):
        status("clock.csv", range(40, 50))
    said = status("big.csv", range(FRAMES), zoom=4.0)
    assert "100% of the places lie outside of the pictures of view 'view', which have 160" in said


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((["a.avi", "b.avi"], {}), "has 1 view .*, and 2 videos are named"),
        (({"side": "cam1.avi"}, {}), "has the views view, and videos are named for side"),
        (("none.avi", {}), "none.avi: no such video"),
        (("cam1.avi", {"animal": "m9"}), "has no animal 'm9'"),
        (("cam1.avi", {"fps": None}), "does not say its frame rate"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(given, words, tmp_path):
    path = foreign_files.write_dlc_csv(tmp_path / "clipDLC.csv", range(FRAMES))
    videos, options = given
    with pytest.raises(InputError, match=words):
        open_foreign(path, videos, **{"fps": 100.0, **options})


def test_points_in_space_alone_have_nothing_to_be_seen_in(tmp_path):
    path = foreign_files.write_anipose(tmp_path / "clip.csv", range(FRAMES))
    with pytest.raises(InputError, match="points in space, none in pictures"):
        open_foreign(path, [], fps=100.0)
