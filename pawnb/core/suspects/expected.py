"""How many wrong labels are to be expected in tracks, besides those a person has looked at."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray
from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.core.suspects.chances import AROUND_FRAMES
from pawnb.core.suspects.evidence import image_positions
from pawnb.schema import ORIGIN_CODE, Tracks

Seen = tuple[int, str, str]
"""Frame, view and point of a label that a person has said is right."""


def seen_labels(tracks: Tracks, seen: Iterable[Seen]) -> BoolArray:
    """Tell which labels a person has seen to be right.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    seen : iterable of (frame, view, point)
        Labels of which a person said so. They show those of the same point and view up to
        :data:`~pawnb.core.suspects.chances.AROUND_FRAMES` frames before and after, too.

    Returns
    -------
    ndarray of bool, shape (n, V, P)
        Those, and every label that a person has placed.
    """
    mask = np.asarray(tracks["image_origin"].isel(individual=0) == ORIGIN_CODE["edited"]).copy()
    frames = tracks["frame"].to_numpy()
    views, points = (
        {str(name): k for k, name in enumerate(tracks[dim].to_numpy())}
        for dim in ("view", "keypoint")
    )
    for frame, view, point in seen:
        if view in views and point in points:
            near = np.abs(frames - frame) <= AROUND_FRAMES
            mask[near, views[view], points[point]] = True
    return mask


def expected_errors(
    tracks: Tracks, *, clicks: pd.DataFrame | None = None, seen: Iterable[Seen] = ()
) -> float:
    """Return how many labels are expected to be wrong that no person has looked at.

    Each label (one point in one view and frame) that was tracked counts with its chance of being
    wrong, as the verdict on the tracks takes it (``quality.json``). Labels that are missing are
    not counted, nor those that only show a position in space.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    clicks : DataFrame, optional
        Every click they were made from.
    seen : iterable of (frame, view, point)
        As for :func:`seen_labels`; labels seen to be right count as right.

    Returns
    -------
    float
        Number of labels.

    Raises
    ------
    InputError
        If the tracks have no image positions.
    """
    chance = label_chances(tracks, clicks=clicks)
    origin = tracks["image_origin"].isel(individual=0).to_numpy()
    counted = np.isfinite(image_positions(tracks)).all(axis=-1) & np.isfinite(chance)
    counted &= ~np.isin(origin, (ORIGIN_CODE["missing"], ORIGIN_CODE["reprojected"]))
    return float((1.0 - chance)[counted & ~seen_labels(tracks, seen)].sum())
