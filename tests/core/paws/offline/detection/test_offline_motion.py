"""Clicks followed by optical flow over pictures whose motion is known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.motion import detect_by_motion
from pawnb.core.paws.offline.parameters import MotionParameters

N = 12
PARAMETERS = MotionParameters()


def path(t):
    """Where the patch is: 3 px a frame to the right, down and up again."""
    return np.stack([40.0 + 3 * t, 60 + 10 * np.sin(t / 2)], axis=-1)


@pytest.fixture(scope="module")
def pictures(film_animal):
    return film_animal(path(np.arange(N)), np.zeros(N), axes=(16, 16))


def clicked(*rows, point=1):
    return Annotations({row: {point: path(row)} for row in rows})


def test_a_click_is_followed_both_ways(pictures, make_stack):
    found = detect_by_motion(make_stack(pictures), clicked(5), PARAMETERS)
    assert sorted(found.row) == [t for t in range(N) if t != 5]
    assert set(found.point) == {1}
    # 12 px is the radius of the patch; what is followed is right to a fraction of a px a frame
    np.testing.assert_allclose(found.uv, path(found.row), atol=1.0)


def test_trust_falls_with_every_frame_from_gain(pictures, make_stack):
    """Where the flow back ends where it set out, by 2 % a frame from a ratio of 15."""
    found = detect_by_motion(make_stack(pictures), clicked(0), PARAMETERS)
    np.testing.assert_allclose(
        np.exp(found.log_odds), 15 * 0.98 ** found.row.astype(float), rtol=0.05
    )
    np.testing.assert_allclose(found.sd_px, 1.3 * 3)


def test_between_two_clicks_each_is_followed_to_the_other_and_no_further(pictures, make_stack):
    found = detect_by_motion(make_stack(pictures), clicked(2, 6), PARAMETERS)
    assert sorted(found.row) == [0, 1, 2, 3, 3, 4, 4, 5, 5, 6, 7, 8, 9, 10, 11]


def test_a_patch_that_vanishes_is_followed_no_further(pictures, make_stack, make_texture):
    """From frame 7 on every picture is other noise: the flow back does not return."""
    pictures = pictures.copy()
    for t in range(7, N):
        pictures[t] = make_texture(*pictures.shape[1:], seed=100 + t)
    found = detect_by_motion(make_stack(pictures), clicked(2), PARAMETERS)
    assert set(range(7)) - {2} <= set(found.row)
    ratio = np.exp(found.log_odds)
    assert ratio[found.row < 7].min() > 10
    assert found.row.max() <= 7  # by chance the flow may return once


def test_positions_come_back_in_px_of_the_view(pictures, make_stack):
    """A view of half the size, 20 and 10 px further: the same pictures, other numbers."""
    A = np.array([[2.0, 0, -40], [0, 2, -20]])
    stack = dataclasses.replace(make_stack(pictures), to_body=np.tile(A, (N, 1, 1)), scale=2.0)
    uv = path(np.arange(N)) / 2 + [20, 10]
    found = detect_by_motion(stack, Annotations({0: {0: uv[0]}}), PARAMETERS)
    np.testing.assert_allclose(found.uv, uv[found.row], atol=0.5)
    np.testing.assert_allclose(found.sd_px, 1.3 * 3 / 2)


def test_without_clicks_or_further_frames_nothing_is_found(pictures, make_stack):
    assert len(detect_by_motion(make_stack(pictures), Annotations({}), PARAMETERS).row) == 0
    assert len(detect_by_motion(make_stack(pictures[:1]), clicked(0), PARAMETERS).row) == 0
