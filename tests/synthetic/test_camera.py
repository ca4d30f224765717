"""The cameras of the synthetic treadmill."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core import dlt
from pawnb.synthetic.camera import make_cameras
from pawnb.synthetic.scene import scene_settings

points = st.tuples(st.floats(-120, 120), st.floats(-60, 60), st.floats(0, 90)).map(np.array)


def cameras(**changes):
    return make_cameras(scene_settings("normal", changes=changes))


@given(points, st.integers(0, 1000), st.integers(0, 3))
def test_dlt_coefficients_say_the_same_as_the_camera(point, seed, number):
    camera = cameras(seed=seed)[number]
    uv, depth = camera.project(point)
    L = camera.coefs
    below = L[8:11] @ point + 1.0
    expected = [(L[0:3] @ point + L[3]) / below, (L[4:7] @ point + L[7]) / below]
    np.testing.assert_allclose(uv, expected, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(dlt.project(L[:, None], point)[0], uv, rtol=1e-9, atol=1e-7)
    assert depth == pytest.approx((point - camera.centre) @ look(camera), rel=1e-9)


def look(camera):
    """Direction of the optical axis."""
    return camera.matrix[2, :3]


@settings(max_examples=30)
@given(points, st.floats(0.1, 1.5))
def test_a_smaller_picture_is_the_full_one_resampled_about_pixel_centres(point, scale):
    full, small = cameras(scale=1.0)[1], cameras(scale=scale)[1]
    expected = (full.project(point)[0] + 0.5) * scale - 0.5
    np.testing.assert_allclose(small.project(point)[0], expected, atol=1e-8)


def test_rays_go_back_to_where_projection_came_from():
    camera = cameras()[3]
    u, v = np.array([0.0, 300.5, 1023.0]), np.array([10.0, 349.0, 120.25])
    there = camera.centre + 517.0 * camera.rays(u, v)
    uv, depth = camera.project(there)
    np.testing.assert_allclose(uv, np.column_stack([u, v]), atol=1e-8)
    np.testing.assert_allclose(depth, 517.0)


@pytest.mark.parametrize("number", range(4))
def test_two_cameras_look_from_each_side_and_up_is_up(number):
    camera = cameras()[number]
    (u0, v0), (u1, _), (u2, v2) = camera.project(np.array([[0, 0, 0], [10, 0, 0], [0, 0, 10]]))[0]
    rightwards = 1 if number < 2 else -1
    assert np.sign(u1 - u0) == rightwards
    assert np.sign(camera.centre[1]) == -rightwards
    assert v2 < v0
    assert abs(u2 - u0) < 3
    # the animal, 87 mm long, takes a fifth to a quarter of the 1024 px of the picture
    nose, rump = camera.project(np.array([[50.0, 0, 20], [-37.0, 0, 25]]))[0][:, 0]
    assert 0.17 < abs(nose - rump) / 1024 < 0.27


def test_views_of_one_side_stand_apart_enough_for_space():
    for seed in range(20):
        axes = [look(c) / np.linalg.norm(look(c)) for c in cameras(seed=seed)]
        for a, b in ((0, 1), (2, 3)):
            assert 25 < np.degrees(np.arccos(axes[a] @ axes[b])) < 60


@pytest.mark.parametrize("n_views", [2, 3, 4])
def test_fewer_views(n_views):
    assert [c.name for c in cameras(n_views=n_views)] == [f"cam{i}" for i in range(1, n_views + 1)]
