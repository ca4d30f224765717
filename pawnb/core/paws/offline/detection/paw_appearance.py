"""What paws look like where colour does not tell: a classifier that is learnt in the recording.

Brightness alone does not tell a paw from belt and box, but what is about it does: it is the end of
something thin, below a body, above its own shadow. A small network learns from the clicks what
the places of paws look like at several scales: one class for all paws, as which is which is for the
tracks to decide. Views are mirrored so that the animal faces to the right in all of them, and one
network serves them all. It is learnt again from tracks that were found with it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from pawnb.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from pawnb.core.checkpoint import code_checksum
from pawnb.core.paws.layout import Layout, Placement, Views
from pawnb.core.paws.offline.detection.appearance import probabilities_of, vary_picture
from pawnb.core.paws.offline.detection.classifier import Classifier, train_classifier
from pawnb.core.paws.offline.detection.colour.blob_detection import peaks_at
from pawnb.core.paws.offline.detection.colour.colour_model import Appearance
from pawnb.core.paws.offline.detection.colour.photometry.illumination import normalise_illumination
from pawnb.core.paws.offline.detection.colour.scan import ROI, searched
from pawnb.core.paws.offline.detection.features import PictureFeatures, feature_maps
from pawnb.core.paws.offline.detection.parameters import LEARNT
from pawnb.core.paws.offline.parameters import AppearanceParameters
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.treadmill import Scene
from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks
from pawnb.core.pixels.grey import grey, has_colour

_CODE_OF_APPEARANCE = ("appearance.py", "classifier.py", "features.py", "paw_appearance.py")
"""What kept detections depend on besides what was learnt from."""


@dataclass(frozen=True)
class PawTrainingFrame:
    """A frame that a classifier of paws is trained on: where paws are in it.

    Parameters
    ----------
    paws : sequence of ndarray, shape (k, 2)
        For each view, positions, px.
    doubtful : sequence of ndarray, shape (k, 2)
        Where there may be a paw as well.
    clicked : bool
        Whether a person placed them.
    whole : bool
        Whether as many paws as in any frame are among them: then what is elsewhere is none.
    """

    paws: Sequence[FloatArray]
    doubtful: Sequence[FloatArray]
    clicked: bool = True
    whole: bool = True


@dataclass(frozen=True)
class _Reading:
    """How pictures of one view are read: enlarged so much, mirrored, from black to white."""

    scale: float
    mirrored: bool
    black: float
    white: float
    is_colour: bool

    def read(self, pixels: ByteArray) -> tuple[np.ndarray, np.ndarray | None]:
        """Return brightness and colour (two channels) of a picture at the working scale."""
        if self.mirrored:
            pixels = np.ascontiguousarray(pixels[:, ::-1])
        h, w = (max(LEARNT.paw_spacing_px, round(side * self.scale)) for side in pixels.shape[:2])
        large = cv2.resize(pixels, (w, h), interpolation=cv2.INTER_LINEAR)
        level = large if large.ndim == 2 else cv2.cvtColor(large, cv2.COLOR_RGB2GRAY)
        steps = np.clip((np.arange(256) - self.black) / max(self.white - self.black, 1.0), 0, 1)
        level = cv2.LUT(level, (steps**CAMERA.gamma * 255).astype(np.uint8))
        colour = cv2.cvtColor(large, cv2.COLOR_RGB2LAB)[..., 1:] if self.is_colour else None
        return level, colour

    def place(self, xy: FloatArray, width: int) -> FloatArray:
        """Return working px of positions (..., 2) in a picture that is so wide."""
        xy = np.array(xy, float)
        if self.mirrored:
            xy[..., 0] = width - 1 - xy[..., 0]
        return (xy + 0.5) * self.scale - 0.5

    def back(self, grid: Float32Array, size: tuple[int, int]) -> Float32Array:
        """Return values of the grid (h, w) at the pixels of a picture of this width and height."""
        k = self.scale / LEARNT.paw_spacing_px
        shift = (0.5 * self.scale - 0.5 - LEARNT.paw_spacing_px // 2) / LEARNT.paw_spacing_px
        values = cv2.warpAffine(
            grid, np.array([[k, 0, shift], [0, k, shift]]), size,
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        return np.ascontiguousarray(values[:, ::-1]) if self.mirrored else np.asarray(values)


class _KnownClassifier:
    """A classifier that is known by what it was learnt from: kept detections depend on it."""

    def __init__(self, classify: Classifier, key: str) -> None:
        self.classify, self._key = classify, key

    def __repr__(self) -> str:
        return f"classifier {self._key}"


@dataclass(frozen=True)
class PawLook(Appearance):
    """A look whose score is what a classifier says, instead of a table of colours.

    Parameters
    ----------
    known : _KnownClassifier
        The classifier.
    reading : _Reading
        How pictures are read.
    """

    known: _KnownClassifier | None = None
    reading: _Reading | None = None

    def score(
        self, pixels: ByteArray, origin: tuple[int, int] = (0, 0), *, shrink: int = 1
    ) -> Float32Array:
        """Return how far the logarithm of odds exceeds what tells neither way, (h, w) float32.

        Parameters
        ----------
        pixels : ndarray
            Part of a picture.
        origin, shrink
            Not used.

        Returns
        -------
        ndarray of float32, shape (h, w)
            The score.
        """
        del origin, shrink  # what is about a place tells, and how it is read is known
        if self.known is None or self.reading is None:
            raise ValueError("this look was not learnt")
        features = PictureFeatures(*self.reading.read(pixels), LEARNT.paw_spacing_px)
        (chance,) = probabilities_of(features, self.known.classify, [0])
        least = 1.0 / (1.0 + np.exp(LEARNT.paw_most_odds))
        chance = np.clip(chance, least, 1.0 - least)
        odds = (np.log(chance / (1.0 - chance)) - LEARNT.paw_neutral).astype(np.float32)
        return self.reading.back(odds, (pixels.shape[1], pixels.shape[0]))


def clicked_training_frames(
    scene: Scene, layout: Layout, clicks: Mapping[int, Sequence[Placement]]
) -> dict[int, PawTrainingFrame]:
    """Return the frames with clicks, to train on.

    A paw that is clicked in other views only may be in sight.

    Parameters
    ----------
    scene : Scene
        What the clicks say.
    layout : Layout
        Points and views.
    clicks : mapping
        Frame to what was placed by hand.

    Returns
    -------
    dict
        Frame to example.
    """
    training_frames = {}
    views = range(len(layout.views))
    most = max(len({place.point for place in here}) for here in clicks.values())
    for frame, here in clicks.items():
        paws = [np.array([p.uv for p in here if p.view == v], float).reshape(-1, 2) for v in views]
        doubtful = []
        for v in views:
            own = {place.point for place in here if place.view == v}
            others = [x for p, x in scene.anchors.get(frame, {}).items() if p not in own]
            shown = scene.projection.project(np.array(others))[:, v] if others else np.empty((0, 2))
            doubtful.append(shown)
        whole = len({place.point for place in here}) == most
        training_frames[frame] = PawTrainingFrame(paws, doubtful, whole=whole)
    return training_frames


def tracked_training_frames(
    refined: SmoothedTracks, scene: Scene, tracked: BoolArray, *, first: int
) -> dict[int, PawTrainingFrame]:
    """Return frames in which tracks are certain and the paw was seen, to train on.

    Parameters
    ----------
    refined : SmoothedTracks
        The tracks.
    scene : Scene
        What the clicks say.
    tracked : ndarray of bool, shape (V, P)
        Which point each view tracks. A paw on the other side may or may not be in sight.
    first : int
        The frame of their first row.

    Returns
    -------
    dict
        Frame to example.
    """
    shown = scene.projection.project(refined.x)  # (n, P, V, 2)
    seen = np.isfinite(np.swapaxes(refined.measured[..., 0], 1, 2))  # (n, V, P)
    sure = refined.sd.mean(axis=-1) < LEARNT.paw_sure * scene.paw_width
    training_frames = {}
    for row in np.unique(
        np.linspace(0, len(shown) - 1, LEARNT.paw_frames).round().astype(int)
    ).tolist():
        own = seen[row] & sure[row] & tracked
        training_frames[first + row] = PawTrainingFrame(
            [shown[row, here, v] for v, here in enumerate(own)],
            [shown[row, ~here, v] for v, here in enumerate(own)],
            clicked=False,
        )
    return training_frames


def with_paw_looks(
    views: Views,
    layout: Layout,
    scene: Scene,
    *,
    training_frames: Mapping[int, PawTrainingFrame],
    parameters: AppearanceParameters,
) -> Scene:
    """Return a scene with appearances that are learnt from examples.

    Parameters
    ----------
    views : Views
        The opened views.
    layout : Layout
        Points and views.
    scene : Scene
        What the clicks say.
    training_frames : mapping
        Frame to where paws are.
    parameters : AppearanceParameters
        Of the classifier.

    Returns
    -------
    Scene
        The same scene with other appearances.
    """
    pictures = _pictures(views, layout, scene, training_frames)
    levels = np.concatenate([grey(p.pixels).ravel()[::7] for p in pictures])
    black, white = (float(x) for x in np.percentile(levels, CAMERA.percentiles))
    is_colour = all(has_colour(p.pixels) for p in pictures)
    readings = [
        _Reading(
            LEARNT.paw_px * detector.shrink / float(scene.paw_width_px[v]), layout.facing[v] < 0,
            black, white, is_colour,
        )
        for v, detector in enumerate(scene.detectors)
    ]  # fmt: skip
    random = np.random.default_rng(0)
    lots = [lot for p in pictures for lot in _lots(p, readings[p.view], random, parameters)]
    features, labels = (np.concatenate(part) for part in zip(*lots, strict=True))
    learnt_from = code_checksum("pawnb.core.paws.offline.detection", _CODE_OF_APPEARANCE).encode()
    how = repr(parameters).encode()
    key = hashlib.sha256(learnt_from + how + features.tobytes() + labels.tobytes()).hexdigest()
    classifier = train_classifier(features, labels, n_points=1, parameters=parameters)
    known = _KnownClassifier(classifier, key)
    learnt = [
        PawLook(
            np.empty(0, np.float32),
            detector.appearance.paw_width_px,
            detector.appearance.around_px,
            known=known,
            reading=reading,
        )
        for detector, reading in zip(scene.detectors, readings, strict=True)
    ]
    at_clicks = [
        peaks_at(learnt[p.view].score(p.pixels), p.paws, scene.detectors[p.view].reach)
        for p in pictures
        if p.copies == LEARNT.paw_copies
    ]
    usual = max(float(np.median(np.concatenate(at_clicks))), LEARNT.paw_usual_least)
    detectors = [
        replace(detector, finds_blobs=True, appearance=replace(one, usual=usual))
        for detector, one in zip(scene.detectors, learnt, strict=True)
    ]
    return replace(scene, detectors=detectors)


@dataclass(frozen=True)
class _Picture:
    """The searched part of one view in one frame, with where paws are in it."""

    view: int
    pixels: np.ndarray
    paws: np.ndarray
    doubtful: np.ndarray
    copies: int
    whole: bool


def _pictures(
    views: Views, layout: Layout, scene: Scene, training_frames: Mapping[int, PawTrainingFrame]
) -> list[_Picture]:
    """Return the searched part of each view of each example."""
    found = []
    for frame, training_frame in sorted(training_frames.items()):
        opened = views.frame(frame)
        for v, name in enumerate(layout.views):
            paws, doubtful = training_frame.paws[v], training_frame.doubtful[v]
            if not len(paws):
                continue
            detector, roi = scene.detectors[v], scene.rois[v]
            if frame != scene.home:  # the animal may have moved
                centre = np.array([paws[:, 0].mean(), roi.centre[1]])
                roi = ROI(centre, roi.half, roi.size)
            pixels, origin = searched(opened[name], roi, detector.shrink)
            paws, doubtful = (
                (at - origin + 0.5) / detector.shrink - 0.5 for at in (paws, doubtful)
            )
            copies = LEARNT.paw_copies if training_frame.clicked else LEARNT.paw_copies_tracked
            pixels = normalise_illumination(pixels, detector.illumination)
            found.append(_Picture(v, pixels, paws, doubtful, copies, training_frame.whole))
    return found


def _lots(
    picture: _Picture,
    reading: _Reading,
    random: np.random.Generator,
    parameters: AppearanceParameters,
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return features and labels of places in a picture as it is, and varied."""
    level, colour = reading.read(picture.pixels)
    paws, doubtful = (
        reading.place(at, picture.pixels.shape[1]) for at in (picture.paws, picture.doubtful)
    )
    lots = []
    for copy in range(picture.copies):
        seen, shade, turned = level, colour, np.eye(2, 3)
        if copy:
            most = LEARNT.paw_turn_deg, LEARNT.paw_scale
            seen, shade, turned = vary_picture(level, colour, random, most=most)
        features = feature_maps(seen, shade, LEARNT.paw_spacing_px)
        h, w = features.shape[:2]
        near, may = (
            _distances((h, w), at @ turned[:, :2].T + turned[:, 2]) for at in (paws, doubtful)
        )
        positive = np.flatnonzero(near < LEARNT.paw_own)
        chosen: np.ndarray = np.empty(0, int)
        if picture.whole:
            free = np.flatnonzero((near >= LEARNT.paw_doubtful) & (may >= LEARNT.paw_open))
            weight = 1.0 / (1.0 + (near[free] / LEARNT.paw_background) ** 2)
            count = min(len(free), parameters.background)
            chosen = random.choice(free, count, replace=False, p=weight / weight.sum())
        taken = np.concatenate([positive, chosen])
        labels: np.ndarray = np.repeat([1, 0], [len(positive), len(chosen)])
        lots.append((features.reshape(h * w, -1)[taken], labels))
    return lots


def _distances(shape: tuple[int, int], at: np.ndarray) -> np.ndarray:
    """Return how far each place of a grid (h * w,) is from the nearest position, paw widths."""
    h, w = shape
    grid = (
        np.stack(np.meshgrid(np.arange(w), np.arange(h)), axis=-1) * LEARNT.paw_spacing_px
        + LEARNT.paw_spacing_px // 2
    )
    away = np.full(h * w, np.inf)
    for xy in at:
        away = np.minimum(away, np.linalg.norm(grid - xy, axis=-1).ravel() / LEARNT.paw_px)
    return away
