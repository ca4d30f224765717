"""Detections: the ends of drawn limbs, and the look of paws learnt from clicks."""

import cv2
import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.colour_model import learn
from pawnb.core.paws.offline.detection.colour.detector import DetectorConfig, detect, endpoint_score

PINK, GREEN, FUR = (200, 130, 120), (70, 130, 70), (50, 48, 46)


ENDS = np.array([[79.0, 97.0], [150.0, 92.0]])


def drawn(times=1):
    """Two limbs 8 px thick, ending at (80, 100) and (150, 95), under a dark body."""
    image = np.full((240 * times, 700 * times, 3), GREEN, np.uint8)
    corners = np.array([[30, 10], [190, 60]]) * times
    cv2.rectangle(image, *corners.tolist(), FUR, -1)
    for limb in ([[60, 70], [80, 100]], [[150, 62], [150, 95]]):
        cv2.line(image, *(np.array(limb) * times).tolist(), PINK, 8 * times)
    return image


def picture(*, grey=False, seed=0):
    """That picture with the noise of a camera."""
    rng = np.random.default_rng(seed)
    image = drawn()
    noisy = np.clip(image + rng.normal(scale=3.0, size=image.shape), 0, 255).astype(np.uint8)
    return noisy if not grey else cv2.cvtColor(noisy, cv2.COLOR_RGB2GRAY)


@pytest.mark.parametrize("grey", [False, True])
def test_ends_of_limbs_are_the_best_candidates(grey):
    image = picture(grey=grey)
    detector = learn([image], [ENDS], around_px=15)
    assert 6.0 <= detector.paw_width_px <= 11.0
    rows = detect(image, (0, 0), DetectorConfig(detector, 1, 7, (0.0, 1.0)))
    best = rows.take(np.argsort(-endpoint_score(rows, (0.0, 1.0)))[:2]).uv
    for end in ENDS:
        assert np.linalg.norm(best - end, axis=1).min() < 6.0


def test_the_direction_points_to_the_end_and_origin_and_scale_are_undone():
    image = picture()
    detector = learn([image], [ENDS], around_px=15)
    plain = detect(image, (0, 0), DetectorConfig(detector, 1, 7, (0.0, 1.0)))
    moved = detect(image, (1000, 500), DetectorConfig(detector, 1, 7, (0.0, 1.0)))
    np.testing.assert_allclose(moved.uv - plain.uv, [[1000, 500]] * len(plain), atol=1e-3)
    nearest = np.argmin(np.linalg.norm(plain.uv - ENDS[1], axis=1))
    across, down = plain.direction[nearest]
    assert down > 2.0 * abs(across)
    halved = detect(image, (0, 0), DetectorConfig(detector, 2, 7, (0.0, 1.0)))
    away = np.linalg.norm((halved.uv[:, None] + 0.5) / 2 - 0.5 - plain.uv, axis=-1)
    assert np.median(away.min(axis=1)) < 1.0


def test_nothing_is_found_where_there_is_no_paw_or_beyond_the_limits():
    image = picture()
    detector = learn([image], [ENDS], around_px=15)
    empty = np.full((60, 60, 3), GREEN, np.uint8)
    assert len(detect(empty, (0, 0), DetectorConfig(detector, 1, 7))) == 0
    left_only = np.array([[-1.0, 0.0, 110.0]])
    rows = detect(image, (0, 0), DetectorConfig(detector, 1, 7, (0.0, 1.0), left_only))
    assert len(rows) > 0
    assert rows.uv[:, 0].max() <= 110.0


def test_many_thin_ends_do_not_crowd_out_the_paws():
    """100 strips of the paws' colour, too thin for paws: their ends are hundreds."""
    detector = learn([picture()], [ENDS], around_px=15)
    image = picture(seed=1)
    for k in range(100):
        u, v = 215 + k % 20 * 24, 20 + k // 20 * 44
        cv2.line(image, (u, v), (u, v + 20), PINK, 3)
    rows = detect(image, (0, 0), DetectorConfig(detector, 1, 7, (0.0, 1.0)))
    for end in ENDS:
        assert np.linalg.norm(rows.uv - end, axis=1).min() < 6.0


@pytest.mark.slow
def test_fine_marks_of_a_large_picture_do_not_change_how_thick_paws_are():
    """One pixel in five is of the wrong colour, on the paws and beside them."""
    rng = np.random.default_rng(0)
    image = drawn(4)
    wrong, is_paw = rng.random(image.shape[:2]) < 0.2, (image == PINK).all(axis=-1)
    image[wrong & is_paw], image[wrong & ~is_paw] = GREEN, PINK
    noisy = image + rng.normal(scale=10.0, size=image.shape)
    large = np.clip(noisy, 0, 255).astype(np.uint8)
    detector = learn([large], [(ENDS + 0.5) * 4 - 0.5], around_px=60)
    assert detector.paw_width_px == pytest.approx(32.0, rel=0.2)


def test_paws_are_told_from_a_belt_of_nearly_their_colour_and_shadows_on_it():
    """A brown belt, dull paws, a soft shadow, noise of two steps of the table of colours."""
    rng = np.random.default_rng(1)
    shadow = np.zeros((240, 700), np.float32)
    cv2.ellipse(shadow, (115, 98), (80, 14), 0, 0, 360, 0.45, -1)
    image = (
        np.array([135.0, 108.0, 90.0]) * (1.0 - cv2.GaussianBlur(shadow, (0, 0), 6.0))[..., None]
    )
    cv2.rectangle(image, (30, 10), (190, 60), FUR, -1)
    limbs = np.zeros(image.shape[:2], np.uint8)
    for start, end in ([(60, 70), (80, 100)], [(150, 62), (150, 95)]):
        cv2.line(limbs, start, end, 1, 8)
    image[limbs > 0] = 140.0, 112.0, 101.0
    image = cv2.GaussianBlur(image, (0, 0), 0.8) + rng.normal(scale=10.0, size=image.shape)
    seen = np.clip(image, 0, 255).astype(np.uint8)
    detector = learn([seen], [ENDS], around_px=15)
    score = cv2.GaussianBlur(detector.score(seen), (3, 3), 0.6)
    substrate = cv2.dilate(limbs, np.ones((9, 9), np.uint8)) == 0
    substrate[:66] = False  # the body
    assert (score[limbs > 0] > 0).mean() > 0.45
    assert (score[substrate] > 0).mean() < 0.01
    assert detector.paw_width_px == pytest.approx(8.0, rel=0.25)
