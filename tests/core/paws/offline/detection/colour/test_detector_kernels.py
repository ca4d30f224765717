"""The compiled loops against plain numpy and OpenCV."""

import cv2
import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour import detector_kernels as loops


@pytest.fixture
def score():
    noise = np.random.default_rng(4).normal(-1.0, 4.0, (60, 83)).astype(np.float32)
    return cv2.GaussianBlur(noise, (5, 5), 1.2)


def shares(score, around):
    """Share of mask about each pixel, by OpenCV."""
    weight = np.clip(score * np.float32(0.5) + np.float32(0.5), 0.0, 1.0)
    return cv2.blur(weight, (2 * around + 1,) * 2, borderType=cv2.BORDER_REPLICATE)


def test_look_up_and_weigh(score):
    table = np.linspace(-6, 6, 32768, dtype=np.float32)
    numbers = np.random.default_rng(0).integers(0, 32768, (7, 9)).astype(np.uint16)
    assert np.array_equal(loops.look_up(table, numbers), table[numbers])
    weight = loops.weigh(score)
    # no digit is lost: shares are the same as those of decimal fractions
    assert np.array_equal(weight / 2.0**25, np.clip(score * np.float32(0.5) + 0.5, 0.0, 1.0))


@pytest.mark.parametrize("shape", [(60, 83), (1, 1), (1, 4), (5, 1), (2, 2)])
def test_colours_are_smoothed_and_looked_up_as_by_opencv(shape):
    rng = np.random.default_rng(1)
    table = rng.normal(size=32768).astype(np.float32)
    pixels = rng.integers(0, 256, (*shape, 3)).astype(np.uint8)
    red, green, blue = np.moveaxis(cv2.GaussianBlur(pixels, (3, 3), 0.8) >> 3, -1, 0).astype(int)
    expected = table[red * 1024 + green * 32 + blue]
    assert np.array_equal(loops.score_colours(pixels, table), expected)


@pytest.mark.parametrize("around", [3, 8])
@pytest.mark.parametrize("reach", [1, 2, 4])
def test_ends_are_minima_of_the_share_in_the_mask(score, around, reach):
    share = shares(score, around)
    mask = score > 0
    guarded = np.where(mask, share, np.float32(1.0))
    lowest = cv2.erode(guarded, np.ones((2 * reach + 1,) * 2, np.uint8))
    v, u = np.nonzero(mask & (guarded <= lowest))
    rows, columns, least = loops.find_ends(score, loops.weigh(score), around, reach)
    assert len(v) > 3
    assert np.array_equal(rows, v)
    assert np.array_equal(columns, u)
    assert np.array_equal(least, share[v, u])


def test_where_all_is_mask_its_share_is_one():
    """No sum is too large over the widest square, and ties are all least."""
    score = np.full((70, 70), 5.0, np.float32)
    rows, columns, least = loops.find_ends(score, loops.weigh(score), 30, 2)
    assert len(rows) == len(columns) == 70 * 70
    assert np.array_equal(least, np.ones(70 * 70, np.float32))


def test_centres_are_those_of_discs(score):
    weight = loops.weigh(score)
    at = np.array([[0, 0], [82, 59], [40, 30], [3, 57]])
    rows, columns = np.mgrid[:60, :83]
    expected = []
    for u, v in at:
        inside = (columns - u) ** 2 + (rows - v) ** 2 <= 5.5**2
        mass = weight[inside] / 2.0**25
        places = np.column_stack([columns[inside], rows[inside]])
        expected.append(mass @ places / mass.sum())
    u, v = np.ascontiguousarray(at.T)
    found = loops.centres(weight, u, v, 5)
    assert found == pytest.approx(np.array(expected), abs=1e-9)
    nothing = loops.centres(np.zeros_like(weight), u, v, 5)
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


def test_ends_are_described_in_pixels_of_the_view(score):
    weight = loops.weigh(score)
    pixels = np.array([[20, 21, 60, 41], [10, 11, 40, 31]])
    near = pixels.T + np.array([[0.25, -0.25], [0.5, 0.5], [0.0, 0.0], [-0.125, 0.0]])
    share = np.array([0.1, 0.2, 0.3, 0.4], np.float32)
    beyond = np.array([[-1.0, 0.0, 200.0]])
    found = loops.describe(score, weight, pixels, share, near, 5, 0.7, beyond, (100, 30, 2))
    # the second is close to the first, the third lies beyond u = 200
    kept = [0, 3]
    # close is nearer than 0.7 times the reach: 3.5 px of 5
    for apart, n in ((3.4, 1), (3.6, 2)):
        pair = np.array([[20.0, 10.0], [20.0 + apart, 10.0]])
        of_pair = loops.describe(
            score, weight, pixels[:, :2].copy(), share[:2], pair, 5, 0.7, beyond, (100, 30, 2)
        )
        assert len(of_pair) == n
    assert found[:, :2] == pytest.approx((near[kept] + 0.5) * 2 - 0.5 + [100, 30])
    far = loops.centres(weight, pixels[0, kept], pixels[1, kept], 10)
    assert found[:, 2:4] == pytest.approx((near[kept] - far) * 2)
    assert np.array_equal(found[:, 4], share[kept])
    assert np.array_equal(found[:, 5], loops.mean_score(score, near[kept]))
    assert found[:, 6:] == pytest.approx((pixels.T[kept] + 0.5) * 2 - 0.5 + [100, 30])
