"""Two legs that have taken each other's ends give them back, unless they do cross."""

from types import SimpleNamespace

import numpy as np
import pytest

from pawnb.core.pose.fit.candidates.crossed_legs import uncrossed, with_ends_swapped
from pawnb.core.pose.fit.fitter import make_fitter
from pawnb.core.pose.fit.layout import leg_numbers, make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species

SCALE, SIZE = 2.4, 240
PAIR = (1, 2)


@pytest.fixture
def animal_seen():
    """A fitter, a pose in which two legs are 8 degrees apart, and a function that shows a pose."""
    animal = load_species("dolomedes")
    natural = natural_pose(animal, xy=(118.0, 120.0), heading_deg=15.0, scale=SCALE)
    pose = pose_vectors(animal, natural)[0]
    fitter = make_fitter(
        animal,
        make_layout(animal, px_per_unit=SCALE),
        evidence=SimpleNamespace(),
        anatomy=anatomy(animal, pose, foreshortening_sd=0.12),
        settings=PoseSettings(),
    )
    first, second = (fitter.index.numbers[leg][0] for leg in PAIR)
    joints = fitter.joints(pose)
    directions = [np.arctan2(*(joints[leg, -1] - joints[leg, 0])[::-1]) for leg in PAIR]
    apart = fitter.layout.side[1] * (directions[1] - directions[0])
    pose[first] -= 0.5 * (abs(apart) - np.radians(8.0))
    pose[second] += 0.5 * (abs(apart) - np.radians(8.0))

    def shown(pose):
        canvas = make_canvas(SIZE, SIZE, fitter.layout)
        paint(fitter.layout, pose, fitter.blur, np.zeros(2), *canvas)
        return ImageEvidence(canvas[0].copy(), np.full((SIZE, SIZE), 70.0), np.zeros(2))

    return fitter, pose, shown


def crossed_over(fitter, pose):
    """Return a pose whose two legs go from their own inner halves to the other's tips."""
    out, joints = pose.copy(), fitter.joints(pose)
    for leg, other in (PAIR, PAIR[::-1]):
        share = np.clip(np.linspace(-1.0, 1.0, joints.shape[1]), 0.0, 1.0)[:, None]
        places = (1.0 - share) * joints[leg] + share * joints[other]
        out[fitter.index.numbers[leg]] = leg_numbers(fitter.layout, leg, places, heading=pose[2])
    return out


def test_legs_get_their_ends_back(animal_seen):
    fitter, pose, shown = animal_seen
    image_evidence = shown(pose)
    lost, _ = fitter.fit(crossed_over(fitter, pose), image_evidence, fitter.anatomy, rounds=30)
    tips = [fitter.joints(p)[list(PAIR), -1] for p in (pose, lost)]
    assert np.hypot(*(tips[1] - tips[0]).T).min() > 4.0, "the fit alone found the way back"
    found = uncrossed(fitter, lost, image_evidence, prior=fitter.anatomy)
    found, _ = fitter.fit(found, image_evidence, fitter.anatomy, rounds=30)
    away = fitter.joints(found)[list(PAIR), -1] - tips[0]
    assert np.hypot(*away.T).max() < 0.5


def test_legs_that_cross_stay_crossed(animal_seen):
    fitter, pose, shown = animal_seen
    crossed = crossed_over(fitter, pose)
    found = uncrossed(fitter, crossed, shown(crossed), prior=fitter.anatomy)
    np.testing.assert_array_equal(found, crossed)


def test_a_pose_without_crossings_is_given_back(animal_seen):
    fitter, pose, shown = animal_seen
    assert uncrossed(fitter, pose, shown(pose), prior=fitter.anatomy) is pose


def test_ends_are_swapped_where_chains_meet():
    # an X: from (0, 0) and (0, 4), crossing at (2, 2); the ends beyond it are as long
    one = np.array([[0.0, 0.0], [1.0, 1.0], [4.0, 4.0]])
    other = np.array([[0.0, 4.0], [4.0, 0.0]])
    new_one, new_other = with_ends_swapped(one, other)
    np.testing.assert_allclose(new_one, [[0.0, 0.0], [1.0, 1.0], [4.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(new_other, [[0.0, 4.0], [4.0, 4.0]], atol=1e-12)
    same = with_ends_swapped(one, other + 10.0)
    np.testing.assert_array_equal(same[0], one)
