"""Debayering: patterns by their usual names, crops bit-identical to whole pictures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.pixels.bayer import debayered
from pawnb.core.pixels.colour import GreyPicture, PackedPicture
from pawnb.core.pixels.yuv import YuvPicture
from pawnb.errors import VideoError

PATTERNS = ("rggb", "bggr", "grbg", "gbrg")


def mosaic_of(rgb, pattern):
    """What a sensor with that pattern sees: pattern[0], [1] begin row 0, [2], [3] row 1."""
    mosaic = np.empty(rgb.shape[:2], np.uint8)
    for place, letter in enumerate(pattern):
        rows, columns = slice(place // 2, None, 2), slice(place % 2, None, 2)
        mosaic[rows, columns] = rgb[rows, columns, "rgb".index(letter)]
    return mosaic


@pytest.mark.parametrize("pattern", PATTERNS)
def test_flat_colour_comes_back(pattern):
    """cv2's names are one pixel off the usual ones: a wrong one swaps red and blue or worse."""
    rgb = np.broadcast_to(np.array([200, 120, 30], np.uint8), (12, 16, 3))
    picture = debayered(GreyPicture(mosaic_of(rgb, pattern)), pattern, where="view 'cam1'")
    assert picture.is_colour
    assert np.array_equal(picture.region(0, 0, 16, 12), rgb)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_measured_values_are_kept_and_others_are_means(pattern):
    rng = np.random.default_rng(2)
    mosaic = rng.integers(0, 256, (10, 12), dtype=np.uint8)
    image = debayered(GreyPicture(mosaic), pattern, where="").region(0, 0, 12, 10)
    for v in range(2, 8):
        for u in range(2, 10):
            letter = pattern[v % 2 * 2 + u % 2]
            assert image[v, u, "rgb".index(letter)] == mosaic[v, u]
            if letter != "g":  # green is the mean of its four neighbours
                near = mosaic[[v - 1, v + 1, v, v], [u, u, u - 1, u + 1]]
                assert abs(image[v, u, 1] - near.mean()) <= 0.5


@settings(max_examples=80, deadline=None)
@given(data=st.data())
def test_a_crop_is_that_part_of_the_whole(data):
    width, height = data.draw(st.integers(4, 75)), data.draw(st.integers(4, 40))
    pattern = data.draw(st.sampled_from(PATTERNS))
    rng = np.random.default_rng(width * height)
    mosaic = rng.integers(0, 256, (height, width), dtype=np.uint8)
    picture = debayered(GreyPicture(mosaic), pattern, where="")
    u0, v0 = data.draw(st.integers(0, width - 1)), data.draw(st.integers(0, height - 1))
    u1, v1 = data.draw(st.integers(u0 + 1, width)), data.draw(st.integers(v0 + 1, height))
    everything = picture.region(0, 0, width, height)
    assert np.array_equal(picture.region(u0, v0, u1, v1), everything[v0:v1, u0:u1])


def test_mosaic_in_the_luma_of_a_video():
    """Raw sensor values compressed as grey video: Y is the mosaic, chroma is not used."""
    rgb = np.broadcast_to(np.array([200, 120, 30], np.uint8), (16, 16, 3))
    luma = mosaic_of(rgb, "grbg")
    chroma = np.full((8, 8), 90, np.uint8)
    video = YuvPicture(luma, chroma, chroma, steps=(2, 2), full_range=True)
    assert np.array_equal(debayered(video, "grbg", where="").region(0, 0, 16, 16), rgb)


def test_colour_pictures_are_refused():
    picture = PackedPicture(np.zeros((8, 8, 3), np.uint8))
    with pytest.raises(VideoError) as caught:
        debayered(picture, "rggb", where="view 'cam1'")
    assert str(caught.value) == (
        "view 'cam1': bayer is 'rggb', but the pictures are in colour already; leave out bayer, "
        "or name the raw grey pictures."
    )


def test_tiny_pictures_are_refused():
    with pytest.raises(VideoError, match="3 x 8 px is too small to debayer"):
        debayered(GreyPicture(np.zeros((8, 3), np.uint8)), "rggb", where="view 'cam1'")
