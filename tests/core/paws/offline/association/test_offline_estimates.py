"""From probabilities of places to positions, against sums over all places."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.association.estimates import estimate, modes
from pawnb.core.paws.offline.detection.evidence import bump_at


def gaussian(shape, place, sd):
    mass = bump_at(shape, place, sd).astype(float)
    return mass / mass.sum()


def test_a_gaussian_is_found_between_the_places_with_its_standard_deviation():
    mass = gaussian((30, 40), (17.3, 12.6), 1.5)
    found = estimate(mass[None].astype(np.float32), 8)
    np.testing.assert_allclose(found.place, [[17.3, 12.6]], atol=0.02)
    np.testing.assert_allclose(found.sd, 1.5, atol=0.02)
    np.testing.assert_allclose(found.probability, 1, atol=1e-4)


def test_of_two_modes_the_higher_is_taken_and_the_other_is_its_doubt():
    """70 % at (10, 10) and 30 % at (30, 10): variance about the first 30 % of 20² along x."""
    mass = 0.7 * gaussian((21, 41), (10, 10), 0.8) + 0.3 * gaussian((21, 41), (30, 10), 0.8)
    found = estimate(mass[None].astype(np.float32), 4)
    np.testing.assert_allclose(found.place, [[10, 10]], atol=0.05)
    np.testing.assert_allclose(found.probability, 0.7, atol=0.01)
    np.testing.assert_allclose(found.sd, np.sqrt((0.3 * 400 + 2 * 0.8**2) / 2), rtol=0.01)


def test_modes_come_the_likeliest_first_and_the_unlikely_not_at_all():
    mass = np.zeros((20, 30))
    for (x, y), p in {(5, 5): 0.3, (20, 10): 0.5, (28, 1): 0.14, (12, 17): 0.01}.items():
        mass[y, x] = p
    mass[10, 21] = 0.05  # of the mode beside it, less than another's
    found = modes(mass, 3, 9)
    assert [tuple(place) for place, _ in found] == [(20, 10), (5, 5), (28, 1)]
    assert [p for _, p in found] == pytest.approx([0.55, 0.3, 0.14])
    assert len(modes(mass, 3, 2)) == 2
    assert mass.sum() == pytest.approx(1)  # left as it was


def test_without_frames_there_are_no_estimates():
    assert estimate(np.empty((0, 4, 4), np.float32), 2).place.shape == (0, 2)
