"""How much detections look like paws, once it is known what clicked paws look like."""

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.detector import endpoint_score
from pawnb.core.paws.offline.detection.colour.likelihood import (
    AppearanceLikelihood,
    curves,
    measures,
    score_at_clicks,
)

DOWN_AHEAD = (0.6, 0.8)
THICKNESS = np.array([8.0, 8.0])


def candidate(score, share=0.22, step=(2.4, 3.2), at=(50.0, 40.0)):
    """One detection: its score, share of mask, direction and place."""
    return ColourDetections(np.array([[*at, *step, share, score, *at]], np.float32))


def likelihood(score=None):
    return AppearanceLikelihood([DOWN_AHEAD, (-0.6, 0.8)], THICKNESS, score)


def test_without_clicks_it_is_the_plain_rule():
    rows = ColourDetections.joined(
        [candidate(3.0), candidate(1.0, 0.4), candidate(5.0, step=(-3, 0))]
    )
    np.testing.assert_array_equal(likelihood().likeness(rows, 0), endpoint_score(rows, DOWN_AHEAD))


def test_it_is_the_geometric_mean_of_the_rule_and_the_curves():
    # all measures at knots: score 1.5 of 3, share 0.22, straight ahead, four of eight px
    rows = candidate(1.5)
    at = {"score": 0.5, "share": 0.22, "ahead": 1.0, "beside": 0.0, "length": 0.5}
    odds = 0.0
    for name, (knots, values) in curves().items():
        odds += values[knots.index(at[name])]
    expected = np.sqrt(endpoint_score(rows, DOWN_AHEAD) / (1.0 + np.exp(-odds)))
    np.testing.assert_allclose(likelihood(3.0).likeness(rows, 0), expected, rtol=1e-5)


def test_a_low_score_is_good_where_clicked_paws_score_low():
    rows = candidate(1.4)
    assert likelihood(1.4).likeness(rows, 0) > 3.0 * likelihood(4.0).likeness(rows, 0)


def test_specks_and_heels_are_worse_than_ends():
    paw = likelihood(3.0).likeness(candidate(3.0, 0.2), 0)
    assert likelihood(3.0).likeness(candidate(3.0, 0.04), 0) < 0.98 * paw
    assert likelihood(3.0).likeness(candidate(3.0, 0.45), 0) < 0.3 * paw
    assert likelihood(3.0).likeness(candidate(3.0, 0.2, step=(-2.4, -3.2)), 0) < 0.5 * paw


def test_measures_are_the_same_for_an_animal_that_faces_the_other_way():
    one = measures(candidate(3.0, step=(1.0, 3.0)), DOWN_AHEAD, score=3.0, paw_width_px=8.0)
    other = measures(candidate(3.0, step=(-1.0, 3.0)), (-0.6, 0.8), score=3.0, paw_width_px=8.0)
    for name, value in one.items():
        np.testing.assert_allclose(value, other[name], rtol=1e-6)
    # turned from (0.6, 0.8) to (1, 3): the cross product of unit vectors
    assert one["beside"][0] == pytest.approx((0.6 * 3 - 0.8 * 1) / np.sqrt(10))


def test_the_score_is_that_of_the_candidates_clicked():
    clicks = np.full((2, 3, 2, 2), np.nan)
    clicks[0, 0, 0] = 50.0, 40.0
    clicks[0, 1, 1] = 20.0, 20.0
    clicks[1, 0, 0] = 90.0, 90.0
    rows = ColourDetections.joined([
        candidate(2.0, at=(51.0, 41.0)), candidate(9.0, at=(70.0, 40.0)),
        # a heel nearer to the click
        candidate(9.0, 0.5, step=(-2.4, -3.2), at=(50.0, 40.5)),
    ])  # fmt: skip
    found = {0: [rows, candidate(3.0, at=(20.0, 21.0))], 7: [rows, rows]}
    assert score_at_clicks(clicks, found, likelihood()) == pytest.approx(2.5)
    assert score_at_clicks(clicks[1:], {7: [rows, rows]}, likelihood()) is None
