"""Whether the films of several views are in step: what moves in one moves in the others, too.

Tracks cannot tell: points in space are found by all views together and fit films that are a few
frames apart as well as others, in another place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import ByteArray, FloatArray
from pawnb.core.video.viewset import ViewSet

MOST_COMPARED = 200
"""Frames that are looked at: more say nothing new of films that were started at other times."""
_FEWEST_COMPARED = 60
"""Fewer hold too little movement to tell. Half of it is asked by itself, too."""
_MOST_FRAMES_APART = 8
"""Frames that films are looked for apart."""
_COMPARED_WIDTH_PX = 400
"""Pictures are reduced to at most this width."""
_MOTION_BLUR_PX = 1.5
_LEAST_GREY, _TIMES_MEDIAN = 6.0, 4.0
"""Change of grey that is no noise: so much, and so many times the median pixel of that frame."""
_SLOW_FRAMES = 25
"""Frames over which slow changes are taken out."""
_LEAST_LIKENESS, _LEAST_GAIN = 0.6, 0.15
"""Correlation of films once moved, and how much higher than as they are. Measured: films in step
(mouse-4cam-cage, fly_ball_left, the rendered mouse) have 0.6 to 0.9 where cameras see the same
legs, 0.1 to 0.5 eight frames or less apart, and 0.2 lower at least beside the right frame."""


@dataclass(frozen=True)
class OutOfStep:
    """Two views that are alike once one of them is moved in time.

    Parameters
    ----------
    view, other : str
        The view that is out of step, and one that it was compared with.
    late : int
        Frames by which what moves comes later in ``view``.
    likeness, likeness_now : float
        Correlation of both once moved, and as they are.
    """

    view: str
    other: str
    late: int
    likeness: float
    likeness_now: float


def motion_of_views(views: ViewSet, start: int, stop: int) -> dict[str, FloatArray]:
    """Return how much moves from each frame to the next.

    Parameters
    ----------
    views : ViewSet
        The open views.
    start, stop : int
        Frames of the trial, half open; at most :data:`MOST_COMPARED` from ``start`` on are read.

    Returns
    -------
    dict of str to ndarray, shape (n_frames - 1,)
        Of each view: mean change of grey above what is noise.
    """
    stop = min(stop, start + MOST_COMPARED)
    factor = {name: _factor(r.width) for name, r in views.readers.items()}
    before: dict[str, FloatArray] = {}
    found: dict[str, list[float]] = {name: [] for name in views.names}
    for _, frames in views.frames(start, stop):
        for name, frame in frames.items():
            by = factor[name]
            whole = (frame.width // by * by, frame.height // by * by)
            grey = _smooth_grey(frame.reduced(0, 0, *whole, factor=by))
            if name in before:
                change = np.abs(grey - before[name])
                noise = max(_LEAST_GREY, _TIMES_MEDIAN * float(np.median(change)))
                found[name].append(float(np.maximum(change - noise, 0.0).mean()))
            before[name] = grey
    return {name: np.array(values) for name, values in found.items()}


def find_out_of_step(
    motion: Mapping[str, FloatArray], *, pairs: Sequence[tuple[str, str]]
) -> list[OutOfStep]:
    """Find views whose films are some frames apart from the others.

    Parameters
    ----------
    motion : mapping of str to ndarray
        Of :func:`motion_of_views`.
    pairs : sequence of (str, str)
        Views that are compared: of different films, and of the same legs, as others move at other
        times.

    Returns
    -------
    list of OutOfStep
        One for each view that is out of step; empty where films are in step, or it cannot be told.
    """
    apart = [found for a, b in pairs if (found := _compared(motion, a, b)) is not None]
    said = []
    while apart:
        # the view that the most others disagree with; of two, the later one
        count = {v: sum(v in (p.view, p.other) for p in apart) for v in motion}
        worst = max(reversed(list(motion)), key=lambda v: count[v])
        own = [p for p in apart if worst in (p.view, p.other)]
        best = max(own, key=lambda p: p.likeness)
        if best.view != worst:
            best = OutOfStep(worst, best.view, -best.late, best.likeness, best.likeness_now)
        said.append(best)
        apart = [p for p in apart if worst not in (p.view, p.other)]
    return said


def _compared(motion: Mapping[str, FloatArray], other: str, view: str) -> OutOfStep | None:
    """Compare two views; None where they are in step or it cannot be told."""
    a, b = _fast_part(motion[other]), _fast_part(motion[view])
    if len(a) < _FEWEST_COMPARED:
        return None
    lags = range(-_MOST_FRAMES_APART, _MOST_FRAMES_APART + 1)
    likeness = {k: _likeness(a, b, k) for k in lags}
    late = max(likeness, key=lambda k: likeness[k])
    if likeness[late] < max(_LEAST_LIKENESS, likeness[0] + _LEAST_GAIN):
        return None
    half = len(a) // 2
    for part in (slice(None, half), slice(half, None)):
        if _likeness(a[part], b[part], late) <= _likeness(a[part], b[part], 0):
            return None
    return OutOfStep(view, other, late, likeness[late], likeness[0])


def _factor(width_px: int) -> int:
    """Return by what pictures are reduced: a power of two, which is quick (1, 2, 4, ...)."""
    return 1 << math.ceil(math.log2(max(1.0, width_px / _COMPARED_WIDTH_PX)))


def _smooth_grey(image: ByteArray) -> FloatArray:
    """Return a picture in grey without its finest detail."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) if image.ndim == 3 else image
    return np.asarray(cv2.GaussianBlur(grey.astype(np.float32), (0, 0), _MOTION_BLUR_PX))


def _fast_part(motion: FloatArray) -> FloatArray:
    """Return what changes within the window: sudden large movements weigh less (square root)."""
    root = np.sqrt(motion)
    slow = np.convolve(
        np.pad(root, _SLOW_FRAMES // 2, mode="edge"), np.ones(_SLOW_FRAMES) / _SLOW_FRAMES, "valid"
    )
    return np.asarray(root - slow)


def _likeness(a: FloatArray, b: FloatArray, late: int) -> float:
    """Return the correlation of a at a frame with b so many frames later; 0 where one is still."""
    n = len(a) - abs(late)
    x, y = a[max(0, -late) :][:n], b[max(0, late) :][:n]
    spread = float(x.std() * y.std())
    return float(((x - x.mean()) * (y - y.mean())).mean()) / spread if spread > 0 else 0.0
