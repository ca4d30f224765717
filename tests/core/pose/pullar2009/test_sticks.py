"""Distances from the stick animal against points along it, and against a rasterised shape."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from painted_spider import random_pose

from pawnb.core.pose.poses import joint_positions, tip_positions
from pawnb.core.pose.pullar2009.sticks import (
    distance_map,
    from_body,
    from_ellipse,
    from_line,
    make_sticks,
    pose_vector,
)
from pawnb.core.pose.species_file import load_species


def posed(species="dolomedes", seed=0, scale=1.5):
    animal = load_species(species)
    pose = random_pose(animal, np.random.default_rng(seed), frame=0, xy=(100.3, 90.6),
                       heading_deg=33.0, scale=scale)  # fmt: skip
    return animal, pose, make_sticks(animal, pose)


@pytest.mark.parametrize("species", ["dolomedes", "spider", "insect"])
def test_links_end_where_the_joints_are(species):
    animal, pose, sticks = posed(species)
    points = sticks.points(pose_vector(pose))
    tips = points[np.arange(len(animal.legs)), sticks.n_links]
    np.testing.assert_allclose(tips, tip_positions(animal, pose)[0], atol=1e-9)
    np.testing.assert_allclose(points[:, 0], joint_positions(animal, pose)[0, :, 0], atol=1e-9)


def test_joints_that_do_not_turn_make_no_links():
    _, _, sticks = posed("dolomedes")
    # coxa | trochanter + femur + patella | tibia | metatarsus | tarsus
    assert list(sticks.n_links) == [5] * 8


@given(
    st.floats(-40, 40), st.floats(-40, 40), st.floats(2, 20), st.floats(2, 20)
)  # fmt: skip
def test_distance_from_an_ellipse(x, y, a, b):
    turn = np.linspace(0, 2 * np.pi, 4001)
    nearest = np.hypot(a * np.cos(turn) - x, b * np.sin(turn) - y).min()
    expected = 0.0 if (x / a) ** 2 + (y / b) ** 2 <= 1 else nearest
    assert from_ellipse(x, y, a, b) == pytest.approx(expected, abs=0.05)


def test_distance_from_a_leg_is_that_of_its_nearest_point_less_half_a_line():
    _, pose, sticks = posed()
    points = sticks.points(pose_vector(pose))[2]
    share = np.linspace(0, 1, 2001)[:, None]
    fine = np.concatenate([points[i] + share * (points[i + 1] - points[i]) for i in range(5)])
    for u, v in np.random.default_rng(4).uniform(20, 180, (40, 2)):
        nearest = np.hypot(*(fine - [u, v]).T).min()
        assert from_line(u, v, points, 5) == pytest.approx(max(0, nearest - 0.5), abs=1e-3)


def test_map_is_the_least_distance_of_body_and_legs():
    _, pose, sticks = posed()
    vector = pose_vector(pose)
    points, parts = sticks.points(vector), sticks.parts(vector)
    made = distance_map((30, 20), (150, 140), 33.0, points, sticks.n_links, parts, 12.0)
    rng = np.random.default_rng(2)
    turn = np.cos(np.radians(33)), np.sin(np.radians(33))
    for v, u in zip(rng.integers(0, 150, 300), rng.integers(0, 140, 300), strict=True):
        one = [from_line(u + 30.0, v + 20.0, points[i], 5) for i in range(8)]
        expected = min(*one, from_body(u + 30.0, v + 20.0, *turn, parts, np.inf), 12.0)
        assert made[v, u] == pytest.approx(expected, abs=1e-3)


def test_map_agrees_with_the_distance_transform_of_the_rasterised_shape():
    # section 3.3.2, implementation: lines one pixel thick and filled ellipses, bwdist
    animal, pose, sticks = posed(scale=2.0)
    vector = pose_vector(pose)
    points, parts = sticks.points(vector), sticks.parts(vector)
    raster = np.ones((200, 220), np.uint8)
    for line in points:
        cv2.polylines(raster, [np.round(line).astype(np.int32)], False, 0, 1)
    for part in parts:
        cv2.ellipse(raster, tuple(np.round(part[:2]).astype(int)),
                    tuple(np.round(part[2:]).astype(int)), 33.0, 0, 360, 0, -1)  # fmt: skip
    expected = cv2.distanceTransform(raster, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    made = distance_map((0, 0), raster.shape, 33.0, points, sticks.n_links, parts, 1e3)
    away = np.abs(made - expected)
    assert away.mean() < 0.5  # ends of lines are rounded to whole pixels in the raster
    assert away.max() < 1.6
    assert len(animal.legs) == 8
