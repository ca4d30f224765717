"""Labels that state their chance of being right: which are listed, and in which order."""

import numpy as np
import pandas as pd

from pawnb.core.paws.offline.quality.measures import CALIBRATED
from pawnb.core.suspects.chances import doubted_labels, worth_a_look
from pawnb.core.suspects.frames import SuspectSettings, find_suspects
from pawnb.schema import ORIGIN_CODE, make_tracks


def listed(wrong, **options):
    """Rows and scores of one point in one view."""
    options = {"around": 3, "least": 0.1} | options
    found = doubted_labels(np.array(wrong)[:, None, None], np.arange(len(wrong)), **options)
    return [(one.row, round(one.score, 6)) for one in found]


def test_one_label_of_a_stretch_comes_first_and_shows_all_of_it():
    """Frames 10 to 16 are seen from frame 13: 6 x 0.5 + 0.6."""
    wrong = np.zeros(40)
    wrong[10:17] = 0.5
    wrong[13], wrong[30] = 0.6, 0.9
    order = listed(wrong)
    assert order[:2] == [(13, 3.6), (30, 0.9)]
    assert sorted(row for row, _ in order[2:]) == [10, 11, 12, 14, 15, 16]
    assert {score for _, score in order[2:]} == {0.0}


def test_a_long_stretch_is_shown_part_by_part():
    """21 frames are three times what one look shows."""
    wrong = np.zeros(50)
    wrong[20:41] = 0.8
    heads = [row for row, score in listed(wrong) if score > 0]
    assert len(heads) <= 4
    assert all(min(abs(row - head) for head in heads) <= 3 for row in range(20, 41))


def test_labels_of_all_points_are_ranked_together():
    wrong = np.zeros((20, 2, 2))
    wrong[5, 0, 1], wrong[5, 1, 0], wrong[15, 0, 1] = 0.3, 0.7, 0.5
    found = doubted_labels(wrong, np.arange(20), around=3, least=0.1)
    assert [(one.row, one.view, one.point) for one in found] == [(5, 1, 0), (15, 0, 1), (5, 0, 1)]


def test_what_is_nearly_sure_is_not_listed():
    assert listed([0.0, 0.09, 0.05]) == []
    assert listed([0.0, 0.09, 0.05], least=0.06) == [(1, 0.09)]


def test_frames_that_were_left_out_are_not_seen_from_their_neighbours():
    wrong = np.full((4, 1, 1), 0.5)
    found = doubted_labels(wrong, np.array([0, 1, 100, 101]), around=3, least=0.1)
    assert [one.score for one in found] == [1.0, 1.0, 0.0, 0.0]


def test_a_review_shows_each_stretch_once():
    table = pd.DataFrame(
        [(13, "a", "FL"), (10, "a", "FL"), (17, "a", "FL"), (13, "b", "FL"), (13, "a", "FR")],
        columns=["frame", "view", "point"],
    )
    kept = worth_a_look(table)
    assert kept.index.tolist() == [0, 2, 3, 4]
    assert worth_a_look(table[:0]).empty


def stated(chance):
    """Tracks of two points in one view, of which the second states its chances."""
    n = len(chance)
    tracks = make_tracks(range(100, 100 + n), ["FL", "FR"], fps=50.0, views=["side"])
    tracks["image_position"].to_numpy()[:] = 7.0
    tracks["image_origin"].to_numpy()[:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"].to_numpy()[:] = 1.0
    tracks["image_confidence"].to_numpy()[:, 0, 1, 0] = chance
    tracks["image_confidence"].attrs[CALIBRATED] = 1
    return tracks


def test_every_doubtful_label_has_a_row_that_says_how_sure_the_tracker_is():
    table = find_suspects(stated([1.0, 0.95, 0.4, 0.3, 0.95, 1.0, 1.0, 1.0, 1.0, 0.85]))
    assert table["frame"].tolist() == [103, 109, 102]
    assert set(table["point"]) == {"FR"}
    assert set(table["view"]) == {"side"}
    assert table["reason"].iloc[0] == "the tracker is 30 % sure of it"
    np.testing.assert_allclose(table["score"], [0.6 + 0.7, 0.15, 0.0])


def test_of_a_label_that_is_missing_it_is_said_that_it_was_not_found():
    tracks = stated([1.0, 1.0, 0.0, 1.0])
    tracks["image_position"].to_numpy()[2, 0, :, 1] = np.nan
    tracks["image_origin"].to_numpy()[2, 0, 1, 0] = ORIGIN_CODE["missing"]
    table = find_suspects(tracks)
    assert table["frame"].tolist() == [102]
    assert table["reason"].tolist() == ["it was not found here"]


def test_what_a_person_placed_and_what_is_nowhere_followed_is_no_suspect():
    tracks = stated(np.full(5, 0.2))
    tracks["image_origin"].to_numpy()[2, 0, 1, 0] = ORIGIN_CODE["edited"]
    tracks["image_position"].to_numpy()[:, :, 0, 0] = np.nan
    tracks["image_confidence"].to_numpy()[:, 0, 0, 0] = 0.0
    table = find_suspects(tracks)
    assert set(table["point"]) == {"FR"}
    assert 102 not in set(table["frame"])


def test_settings_say_what_is_listed():
    tracks = stated(np.full(9, 0.85))
    assert len(find_suspects(tracks)) == 9
    assert find_suspects(tracks, settings=SuspectSettings(least_score=0.2)).empty
    alone = find_suspects(tracks, settings=SuspectSettings(apart_frames=0.5))
    np.testing.assert_allclose(alone["score"], 0.15)
