"""How many wrong labels are to be expected in tracks, besides those a person has looked at.

The chances of being right that the verdict takes are meant to miss no recording that failed. Added
up over the thousands of labels of tracks by colour they state far too many errors: the small doubt
of labels whose place is only known to a millimetre, or that other places fit about as well, is
nearly always in vain there. So for these tracks the chances are calibrated anew, by what they are
and by how much of the recording is doubted at all.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd
from scipy.special import expit, logit

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.quality.assessment import label_chances
from pawnb.core.suspects.chances import SEEN_AROUND_FRAMES
from pawnb.core.suspects.evidence import image_positions
from pawnb.schema import ORIGIN_CODE, Tracks

_BY_COLOUR = "colour"
"""Value of the attribute ``evidence`` of tracks that are calibrated anew."""
_OFFSET, _SLOPE, _DOUBTED = -3.41, 0.47, 10.9
"""Log-odds that a label of such tracks is wrong: an offset, per log-odds of the chance that the
verdict takes, and per share of labels that are likelier wrong than right. Fitted by
``benchmarks/learn_errors_left.py`` to 17,213 labels of 13 recordings of two rendered scenes in 11
films, good ones and such on which tracking by colour fails (compressed, grey, few frames a second).
Of 16,096 labels of 11 recordings of other scenes it states 2.0 errors in a hundred labels too many
or too few in the mean, the chances of the verdict 8.0."""
_LEAST_CHANCE = 1e-3
"""Chances nearer to 0 or 1 tell no more."""

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
        :data:`~pawnb.core.suspects.chances.SEEN_AROUND_FRAMES` frames before and after, too.

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
            near = np.abs(frames - frame) <= SEEN_AROUND_FRAMES
            mask[near, views[view], points[point]] = True
    return mask


def expected_errors(
    tracks: Tracks, *, clicks: pd.DataFrame | None = None, seen: Iterable[Seen] = ()
) -> float:
    """Return how many labels are expected to be wrong that no person has looked at.

    Each label (one point in one view and frame) that was tracked counts with its chance of being
    wrong: as the verdict on the tracks takes it (``quality.json``), for tracks by colour calibrated
    anew. Labels that are missing are
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
    wrong = 1.0 - chance
    if tracks.attrs.get("evidence") == _BY_COLOUR:
        wrong = calibrated_anew(wrong, counted & (origin != ORIGIN_CODE["edited"]))
    return float(wrong[counted & ~seen_labels(tracks, seen)].sum())


def calibrated_anew(wrong: FloatArray, counted: BoolArray) -> FloatArray:
    """Return how likely labels of tracks by colour are wrong.

    Parameters
    ----------
    wrong : ndarray
        Chances of being wrong, 0 to 1, as the verdict takes them.
    counted : ndarray of bool
        Those that were tracked, and not placed by hand.

    Returns
    -------
    ndarray
        0 to 1, of the same shape.
    """
    doubted = float((wrong[counted] > 0.5).mean()) if counted.any() else 0.0
    odds = logit(np.clip(wrong, _LEAST_CHANCE, 1.0 - _LEAST_CHANCE))
    return np.asarray(expit(_OFFSET + _SLOPE * odds + _DOUBTED * doubted))
