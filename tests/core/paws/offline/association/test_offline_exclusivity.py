"""Points shut each other out of places."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.association.associate import ViewEvidence, associate
from pawnb.core.paws.offline.association.exclusivity import open_to_each
from pawnb.core.paws.offline.parameters import AssociationParameters

RADIUS = 2.0
LEFT, RIGHT = (6, 5), (22, 5)


def test_a_place_surely_taken_is_closed_to_others_about_it_and_open_to_its_own():
    """The window is the largest odd number of places up to 1.8 radii: 3 x 3 about the place."""
    own = np.zeros((1, 11, 30), np.float32)
    own[0, LEFT[1], LEFT[0]] = 1
    half = np.zeros((1, 11, 30), np.float32)
    half[0, RIGHT[1], RIGHT[0]] = half[0, 0, 0] = 0.5
    factors = open_to_each({3: own, 7: half}, RADIUS, 0.9)
    closed = np.zeros((11, 30))
    closed[4:7, 5:8] = 0.9
    np.testing.assert_allclose(factors[7][0], 1 - closed, atol=1e-6)
    assert factors[3][0, RIGHT[1], RIGHT[0]] == pytest.approx(1 - 0.9 * 0.5)
    assert factors[3][0, LEFT[1], LEFT[0]] == 1


def test_what_two_others_share_is_closed_once():
    taken = np.full((1, 5, 5), 1.0, np.float32)
    factors = open_to_each({0: taken, 1: taken, 2: taken}, RADIUS, 0.8)
    np.testing.assert_allclose(factors[2], 0.2, atol=1e-6)


def two_places(stack, left):
    likelihood = np.full(stack.shape, 0.01, np.float32)
    likelihood[:, LEFT[1], LEFT[0]] = left
    likelihood[:, RIGHT[1], RIGHT[0]] = 20.0
    return likelihood


@pytest.fixture
def view(make_stack):
    """Two points of which the same two places are likely; point 1 is a little likelier left."""
    stack = make_stack(np.zeros((8, 33, 90), np.uint8))
    likelihood = {0: two_places(stack, 20.0), 1: two_places(stack, 22.0)}
    prior = np.full(stack.shape[1:], 1 / 330, np.float32)
    return ViewEvidence(stack, "side", (90, 33), Annotations({}), likelihood, {0: prior, 1: prior})


def about(posterior, place):
    x, y = place
    return posterior.mass[:, y - 1 : y + 2, x - 1 : x + 2].sum(axis=(1, 2))


def test_two_points_with_one_look_end_on_different_places(view):
    (found,) = associate([view], radius=RADIUS, parameters=AssociationParameters())
    assert (about(found[1], LEFT) > 0.9).all()
    assert (about(found[0], RIGHT) > 0.9).all()
    (alone,) = associate([view], radius=RADIUS, parameters=AssociationParameters(iterations=1))
    np.testing.assert_allclose(about(alone[0], RIGHT), about(alone[0], LEFT), rtol=1e-3)


def test_a_click_is_certain_and_shuts_the_other_point_out(view):
    """Point 0 is placed left, against the preference of point 1, in the fourth frame only."""
    clicked = Annotations({3: {0: np.array([3.0 * LEFT[0] + 1, 3.0 * LEFT[1] + 1])}})
    view = ViewEvidence(view.stack, view.name, view.size, clicked, view.likelihood, view.prior)
    (found,) = associate([view], radius=RADIUS, parameters=AssociationParameters(iterations=5))
    assert about(found[0], LEFT)[3] > 0.99
    assert about(found[1], RIGHT)[3] > 0.9
