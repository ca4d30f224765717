"""Two calibrated views: what one sees is a line in the other."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.epipolar import epipolar_support
from pawnb.core.paws.offline.parameters import AssociationParameters
from pawnb.core.rig import Rig
from pawnb.core.sightlines import find_fundamental_matrix

SIZE = (120, 90)
RADIUS = 2.0
TRUTH = np.array([[3.0, 2.0, -4.0], [-2.0, 5.0, 3.0]])
"""A point in each of two frames, mm."""


def look_at(position):
    """Projection matrix (3, 4) of a camera that looks at the origin from a position, Z up."""
    position = np.asarray(position, float)
    z = -position / np.linalg.norm(position)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z])
    K = np.array([[300.0, 0, 60.0], [0, 300.0, 45.0], [0, 0, 1]])
    return K @ np.c_[R, -R @ position]


CAMERAS = {"left": look_at([-60, -100, 0]), "right": look_at([60, -100, 30])}
RIG = Rig(tuple(CAMERAS), np.stack([(P / P[2, 3]).ravel()[:11] for P in CAMERAS.values()], axis=1))


def project(view, xyz):
    """Return (u, v) by the projection matrix itself."""
    u, v, w = CAMERAS[view] @ np.append(xyz, 1.0)
    return np.array([u / w, v / w])


def place_of(view, xyz):
    """Return the place (x, y) of the grid of 3 px whose first is at (1, 1), rounded."""
    return tuple(np.round((project(view, xyz) - 1) / 3).astype(int))


def other_place(xyz):
    """Return a place that looks like the point in the right view, off its line: 11 px away."""
    x, y = place_of("right", xyz)
    return x + 1, y + 11 if y < 15 else y - 11


@pytest.fixture
def stacks(make_stack):
    return [make_stack(np.zeros((2, SIZE[1], SIZE[0]), np.uint8)) for _ in range(2)]


def at(shape, places):
    mass = np.full(shape, 1e-6, np.float32)
    for t, here in enumerate(places):
        for x, y in here:
            mass[t, y, x] = 1.0
    return mass / mass.sum(axis=(1, 2), keepdims=True)


def support(stacks, left, right):
    return epipolar_support([left, right], stacks, names=list(CAMERAS), rig=RIG, radius=RADIUS)


def test_support_is_highest_along_the_line_through_the_true_point(stacks):
    """Farther points of the ray of the left camera are on the line in the right view, too."""
    shape = stacks[0].shape
    left = {5: at(shape, [[place_of("left", xyz)] for xyz in TRUTH])}
    found = support(stacks, left, {5: np.full(shape, 1 / 1200, np.float32), 6: left[5]})[1]
    assert found[5].max() <= 1
    np.testing.assert_array_equal(found[6], 1)  # the left view does not track it
    centre = np.linalg.solve(CAMERAS["left"][:, :3], -CAMERAS["left"][:, 3])
    for t, xyz in enumerate(TRUTH):
        for farther in (1.0, 0.95, 1.05):
            x, y = place_of("right", centre + farther * (xyz - centre))
            assert found[5][t, y, x] > 0.7
        x, y = other_place(xyz)
        assert found[5][t, y, x] < 0.1


def test_the_fundamental_matrix_gives_the_line_through_the_point_in_the_other_view():
    """A line a u + b v + c = 0; the point itself is seen in both pictures."""
    F = find_fundamental_matrix(CAMERAS["left"], CAMERAS["right"])
    assert np.linalg.norm(F) == pytest.approx(1)
    for xyz in TRUTH:
        line = F @ np.append(project("left", xyz), 1.0)
        on, off = project("right", xyz), project("right", np.add(xyz, [0, 0, 5]))
        away = [abs(line @ np.append(uv, 1.0)) / np.hypot(*line[:2]) for uv in (on, off)]
        assert away[0] < 1e-6
        assert away[1] > 5


def test_what_is_not_seen_says_nothing(stacks):
    """Every mode holds 25 of 1200 places, 2 % each: three are some 6 %, the rest is open."""
    shape = stacks[0].shape
    even = {0: np.full(shape, 1 / 1200, np.float32)}
    found = support(stacks, even, even)[0][0]
    assert found.min() > 0.93


def test_a_point_with_two_likely_places_in_one_view_is_decided_by_the_other(stacks):
    shape = stacks[0].shape
    prior = {0: np.full(shape[1:], 1 / 1200, np.float32)}
    likely = [
        {0: 1000 * at(shape, [[place_of("left", xyz)] for xyz in TRUTH])},
        {0: 1000 * at(shape, [[place_of("right", xyz), other_place(xyz)] for xyz in TRUTH])},
    ]
    # the point goes far between its two frames
    parameters = AssociationParameters(lost=0.9)
    views = [
        ViewEvidence(stack, name, SIZE, Annotations({}), ratio, prior)
        for stack, name, ratio in zip(stacks, CAMERAS, likely, strict=True)
    ]
    alone = associate(views, radius=RADIUS, parameters=parameters)[1][0].mass
    found = associate(views, radius=RADIUS, parameters=parameters, rig=RIG)[1][0].mass
    for t, xyz in enumerate(TRUTH):
        x, y = place_of("right", xyz)
        assert alone[t, y, x] < 0.6
        assert found[t, y, x] > 0.9
