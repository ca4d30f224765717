"""The look of paws that is learnt: places in the picture, and what is learnt from where."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from pawnb.core.paws.layout import Placement
from pawnb.core.paws.offline.detection import paw_appearance
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.detection.paw_appearance import (
    PawLook,
    _KnownClassifier,
    _lots,
    _Picture,
    _Reading,
    clicked_training_frames,
    tracked_training_frames,
)
from pawnb.core.paws.offline.parameters import AppearanceParameters

BRIGHTNESS = 4
"""Column of the features that is the smoothed brightness of the place itself."""


def bright(features):
    """What is bright is a paw."""
    chance = np.clip(features[:, BRIGHTNESS], 0.01, 0.99)
    return np.stack([1 - chance, chance], axis=1)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("scale", [1.7, 3.0])
def test_the_score_is_highest_where_the_classifier_sees_a_paw(scale, mirrored):
    picture = np.full((60, 90), 10, np.uint8)
    picture[30:35, 61:66] = 250  # about (63, 32)
    reading = _Reading(scale, mirrored, 0.0, 255.0, is_colour=False)
    detector = PawLook(
        np.empty(0, np.float32), 5.0, 11, known=_KnownClassifier(bright, "a"), reading=reading
    )
    score = detector.score(picture)
    assert score.shape == picture.shape
    weight = np.exp(score - score.max()) > 0.5
    v, u = np.nonzero(weight)
    np.testing.assert_allclose([u.mean(), v.mean()], [63, 32], atol=0.8)


def test_a_position_is_found_again_at_the_working_scale():
    """A mirrored picture, twice as large: the first column is the last one there."""
    reading = _Reading(2.0, True, 0.0, 255.0, is_colour=False)
    np.testing.assert_allclose(reading.place(np.array([[0.0, 3.0]]), 50), [[98.5, 6.5]])


def test_copies_of_a_click_are_turned_as_paws_in_swing_are_and_labels_turn_with_them(monkeypatch):
    """A flat bright bar: its axis in each copy is that of its second moments."""
    picture = np.full((240, 320), 10, np.uint8)
    cv2.ellipse(picture, (220, 140), (24, 10), 0, 0, 360, 250, -1)
    shown = []

    def brightness(grey, colour, spacing):
        shown.append(grey)
        return grey[spacing // 2 :: spacing, spacing // 2 :: spacing, None]

    monkeypatch.setattr(paw_appearance, "feature_maps", brightness)
    clicked = _Picture(0, picture, np.array([[220.0, 140.0]]), np.empty((0, 2)), 64, True)
    reading = _Reading(1.0, False, 0.0, 255.0, is_colour=False)
    lots = _lots(clicked, reading, np.random.default_rng(0), AppearanceParameters())
    assert all(values[labels == 1].min() > 120 for values, labels in lots)
    moments = [cv2.moments((grey > 120).astype(np.uint8), binaryImage=True) for grey in shown]
    axes = np.rad2deg([np.arctan2(2 * m["mu11"], m["mu20"] - m["mu02"]) / 2 for m in moments])
    assert abs(axes[0]) < 1
    # of 63 even draws the outermost two leave a thirty-second of the range, on average
    assert np.ptp(axes) > 0.85 * 2 * LEARNT.paw_turn_deg
    assert np.abs(axes).max() < LEARNT.paw_turn_deg + 1


def scene(anchors=None):
    """Two views of a plane: the second is shifted by 100 px."""

    def project(x):
        return np.stack([x[..., :2], x[..., :2] + 100.0], axis=-2)

    return SimpleNamespace(
        projection=SimpleNamespace(project=project), anchors=anchors or {}, paw_width=2.0
    )


def test_a_paw_that_is_clicked_in_another_view_is_doubtful_in_this_one():
    layout = SimpleNamespace(views=("a", "b"), points=("FR", "FL"))
    here = [Placement(0, 0, np.array([5.0, 6.0])), Placement(1, 1, np.array([120.0, 130.0]))]
    anchors = {7: {0: np.array([5.0, 6.0, 0.0]), 1: np.array([20.0, 30.0, 0.0])}}
    training_frame = clicked_training_frames(scene(anchors), layout, {7: here})[7]
    np.testing.assert_array_equal(training_frame.paws[0], [[5, 6]])
    np.testing.assert_array_equal(training_frame.doubtful[0], [[20, 30]])
    np.testing.assert_array_equal(training_frame.doubtful[1], [[105, 106]])
    assert training_frame.whole


def test_where_fewer_paws_are_clicked_than_elsewhere_nothing_is_background():
    layout = SimpleNamespace(views=("a",), points=("FR", "FL"))
    one = Placement(0, 0, np.array([5.0, 6.0]))
    both = [one, Placement(0, 1, np.array([20.0, 6.0]))]
    training_frames = clicked_training_frames(scene(), layout, {0: [one], 4: both})
    assert not training_frames[0].whole
    assert training_frames[4].whole
    # with no better frame this one has to do
    assert clicked_training_frames(scene(), layout, {0: [one]})[0].whole


def test_tracks_teach_where_they_are_certain_and_in_views_that_track_the_point():
    x = np.zeros((4, 2, 3))
    x[:, 1] = 50.0
    sd = np.full((4, 2, 3), 0.1)
    sd[2:, 1] = 5.0
    tracked = np.array([[True, True], [False, True]])
    measured = np.zeros((4, 2, 2, 2))
    measured[1, 0, 0] = np.nan
    tracks = SimpleNamespace(x=x, sd=sd, measured=measured)
    training_frames = tracked_training_frames(tracks, scene(), tracked, first=10)
    assert sorted(training_frames) == [10, 11, 12, 13]
    np.testing.assert_array_equal(training_frames[10].paws[0], [[0, 0], [50, 50]])
    np.testing.assert_array_equal(training_frames[10].paws[1], [[150, 150]])
    np.testing.assert_array_equal(training_frames[11].paws[0], [[50, 50]])
    np.testing.assert_array_equal(training_frames[13].paws[0], [[0, 0]])
    np.testing.assert_array_equal(training_frames[13].doubtful[0], [[50, 50]])
    assert not training_frames[13].clicked
