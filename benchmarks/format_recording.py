"""The recording that the table of formats is made of. See ``formats.py``."""

from __future__ import annotations

import numpy as np

from pawnb.io.points import build_tracks
from pawnb.schema import Tracks

FPS, N = 100.0, 60
POINTS, ANIMALS = ["FR", "HR", "FL", "HL"], ["m1", "m2"]


def recording(n_animals: int = 2, *, space: bool = False) -> np.ndarray:
    """Return positions (frames, points, animals, axes) of the recording; HR is lost for a while."""
    t, k = np.arange(N)[:, None] / FPS, np.arange(4)
    u = 200 + 60 * np.sin(2 * np.pi * 3 * t + 1.5 * k) + 40 * k
    v = 300 + 5 * np.cos(2 * np.pi * 3 * t + k)
    parts = [u / 10, v / 10, 2 + 0 * u] if space else [u, v]
    place = np.stack(parts, axis=-1)[:, :, None] + 50.0 * np.arange(n_animals)[:, None]
    place[10:13, 1] = np.nan
    return place


def tracks_of(place: np.ndarray, *, views: int = 0) -> Tracks:
    """Return a recording as Tracks; with views, seen alike by several."""
    n_animals = place.shape[2]
    values = np.repeat(place[:, None], views, axis=1) if views else place
    return build_tracks(
        np.arange(N), values, np.full(values.shape[:-1], 0.9), points=POINTS, fps=FPS,
        unit="px" if place.shape[-1] == 2 else "mm", program="pawnb", where="benchmark",
        individuals=ANIMALS[:n_animals] if n_animals > 1 else ["animal"],
        views=[f"cam{i + 1}" for i in range(views)],
    )  # fmt: skip


def places(tracks: Tracks) -> np.ndarray:
    """Return positions in the order of :func:`recording`; of several views, those of the first."""
    own = tracks.sel(keypoint=POINTS)
    if "view" in own.dims:
        first = own["image_position"].isel(view=0)
        return first.transpose("time", "keypoint", "individual", "image_space").to_numpy()
    return own["position"].transpose("time", "keypoint", "individual", "space").to_numpy()


def off(found: np.ndarray, true: np.ndarray) -> str:
    """Return the largest error; what is missing in one of the two only is said."""
    found, true = np.asarray(found, float), np.asarray(true, float)
    lost = np.isnan(true).any(axis=-1)
    if found.shape != true.shape:
        return f"shape {found.shape}"
    if not np.isnan(found[lost]).all() or np.isnan(found[~lost]).any():
        return "gap lost"
    return f"{np.abs(found - true)[~lost].max():.1g}"
