"""Whether the pictures at a track look like what was clicked: a check that knows no tracker.

The grey values about a label are compared with those about the clicks of its point, by normalised
cross-correlation. In a sample of frames only: what is asked is the share of labels.
"""

from __future__ import annotations

import cv2
import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.core.paws.layout import Views
from pawnb.core.paws.offline.quality.measures import CALIBRATED, LIKENESS, read_labels
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.core.paws.superpixels import FramePixels
from pawnb.core.pixels.grey import grey
from pawnb.schema import Tracks

_EVEN_GREY = 1e-3
"""Guard: grey values that differ by less are even, and have no correlation."""


def measure_likeness(views: Views, tracks: Tracks, clicks: pd.DataFrame) -> FloatArray:
    """Measure how much the pictures at labels look like those at the clicks of their point.

    Parameters
    ----------
    views : ViewSet
        The opened views.
    tracks : xarray.Dataset
        Tracks of them.
    clicks : DataFrame
        frame, view, point, u, v.

    Returns
    -------
    ndarray, shape (n, V, P)
        The largest correlation with any click within half of what counts as right; NaN but in
        a few frames, and where the point was not clicked in that view.
    """
    labels = read_labels(tracks, clicks)
    found = np.full(labels.origin.shape, np.nan)
    names = tracks["view"].to_numpy().tolist()
    sizes = [(views.readers[name].width, views.readers[name].height) for name in names]
    points = tracks["keypoint"].to_numpy().tolist()
    clicks = clicks[clicks["view"].isin(names) & clicks["point"].isin(points)]
    clicked: dict[tuple[int, int], list[np.ndarray]] = {}
    for frame in np.unique(clicks["frame"]).tolist():
        here = clicks[clicks["frame"] == frame]
        pictures = views.frame(frame)
        for view, point, uv in zip(
            here["view"], here["point"], here[["u", "v"]].to_numpy(float), strict=True
        ):
            v, p = names.index(view), points.index(point)
            what = _about(pictures[view], uv, sizes[v], body=labels.body_px[v], spare=0)
            if what is not None and what.std() > _EVEN_GREY:
                clicked.setdefault((v, p), []).append(what)
    frames = tracks["frame"].to_numpy()
    rows = np.flatnonzero(~np.isin(frames, clicks["frame"]))
    few = np.unique(np.linspace(0, max(len(rows) - 1, 0), QUALITY.likeness_frames).astype(int))
    for t in rows[few[: len(rows)]].tolist():
        pictures = views.frame(int(frames[t]))
        for (v, p), patterns in clicked.items():
            where = _about(
                pictures[names[v]], labels.uv[t, v, p], sizes[v],
                body=labels.body_px[v], spare=QUALITY.likeness_spare,
            )  # fmt: skip
            if where is not None:
                found[t, v, p] = max(_correlation(where, pattern) for pattern in patterns)
    return found


def _about(
    picture: FramePixels, at: np.ndarray, size: tuple[int, int], *, body: float, spare: int
) -> np.ndarray | None:
    """Return the scaled grey values about a place; None where that is off the picture."""
    if not (np.isfinite(at).all() and np.isfinite(body)):
        return None
    u, v = at
    if not (-0.5 <= u <= size[0] - 0.5 and -0.5 <= v <= size[1] - 0.5):
        return None
    side = QUALITY.likeness_side + 2 * spare
    scale = max(
        2.0 * QUALITY.likeness_reach * body / QUALITY.likeness_side, QUALITY.likeness_finest
    )
    reach = int(np.ceil(0.5 * side * scale)) + 2
    left, top = round(float(u)) - reach, round(float(v)) - reach
    u0, v0 = max(left, 0), max(top, 0)
    u1 = min(left + 2 * reach + 1, size[0])
    v1 = min(top + 2 * reach + 1, size[1])
    pixels = grey(picture.crop(u0, v0, u1, v1))
    if scale > 1.0:  # what is smaller than a pixel of the result would be noise there
        pixels = cv2.GaussianBlur(pixels, (0, 0), 0.5 * scale)
    middle = 0.5 * (side - 1)
    to_picture = np.array(
        [[scale, 0.0, u - u0 - scale * middle], [0.0, scale, v - v0 - scale * middle]]
    )
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(
        pixels, to_picture, (side, side), flags=flags, borderMode=cv2.BORDER_REPLICATE
    )


def _correlation(where: np.ndarray, pattern: np.ndarray) -> float:
    """Return the largest correlation of a pattern with any place of a picture."""
    # an even picture has no correlation with anything
    if where.std() <= _EVEN_GREY:
        return 0.0
    values = cv2.matchTemplate(where, pattern, cv2.TM_CCOEFF_NORMED)
    return float(np.nanmax(np.where(np.isfinite(values), values, 0.0)))


def add_likeness(views: Views, tracks: Tracks, clicks: pd.DataFrame) -> Tracks:
    """Return tracks that say how much pictures at labels look like those at clicks.

    Parameters
    ----------
    views, tracks, clicks
        As for :func:`measure_likeness`.

    Returns
    -------
    xarray.Dataset
        Tracks with the variable ``image_likeness``; as they are where the method gives the
        probability that labels are right.
    """
    if tracks["image_confidence"].attrs.get(CALIBRATED):
        return tracks
    values = measure_likeness(views, tracks, clicks)[..., None]
    return tracks.assign({LIKENESS: (tracks["image_confidence"].dims, values, {"units": "1"})})


def keep_likeness(old: Tracks, new: Tracks) -> Tracks:
    """Return new tracks with what was measured of old ones, where a label has stayed in place.

    Parameters
    ----------
    old, new : xarray.Dataset
        Tracks of the same frames.
    """
    if LIKENESS not in old:
        return new
    dims = new["image_confidence"].dims
    before, now = (
        tracks["image_position"].transpose(*dims, "image_space").to_numpy() for tracks in (old, new)
    )
    stayed = np.linalg.norm(now - before, axis=-1) < QUALITY.stayed_px
    values = np.where(stayed, old[LIKENESS].transpose(*dims).to_numpy(), np.nan)
    return new.assign({LIKENESS: (dims, values, {"units": "1"})})
