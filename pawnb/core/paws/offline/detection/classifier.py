"""A small classifier of places: which point, if any."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPClassifier
from sklearn.preprocessing import StandardScaler

from pawnb.core.paws.offline.parameters import AppearanceParameters

Classifier = Callable[[np.ndarray], np.ndarray]
"""Features (m, F) to probabilities (m, 1 + P) of no point and of each."""


def train_classifier(
    features: np.ndarray, labels: np.ndarray, *, n_points: int, parameters: AppearanceParameters
) -> Classifier:
    """Train a few networks with one hidden layer and return the mean of their probabilities.

    Parameters
    ----------
    features : ndarray, shape (m, F)
        Samples.
    labels : ndarray of int, shape (m,)
        0 for no point, else 1 + its number.
    n_points : int
        P.
    parameters : AppearanceParameters
        The kind's parameters.

    Returns
    -------
    callable
        See :data:`Classifier`.
    """
    scaler = StandardScaler().fit(features)
    scaled = scaler.transform(features).astype(np.float32)
    networks = []
    for seed in range(parameters.networks):
        network = MLPClassifier(
            (parameters.hidden,), alpha=0.3, batch_size=min(256, len(scaled)),
            learning_rate_init=3e-3, max_iter=parameters.epochs, random_state=seed,
        )  # fmt: skip
        with warnings.catch_warnings():  # a few epochs are enough, and less sure
            warnings.simplefilter("ignore", ConvergenceWarning)
            networks.append(network.fit(scaled, labels))
    # one product for the hidden layers of all networks, with the scaling inside
    inner = np.hstack([network.coefs_[0] for network in networks]) / scaler.scale_[:, None]
    bias = np.hstack([network.intercepts_[0] for network in networks]) - scaler.mean_ @ inner
    inner, bias = inner.astype(np.float32), bias.astype(np.float32)
    outer = [
        (n.coefs_[1].astype(np.float32), n.intercepts_[1].astype(np.float32)) for n in networks
    ]
    classes, hidden = networks[0].classes_, parameters.hidden

    def classify(samples: np.ndarray) -> np.ndarray:
        active = np.maximum(samples @ inner + bias, 0)
        probability = np.zeros((len(samples), n_points + 1), np.float32)
        for i, (weights, intercept) in enumerate(outer):
            score = active[:, i * hidden : (i + 1) * hidden] @ weights + intercept
            if score.shape[1] < len(classes):  # two classes have one output
                score = np.hstack([-score / 2, score / 2])
            score = np.exp(score - score.max(axis=1, keepdims=True))
            probability[:, classes] += score / score.sum(axis=1, keepdims=True) / len(outer)
        return probability

    return classify
