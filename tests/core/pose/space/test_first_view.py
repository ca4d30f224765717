"""The pose of the first view, corrected by joints in space."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import least_squares
from walking_poses import walking_poses

from pawnb.core.pose.poses import joint_positions
from pawnb.core.pose.space.first_view import corrected_first_view
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.settings import SpaceSettings
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.schema import ORIGIN_CODE

ANIMAL = load_species("dolomedes")
FROM_ABOVE = np.array([1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0])  # u = x, v = y
SETTINGS = SpaceSettings()


def in_space(places, *, support=1.0):
    """Joints in space above these places of the first view."""
    n, legs, joints = places.shape[:3]
    height = np.broadcast_to(np.arange(joints, dtype=float), (n, legs, joints))
    return SpaceTrack(
        body=np.zeros((n, 3)),
        joints=np.concatenate([places, height[..., None]], axis=-1),
        body_sd=np.zeros((n, 3)),
        joints_sd=np.zeros((n, legs, joints, 3)),
        seen_uv=places,
        body_uv=np.zeros((n, 2)),
        residual_px=np.zeros((n, legs, joints)),
        support=np.full((n, legs), support),
    )


def corrected(track, space):
    return corrected_first_view(ANIMAL, track, space, coefs=FROM_ABOVE, settings=SETTINGS)


@pytest.fixture
def scene():
    """The true poses, and what the first view made of them: joints slid along each leg."""
    true = walking_poses(ANIMAL, 5)
    slid = true.lengths_px.reshape(5, 8, 7) * [1.0, 1.2, 0.7, 1.15, 0.95, 1.0, 1.0]
    return true, plain_track(ANIMAL, dataclasses.replace(true, lengths_px=slid.reshape(5, 56)))


def test_joints_come_to_where_space_has_them(scene):
    true, wrong = scene
    places = joint_positions(ANIMAL, true)
    found = corrected(wrong, in_space(places))
    np.testing.assert_allclose(joint_positions(ANIMAL, found.poses), places, atol=0.02)
    np.testing.assert_allclose(found.poses.angles_deg, true.angles_deg, atol=0.05)
    np.testing.assert_array_equal(found.poses.xy, true.xy)


def test_it_is_the_least_squares_fit(scene):
    """One leg in one frame, noise on its places, against SciPy on the same sum of squares."""
    true, wrong = scene
    rng = np.random.default_rng(0)
    places = joint_positions(ANIMAL, true) + rng.normal(0, 1.0, (5, 8, 8, 2))
    places[:, :, 0] = joint_positions(ANIMAL, true)[:, :, 0]
    found = corrected(wrong, in_space(places)).poses
    span = ANIMAL.span * true.scale[0]
    one, target = wrong.poses.take([2]), places[2, 3]
    free = int(sum(ANIMAL.leg("L4").free))
    at = slice(15, 15 + free), slice(21, 28)
    known = np.linalg.norm(np.diff(target, axis=0), axis=1)

    def off(x):
        angles, lengths = one.angles_deg.copy(), one.lengths_px.copy()
        angles[0, at[0]], lengths[0, at[1]] = x[:free], x[free:]
        moved = dataclasses.replace(one, angles_deg=angles, lengths_px=lengths)
        place = joint_positions(ANIMAL, moved)[0, 3] - target
        return np.concatenate(
            [
                place[1:].ravel() / (SETTINGS.across_share * span),
                (x[:free] - one.angles_deg[0, at[0]]) / SETTINGS.angle_sd_deg,
                (x[free:] - known) / (IN_SPACE.projected_length_sd * span),
            ]
        )

    best = least_squares(off, np.r_[one.angles_deg[0, at[0]], known], xtol=1e-12).x
    np.testing.assert_allclose(found.angles_deg[2, at[0]], best[:free], atol=0.02)
    np.testing.assert_allclose(found.lengths_px[2, at[1]], best[free:], atol=0.02)


def test_what_the_second_view_does_not_show_stays(scene):
    true, wrong = scene
    space = in_space(joint_positions(ANIMAL, true))
    space.support[1, 3] = 0.4
    space.joints[2, 0] = np.nan
    wrong.origin[3] = ORIGIN_CODE["edited"]
    found = corrected(wrong, space)
    same = np.isclose(found.poses.lengths_px, wrong.poses.lengths_px).reshape(5, 8, 7).all(axis=2)
    expected = np.zeros((5, 8), bool)
    expected[1, 3] = expected[2, 0] = expected[3] = True
    np.testing.assert_array_equal(same, expected)
