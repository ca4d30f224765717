"""Two tracks of one trial beside each other: what differs, where most, and what a person sees."""

import numpy as np
import pytest
import small_trial as scene

from pawnb import load_trial
from pawnb.core.rig import load_rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks
from pawnb.widgets import TrackReviewer
from pawnb.widgets.comparison import Comparison


@pytest.fixture(scope="module")
def trial_file(tmp_path_factory):
    return scene.write_trial(tmp_path_factory.mktemp("small") / "trial")


def moved(by, frames, view=0, point=0):
    """Return the true tracks with a point ``by`` px further down in some frames of a view."""
    tracks = scene.true_tracks()
    for frame, px in zip(frames, by, strict=True):
        tracks["image_position"][frame, view, 1, point, 0] += px
    return tracks


def test_differences_are_listed_the_largest_first_one_for_each_stretch():
    other = moved([3.0, 8.0, 30.0, 4.0, 0.5], [4, 5, 6, 20, 33])
    other["image_position"][5, 1, 0, 1, 0] -= 12.0
    compared = Comparison(scene.true_tracks(), other, name="by hand")
    found = compared.largest(scene.true_tracks())
    assert found[["frame", "view", "point"]].to_numpy().tolist() == [
        [6, "cam1", "FR"], [5, "cam2", "HR"], [20, "cam1", "FR"],
    ]  # fmt: skip
    np.testing.assert_allclose(found["score"], [30.0, 12.0, 4.0])
    assert found["reason"].iloc[0] == "30.0 px from by hand"
    far = compared.farthest(scene.true_tracks())
    assert far[5].tolist() == [8.0, 12.0]


def test_what_both_have_is_compared_by_frame_view_and_name():
    given = moved([5.0], [12])
    other = given.isel(time=slice(10, 20), view=[1, 0], keypoint=[1, 0])
    compared = Comparison(scene.true_tracks(), other, name="x")
    far = compared.farthest(scene.true_tracks())
    assert np.isfinite(far).all(axis=1).nonzero()[0].tolist() == list(range(10, 20))
    assert far[12].tolist() == [5.0, 0.0]


def test_positions_in_space_are_shown_in_the_pictures(trial_file):
    rig = load_rig(load_trial(trial_file))
    other = make_tracks(range(40), ["FR"], fps=scene.FPS, unit="mm")
    other["position"].to_numpy()[:, :, 0, 0] = [scene.place(frame)[0] for frame in range(40)]
    compared = Comparison(scene.true_tracks(), other, name="x", rig=rig)
    np.testing.assert_allclose(compared.uv[7, :, :, 0], scene.seen(7)[:, 0], atol=1e-9)
    assert np.isnan(compared.uv[..., 1]).all()


def test_a_review_draws_the_others_and_jumps_to_the_largest_difference(trial_file, tmp_path):
    other = moved([30.0, 15.0], [6, 25])
    widget = TrackReviewer(
        trial_file, scene.true_tracks(), edits=tmp_path / "e.jsonl", against=other,
        against_name="<b>Anna</b>",
    )  # fmt: skip
    marks = widget.overlay(6)["views"]["cam1"]["others"]
    u, v = scene.seen(6)[0, 0]
    assert (marks[0]["id"], marks[0]["u"], marks[0]["v"]) == ("FR", u, v + 30)
    assert widget.edit("action", {"action": "apart", "frame": 0}) == 6
    assert widget.status.startswith(
        "Difference 1 of 2, frame 6: FR in cam1, 30.0 px from the other"
    )
    assert widget.overlay(6)["current"] == ["cam1", "FR"]
    assert widget.edit("action", {"action": "apart", "frame": 6}) == 25
    assert widget.edit("action", {"action": "apart", "frame": 25}) is None
    assert widget.edit("action", {"action": "difference", "value": "1", "frame": 0}) == 25
    assert widget.thin_line == ["distance", " px from the other tracks (<b>Anna</b>)"]
    # 30 px fill the lane: the scale is the 99.5th percentile of the largest distances
    assert widget._lane_bytes[0, 6, 1] == 250
    # corrected onto the other track, the difference is gone from list and lane
    message = {"type": "edit", "who": "a", "n": 1, "what": "moved", "frame": 6, "view": "cam1"}
    widget._receive(widget, message | {"point": "FR", "u": u, "v": v + 30}, [])
    assert widget._lane_bytes[0, 6, 1] == 0
    menu = next(action for action in widget.actions if action["id"] == "difference")
    assert [text.split(":")[0] for _, text in menu["options"]] == ["frame 25"]
    widget.close()


def test_corrected_tracks_are_compared_with_those_of_before(trial_file, tmp_path):
    edits = tmp_path / "e.jsonl"
    first = TrackReviewer(trial_file, scene.true_tracks(), edits=edits)
    first.session.move(9, "cam1", "HR", u=200.0, v=100.0)
    first.close()
    widget = TrackReviewer(trial_file, scene.true_tracks(), edits=edits, against="before")
    assert widget.edit("action", {"action": "apart", "frame": 0}) == 9
    assert "px from the other tracks (before the corrections)" in widget.status
    widget.close()


def test_tracks_that_share_nothing_are_refused_in_a_sentence(trial_file, tmp_path):
    other = make_tracks(range(40), ["nose"], fps=scene.FPS, views=["cam1"], unit="mm")
    other["image_position"].to_numpy()[:] = 3.0
    other["image_origin"].to_numpy()[:] = ORIGIN_CODE["measured"]
    with pytest.raises(InputError, match=r"^the tracks to compare with share no point of a view"):
        Comparison(scene.true_tracks(), other, name="x")
    with pytest.raises(InputError, match=r"^against is 'after'; expected tracks, or \"before\"\.$"):
        TrackReviewer(trial_file, scene.true_tracks(), edits=tmp_path / "e.jsonl", against="after")
