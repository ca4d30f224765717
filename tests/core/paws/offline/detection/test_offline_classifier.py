"""Networks that tell points apart, against those of scikit-learn and samples that are known."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from sklearn.neural_network import MLPClassifier
from sklearn.preprocessing import StandardScaler

from pawnb.core.paws.offline.detection import classifier
from pawnb.core.paws.offline.detection.classifier import train_classifier
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.parameters import AppearanceParameters

PARAMETERS = AppearanceParameters(hidden=12, networks=2, epochs=60)


def samples(*labels, count=60, spread=3, seed=0):
    """Samples about places of four dimensions, one place for each label; far from 0 and 1."""
    random = np.random.default_rng(seed)
    places = np.random.default_rng(1).normal([500, 0, -80, 3], 30, (10, 4))
    features = np.concatenate([random.normal(places[k], spread, (count, 4)) for k in labels])
    return features.astype(np.float32), np.repeat(labels, count)


def test_points_are_told_apart_and_one_that_was_never_placed_is_nowhere():
    features, labels = samples(0, 1, 3)  # labels 1 and 3 are points 0 and 2; point 1 is missing
    probability = train_classifier(features, labels, n_points=4, parameters=PARAMETERS)(features)
    assert probability.shape == (180, 5)
    assert (probability[:, [2, 4]] == 0).all()
    np.testing.assert_allclose(probability.sum(axis=1), 1, rtol=1e-5)
    assert (probability.argmax(axis=1) == labels).mean() > 0.98


@pytest.mark.parametrize("labels", [(0, 1), (0, 2, 3)])
def test_it_learns_as_well_as_the_networks_of_scikit_learn(labels):
    """Samples overlap; held-out ones are told as well as by the mean of theirs."""
    given, names = samples(*labels, count=300, spread=30)
    held, truth = samples(*labels, count=1000, spread=30, seed=5)
    found = train_classifier(given, names, n_points=3, parameters=PARAMETERS)(held)
    scaler = StandardScaler().fit(given)
    expected = np.zeros((len(held), 4))
    for seed in range(2):
        network = MLPClassifier(
            (12,), alpha=0.3, batch_size=min(256, len(names)), learning_rate_init=3e-3,
            max_iter=60, random_state=seed,
        )  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            network.fit(scaler.transform(given).astype(np.float32), names)
        probability = network.predict_proba(scaler.transform(held).astype(np.float32))
        expected[:, network.classes_] += probability / 2
    row = np.arange(len(truth))
    ours, theirs = (-np.log(p[row, truth]).mean() for p in (found, expected))
    assert theirs > 0.1  # there is something to be unsure of
    assert ours == pytest.approx(theirs, rel=0.05)
    right, expected_right = ((p.argmax(axis=1) == truth).mean() for p in (found, expected))
    assert right == pytest.approx(expected_right, abs=0.04)


def test_slopes_are_those_of_the_loss():
    """Each parameter is moved by a little: central differences of the loss, in float64."""
    random = np.random.default_rng(3)
    x, y = random.normal(size=(7, 4)), random.integers(0, 3, 7)
    vector = random.normal(size=5 * 2 * 6 + 2 * 7 * 3)

    def loss(v):
        nets = classifier._Networks.in_vector(v, (4, 2, 6, 3))
        active = np.maximum(x @ nets.inner + nets.inner_bias, 0).reshape(7, 2, 6)
        score = np.einsum("nkh,khc->nkc", active, nets.outer) + nets.outer_bias
        score -= np.log(np.exp(score).sum(axis=2, keepdims=True))
        weights = (nets.inner**2).sum() + (nets.outer**2).sum()
        return -score[np.arange(7), :, y].sum() / 7 + LEARNT.weight_decay * weights / (2 * 7)

    slopes = np.empty_like(vector)
    classifier._find_slopes(
        classifier._Networks.in_vector(vector, (4, 2, 6, 3)),
        classifier._Networks.in_vector(slopes, (4, 2, 6, 3)), x, np.eye(3)[y],
    )  # fmt: skip
    steps = 1e-6 * np.eye(len(vector))
    expected = [(loss(vector + e) - loss(vector - e)) / 2e-6 for e in steps]
    np.testing.assert_allclose(slopes, expected, atol=1e-6)


def test_where_no_point_is_in_any_sample_all_is_background():
    features, labels = samples(0)
    found = train_classifier(features, labels, n_points=2, parameters=PARAMETERS)(features)
    np.testing.assert_allclose(found, np.tile([1, 0, 0], (len(found), 1)))
