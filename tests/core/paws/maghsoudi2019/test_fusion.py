"""Eq. 3 to 6 on numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pawnb.core.paws.maghsoudi2019.fusion import best_superpixels, compute_features, fuse, normalise
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.superpixels import Look, Superpixels, Window

# three superpixels in a sub-image of 140 x 80 px about (100, 50)
WINDOW = Window(np.array([100.0, 50.0]), 70.0, 40.0, (30, 10, 170, 90))
THREE = Superpixels(
    green=np.array([110.0, 130.0, 190.0]),
    hue=np.array([355.0, 15.0, 95.0]),
    red=np.array([200.0, 220.0, 100.0]),
    uv=np.array([[103.0, 54.0], [100.0, 60.0], [140.0, 90.0]]),
    labels=np.zeros((80, 140), dtype=int),
    window=WINDOW,
)
INITIAL = Look(green=120.0, hue=5.0, red=220.0)
PREVIOUS = Look(green=130.0, hue=350.0, red=200.0)

# by hand: hue 355 and 5 are 10 degrees apart; corner (170, 90) faces right, (30, 90) left
FEATURES_RIGHT = [
    [10, 20, 10, 5, 20, 0, np.hypot(67, 36), 5],
    [10, 0, 10, 25, 0, 20, np.hypot(70, 30), 10],
    [70, 60, 90, 105, 120, 100, 30, np.hypot(40, 40)],
]


def test_features_of_eq_3():
    found = compute_features(THREE, INITIAL, PREVIOUS, facing=+1)
    np.testing.assert_allclose(found, FEATURES_RIGHT)


def test_corner_lies_towards_the_direction_of_travel():
    left = compute_features(THREE, INITIAL, PREVIOUS, facing=-1)[:, 6]
    np.testing.assert_allclose(left, [np.hypot(73, 36), np.hypot(70, 30), 110])
    assert not compute_features(THREE, INITIAL, PREVIOUS, facing=0)[:, 6].any()


def test_normalised_and_fused_by_hand():
    features = np.array([[10.0, 0.0, 3.0], [20.0, 0.0, 5.0], [30.0, 0.0, 4.0]])
    # Eq. 4: 1 - (F - min) / (max - min); the second separates nothing: 1 for all
    np.testing.assert_allclose(
        normalise(features), [[1.0, 1.0, 1.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.5]]
    )
    # Eq. 6 with weights 4, 2, 2: (4 + 2 + 2)/8, (2 + 2 + 0)/8, (0 + 2 + 1)/8
    scores = fuse(normalise(features), (4, 2, 2))
    np.testing.assert_allclose(scores, [1.0, 0.5, 0.375])
    assert best_superpixels(scores, count=3).tolist() == [0, 1, 2]


def test_front_and_hind_weights_on_the_three_superpixels():
    likenesses = normalise(np.array(FEATURES_RIGHT))
    settings = Maghsoudi2019Settings()
    # F1, F3 tie between the first two; only these differ, all over the spread of the three
    f4, f5 = [1.0, 0.8, 0.0], [1 - 20 / 120, 1.0, 0.0]
    corner = np.array([np.hypot(67, 36), np.hypot(70, 30), 30])
    f7 = 1 - (corner - 30) / (corner.max() - 30)
    away = np.array([5.0, 10.0, np.hypot(40, 40)])
    f8 = 1 - (away - 5) / (away.max() - 5)
    same = np.array([1.0, 1.0, 0.0])
    front = (2 * same + 4 * same + 2 * np.array(f4) + 2 * np.array(f5) + f7 + 4 * f8) / 15
    hind = (2 * same + 4 * same + np.array(f4) + 2 * np.array(f5) + 2 * f7 + 4 * f8) / 15
    np.testing.assert_allclose(fuse(likenesses, settings.weights("FR")), front)
    np.testing.assert_allclose(fuse(likenesses, settings.weights("HL")), hind)
    # the best is the highest, though the paper says the lowest
    assert best_superpixels(front, count=2).tolist() == [0, 1]


@given(
    hnp.arrays(float, (6, 8), elements=st.floats(0, 1e6)),
    st.floats(0.01, 100),
    st.floats(0, 1000),
)
def test_likenesses_do_not_depend_on_unit_or_offset(features, factor, offset):
    likenesses = normalise(features)
    assert likenesses.min() >= 0
    assert likenesses.max() <= 1
    spread = np.ptp(features, axis=0)
    firm = spread > 1e-3 * (1 + features.max(axis=0) + offset / factor)
    shifted = normalise(features * factor + offset)
    np.testing.assert_allclose(shifted[:, firm], likenesses[:, firm], atol=1e-6)
    assert (likenesses[:, spread == 0] == 1).all()


def test_fewer_superpixels_than_asked_for():
    assert best_superpixels(np.array([0.2, 0.9]), count=3).tolist() == [1, 0]
    assert best_superpixels(np.array([0.5, 0.9, 0.9, 0.1]), count=3).tolist() == [1, 2, 0]


def test_one_superpixel_alone_scores_full():
    assert fuse(normalise(np.array([[3.0, 4.0]])), (1, 1)) == pytest.approx([1.0])
