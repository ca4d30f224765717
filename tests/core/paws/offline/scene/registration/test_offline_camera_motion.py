"""The camera's motion from pictures that were moved by known similarities."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.registration import camera_motion
from pawnb.core.paws.offline.scene.registration.camera_motion import find_camera_motion

SIZE = (160, 120)


def similarity(degrees, scale, shift):
    """Similarity (3, 3) about the middle of the picture."""
    A = cv2.getRotationMatrix2D((SIZE[0] / 2, SIZE[1] / 2), degrees, scale)
    A[:, 2] += shift
    return np.vstack([A, [0, 0, 1]])


@pytest.mark.parametrize(
    ("degrees", "scale", "shift"), [(0, 1.0, (2.0, -1.0)), (1.0, 1.0, (1, 1)), (0.5, 1.01, (2, 0))]
)
def test_pictures_moved_by_a_similarity_are_brought_back(make_texture, degrees, scale, shift):
    """Six pictures; the corners of each come to where they are in the first, to half a px."""
    large = make_texture(240, 280, seed=5)
    shot = np.array([[1.0, 0, -60], [0, 1, -60], [0, 0, 1]])
    step = similarity(degrees, scale, shift)
    from_first = [np.linalg.matrix_power(step, t) for t in range(6)]
    pictures = np.stack([cv2.warpAffine(large, (M @ shot)[:2], SIZE) for M in from_first])
    found = find_camera_motion(pictures)
    assert found.pans
    corners = np.array([[0, SIZE[0], 0, SIZE[0]], [0, 0, SIZE[1], SIZE[1]], [1, 1, 1, 1]])
    for t, M in enumerate(from_first):
        np.testing.assert_allclose(found.to_first[t] @ M @ corners, corners, atol=0.5)
    np.testing.assert_allclose(
        found.between(1, 4) @ from_first[1] @ corners, from_first[4] @ corners, atol=0.5
    )


def test_a_still_camera_before_a_moving_animal_does_not_pan(film_animal):
    """A large animal: a fifth of the picture moves by 2 px a frame."""
    n = 10
    centre = np.stack([50 + 2.0 * np.arange(n), np.full(n, 60.0)], axis=-1)
    found = find_camera_motion(film_animal(centre, np.zeros(n), axes=(45, 28)))
    assert not found.pans
    np.testing.assert_array_equal(found.to_first, np.tile(np.eye(3), (n, 1, 1)))


def test_pictures_that_have_nothing_in_common_do_not_pan(make_texture):
    assert not find_camera_motion(np.stack([make_texture(120, 160, seed=t) for t in range(5)])).pans


@pytest.mark.parametrize("n", [1, 4])
def test_pictures_without_features_do_not_pan(n):
    found = find_camera_motion(np.full((n, 60, 80), 90, np.uint8))
    assert not found.pans
    assert found.to_first.shape == (n, 3, 3)


def test_long_recordings_of_a_still_camera_are_looked_at_in_part(make_texture, monkeypatch):
    asked = []

    def counted(before, after, step=camera_motion._step):
        asked.append(1)
        return step(before, after)

    monkeypatch.setattr(camera_motion, "_step", counted)
    texture = make_texture(130, 200)
    still = np.stack([texture[:100, :120]] * 90)
    assert not find_camera_motion(still).pans
    assert len(asked) == CAMERA.camera_tried
    moving = np.stack([texture[:100, t // 2 : 120 + t // 2] for t in range(0, 160, 2)])
    found = find_camera_motion(moving)
    assert found.pans
    np.testing.assert_allclose(found.to_first[79, :2, 2], (79, 0), atol=2)
