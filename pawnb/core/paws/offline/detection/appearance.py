"""Evidence of appearance, learnt in the recording: what each point looks like, and the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import AnyArray, ByteArray, Float32Array, FloatArray, IntArray
from pawnb.core.parallel import in_parts
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.classifier import Classifier, train_classifier
from pawnb.core.paws.offline.detection.features import PictureFeatures
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.parameters import AppearanceParameters
from pawnb.core.paws.offline.scene.stack import BodyStack


@dataclass(frozen=True)
class TrainingFrame:
    """A frame that a classifier is trained on.

    Parameters
    ----------
    points : mapping
        Point number to its position, working px.
    doubtful : sequence
        Positions that are no safe background.
    clicked : bool
        Whether a person placed the points.
    """

    points: Mapping[int, FloatArray]
    doubtful: Sequence[FloatArray] = ()
    clicked: bool = True


def clicked_training_frames(stack: BodyStack, annotations: Annotations) -> dict[int, TrainingFrame]:
    """Return the frames with clicks, to train on.

    Parameters
    ----------
    stack : BodyStack
        The view.
    annotations : Annotations
        Its clicks.

    Returns
    -------
    dict
        Row to its frame.
    """
    placed = annotations.moved(stack.to_body)
    return {row: TrainingFrame(here) for row, here in placed.places.items()}


def learn_appearance(
    stack: BodyStack,
    training_frames: Mapping[int, TrainingFrame],
    *,
    n_points: int,
    parameters: AppearanceParameters,
) -> Classifier:
    """Learn from some frames what every point looks like; each is a negative of the others.

    Parameters
    ----------
    stack : BodyStack
        The view.
    training_frames : mapping
        Row to what is known of it.
    n_points : int
        Number of points in all.
    parameters : AppearanceParameters
        The kind's parameters.

    Returns
    -------
    callable
        See :data:`.classifier.Classifier`.
    """
    random = np.random.default_rng(0)
    samples, labels = [], []
    for row, training_frame in sorted(training_frames.items()):
        copies = (
            parameters.copies
            if training_frame.clicked
            else max(1, parameters.copies // LEARNT.copies_fewer)
        )
        for copy in range(copies):
            found, names = _samples(stack, row, training_frame, random, parameters, varied=copy > 0)
            samples.append(found)
            labels.append(names)
    return train_classifier(
        np.concatenate(samples), np.concatenate(labels), n_points=n_points, parameters=parameters
    )


def _samples(
    stack: BodyStack,
    row: int,
    training_frame: TrainingFrame,
    random: np.random.Generator,
    parameters: AppearanceParameters,
    *,
    varied: bool,
) -> tuple[Float32Array, IntArray]:
    """Return features and labels of places in one picture, as it is or varied."""
    grey = stack.grey[row]
    colour = None if stack.colour is None else stack.colour[row]
    turned = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    if varied:
        most = LEARNT.copies_turn_deg, LEARNT.copies_scale
        grey, colour, turned = vary_picture(grey, colour, random, most=most)
    features = PictureFeatures(grey, colour, stack.spacing)
    h, w = features.shape
    label = np.zeros((h, w), int)
    usable = np.ones((h, w), bool)
    nearest = np.full((h, w), np.inf, np.float32)
    radius = parameters.radius
    for point, xy in training_frame.points.items():
        away = _distances(stack, (h, w), turned[:, :2] @ xy + turned[:, 2])
        label[away < LEARNT.own_radii * radius] = point + 1
        usable &= (away < LEARNT.own_radii * radius) | (away >= LEARNT.doubtful_radii * radius)
        nearest = np.minimum(nearest, away)
    for xy in training_frame.doubtful:
        away = _distances(stack, (h, w), turned[:, :2] @ xy + turned[:, 2])
        usable &= (away >= LEARNT.open_radii * radius) | (label > 0)
    positive = np.flatnonzero(label > 0)
    negative = np.flatnonzero((label == 0) & usable)
    weight = 1 / (
        1 + (nearest.ravel()[negative].astype(float) / (LEARNT.background_radii * radius)) ** 2
    )
    chosen = random.choice(
        negative, min(len(negative), parameters.background), replace=False, p=weight / weight.sum()
    )
    taken = np.concatenate([positive, chosen])
    return features.at(taken), label.ravel()[taken]


def _distances(stack: BodyStack, shape: tuple[int, int], xy: FloatArray) -> Float32Array:
    """Return how far every place is from a position, working px, float32."""
    x, y = (
        np.square(stack.spacing * np.arange(n) + stack.spacing // 2 - at, dtype=np.float32)
        for n, at in zip(shape[::-1], xy, strict=True)
    )
    return np.sqrt(x + y[:, None])


def vary_picture(
    grey: ByteArray,
    colour: AnyArray | None,
    random: np.random.Generator,
    *,
    most: tuple[float, float],
) -> tuple[AnyArray, AnyArray | None, AnyArray]:
    """Return a picture turned, scaled, shifted and lit differently, and the map to it.

    Parameters
    ----------
    grey : ndarray, shape (h, w)
        The picture.
    colour : ndarray, shape (h, w, k), optional
        Its colours.
    random : Generator
        Where chance comes from.
    most : tuple of float
        How far it is turned at most, degrees, and scaled, as a share, either way.

    Returns
    -------
    grey, colour : ndarray
        The picture as it might be; ``colour`` is None where there is none.
    turned : ndarray, shape (2, 3)
        The affine map from the picture to it.
    """
    height, width = grey.shape
    turned = cv2.getRotationMatrix2D(
        (width / 2, height / 2),
        random.uniform(-most[0], most[0]),
        random.uniform(1 - most[1], 1 + most[1]),
    )
    turned = np.hstack(
        [
            turned[:, :2],
            turned[:, 2:] + random.uniform(-LEARNT.copies_shift_px, LEARNT.copies_shift_px, (2, 1)),
        ]
    )
    moved = cv2.warpAffine(grey, turned, (width, height), borderMode=cv2.BORDER_REPLICATE)
    lit = moved * np.float32(random.uniform(*LEARNT.copies_light))
    lit += np.float32(LEARNT.copies_noise) * random.standard_normal(moved.shape, dtype=np.float32)
    if colour is not None:
        colour = cv2.warpAffine(colour, turned, (width, height), borderMode=cv2.BORDER_REPLICATE)
    return np.clip(lit, 0, 255).astype(np.uint8), colour, turned


def appearance_maps(
    stack: BodyStack,
    classify: Classifier,
    *,
    points: Sequence[int],
    parameters: AppearanceParameters,
    rows: Sequence[int] | None = None,
) -> dict[int, Float32Array]:
    """Return how much likelier each point is at every place, by its appearance.

    Parameters
    ----------
    stack : BodyStack
        The view.
    classify : callable
        What was learnt.
    points : sequence of int
        The points.
    parameters : AppearanceParameters
        The kind's parameters.
    rows : sequence of int, optional
        Rows that are looked at; default all.

    Returns
    -------
    dict
        Point to ratios of likelihoods (rows, h, w), float32.
    """
    n, h, w = stack.shape
    wanted = range(n) if rows is None else rows
    maps = {point: np.empty((len(wanted), h, w), np.float32) for point in points}

    def look(i: int) -> None:
        row = wanted[i]
        colour = None if stack.colour is None else stack.colour[row]
        features = PictureFeatures(stack.grey[row], colour, stack.spacing)
        for point, found in zip(points, probabilities_of(features, classify, points), strict=True):
            own = cv2.GaussianBlur(found, (0, 0), LEARNT.found_blur)
            maps[point][i] = np.clip(
                own / (1.0 + LEARNT.found_unsure - own), parameters.lowest, parameters.highest
            )

    in_parts(look, range(len(wanted)))
    return maps


def probabilities_of(
    features: PictureFeatures, classify: Classifier, points: Sequence[int]
) -> Float32Array:
    """Return the probability (points, h, w) of each point at every place of a picture.

    Every other place in each direction is looked at first, and all of them about those where
    points are likelier than ``nowhere``.

    Parameters
    ----------
    features : PictureFeatures
        Of the picture.
    classify : callable
        The classifier.
    points : sequence of int
        Which points.

    Returns
    -------
    ndarray of float32, shape (points, h, w)
        The probabilities, 0 at places that were not looked at.
    """
    h, w = features.shape
    found = np.zeros((len(points), h, w), np.float32)
    columns = np.asarray(points, int) + 1
    near = np.zeros((h, w), np.uint8)
    first = (w * np.arange(0, h, 2)[:, None] + np.arange(0, w, 2)).ravel()
    probability = classify(features.at(first)).T.reshape(-1, (h + 1) // 2, (w + 1) // 2)
    np.less(probability[0], 1 - LEARNT.nowhere, out=near[::2, ::2], casting="unsafe")
    for own, column in zip(found, columns, strict=True):
        own[::2, ::2] = probability[column]
    near = cv2.dilate(near, np.ones((5, 5), np.uint8))
    near[::2, ::2] = 0
    rest = np.flatnonzero(near)
    if len(rest):
        probability = classify(features.at(rest)).T
        for own, column in zip(found.reshape(len(found), -1), columns, strict=True):
            own[rest] = probability[column]
    return found
