"""The one pass over the video: detections of every frame and view, and nothing else, are kept."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from pawnb.arrays import AnyArray, FloatArray
from pawnb.core.parallel import THREADS, Threads
from pawnb.core.paws.layout import Views
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.colour.colour_model import Appearance, reduce
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections, InViews
from pawnb.core.paws.offline.detection.colour.detector import (
    DetectorConfig,
    detect,
    endpoint_score,
)
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR
from pawnb.core.paws.superpixels import FramePixels
from pawnb.core.video.views import Frame

Watch: TypeAlias = Callable[[int, Mapping[str, FramePixels]], None]


@dataclass
class ROI:
    """The part of one view that is searched; it follows the animal.

    Parameters
    ----------
    centre : ndarray, shape (2,)
        Its middle, px.
    half : ndarray, shape (2,)
        Half its width and height, px.
    size : tuple of int
        Width and height of the view.
    offset : float, optional
        By how much the mean of the detections lies to the right of the middle, px: that of the
        first detections that :meth:`follow` was given.
    """

    centre: FloatArray
    half: FloatArray
    size: tuple[int, int]
    offset: float | None = field(default=None)

    def box(self, step: int = 1) -> tuple[int, int, int, int]:
        """Return left, top, right, bottom within the view, multiples of ``step``."""
        ends = []
        for centre, half, size in zip(self.centre, self.half, self.size, strict=True):
            least = step * -(-8 // step)
            last = size // step * step
            low = min(max(int(np.floor((centre - half) / step)) * step, 0), last - least)
            high = int(np.ceil((centre + half) / step)) * step
            ends.append((low, max(min(high, last), low + least)))
        (u0, u1), (v0, v1) = ends
        return u0, v0, u1, v1

    def follow(self, u: AnyArray, likeness: FloatArray) -> None:
        """Move with the mean of the detections, by how much each looks like a paw.

        What looks little like one may be a part of the belt or the box: it does not move
        with the animal, and each view has its own.

        Parameters
        ----------
        u : ndarray, shape (n,)
            Where the detections are, px.
        likeness : ndarray, shape (n,)
            How much each looks like a paw, 0 to 1.
        """
        if len(u) < 2:
            return
        mean = float(np.average(u, weights=likeness))
        if self.offset is None:
            self.offset = mean - float(self.centre[0])
        step = mean - self.offset - self.centre[0]
        limit = COLOUR.scan_most_step * self.half[0]
        self.centre = self.centre + np.array(
            [COLOUR.scan_follow * np.clip(step, -limit, limit), 0.0]
        )


def configure_detector(
    appearance: Appearance,
    paw_width_px: float,
    limb_direction: tuple[float, float],
    *,
    limits: FloatArray | None = None,
    is_below: bool = False,
) -> DetectorConfig:
    """Choose the scale of the search: a paw is about six reduced pixels thick.

    Parameters
    ----------
    appearance : Appearance
        What paws look like.
    paw_width_px : float
        Thickness of a paw, px.
    limb_direction : tuple of float
        Unit vector from paw to limb, in the picture.
    limits : ndarray, shape (k, 3), optional
        Lines a, b, c; detections lie where a u + b v + c is not negative.
    is_below : bool
        Whether the view is from below.

    Returns
    -------
    DetectorConfig
        How the view is searched.
    """
    shrink = max(1, round(paw_width_px / COLOUR.reduced_paw_px))
    reach = max(3, round(COLOUR.search_reach * paw_width_px / shrink))
    most = COLOUR.most_faint if appearance.is_faint else COLOUR.most_found
    return DetectorConfig(appearance, shrink, reach, limb_direction, limits, is_below, most=most)


def scan_video(
    views: Views,
    frames: tuple[int, int],
    *,
    detectors: Sequence[DetectorConfig],
    rois: Sequence[ROI],
    home: int | None = None,
    store: DetectionCache | None = None,
    watch: Watch | None = None,
    progress: Callable[[int], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> list[list[ColourDetections]]:
    """Find the detections of every view in consecutive frames.

    Parameters
    ----------
    views : Views
        The opened views.
    frames : tuple of int
        First frame and one past the last.
    detectors, rois : sequence
        How to search each view, and where in frame ``home``.
    home : int, optional
        Frame in which the regions are about the animal; default the first. From a later one the
        animal is sought backwards, in a few frames, to know where it was in the first.
    store : DetectionCache, optional
        What an earlier run found is taken from it, and the rest is kept in it.
    watch : callable, optional
        ``watch(frame, pictures)`` is shown every frame in order, also those of the store.
    progress : callable, optional
        Called with the number of frames done.
    stop : callable, optional
        Asked before each frame.

    Returns
    -------
    list of list of ColourDetections
        For each frame done, the detections of each view.
    """
    store = store or DetectionCache()
    home = frames[0] if home is None else home
    found = store.begin(len(detectors), frames[0], home, detectors, rois)[: frames[1] - frames[0]]
    begin = frames[0] + len(found)
    if watch is not None:
        deque(_shown(views, (frames[0], begin), watch), maxlen=0)
    if found and progress is not None:
        progress(len(found))
    if begin == frames[1]:
        return found
    search = _Search(detectors, rois, home)
    if frames[0] < home and begin < home and not search.go_back(views, frames[0], stop):
        return found
    for t, here in enumerate(found, frames[0]):
        search.again(t, here)

    waiting: deque[list[Future[ColourDetections]]] = deque()
    with contextlib.ExitStack() as stack:
        stack.callback(store.close)
        # a view stays with its thread: its region follows what the frame before has shown
        pools = [stack.enter_context(Threads(1)) for _ in range(THREADS)]

        def finish() -> None:
            found.append([future.result() for future in waiting.popleft()])
            store.add(found[-1])
            if progress is not None:
                progress(len(found))

        for t, pictures in enumerate(_shown(views, (begin, frames[1]), watch), begin):
            if stop is not None and stop():
                break
            waiting.append(
                [pools[v % THREADS].submit(search.find, v, t, pictures[name])
                 for v, name in enumerate(views.names)]
            )  # fmt: skip
            if len(waiting) > COLOUR.in_hand:
                finish()
        while waiting:
            finish()
    return found


class _Search:
    """The search of every view, frame after frame.

    Parameters
    ----------
    detectors, rois : sequence
        How to search each view, and where in frame ``home``.
    home : int
        That frame: what is searched from there on does not depend on the frames before it.
    """

    def __init__(self, detectors: Sequence[DetectorConfig], rois: Sequence[ROI], home: int) -> None:
        self.detectors, self.home = detectors, home
        self.at_home = rois
        self.rois = [replace(roi) for roi in rois]

    def find(self, view: int, frame: int, picture: FramePixels) -> ColourDetections:
        """Return the detections of the next frame of a view, and follow them."""
        self._come_home(view, frame)
        detector = self.detectors[view]
        found = detect(*searched(picture, self.rois[view], detector.shrink), detector)
        self._follow(view, found)
        return found

    def again(self, frame: int, here: InViews) -> None:
        """Follow detections that were found before in the next frame."""
        for view, found in enumerate(here):
            self._come_home(view, frame)
            self._follow(view, found)

    def go_back(self, views: Views, begin: int, stop: Callable[[], bool] | None) -> bool:
        """Move the regions to where the animal was in an earlier frame; False if stopped."""
        for t, pictures in views.frames(
            self.home, begin - 1, step=-COLOUR.scan_stride, partly=True
        ):
            if stop is not None and stop():
                return False
            for v, name in enumerate(views.names):
                found = self.find(v, t, pictures[name])
                for _ in range(min(COLOUR.scan_stride, t - begin) - 1):
                    self._follow(v, found)
        return True

    def _follow(self, view: int, found: ColourDetections) -> None:
        """Move the region of a view with its detections."""
        likeness = endpoint_score(found, self.detectors[view].limb_direction)
        self.rois[view].follow(found.uv[:, 0], likeness)

    def _come_home(self, view: int, frame: int) -> None:
        """Return to where the animal is known to be in its frame."""
        if frame == self.home:
            self.rois[view] = replace(self.at_home[view])


def _shown(
    views: Views,
    frames: tuple[int, int],
    watch: Callable[[int, Mapping[str, FramePixels]], None] | None,
) -> Iterator[Mapping[str, FramePixels]]:
    """Go through frames, each shown to whoever watches."""
    for i, pictures in views.frames(*frames, partly=True):
        if watch is not None:
            watch(i, pictures)
        yield pictures


def searched(picture: FramePixels, roi: ROI, shrink: int) -> tuple[AnyArray, tuple[int, int]]:
    """Return the part of a picture that is searched, reduced, and its left and top in px.

    Parameters
    ----------
    picture : FramePixels
        The whole picture.
    roi : ROI
        What is searched.
    shrink : int
        Factor by which it is reduced.

    Returns
    -------
    pixels : ndarray
        The reduced part.
    origin : tuple of int
        Its left and top, px.
    """
    # chroma has half the resolution: reduced, its planes need an even grid
    box = roi.box(1 if shrink == 1 else 2 * shrink)
    if isinstance(picture, Frame):  # frames of a video reduce as they are decoded
        return picture.reduced(*box, factor=shrink), box[:2]
    return reduce(picture.crop(*box), shrink), box[:2]
