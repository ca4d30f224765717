"""Networks that tell points apart, against those of scikit-learn and samples that are known."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from sklearn.neural_network import MLPClassifier
from sklearn.preprocessing import StandardScaler

from pawnb.core.paws.offline.detection.classifier import train_classifier
from pawnb.core.paws.offline.parameters import AppearanceParameters

PARAMETERS = AppearanceParameters(hidden=12, networks=2, epochs=60)


def samples(*labels, count=60):
    """Samples about places of four dimensions, one place for each label; far from 0 and 1."""
    random = np.random.default_rng(0)
    places = np.random.default_rng(1).normal([500, 0, -80, 3], 30, (10, 4))
    features = np.concatenate([random.normal(places[k], 3, (count, 4)) for k in labels])
    return features.astype(np.float32), np.repeat(labels, count)


def test_points_are_told_apart_and_one_that_was_never_placed_is_nowhere():
    features, labels = samples(0, 1, 3)  # labels 1 and 3 are points 0 and 2; point 1 is missing
    probability = train_classifier(features, labels, n_points=4, parameters=PARAMETERS)(features)
    assert probability.shape == (180, 5)
    assert (probability[:, [2, 4]] == 0).all()
    np.testing.assert_allclose(probability.sum(axis=1), 1, rtol=1e-5)
    assert (probability.argmax(axis=1) == labels).mean() > 0.98


@pytest.mark.parametrize("labels", [(0, 1), (0, 2, 3)])
def test_it_is_the_mean_of_the_networks(labels):
    """Scaling and all hidden layers are one product; two classes have one output."""
    features, names = samples(*labels)
    found = train_classifier(features, names, n_points=3, parameters=PARAMETERS)(features + 1)
    scaler = StandardScaler().fit(features)
    expected = np.zeros((len(features), 4))
    for seed in range(2):
        network = MLPClassifier(
            (12,), alpha=0.3, batch_size=len(names) if len(names) < 256 else 256,
            learning_rate_init=3e-3, max_iter=60, random_state=seed,
        )  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            network.fit(scaler.transform(features).astype(np.float32), names)
        probability = network.predict_proba(scaler.transform(features + 1).astype(np.float32))
        expected[:, network.classes_] += probability / 2
    np.testing.assert_allclose(found, expected, atol=2e-3)


def test_where_no_point_is_in_any_sample_all_is_background():
    features, labels = samples(0)
    found = train_classifier(features, labels, n_points=2, parameters=PARAMETERS)(features)
    np.testing.assert_allclose(found, np.tile([1, 0, 0], (len(found), 1)))
