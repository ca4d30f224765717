"""Features of places: shape, what they say of simple pictures, and that they go with them."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.features import PictureFeatures, feature_maps

RING = 4 + 4 + 3 * 4 + 3
"""Structure, finest scale, three coarser ones and their differences come before the rings."""


def test_features_of_some_places_are_those_among_all(make_texture):
    grey = make_texture(62, 91)
    colour = np.stack([grey, grey[::-1]], axis=-1)
    places = np.array([0, 17, 31, 599, 200])
    some = PictureFeatures(grey, colour, 2).at(places)
    np.testing.assert_array_equal(some, feature_maps(grey, colour, 2).reshape(31 * 45, -1)[places])


def test_shape_is_that_of_the_whole_places(make_texture):
    grey = make_texture(62, 91)
    colour = np.stack([grey, grey[::-1]], axis=-1)
    assert feature_maps(grey, None, 2).shape == (31, 45, 47)
    assert feature_maps(grey, colour, 2).shape == (31, 45, 59)
    assert feature_maps(grey, None, 4).shape == (15, 22, 47)
    assert feature_maps(grey, None, 4).dtype == np.float32


def test_odd_spacings_are_refused():
    """Places would lie between the pixels of the halved picture."""
    with pytest.raises(ValueError, match="even"):
        feature_maps(np.zeros((60, 60), np.uint8), None, 3)


@pytest.mark.parametrize("spacing", [2, 4])
def test_features_go_with_the_picture(make_texture, spacing):
    """Moved by 2 and 3 places; nearer to the edge than 30 places smoothing may look beyond it."""
    whole = make_texture(88 * spacing, 90 * spacing)
    colour = np.stack([whole, 255 - whole], axis=-1)
    dx, dy = 2 * spacing, 3 * spacing
    here = feature_maps(whole[:-dy, :-dx], colour[:-dy, :-dx], spacing)
    moved = feature_maps(whole[dy:, dx:], colour[dy:, dx:], spacing)
    inner = np.s_[33:52, 32:58]
    np.testing.assert_allclose(here[inner], moved[30:49, 30:56], atol=2e-4)
    # a picture moved by less than a place is another
    other = feature_maps(whole[1 : 1 - dy, :-dx], colour[1 : 1 - dy, :-dx], spacing)
    assert np.abs(here[inner] - other[inner]).max() > 0.1


def test_an_even_picture_has_brightness_only():
    found = feature_maps(np.full((90, 90), 51, np.uint8), None, 4)
    expected = np.zeros(47)
    expected[4] = expected[[8, 12, 16]] = 51 / 255
    expected[RING:] = 0.3 * 51 / 255  # brightness less 0.7 of that at the place
    expected[0] = np.sqrt(1e-4) * 4  # the floor of the strength of texture
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-5)


def test_rings_tell_what_lies_in_each_direction():
    """Bright on the right (u) and dark on the left; below (v) and above are alike."""
    grey = np.zeros((120, 120), np.uint8)
    grey[:, 62:] = 200
    ring = feature_maps(grey, None, 4)[20, 15, RING : RING + 8]  # at the edge, 10 px about it
    assert ring[0] - ring[4] == pytest.approx(200 / 255, abs=0.02)
    assert ring[2] == pytest.approx(ring[6], abs=1e-6)


@pytest.mark.parametrize("spacing", [2, 4, 6])
def test_a_place_is_the_middle_of_its_square(spacing):
    """A dot there is as bright to the left as to the right, and above as below."""
    grey = np.zeros((20 * spacing, 20 * spacing), np.uint8)
    grey[10 * spacing + spacing // 2, 8 * spacing + spacing // 2] = 255
    brightness = feature_maps(grey, None, spacing)[..., 4]
    assert np.unravel_index(brightness.argmax(), (20, 20)) == (10, 8)
    assert brightness[10, 7] == pytest.approx(brightness[10, 9], rel=1e-4)
    assert brightness[9, 8] == pytest.approx(brightness[11, 8], rel=1e-4)


def test_texture_has_its_direction():
    """Stripes along v: change along u only, coherence 1; a quarter turn is the opposite."""
    stripes = np.tile(128 + 100 * np.sin(np.arange(120) / 2), (120, 1)).astype(np.uint8)
    across, along = (feature_maps(p, None, 4)[15, 15, 1:4] for p in (stripes, stripes.T))
    np.testing.assert_allclose(across, [1, 1, 0], atol=0.02)
    np.testing.assert_allclose(along, [1, -1, 0], atol=0.02)


def test_features_do_not_depend_on_where_arrays_lie_in_memory(make_texture):
    """Results are the same bytes each time: the last digits of cv2.magnitude were not."""
    picture = make_texture(402, 518)
    first = feature_maps(picture, None, 4)
    kept = []
    for size in range(1, 40):
        kept.append(np.empty(97 * size, np.float32))  # what comes next lies elsewhere
        assert np.array_equal(feature_maps(picture, None, 4), first)
