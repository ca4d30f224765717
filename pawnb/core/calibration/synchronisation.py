"""Whether the films of several views are synchronised: what moves in one moves in the others, too.

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
_LEAST_CORRELATION, _LEAST_GAIN = 0.6, 0.15
"""Correlation of films once moved, and how much higher than as they are. Set by hand: films that
are synchronised (mouse-4cam-cage, five rendered mice in colour, grey and H.264) have 0.4 to 0.8
where cameras see the same legs, the most of all lags; with 3 frames between them 0 or less."""


@dataclass(frozen=True)
class Unsynchronised:
    """Two views that are alike once one of them is moved in time.

    Parameters
    ----------
    view, other : str
        The view that is not synchronised, and one that it was compared with.
    lag_frames : int
        Frames by which what moves comes later in ``view``.
    correlation, correlation_now : float
        Correlation of both once moved, and as they are.
    """

    view: str
    other: str
    lag_frames: int
    correlation: float
    correlation_now: float


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


def find_unsynchronised(
    motion: Mapping[str, FloatArray], *, pairs: Sequence[tuple[str, str]]
) -> list[Unsynchronised]:
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
    list of Unsynchronised
        One for each view that is not synchronised; empty where all are, or it cannot be told.
    """
    apart = [found for a, b in pairs if (found := _compared(motion, a, b)) is not None]
    said = []
    while apart:
        # the view that the most others disagree with; of two, the later one
        count = {v: sum(v in (p.view, p.other) for p in apart) for v in motion}
        worst = max(reversed(list(motion)), key=lambda v: count[v])
        own = [p for p in apart if worst in (p.view, p.other)]
        best = max(own, key=lambda p: p.correlation)
        if best.view != worst:
            best = Unsynchronised(
                worst, best.view, -best.lag_frames, best.correlation, best.correlation_now
            )
        said.append(best)
        apart = [p for p in apart if worst not in (p.view, p.other)]
    return said


def _compared(motion: Mapping[str, FloatArray], other: str, view: str) -> Unsynchronised | None:
    """Compare two views; None where they are synchronised or it cannot be told."""
    a, b = _fast_part(motion[other]), _fast_part(motion[view])
    if len(a) < _FEWEST_COMPARED:
        return None
    lags = range(-_MOST_FRAMES_APART, _MOST_FRAMES_APART + 1)
    correlation = {k: _correlation(a, b, k) for k in lags}
    lag = max(correlation, key=lambda k: correlation[k])
    if correlation[lag] < max(_LEAST_CORRELATION, correlation[0] + _LEAST_GAIN):
        return None
    half = len(a) // 2
    for part in (slice(None, half), slice(half, None)):
        if _correlation(a[part], b[part], lag) <= _correlation(a[part], b[part], 0):
            return None
    return Unsynchronised(view, other, lag, correlation[lag], correlation[0])


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


def _correlation(a: FloatArray, b: FloatArray, lag: int) -> float:
    """Return the correlation of a at a frame with b so many frames later; 0 where one is still."""
    n = len(a) - abs(lag)
    x, y = a[max(0, -lag) :][:n], b[max(0, lag) :][:n]
    spread = float(x.std() * y.std())
    return float(((x - x.mean()) * (y - y.mean())).mean()) / spread if spread > 0 else 0.0
