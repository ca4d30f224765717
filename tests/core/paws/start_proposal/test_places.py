"""Spots, places and the ground: known geometry in, known geometry out."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skimage.color import rgb2lab

from pawnb.core.paws.start_proposal.blobs import (
    Blobs,
    find_blobs,
    find_digits,
    paw_likeness,
    share_as_paw_like,
)
from pawnb.core.paws.start_proposal.places import (
    CandidatePlaces,
    Stage,
    find_stage,
    on_ground,
    pair_blobs,
)
from pawnb.core.rig import Rig

# two cameras infinitely far away, 30 degrees apart and looking down a little
COEFS = np.array(
    [
        [2, 0.6, 0, 300, 0, 0.3, -2, 200, 0, 0, 0],
        [2, -0.6, 0, 300, 0, 0.3, -2, 200, 0, 0, 0],
    ],
    float,
).T
RIG = Rig(("cam1", "cam2"), COEFS)
PAW_PX = {"cam1": 20.0, "cam2": 20.0}


def test_a_pink_spot_on_green_stands_out_and_its_front_is_found():
    picture = np.full((120, 300, 3), (100, 140, 100), np.uint8)
    picture[30:70, 60:240] = (52, 53, 50)  # the body
    picture[80:86, 100:121] = (178, 136, 122)  # a paw 21 px long
    likeness = paw_likeness(picture, 20.0)
    blobs = find_blobs(likeness, 20.0)
    np.testing.assert_allclose(blobs.uv[0], (110, 82.5), atol=4)
    for facing, tip in ((1, 120), (-1, 100)):
        direction = np.array([facing, 0.0])
        uv = find_digits(likeness, blobs.uv[0], direction, reach_px=25.0, pad_px=5.0)
        # within the pad: the 5 px behind the tip
        assert 0.5 <= facing * (tip - uv[0]) <= 5.0
        assert uv[1] == pytest.approx(82.5, abs=0.7)


def test_a_light_spot_in_a_grey_picture_stored_as_colour():
    grey = np.full((120, 300), 40, np.uint8)
    grey[20:70, 60:240] = 90
    cv2.circle(grey, (150, 95), 6, 200, -1)
    for picture in (grey, np.repeat(grey[..., None], 3, axis=2)):
        np.testing.assert_allclose(
            find_blobs(paw_likeness(picture, 20), 20).uv[0], (150, 95), atol=1
        )


def on_a_belt(belt, *, light=True):
    """A wall, a belt (with light knots and a white edge), a dark body, a paw at (96.5, 84.5)."""
    rng = np.random.default_rng(0)
    picture = np.empty((120, 200, 3))
    picture[:50] = (92, 95, 90)
    picture[50:] = belt
    picture[50:] *= np.linspace(0.8, 1.2, 200)[None, :, None]
    if light:
        for u in range(10, 200, 30):
            picture[100:108, u : u + 12] *= 1.35
        picture[112:115] = (215, 222, 218)
    picture[30:70, 40:150] = (38, 36, 35)
    picture[80:90, 90:104] = (178, 136, 122)
    return (picture + rng.normal(0, 3, picture.shape)).round().astype(np.uint8)


def best_spot(picture, look):
    """Return the most paw-like spot of a picture."""
    return find_blobs(paw_likeness(picture, 20.0, look=look), 20.0).uv[0]


def test_redness_is_that_of_cielab():
    belt, paw = (136, 78, 111), (205, 150, 140)
    picture = np.full((120, 200, 3), belt, np.uint8)
    picture[60:70, 90:104] = paw
    # colours by scikit-image, OpenCV goes by tables; the belt is most of the picture
    lab = rgb2lab(np.array([[belt, paw]], np.uint8))[0]
    likeness = paw_likeness(picture, 20, look="red")
    np.testing.assert_allclose(likeness[65, 97], lab[1, 1] - lab[0, 1], atol=0.5)


@pytest.mark.parametrize(
    "belt", [(100, 140, 100), (136, 78, 111), (158, 83, 107), (90, 100, 150), (105, 90, 78)]
)
def test_skin_stands_out_from_belts_of_any_colour(belt):
    picture = on_a_belt(belt)
    np.testing.assert_allclose(best_spot(picture, "skin"), (96.5, 84.5), atol=3)
    if belt[0] - belt[1] > 50:  # redder than a paw
        assert np.linalg.norm(best_spot(picture, "red") - (96.5, 84.5)) > 8


def test_on_a_belt_of_the_colour_of_skin_a_paw_is_lighter():
    picture = on_a_belt(
        (151, 90, 70), light=False
    )  # darker and more vivid than skin, of the same hue
    assert np.linalg.norm(best_spot(picture, "skin") - (96.5, 84.5)) > 20
    np.testing.assert_allclose(best_spot(picture, "light"), (96.5, 84.5), atol=3)


def test_what_stays_where_it_is_comes_after_what_moves():
    paws = [np.zeros((120, 300)) for _ in range(9)]
    for frame, shown in enumerate(paws):
        shown[80:86, 40 + 25 * frame : 60 + 25 * frame] = 30.0  # a paw that moves on
        shown[20:30, 200:230] = 40.0  # a knot in the wood behind it
    alone = find_blobs(paws[4], 20.0)
    np.testing.assert_allclose(alone.uv[0], (214.5, 24.5), atol=8)
    told = find_blobs(paws[4], 20.0, still=np.median(paws, axis=0))
    np.testing.assert_allclose(told.uv[0], (149.5, 82.5), atol=8)
    in_knot = np.linalg.norm(told.uv - (214.5, 24.5), axis=1) < 20.0
    assert told.strength[in_knot].max() < 0.3 * told.strength[0]
    # where nothing moves, spots are still there to choose from
    assert len(find_blobs(paws[4], 20.0, still=paws[4]).uv)


def test_how_much_of_a_picture_is_as_paw_like_as_a_place():
    likeness = np.repeat(np.arange(100.0)[None], 40, axis=0)  # as paw-like as u is large
    for u, share in ((0, 0.99), (50, 0.5), (90, 0.1)):
        assert share_as_paw_like(likeness, np.array([u, 20.4])) == pytest.approx(share, abs=0.011)
    for outside in ((-5.0, 20.0), (50.0, 60.0)):
        assert share_as_paw_like(likeness, np.array(outside)) == 1.0


def test_digits_without_a_paw_stay_where_they_were():
    flat = np.zeros((50, 50))
    uv = find_digits(flat, np.array([20.0, 20.0]), np.array([1.0, 0.0]), reach_px=5.0, pad_px=2.0)
    np.testing.assert_allclose(uv, (20, 20))
    outside = np.array([80.0, 20.0])
    np.testing.assert_array_equal(
        find_digits(flat, outside, np.array([1.0, 0.0]), reach_px=5.0, pad_px=2.0), outside
    )


@settings(deadline=None, max_examples=30)
@given(st.lists(st.tuples(*[st.floats(-60, 60)] * 3), min_size=1, max_size=6))
def test_places_that_both_views_see_are_among_the_pairs(points):
    xyz = np.array(points)
    seen = RIG.project(xyz)
    strength = np.linspace(1.0, 0.5, len(xyz))
    blobs = {name: Blobs(seen[:, k], strength) for k, name in enumerate(RIG.names)}
    places = pair_blobs(RIG, blobs, paw_px=PAW_PX)
    away = np.linalg.norm(places.xyz[:, None] - xyz, axis=-1).min(axis=0)
    np.testing.assert_allclose(away, 0, atol=1e-6)
    assert (places.residual <= 0.2).all()


def test_a_place_is_as_paw_like_as_its_least_paw_like_spot():
    uv = RIG.project(np.array([[5.0, -9.0, 2.0]]))
    blobs = {
        "cam1": Blobs(uv[:, 0], np.array([1.0])),
        "cam2": Blobs(uv[:, 1], np.array([0.25])),
    }
    np.testing.assert_array_equal(pair_blobs(RIG, blobs, paw_px=PAW_PX).strength, [0.25])


def test_views_that_do_not_agree_make_no_place():
    blobs = {
        "cam1": Blobs(np.array([[300.0, 200.0]]), np.ones(1)),
        "cam2": Blobs(np.array([[300.0, 240.0]]), np.ones(1)),  # 40 px lower: 2 paws
    }
    assert len(pair_blobs(RIG, blobs, paw_px=PAW_PX).xyz) == 0


def stand(rng, *, tilt=None, clutter=400, tail_sd=5.0):
    """Paws about (+-20, +-10, 2), a tail about 25 high with more places, and clutter all over."""
    corners = [(x, y, 2.0) for x in (-20, 20) for y in (-10, 10)]
    paws = np.concatenate([c + rng.normal(0, (6, 2, 0.5), (120, 3)) for c in corners])
    tail = rng.normal((-45, 0, 25), (10, 3, tail_sd), (900, 3))
    rest = rng.uniform(-90, 90, (clutter, 3))
    xyz = np.concatenate([paws, tail, rest])
    if tilt is not None:
        xyz = xyz @ tilt.T
    residual = np.concatenate(
        [np.abs(rng.normal(0, 0.03, 480 + 900)), rng.uniform(0, 0.2, clutter)]
    )
    return CandidatePlaces(xyz, np.full(len(xyz), 0.8), residual)


def test_ground_middle_and_span_are_told_from_tail_and_clutter():
    stage = find_stage(stand(np.random.default_rng(0)), RIG)
    assert stage.ground == pytest.approx(2.0, abs=1.5)
    assert stage.middle == pytest.approx(0.0, abs=2.0)
    assert (stage.hind, stage.front) == pytest.approx((-20, 20), abs=4)


def test_the_ground_is_the_lowest_height_where_places_gather():
    """A tail held level gathers more places than the paws, but higher."""
    stage = find_stage(stand(np.random.default_rng(0), tail_sd=0.7), RIG)
    assert stage.ground == pytest.approx(2.0, abs=1.5)


def test_directions_of_the_rig_are_kept_to():
    """The same scene turned: forward is -Y and up is +X."""
    forward, up = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    # the columns are where X (forward), Y (left) and Z (up) go
    tilt = np.stack([forward, np.cross(up, forward), up], axis=1)
    rig = Rig(RIG.names, COEFS, forward=tuple(forward), up=tuple(up))
    stage = find_stage(stand(np.random.default_rng(0), tilt=tilt), rig)
    assert stage.ground == pytest.approx(2.0, abs=1.5)
    assert (stage.hind, stage.front) == pytest.approx((-20, 20), abs=4)
    # to the animal's right is -Y of the scene as it was
    np.testing.assert_allclose(stage.axes[1], tilt @ [0, -1, 0], atol=1e-12)


def test_too_few_places_make_no_ground():
    places = stand(np.random.default_rng(0))
    few = CandidatePlaces(places.xyz[:10], places.strength[:10], places.residual[:10])
    assert find_stage(few, RIG) is None


def test_one_view_and_the_ground_give_the_place():
    stage = Stage(np.stack([np.eye(3)[0], -np.eye(3)[1], np.eye(3)[2]]), 2.0, 0.0, -20.0, 20.0)
    xyz = np.array([[5.0, -9.0, 2.0], [-30.0, 12.0, 2.0]])
    blobs = Blobs(RIG.project(xyz)[:, 1], np.array([1.0, 0.4]))
    places = on_ground(RIG, "cam2", blobs, stage=stage)
    np.testing.assert_allclose(places.xyz, xyz, atol=1e-9)
    np.testing.assert_array_equal(places.strength, [1.0, 0.4])
    assert np.isnan(places.residual).all()
    np.testing.assert_array_equal(places.weight, [1.0, 0.4])
