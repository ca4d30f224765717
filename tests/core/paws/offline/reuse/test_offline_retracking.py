"""What a correction or a further click needs to know of the run before."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline.detection.appearance import TrainingFrame
from pawnb.core.paws.offline.parameters import OfflineParameters
from pawnb.core.paws.offline.reuse.retracking import (
    Again,
    after_clicks,
    weighing_as_attributes,
    weighing_of,
)
from pawnb.core.paws.offline.self_training.learnt import (
    LEARNT_IN,
    Earlier,
    Learnt,
    learnt_as_text,
    learnt_of,
)
from pawnb.core.paws.offline.self_training.weighing import Powers, Weighing, usual_powers
from pawnb.io import native
from pawnb.schema import ORIGIN_CODE, make_tracks

POINTS = ("FL", "HL")


def test_what_leaving_out_clicks_has_shown_is_kept_in_the_file_of_tracks(tmp_path):
    tracks = make_tracks(range(3), POINTS, fps=50.0, views=["side"])
    weighing = Weighing(Powers(1.0, 0.0), {1: -0.25})
    tracks.attrs.update(weighing_as_attributes(weighing, POINTS))
    native.write_tracks(tracks, tmp_path / "tracks.nc")
    read = native.read_tracks(tmp_path / "tracks.nc")
    assert weighing_of(read, POINTS) == weighing
    assert weighing_of(read, POINTS[::-1]).offsets == {0: -0.25}  # it is the same point's


def test_tracks_that_say_nothing_are_taken_as_usual():
    usual = Weighing(usual_powers(OfflineParameters()))
    assert weighing_of(make_tracks(range(3), ["FL"], fps=50.0), ["FL"]) == usual


def clicks(*placed, u=5.0):
    rows = [(frame, "side", point, u, 6.0) for frame, points in placed for point in points]
    return pd.DataFrame(rows, columns=["frame", "view", "point", "u", "v"])


BEFORE = clicks((20, POINTS), (60, POINTS), (80, ["FL"]))


@pytest.mark.parametrize(
    ("added", "frames", "closed"),
    [
        ((40, POINTS), (20, 61), [20, 60]),
        ((10, POINTS), (0, 21), [20]),
        ((70, ["FL"]), (60, 81), [60, 80]),
        ((70, ["HL"]), (60, 100), [60]),  # HL is not clicked again: to the last frame
        ((20, ["FL"]), None, None),  # is there already
    ],
)
def test_added_clicks_bear_on_what_lies_between_the_clicks_on_either_side(added, frames, closed):
    tracks = make_tracks(range(100), POINTS, fps=50.0, views=["side"])
    again = after_clicks(tracks, BEFORE, pd.concat([BEFORE, clicks(added)]))
    if frames is None:
        assert again is None
    else:
        assert (again.frames, list(again.closed)) == (frames, closed)
        assert list(again.placed) == [added[0]]


def test_where_other_pictures_are_read_they_bear_on_all_frames():
    tracks = make_tracks(range(5, 100), POINTS, fps=50.0, views=["side"])
    now = pd.concat([BEFORE, clicks((40, POINTS))])
    again = after_clicks(tracks, BEFORE, now, everywhere=True)
    assert again.frames == (5, 100)
    assert (list(again.placed), list(again.closed)) == ([40], sorted(set(BEFORE["frame"])))


@pytest.mark.parametrize(
    "now",
    [
        pd.concat([BEFORE.iloc[1:], clicks((40, POINTS))]),  # one was taken away
        pd.concat([BEFORE.assign(u=5.5), clicks((40, POINTS))]),  # they were moved
        pd.concat([BEFORE, clicks((40, ["nose"]))]),
    ],
)
def test_other_changes_of_clicks_bear_on_the_whole(now):
    tracks = make_tracks(range(100), POINTS, fps=50.0, views=["side"])
    assert after_clicks(tracks, BEFORE, now) is None


def training_frame(*uv):
    return TrainingFrame(
        {p: np.array(at, float) for p, at in enumerate(uv)}, [np.array([1.25, 2.0])], clicked=False
    )


def test_what_was_learnt_is_kept_in_the_file_of_tracks(tmp_path):
    tracks = make_tracks(range(10, 20), POINTS, fps=50.0, views=["side"])
    learnt = {"side": Learnt({4: training_frame((50.125, 40), (20, 40))}, {1: 0.5})}
    tracks.attrs[LEARNT_IN] = learnt_as_text(learnt, POINTS, 10)
    native.write_tracks(tracks, tmp_path / "tracks.nc")
    kept = native.read_tracks(tmp_path / "tracks.nc")
    (found,) = learnt_of(kept, ("HL", "FL"), 12).values()  # other numbers, another first row
    assert found.agreement == {0: 0.5}
    np.testing.assert_array_equal(found.training_frames[2].points[1], [50.125, 40])
    np.testing.assert_array_equal(found.training_frames[2].doubtful, [[1.25, 2.0]])
    assert not found.training_frames[2].clicked
    assert learnt_of(make_tracks(range(3), POINTS, fps=50.0), POINTS, 0) == {}


def test_frames_are_learnt_from_while_tracks_agree_and_no_correction_is_nearer(make_stack):
    stack = make_stack(np.zeros((40, 60, 90), np.uint8))
    tracks = make_tracks(range(40), POINTS, fps=50.0, views=["side"])
    for p, uv in enumerate(((50.0, 40.0), (20.0, 40.0))):
        here = {"view": 0, "individual": 0, "keypoint": p}
        tracks["image_position"][here] = np.array(uv)
        tracks["image_confidence"][here] = 0.9
        tracks["image_origin"][here] = ORIGIN_CODE["measured"]
    tracks["image_position"][{"time": 4, "view": 0, "individual": 0, "keypoint": 1}] = np.array(
        [20.0, 60.0]
    )
    training_frames = {row: training_frame((50, 40), (20, 40)) for row in (2, 4, 12, 18, 26, 34)}
    tracks.attrs[LEARNT_IN] = learnt_as_text({"side": Learnt(training_frames, {0: 0.8})}, POINTS, 0)
    again = Again(tracks, (10, 31), placed=[20], closed=[10, 30])
    earlier = again.earlier("side", POINTS, frames=(0, 40), stack=stack, radius=10.0)
    # 4 lies 20 px off by now; 18 is nearer to the correction in 20 than to the click in 10
    assert sorted(earlier.learnt.training_frames) == [2, 12, 26, 34]
    assert earlier.learnt.agreement == {0: 0.8}
    np.testing.assert_array_equal(earlier.uv[4, 1], [20, 60])
    np.testing.assert_allclose(earlier.chance, 0.9)
    assert again.earlier("below", POINTS, frames=(0, 40), stack=stack, radius=10.0) is None


def test_where_a_point_was_found_is_as_likely_as_it_was_right(make_stack):
    """In four rows found at place (5, 7) with 0.75; the rest is where it may be, and is even."""
    stack = make_stack(np.zeros((4, 60, 90), np.uint8))
    _, h, w = stack.shape
    uv = stack.picture_of(np.array([5.0, 7.0]), np.arange(4))[:, None]
    chance = np.full((4, 1), 0.75)
    mass = Earlier(Learnt(), uv, chance).mean_mass(stack, 0, np.full((h, w), 1 / (h * w)))
    assert mass.sum() == pytest.approx(1, abs=1e-5)
    assert mass[7, 5] == pytest.approx(0.75 + 0.25 / (h * w), abs=1e-5)
    assert mass[0, 0] == pytest.approx(0.25 / (h * w), rel=1e-4)


def test_only_ends_at_which_something_is_placed_are_certain():
    tracks = make_tracks(range(20), POINTS, fps=50.0, views=["side"])
    here = {"view": 0, "individual": 0}
    tracks["image_position"][here] = 30.0
    tracks["image_confidence"][here] = 0.95
    tracks["image_origin"][here] = ORIGIN_CODE["measured"]
    open_end = Again(tracks, (8, 20), placed=[8])
    assert sorted(open_end.known("side", POINTS, 0).places) == [8]
    closed = Again(tracks, (8, 20), placed=[8], closed=[19])
    assert sorted(closed.known("side", POINTS, 0).places) == [8, 19]
