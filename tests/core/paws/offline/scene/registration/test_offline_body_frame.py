"""Whether the body's frame stays, follows, travels or turns, and where it is."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.parameters import SceneParameters
from pawnb.core.paws.offline.scene.registration.body_frame import ViewBodyFrame, find_body_frame

N = 50
AXES = (30, 13)
EXTENT = 50.0
STEP = 0.03 * EXTENT
"""The frame is held until the animal has moved so far, px."""
T = np.arange(N) / (N - 1)


def find(pictures, centre, angle, *, row=25, scale=1.0):
    along = np.array([np.cos(angle[row]), np.sin(angle[row])])
    clicks = {row: centre[row] + np.outer([-0.7, 0.0, 0.7], AXES[0] * along)}
    return find_body_frame(pictures, clicks, EXTENT, scale=scale, parameters=SceneParameters())


def test_an_animal_that_runs_on_the_spot_stays(film_animal):
    """It sways by 3 px and nods by 3 degrees, as on a treadmill."""
    centre = np.stack([90 + 3 * np.sin(30 * T), 60 + 2 * np.cos(25 * T)], axis=-1)
    angle = np.radians(3) * np.sin(20 * T)
    found = find(film_animal(centre, angle, size=(180, 120)), centre, angle)
    assert found.kind == "stays"
    assert not found.pans
    assert not found.centre.any()
    assert not found.angle.any()


@pytest.mark.slow
def test_an_animal_that_crosses_the_picture_is_followed(film_animal):
    centre = np.stack([35 + 150 * T, np.full(N, 60.0)], axis=-1)
    angle = np.zeros(N)
    pictures = film_animal(centre, angle, size=(220, 120))
    found = find(pictures, centre, angle)
    assert found.kind == "follows"
    assert not found.angle.any()
    np.testing.assert_allclose(found.centre, centre, atol=0.1 * EXTENT)  # of a way of 3 extents
    # of small pictures of half the size: px of the view are twice as many
    np.testing.assert_allclose(find(pictures, centre, angle, scale=0.5).centre, 2 * found.centre)


def test_an_animal_that_walks_a_curve_turns_with_it(film_animal):
    """A half circle; the body points along it."""
    angle = np.pi * T
    centre = np.stack([90 + 45 * np.sin(angle), 75 - 35 * np.cos(angle)], axis=-1)
    found = find(film_animal(centre, angle, size=(180, 150)), centre, angle)
    assert found.kind == "turns"
    np.testing.assert_allclose(found.centre, centre, atol=STEP + 3)
    off = found.angle - angle
    off -= np.pi * np.round(off.mean() / np.pi)  # an axis has no head
    assert np.degrees(np.abs(off)).max() < 8


def test_while_it_rests_the_frame_is_held(film_animal):
    """It walks 200 px, but for 12 frames in the middle."""
    going = np.concatenate([np.arange(19), np.full(12, 19), np.arange(19, 38)]) / 37
    centre = np.stack([35 + 200 * going, np.full(N, 60.0)], axis=-1)
    found = find(film_animal(centre, np.zeros(N), size=(270, 120)), centre, np.zeros(N), row=10)
    assert found.kind == "follows"
    assert (found.centre[23:28] == found.centre[23]).all()
    np.testing.assert_allclose(found.centre[25], centre[25], atol=STEP + 2.5)
    assert len(np.unique(found.centre[:18], axis=0)) > 12


@pytest.mark.slow
def test_frames_in_which_a_part_was_clicked_do_not_move_it(film_animal):
    """Head in one, rump in the other: their middles lie an extent apart on the body."""
    centre = np.stack([35 + 150 * T, np.full(N, 60.0)], axis=-1)
    pictures = film_animal(centre, np.zeros(N), size=(220, 120))
    head = {10: centre[10] + np.array([[25.0, 0.0]])}
    rump = {30: centre[30] + np.array([[-25.0, 0.0]])}
    of_both, of_one = (
        find_body_frame(pictures, clicks, EXTENT, scale=1.0, parameters=SceneParameters())
        for clicks in (head | rump, head)
    )
    assert of_both.kind == of_one.kind == "follows"
    np.testing.assert_array_equal(of_both.centre, of_one.centre)


@pytest.mark.parametrize(("speed", "kind"), [(0.0, "stays"), (2.5, "follows")])
def test_before_a_panning_camera_the_frame_follows_the_animal_in_the_picture(
    film_animal, speed, kind
):
    """The ground goes 3 px a frame to the left; the animal stays, or gains 2.5 px."""
    n = 40
    camera = np.stack([-3.0 * np.arange(n), np.zeros(n)], axis=-1)
    centre = np.stack([110 + speed * (np.arange(n) - n / 2), np.full(n, 35.0)], axis=-1)
    pictures = film_animal(centre, np.zeros(n), camera=camera, size=(220, 70), axes=(18, 9))
    clicks = {20: centre[20] + np.array([[-12, 0], [12, 0]])}
    found = find_body_frame(pictures, clicks, 30.0, scale=1.0, parameters=SceneParameters())
    assert found.pans
    assert found.kind == kind
    if kind == "follows":
        np.testing.assert_allclose(found.centre, centre, atol=STEP + 4)


@pytest.mark.parametrize("degrees", [0, 90, 200])
def test_rotations_bring_the_body_to_the_u_axis(degrees):
    frame = ViewBodyFrame(np.zeros((1, 2)), np.radians([degrees]), "turns", pans=False)
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    np.testing.assert_allclose(frame.rotations()[0] @ along, [1, 0], atol=1e-12)
    assert np.linalg.det(frame.rotations()[0]) == pytest.approx(1)
