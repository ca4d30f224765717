"""The page without Python: one file with what was chosen, nothing of it read as HTML or script."""

import base64
import json
import re

import cv2
import numpy as np
import pytest
import small_trial as scene

import pawnb
from pawnb.errors import InputError
from pawnb.widgets import TrackReviewer


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


def data_of(path):
    """Return title, data and text of a page; as in a browser the data ends at the first ``</``."""
    text = path.read_text(encoding="utf-8")
    title = re.search(r"<title>(.*?)</title>", text, re.DOTALL).group(1)
    inside = text.split('id="pawnb-data">', 1)[1].split("</", 1)[0]
    return title, json.loads(inside), text


def frame_number(jpeg):
    image = cv2.imdecode(np.frombuffer(base64.b64decode(jpeg), np.uint8), cv2.IMREAD_COLOR)
    size = scene.SQUARE * image.shape[1] / scene.WIDTH
    at = [(int(size / 2), int((bit + 0.5) * size)) for bit in range(scene.BITS)]
    return sum((image[v, u, 0] > 128) << bit for bit, (v, u) in enumerate(at))


def test_a_page_has_the_frames_their_marks_their_lanes_and_the_corrections(trial_file, tmp_path):
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    widget.edit("moved", {"frame": 12, "view": "cam1", "point": "FR", "u": 99.0, "v": 88.0})
    path = widget.export_page(tmp_path / "page.html", frames=range(10, 15), width=320)
    lanes = widget._lane_bytes[:, 10:15].tobytes()
    widget.close()
    title, data, text = data_of(path)
    assert title == "Review tracks"
    assert data["traits"]["span"] == [10, 14]
    assert [[frame_number(p) for p in one["pictures"]] for one in data["frames"]] == [
        [frame] * 3 for frame in range(10, 15)
    ]
    marks = data["frames"][2]["overlay"]["views"]["cam1"]["points"][0]
    assert (marks["u"], marks["v"], marks["origin"]) == (99.0, 88.0, "edited")
    assert base64.b64decode(data["lanes"]["data"]) == lanes
    assert data["traits"]["actions"] == data["traits"]["lanes_do"] == []
    assert "<summary>1 correction</summary><ol><li>FR in cam1 moved in frame 12</li></ol>" in text
    # nothing is fetched from anywhere
    assert not re.search(r"""(src|href)\s*=\s*["']?http|@import|url\(["']?http""", text)


def test_frames_with_gaps_are_counted_and_keep_their_number_in_words(trial_file, tmp_path):
    path = pawnb.export_page(
        trial_file, scene.true_tracks(), tmp_path / "p.html", frames=[30, 2], edits=tmp_path / "e"
    )
    _, data, _ = data_of(path)
    assert data["traits"]["span"] == [0, 1]
    assert [frame_number(one["pictures"][0]) for one in data["frames"]] == [2, 30]
    captions = [one["overlay"]["caption"] for one in data["frames"]]
    assert captions == ["frame 2 of the recording, 0.008 s", "frame 30 of the recording, 0.120 s"]


def test_names_end_no_script_and_are_no_html(trial_file, tmp_path):
    evil = "</script><img src=x onerror=alert(1)>"
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    widget.label = evil
    path = widget.export_page(tmp_path / "page.html", frames=[0], title=evil)
    widget.close()
    title, data, text = data_of(path)
    assert data["traits"]["label"] == evil
    assert title == "&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt;"
    assert evil not in text
    assert "<img" not in text


def test_faults_are_said_in_a_sentence(trial_file, tmp_path):
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "edits.jsonl")
    with pytest.raises(InputError, match=r"^p\.txt: a page is written as \.html; give it that"):
        widget.export_page(tmp_path / "p.txt")
    for frames in ([], [40], [-1, 3]):
        with pytest.raises(InputError, match=r"^frames are \[.*\]; expected some of 0 to 39\.$"):
            widget.export_page(tmp_path / "p.html", frames=frames)
    film = widget.export_film(tmp_path / "film.mp4", frames=(0, 2), width=200)
    sheet = widget.export_sheet(tmp_path / "sheet.png", frames=[3], width=200)
    assert film.stat().st_size > 0
    assert sheet.stat().st_size > 0
    widget.close()
