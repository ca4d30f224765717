"""A small classifier of places: which point, if any."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import Float32Array, IntArray
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.parameters import AppearanceParameters

Classifier = Callable[[np.ndarray], np.ndarray]
"""Features (m, F) to probabilities (m, 1 + P) of no point and of each."""

_ADAM_EPSILON = 1e-8
"""Guard: against division by zero, as Kingma & Ba (2015) propose it."""


@dataclass(frozen=True)
class _Networks:
    """Several networks with one hidden layer each, as one: K networks of H units, C classes.

    Parameters
    ----------
    inner : ndarray of float32, shape (F, K H)
        Weights of the hidden layers.
    inner_bias : ndarray of float32, shape (K H,)
        Their biases.
    outer : ndarray of float32, shape (K, H, C)
        Weights of the outputs.
    outer_bias : ndarray of float32, shape (K, C)
        Their biases.
    """

    inner: np.ndarray
    inner_bias: np.ndarray
    outer: np.ndarray
    outer_bias: np.ndarray

    @classmethod
    def in_vector(cls, vector: np.ndarray, sizes: tuple[int, int, int, int]) -> _Networks:
        """Return networks of sizes F, K, H and C whose parameters are parts of a vector."""
        f, k, h, c = sizes
        shapes = ((f, k * h), (k * h,), (k, h, c), (k, c))
        ends = np.cumsum([int(np.prod(shape)) for shape in shapes])
        parts = np.split(vector, ends[:-1])
        return cls(*(part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)))


def train_classifier(
    features: Float32Array, labels: IntArray, *, n_points: int, parameters: AppearanceParameters
) -> Classifier:
    """Train a few networks with one hidden layer and return the mean of their probabilities.

    Rectified linear units, cross-entropy, Adam (Kingma & Ba 2015). The networks differ by
    where they begin; they see the same samples in the same order, so that one product serves
    the hidden layers of all.

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
    mean, scale = features.mean(axis=0, dtype=float), features.std(axis=0, dtype=float)
    scale[scale < _ADAM_EPSILON] = 1.0
    classes, numbers = np.unique(labels, return_inverse=True)
    scaled = np.ascontiguousarray((features - mean) / scale, np.float32)
    networks = _train(scaled, numbers.ravel(), len(classes), parameters)
    # the scaling goes into the product
    inner = (networks.inner / scale[:, None]).T
    bias = (networks.inner_bias - mean @ inner.T).astype(np.float32)[:, None]
    inner = np.ascontiguousarray(inner, np.float32)

    def classify(samples: Float32Array) -> Float32Array:
        # places last: what follows goes along memory
        active = inner @ samples.T
        active += bias
        _rectify(active)
        probability = np.zeros((n_points + 1, len(samples)), np.float32)
        for part, outer, own in zip(
            np.split(active, len(networks.outer)), networks.outer, networks.outer_bias, strict=True
        ):
            score = outer.T @ part
            score += own[:, None]
            score -= score.max(axis=0)
            np.exp(score, out=score)
            score /= score.sum(axis=0) * len(networks.outer)
            probability[classes] += score
        return probability.T

    return classify


def _rectify(active: Float32Array) -> None:
    """Put 0 in the place of what is below it (k, m); NumPy's maximum takes seven times as long."""
    cv2.threshold(active, 0, 0, cv2.THRESH_TOZERO, dst=active)


def _train(
    samples: Float32Array, classes: IntArray, n_classes: int, parameters: AppearanceParameters
) -> _Networks:
    """Return networks that were trained on samples (m, F) float32 of known classes (m,)."""
    k, h, f = parameters.networks, parameters.hidden, samples.shape[1]
    random = np.random.default_rng(0)
    vector = np.concatenate(
        [
            random.uniform(-bound, bound, size)
            for bound, size in (
                (np.sqrt(6 / (f + h)), (f + 1) * k * h),  # Glorot & Bengio 2010
                (np.sqrt(6 / (h + n_classes)), k * (h + 1) * n_classes),
            )
        ]
    ).astype(np.float32)
    gradient = np.empty_like(vector)
    networks = _Networks.in_vector(vector, (f, k, h, n_classes))
    slopes = _Networks.in_vector(gradient, (f, k, h, n_classes))
    first, second, part = np.zeros_like(vector), np.zeros_like(vector), np.empty_like(vector)
    decay, decay_square = LEARNT.moment_decays
    target = np.eye(n_classes, dtype=np.float32)[classes]
    for step, rows in enumerate(_batches(len(samples), parameters.epochs, random), start=1):
        _find_slopes(networks, slopes, samples.take(rows, axis=0), target.take(rows, axis=0))
        first += (1 - decay) * np.subtract(gradient, first, out=part)
        np.multiply(gradient, gradient, out=part)
        second += (1 - decay_square) * np.subtract(part, second, out=part)
        rate = LEARNT.learning_rate * np.sqrt(1 - decay_square**step) / (1 - decay**step)
        np.sqrt(second, out=part)
        part += np.float32(_ADAM_EPSILON)
        vector -= np.divide(np.float32(rate) * first, part, out=part)
    return networks


def _batches(n: int, epochs: int, random: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield the rows of each step: all of them once an epoch, in an order of its own."""
    for _ in range(epochs):
        order = random.permutation(n)
        for begin in range(0, n, LEARNT.batch):
            yield order[begin : begin + LEARNT.batch]


def _find_slopes(
    networks: _Networks, slopes: _Networks, samples: np.ndarray, target: np.ndarray
) -> None:
    """Write into ``slopes`` how the mean cross-entropy of a batch changes with each parameter."""
    n, (k, h, _) = len(samples), networks.outer.shape
    active = samples @ networks.inner
    active += networks.inner_bias
    _rectify(active)
    back = np.empty_like(active)
    # network by network: products of stacks are those of each
    own, own_back = (part.reshape(n, k, h).transpose(1, 0, 2) for part in (active, back))
    score = own @ networks.outer
    score += networks.outer_bias[:, None]
    score -= _of_classes(np.maximum, score)
    np.exp(score, out=score)
    score /= _of_classes(np.add, score)
    score -= target
    score /= n
    np.matmul(own.transpose(0, 2, 1), score, out=slopes.outer)
    score.sum(axis=1, out=slopes.outer_bias)
    np.matmul(score, networks.outer.transpose(0, 2, 1), out=own_back)
    back *= active > 0
    np.matmul(samples.T, back, out=slopes.inner)
    back.sum(axis=0, out=slopes.inner_bias)
    slopes.inner[:] += np.float32(LEARNT.weight_decay / n) * networks.inner
    slopes.outer[:] += np.float32(LEARNT.weight_decay / n) * networks.outer


def _of_classes(take: np.ufunc, score: Float32Array) -> Float32Array:
    """Reduce scores (k, n, classes) to (k, n, 1); of a few classes one by one takes a third."""
    return np.asarray(functools.reduce(take, score.transpose(2, 0, 1)))[..., None]
