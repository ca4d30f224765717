"""Paws on a belt that is nearly as brown as they are: told by finer steps of colour."""

import cv2
import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.colour_model import learn
from pawnb.core.paws.offline.detection.colour.detector import DetectorConfig, detect, endpoint_score
from pawnb.core.paws.offline.detection.colour.photometry.colour_quantisation import (
    FineColours,
    bin_numbers,
    fine_colours_near,
)
from pawnb.core.paws.offline.detection.colour.scan import configure_detector

PAW, BELT, GREEN, FUR = (140, 112, 101), (135, 105, 92), (70, 130, 70), (50, 48, 46)
THICK, STREAKS = 8, 0.1
AT = np.array([[80.0, 100.0], [150.0, 95.0]])


def picture(belt, *, moved=0, seed=0, noise=4.0):
    """Two limbs under a dark body on a belt, in the body's shadow; with the noise of a camera."""
    rng = np.random.default_rng(seed)
    # streaks along the belt, as of wood
    streaks = cv2.GaussianBlur(rng.normal(size=(240, 700)), (0, 0), sigmaX=25.0, sigmaY=1.5)
    image = np.array(belt) * (1.0 + STREAKS * streaks / streaks.std())[..., None]
    image[62:125, 20:220] *= 0.75
    cv2.rectangle(image, (30 + moved, 10), (190 + moved, 62), FUR, -1)
    paws = np.zeros(image.shape[:2], np.uint8)
    for limb in ([[60, 70], [80, 100]], [[150, 62], [150, 95]]):
        cv2.line(paws, *np.add(limb, (moved, 0)).tolist(), 1, THICK)
    image[paws > 0] = 0.9 * np.array(PAW)
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    image += rng.normal(scale=noise, size=image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8), paws > 0


def test_the_middle_colour_is_in_the_middle_and_steps_are_those_stated():
    fine_colours = fine_colours_near(np.array([[139, 112, 101], [140, 112, 101], [150, 112, 101]]))
    colours = np.array([PAW, (143, 112, 101), (140, 112, 104), (143, 115, 104)], np.uint8)
    # a level is 2 of brightness and 4 of colour; 3 levels of red are 12 more of red over green,
    # 6 less of blue, and 0.3 * 3 * 2 of brightness; of blue 12 and 0.11 * 3 * 2
    expected = np.array([[0, 0, 0], [1.8, 12, -6], [0.66, 0, 12], [6, 0, 0]]) + 127.5
    for is_faint in (False, True):
        # even pictures: they stay as they are however much they are smoothed
        even = [
            FineColours(fine_colours.weights, is_faint).of(np.full((9, 9, 3), c)) for c in colours
        ]
        assert np.abs(np.array(even)[:, 4, 4] - expected).max() <= 0.5 + 1e-3


def test_colours_that_share_a_usual_bin_have_shades_of_their_own():
    halves = np.full((20, 40, 3), PAW, np.uint8)
    halves[:, 20:] = (137, 114, 98)
    usual = bin_numbers(halves, 5)
    assert usual[10, 5] == usual[10, 35]
    fine = bin_numbers(halves, 5, fine_colours=fine_colours_near(np.array([PAW])))
    assert fine[10, 5] != fine[10, 35]


@pytest.mark.slow
def test_finer_steps_are_taken_only_where_paws_look_like_the_belt():
    assert learn([picture(GREEN)[0]], [AT], around_px=15).fine_colours is None
    assert learn([picture(BELT)[0]], [AT], around_px=15).fine_colours is not None
    grey = cv2.cvtColor(picture(BELT)[0], cv2.COLOR_RGB2GRAY)
    assert learn([grey], [AT], around_px=15).fine_colours is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_paws_as_brown_as_the_belt_are_found_in_another_frame(seed):
    detector = learn([picture(BELT)[0]], [AT], around_px=15)
    image, paws = picture(BELT, moved=25, seed=seed)
    score = cv2.GaussianBlur(detector.score(image), (3, 3), 0.6)
    beside = ~cv2.dilate(paws.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    assert (score[beside] > 0).mean() < 0.002 < 0.02 < detector.mistaken
    rows = detect(image, (0, 0), DetectorConfig(detector, 1, 7, (0.0, 1.0)))
    best = rows.take(np.argsort(-endpoint_score(rows, (0.0, 1.0)))[:4]).uv
    for end in np.add(AT, (25, 0)):
        assert np.linalg.norm(best - end, axis=1).min() < 4.0


def test_faint_paws_are_smoothed_more_and_more_places_are_kept():
    usual, brown, faint = (
        learn([picture(belt, noise=noise)[0]], [AT], around_px=15)
        for belt, noise in ((GREEN, 4.0), (BELT, 4.0), (BELT, 6.0))
    )
    # 6 % of what is about the animal is the limit that the module states
    assert usual.mistaken < brown.mistaken < 0.06 < faint.mistaken
    assert [detector.is_faint for detector in (usual, brown, faint)] == [False, False, True]
    kept = [
        configure_detector(detector, 8.0, (0.0, 1.0)).most for detector in (usual, brown, faint)
    ]
    assert kept[0] == kept[1] < kept[2]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_much_noise_leaves_paws_that_differ_by_less_to_be_seen(seed):
    # noise of 6 levels is more than the 2 to 10 by which paws and belt differ; of single pixels
    # smoothed as usual hardly half of a paw scores above all but 1 % of the rest
    detector = learn([picture(BELT, noise=6.0)[0]], [AT], around_px=15)
    image, paws = picture(BELT, moved=25, seed=seed, noise=6.0)
    score = cv2.GaussianBlur(detector.score(image), (3, 3), 0.6)
    beside = ~cv2.dilate(paws.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    assert (score[paws] > np.quantile(score[beside], 0.99)).mean() > 0.75


def test_a_faint_paw_stands_out_of_a_shadow_that_passes_for_paws_all_over():
    score = np.full((120, 120), -2.0, np.float32)
    score[20:100, 20:100] = 1.0
    score[58:63, 58:63] = 3.0
    fine_colours = fine_colours_near(np.array([PAW]))
    np.testing.assert_array_equal(fine_colours.stand_out(score), score)
    told = FineColours(fine_colours.weights, is_faint=True).stand_out(score)
    # the mean over 45 x 45 pixels about the paw is 1 + 25 * 2 / 45 ** 2
    assert told[60, 60] == pytest.approx(3.0 - 1.5 * (1.0 + 50.0 / 2025.0), abs=1e-4)
    assert told[60, 60] > 0.0 > told[40, 60]
    # where nothing passes for a paw nothing is taken off
    empty = np.full((90, 90), -2.0, np.float32)
    np.testing.assert_array_equal(
        FineColours(fine_colours.weights, is_faint=True).stand_out(empty), empty
    )
