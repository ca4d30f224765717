"""Sub-images, superpixels and their means."""

from __future__ import annotations

import colorsys

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws import superpixels
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings, lengths_in_view

SETTINGS = Maghsoudi2019Settings(median_px=0)


class Whole:
    def __init__(self, pixels):
        self.pixels = pixels

    def crop(self, u0, v0, u1, v1):
        return self.pixels[v0:v1, u0:u1]


def measure(pixels, settings=SETTINGS, centre=None):
    height, width = pixels.shape[:2]
    lengths = lengths_in_view(settings, 2048)
    centre = np.array([width / 2, height / 2]) if centre is None else centre
    window = superpixels.place_window(centre, lengths, width=width, height=height)
    return superpixels.measure_superpixels(Whole(pixels), window, lengths, settings=settings)


def rgb(hue_deg, saturation=0.5, value=0.8):
    return np.round(255 * np.array(colorsys.hsv_to_rgb(hue_deg / 360, saturation, value)))


def test_whole_sub_image_is_140_by_80_with_112_superpixels():
    # papers' Eq. 10 with its 50 px paw: 140 * 80 / (2 * 50) = 112
    lengths = lengths_in_view(SETTINGS, 2048)
    window = superpixels.place_window(np.array([500.0, 300.0]), lengths, width=2048, height=700)
    assert window.box == (430, 260, 570, 340)
    assert superpixels.count_superpixels(window, lengths, SETTINGS) == 112
    # half the picture has half the lengths and the same number of superpixels
    half = lengths_in_view(SETTINGS, 1024)
    window = superpixels.place_window(np.array([250.0, 150.0]), half, width=1024, height=350)
    assert window.shape == (40, 70)
    assert superpixels.count_superpixels(window, half, SETTINGS) == 112


def test_sub_image_is_clipped_at_the_edges_and_keeps_its_corner():
    lengths = lengths_in_view(SETTINGS, 2048)
    window = superpixels.place_window(np.array([10.0, 690.0]), lengths, width=2048, height=700)
    assert window.box == (0, 650, 80, 700)
    # 80 * 50 / 100; and the share of a number that was given
    assert superpixels.count_superpixels(window, lengths, SETTINGS) == 40
    given = Maghsoudi2019Settings(n_superpixels=280)
    assert superpixels.count_superpixels(window, lengths, given) == 100
    np.testing.assert_array_equal(window.corner(+1), [80, 730])
    np.testing.assert_array_equal(window.corner(-1), [-60, 730])


@pytest.mark.parametrize("centre", [(-1.0, 50.0), (2048.0, 50.0), (5.0, 700.0), (np.nan, 5.0)])
def test_outside_the_picture_there_is_no_sub_image(centre):
    lengths = lengths_in_view(SETTINGS, 2048)
    assert superpixels.place_window(np.array(centre), lengths, width=2048, height=700) is None


def test_means_of_each_superpixel_are_those_of_its_pixels():
    rng = np.random.default_rng(0)
    coarse = rng.integers(0, 256, size=(8, 14, 3), dtype=np.uint8)
    pixels = cv2.resize(coarse, (140, 80), interpolation=cv2.INTER_LINEAR)
    found = measure(pixels)
    u0, v0 = found.window.box[:2]
    for number in (0, 3, len(found.green) - 1):
        rows, columns = np.nonzero(found.labels == number)
        assert found.green[number] == pytest.approx(pixels[rows, columns, 1].mean())
        assert found.red[number] == pytest.approx(pixels[rows, columns, 0].mean())
        np.testing.assert_allclose(found.uv[number], [columns.mean() + u0, rows.mean() + v0])
        hues = [colorsys.rgb_to_hsv(*(c / 255))[0] for c in pixels[rows, columns]]
        expected = np.degrees(np.angle(np.mean(np.exp(2j * np.pi * np.array(hues)))))
        # hue is measured in steps of 360 / 256 degrees
        assert superpixels.hue_difference(found.hue[number], expected) < 1.5
        middle = found.uv[number]
        assert found.look(number).green == found.green[number]
        if found.labels[round(middle[1] - v0), round(middle[0] - u0)] == number:
            assert found.at(middle) == number


def test_mean_hue_crosses_the_wrap():
    """Pink: half the pixels at 350 degrees and half at 10 have hue 0, not 180."""
    pixels = np.empty((80, 140, 3), dtype=np.uint8)
    pixels[:] = rgb(350)
    pixels[::2] = rgb(10)
    found = measure(pixels)
    assert len(found.hue) > 20
    assert superpixels.hue_difference(found.hue, 0.0).max() < 3.0
    # with a plain mean the same pixels would be cyan
    assert np.mean([350.0, 10.0]) == 180.0


@given(st.floats(-720, 720), st.floats(-720, 720))
def test_hue_difference_is_the_shorter_way_round(a, b):
    expected = np.degrees(np.abs(np.angle(np.exp(1j * np.radians(a - b)))))
    assert superpixels.hue_difference(a, b) == pytest.approx(expected, abs=1e-9)


def test_grey_picture_has_its_level_as_green_and_red_and_no_hue():
    rng = np.random.default_rng(1)
    level = rng.integers(0, 256, size=(80, 140), dtype=np.uint8)
    grey = measure(level)
    np.testing.assert_array_equal(grey.green, grey.red)
    assert not grey.hue.any()
    # a grey scene in a colour video, its channels apart by rounding, is the same
    stored = np.stack([level, level, np.maximum(level, 1) - 1], axis=-1)
    np.testing.assert_array_equal(measure(stored).green, grey.green)
    assert not measure(stored).hue.any()
    coloured = np.stack([level, level, np.maximum(level, 20) - 20], axis=-1)
    assert measure(coloured).hue.any()


def test_superpixels_follow_a_bright_disc_in_colour_and_in_grey():
    v, u = np.mgrid[:80, :140]
    disc = np.hypot(u - 60, v - 30) < 7
    pixels = np.where(disc[..., None], (225, 130, 150), (40, 120, 60)).astype(np.uint8)
    for picture in (pixels, pixels[..., 0].copy()):
        found = measure(picture)
        inside = found.red > 180
        assert inside.any()
        assert np.isin(found.labels, np.flatnonzero(inside))[disc].mean() > 0.9
        assert np.isin(found.labels, np.flatnonzero(inside))[~disc].mean() < 0.01


def test_median_filter_takes_single_pixels_away():
    pixels = np.full((80, 140), 50, dtype=np.uint8)
    pixels[::7, ::7] = 255
    assert measure(pixels).green.max() > 52
    assert measure(pixels, Maghsoudi2019Settings(median_px=3)).green.max() == 50


def test_colour_difference_is_zero_for_the_same_and_one_for_the_opposite():
    uv = np.zeros((2, 2))
    window = superpixels.Window(np.zeros(2), 1, 1, (0, 0, 1, 1))
    pair = superpixels.Superpixels(
        np.array([255.0, 0.0]),
        np.array([10.0, 190.0]),
        np.array([255.0, 0.0]),
        uv,
        np.zeros((1, 1), int),
        window,
    )
    look = superpixels.Look(green=255.0, hue=10.0, red=255.0)
    np.testing.assert_allclose(superpixels.colour_difference(pair, look), [0.0, 1.0])
