"""A view as a stack of pictures in the body's frame, at the working scale, with its flow."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from pawnb.arrays import AnyArray, ByteArray, Float32Array, FloatArray, IntArray
from pawnb.core.parallel import Threads, in_parts
from pawnb.core.paws.layout import Views
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.parameters import SceneParameters
from pawnb.core.paws.offline.scene.parameters import CAMERA
from pawnb.core.paws.offline.scene.registration.body_frame import ViewBodyFrame, find_body_frame

_KEPT_BYTES = 2e9
"""Resource: pictures are kept until the body's frame is known, up to so much: those of 1000 frames
of four colour views of 2048 x 700 px in which the animal is 700 px long."""
_AT_ONCE = 64
"""Resource: so many kept pictures go into the body's frame at once, in colour until all have."""
_EMPTY_PICTURE = np.empty((0, 0), np.uint8)
"""Layout: a picture whose memory was given back."""


@dataclass(frozen=True)
class BodyStack:
    """One view of a recording in the body's frame.

    n frames of H x W working px; places of the grid are h x w.

    Parameters
    ----------
    grey : ndarray of uint8, shape (n, H, W)
        Pictures, stretched to the whole range.
    colour : ndarray of uint8, shape (n, H, W, 2), or None
        The two colour channels of CIE Lab, or None in a grey view.
    to_body : ndarray, shape (n, 2, 3)
        From px of the view to working px.
    forward, backward : ndarray of float32, shape (n - 1, h, w, 2)
        Optical flow from each frame to the next, and from the next to it, in places.
    spacing : int
        Working px between places.
    body : ViewBodyFrame
        How the frame was found.
    scale : float
        Working px in one px of the view.
    extent_px : float
        Size of the animal, px of the view.
    ends : ((bool, bool), (bool, bool))
        Whether the view ends where the pictures do: at the left and at the top, at the right and
        at the bottom.
    """

    grey: ByteArray
    colour: ByteArray | None
    to_body: FloatArray
    forward: Float32Array
    backward: Float32Array
    spacing: int
    body: ViewBodyFrame
    scale: float
    extent_px: float
    ends: tuple[tuple[bool, bool], tuple[bool, bool]] = ((False, False), (False, False))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Frames, rows and columns of the grid."""
        n, height, width = self.grey.shape
        return n, height // self.spacing, width // self.spacing

    def part(self, begin: int, end: int) -> BodyStack:
        """Return the rows from ``begin`` up to ``end``."""
        return dataclasses.replace(
            self,
            grey=self.grey[begin:end],
            colour=None if self.colour is None else self.colour[begin:end],
            to_body=self.to_body[begin:end],
            forward=self.forward[begin : end - 1],
            backward=self.backward[begin : end - 1],
        )

    def to_grid(self, xy: AnyArray) -> FloatArray:
        """Return places of the grid (x, y) of positions (..., 2) in working px."""
        return (np.asarray(xy, float) - self.spacing // 2) / self.spacing

    def from_grid(self, place: AnyArray) -> FloatArray:
        """Return positions (..., 2) in working px of places of the grid."""
        return np.asarray(place, float) * self.spacing + self.spacing // 2

    def grid_of(self, uv: FloatArray, row: int) -> FloatArray:
        """Return places of the grid of positions (..., 2), px of the view."""
        A = self.to_body[row]
        return self.to_grid(np.asarray(uv, float) @ A[:, :2].T + A[:, 2])

    def picture_of(self, place: AnyArray, row: int | IntArray) -> FloatArray:
        """Return positions (..., 2), px of the view, of places of the grid in a row (or rows)."""
        offset = self.from_grid(place) - self.to_body[row, :, 2]
        return np.einsum("...ij,...j->...i", self._to_view[row], offset)

    @functools.cached_property
    def _to_view(self) -> FloatArray:
        """What turns and scales working px to px of the view, (n, 2, 2)."""
        return np.asarray(np.linalg.inv(self.to_body[..., :2]))


def read_stacks(
    views: Views,
    annotations: Sequence[Annotations],
    *,
    frames: tuple[int, int],
    parameters: SceneParameters,
    advanced: Callable[[int], bool],
) -> list[BodyStack] | None:
    """Read the views into the body's frame.

    The body's frame is found from all pictures. Until it is known, what may be needed of them is
    kept; where that is too much, the video is read once more.

    Parameters
    ----------
    views : Views
        The opened views.
    annotations : sequence of Annotations
        What was placed in each view; a view without any is left out.
    frames : tuple of int
        First frame and one past the last.
    parameters : SceneParameters
        The stage's parameters.
    advanced : callable
        Told how many frames are read in all (each counts twice); answers whether to go on.

    Returns
    -------
    list of BodyStack or None
        One a view with any annotation, in order; None where the run was stopped.
    """
    names = [n for n, a in zip(views.names, annotations, strict=True) if a.rows]
    crops = [
        _Crops(a, (views.readers[n].width, views.readers[n].height), parameters)
        for n, a in zip(views.names, annotations, strict=True)
        if a.rows
    ]
    n, begun = frames[1] - frames[0], views.frame(frames[0])
    each = [
        crop.picture_bytes(begun[name].image().ndim)  # type: ignore[attr-defined]
        for name, crop in zip(names, crops, strict=True)
    ]
    once = n * sum(each) <= _KEPT_BYTES

    def read(take: Callable[[_Crops, np.ndarray], None], before: int, each: int) -> bool:
        def taken(crop: _Crops, picture: Any) -> None:
            take(crop, picture.image())

        with Threads() as pool:
            for row, (_, pictures) in enumerate(views.frames(*frames)):
                list(pool.map(taken, crops, [pictures[name] for name in names]))
                if not advanced(before + each * (row + 1)):
                    return False
        return True

    if not read(_Crops.look_and_keep if once else _Crops.look, 0, 2 if once else 1):
        return None
    for crop in crops:
        crop.find_body()
    if not once and not read(_Crops.take, n, 1):
        return None
    return [crop.stack() for crop in crops]


class _Crops:
    """The pictures of one view, as they are read, and what of them is in the body's frame."""

    def __init__(
        self, annotations: Annotations, size: tuple[int, int], parameters: SceneParameters
    ) -> None:
        extent = annotations.extent()
        self.extent_px = extent if extent > 0 else CAMERA.unknown_extent * min(size)
        self.clicks = {
            row: np.array(list(here.values())) for row, here in sorted(annotations.places.items())
        }
        self.view_size, self.parameters = size, parameters
        self.scale = min(parameters.extent / self.extent_px, parameters.largest_enlargement)
        self.shrinks = self.scale < CAMERA.shrunk
        self.small_scale = min(1.0, parameters.overview_px / max(size))
        self.small: list[np.ndarray] = []
        self.kept: list[np.ndarray] = []
        self.grey: list[np.ndarray] = []
        self.colour: list[np.ndarray] = []
        self.is_colour: bool | None = None
        self.ends = ((False, False), (False, False))

    def picture_bytes(self, ndim: int) -> float:
        """Size of a picture of 2 (grey) or 3 dimensions, kept until the body's frame is known."""
        shrunk = self.scale**2 if self.shrinks else 1.0
        return float((3 if ndim == 3 else 1) * np.prod(self.view_size) * shrunk)

    def look(self, picture: np.ndarray) -> None:
        """Take a small picture of the whole view."""
        grey = _grey(picture)
        size = [round(side * self.small_scale) for side in self.view_size]
        while min(grey.shape) >= 4 and grey.shape[1] >= 2 * size[0]:  # by two is fast
            grey = cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        self.small.append(cv2.resize(grey, size, interpolation=cv2.INTER_AREA))

    def look_and_keep(self, picture: ByteArray) -> None:
        """Take a small picture of the whole view, and keep what is needed at the working scale."""
        self.look(picture)
        self.kept.append(self._shrunk(picture))

    def find_body(self) -> None:
        """Find the body's frame from all small pictures, and what is to be looked at in it."""
        k, parameters = self.small_scale, self.parameters
        small, self.small = np.stack(self.small), []
        self.body = find_body_frame(
            small,
            {row: uv * k for row, uv in self.clicks.items()},
            self.extent_px * k,
            scale=k,
            parameters=parameters,
        )
        A = self.body.rotations() * self.scale
        offset = -np.einsum("nij,nj->ni", A, self.body.centre)
        margin = parameters.margin * self.extent_px * self.scale
        placed = np.concatenate([uv @ A[row].T + offset[row] for row, uv in self.clicks.items()])
        low, high = placed.min(axis=0) - margin, placed.max(axis=0) + margin
        if self.body.kind == "stays":
            most = np.array(self.view_size) * self.scale
            self.ends = (
                (bool(low[0] <= 0), bool(low[1] <= 0)),
                (bool(high[0] >= most[0]), bool(high[1] >= most[1])),
            )
            low, high = np.maximum(low, 0), np.minimum(high, most)
        spacing = parameters.spacing
        self.size = tuple(int(x) for x in np.ceil((high - low) / spacing) * spacing)
        self.to_body = np.concatenate([A, (offset - low)[..., None]], axis=2)

    def take(self, picture: ByteArray) -> None:
        """Take what is in the body's frame of the next picture."""
        self._keep([self._crop(len(self.grey), self._shrunk(picture))])

    def _shrunk(self, picture: np.ndarray) -> np.ndarray:
        """Return a picture at the working scale where that is smaller, so that nothing aliases."""
        if not self.shrinks:
            return picture
        k = self.scale
        return cv2.resize(picture, None, fx=k, fy=k, interpolation=cv2.INTER_AREA)

    def _crop(self, row: int, picture: np.ndarray) -> ByteArray:
        """Return what is in the body's frame of a picture that was shrunk."""
        A = self.to_body[row]
        if self.shrinks:
            centre = 0.5 / self.scale - 0.5  # of the first pixel, in those of the view
            A = A @ np.array([[1 / self.scale, 0, centre], [0, 1 / self.scale, centre], [0, 0, 1]])
        crop = cv2.warpAffine(picture, A, self.size, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(crop, np.uint8)

    def _crop_kept(self, row: int) -> ByteArray:
        """Return what is in the body's frame of a picture that was kept; it is so no longer."""
        picture, self.kept[row] = self.kept[row], _EMPTY_PICTURE  # its memory is given back
        return self._crop(row, picture)

    def _keep(self, crops: Sequence[ByteArray]) -> None:
        """Keep crops of the next pictures in grey, with their colours if the first has any."""
        if self.is_colour is None:
            self.is_colour = crops[0].ndim == 3 and _coloured(crops[0])
        self.grey += in_parts(_grey, crops)
        if self.is_colour:
            self.colour += in_parts(_chroma, crops)

    def stack(self) -> BodyStack:
        """Return what was taken, with its flow."""
        for begin in range(0, len(self.kept), _AT_ONCE):
            rows = range(begin, min(begin + _AT_ONCE, len(self.kept)))
            self._keep(in_parts(self._crop_kept, rows))
        grey = np.stack(self.grey)
        low, high = _percentiles(grey[::5], CAMERA.percentiles)
        levels = np.clip((np.arange(256) - low) / max(high - low, 1), 0, 1) ** CAMERA.gamma * 255
        for picture in grey:
            cv2.LUT(picture, levels.astype(np.uint8), dst=picture)
        spacing = self.parameters.spacing
        forward, backward = _flows(grey, spacing)
        return BodyStack(
            grey,
            np.stack(self.colour) if self.colour else None,
            self.to_body[: len(grey)],
            forward,
            backward,
            spacing,
            self.body,
            self.scale,
            self.extent_px,
            self.ends,
        )


def _grey(picture: np.ndarray) -> np.ndarray:
    """Return a picture in grey."""
    return cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) if picture.ndim == 3 else picture


def _chroma(picture: ByteArray) -> ByteArray:
    """Return the two colour channels of a picture in CIE Lab."""
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2LAB)[..., 1:])


def _percentiles(pictures: ByteArray, percents: Sequence[float]) -> FloatArray:
    """Return percentiles of all grey values together, as numpy.percentile: they are counted."""
    count = np.zeros(256, np.int64)
    for picture in pictures:
        own = cv2.calcHist([picture], [0], None, [256], [0, 256])
        count += own.ravel().astype(np.int64)
    at = np.array(percents) / 100 * (count.sum() - 1)
    below, above = (np.cumsum(count).searchsorted(f(at), side="right") for f in (np.floor, np.ceil))
    return np.asarray(below + (above - below) * (at - np.floor(at)))


def _coloured(picture: np.ndarray) -> bool:
    """Tell whether a picture has any colour."""
    return float(np.abs(picture[..., 0].astype(int) - picture[..., 2]).mean()) > CAMERA.colour_from


def _flows(grey: ByteArray, spacing: int) -> tuple[Float32Array, Float32Array]:
    """Return dense flow between neighbouring frames (Kroeger et al. 2016), in places."""
    size = (grey.shape[2] // spacing, grey.shape[1] // spacing)
    halves = [cv2.resize(g, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for g in grey]

    def between(pair: tuple[ByteArray, ByteArray]) -> Float32Array:
        flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
        flow.setFinestScale(0)
        flow.setPatchStride(CAMERA.flow_stride)
        flow.setVariationalRefinementIterations(0)
        found = flow.calc(*pair, None)  # type: ignore[call-overload]
        return cv2.resize(found, size, interpolation=cv2.INTER_AREA) * (2 / spacing)

    forward = in_parts(between, itertools.pairwise(halves))
    backward = in_parts(between, itertools.pairwise(halves[::-1]))[::-1]
    empty = np.zeros((0, size[1], size[0], 2), np.float32)
    return (np.stack(forward), np.stack(backward)) if forward else (empty, empty)
