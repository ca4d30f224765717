"""The compiled loops against plain numpy and OpenCV."""

import cv2
import numpy as np
import pytest

from pawnb.core.paws.whole import candidates_loops as loops


@pytest.fixture
def score():
    noise = np.random.default_rng(4).normal(-1.0, 4.0, (60, 83)).astype(np.float32)
    return cv2.GaussianBlur(noise, (5, 5), 1.2)


def test_look_up_and_weigh(score):
    table = np.linspace(-6, 6, 32768, dtype=np.float32)
    numbers = np.random.default_rng(0).integers(0, 32768, (7, 9)).astype(np.uint16)
    assert np.array_equal(loops.look_up(table, numbers), table[numbers])
    assert np.array_equal(loops.weigh(score), np.clip(score * 0.5 + 0.5, 0.0, 1.0))
    assert loops.weigh(score).dtype == np.float32


@pytest.mark.parametrize("reach", [1, 2, 4])
def test_ends_are_minima_of_the_share_in_the_mask(score, reach):
    share = cv2.blur(loops.weigh(score), (9, 9), borderType=cv2.BORDER_REPLICATE)
    mask = score > 0
    guarded = np.where(mask, share, np.float32(1.0))
    lowest = cv2.erode(guarded, np.ones((2 * reach + 1,) * 2, np.uint8))
    v, u = np.nonzero(mask & (guarded <= lowest))
    rows, columns = loops.find_ends(score, share, reach)
    assert len(v) > 3
    assert np.array_equal(rows, v)
    assert np.array_equal(columns, u)


def test_centres_are_those_of_discs(score):
    weight = loops.weigh(score)
    at = np.array([[0, 0], [82, 59], [40, 30], [3, 57]])
    rows, columns = np.mgrid[:60, :83]
    expected = []
    for u, v in at:
        inside = (columns - u) ** 2 + (rows - v) ** 2 <= 5.5**2
        mass = weight[inside].astype(float)
        places = np.column_stack([columns[inside], rows[inside]])
        expected.append(mass @ places / mass.sum())
    found = loops.centres(weight, at[:, 0], at[:, 1], 5)
    assert found == pytest.approx(np.array(expected), abs=1e-9)
    nothing = loops.centres(np.zeros_like(weight), at[:, 0], at[:, 1], 5)
    assert np.array_equal(nothing, at)


def test_mean_score_is_that_of_nine_pixels(score):
    at = np.array([[0.2, 0.4], [40.6, 30.4], [82.4, 59.0]])
    found = loops.mean_score(score, at)
    # at the edge the nearest nine that are in the picture
    middles = [(1, 1), (41, 30), (81, 58)]
    expected = [score[v - 1 : v + 2, u - 1 : u + 2].mean() for u, v in middles]
    assert found == pytest.approx(np.array(expected), rel=1e-6)


def test_distinct_keeps_the_first_of_those_that_are_close():
    at = np.array([[0.0, 0.0], [2.9, 0.0], [5.8, 0.0], [0.0, 3.0], [1.0, 2.0]])
    # the second is close to the first, but the third is close to none that is kept
    assert loops.distinct(at, 3.0).tolist() == [0, 2, 3]
    assert loops.distinct(at[:0], 3.0).tolist() == []
