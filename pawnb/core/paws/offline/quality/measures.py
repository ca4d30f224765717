"""What is left of the probability that labels are right, by each measure, on absolute scales.

Arrays are (n frames, V views, P points). Lengths are in body sizes: the usual largest distance
between two points of one clicked frame. Half a paw, within which a label counts as right, is
0.035 to 0.1 of it in seven real clips with marks (horse, camel, dog, mice, fly), 0.055 in the
middle. A measure that is not known takes nothing away.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.ndimage import distance_transform_edt
from scipy.special import expit, logit

from pawnb.arrays import FloatArray
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.quality.departure import departs_from_clicks
from pawnb.core.paws.offline.quality.labels import Labels, Measure, QualityLimits, in_views
from pawnb.core.paws.offline.quality.one_place import on_one_place, on_one_place_in_space
from pawnb.core.paws.offline.quality.parameters import QUALITY
from pawnb.schema import Tracks

CALIBRATED = "is_probability"
"""Attribute of ``image_confidence``: 1 where it is the probability, 0 to 1, that the label lies
within half a paw of the truth, of labels that were found and of others."""

LIKENESS = "image_likeness"
"""Variable of tracks: how much pictures at labels look like those at clicks of the point, -1 to 1;
NaN where it was not measured (:mod:`.likeness`)."""

_ROUNDS = 30
"""Numerics: rounds of a fixed-point iteration."""
_MOST_MEASURED_FRAMES = 1000
"""Resource: the usual size is the median of so many frames, spread evenly."""


def read_labels(tracks: Tracks, clicks: pd.DataFrame | None) -> Labels:
    """Take from tracks what the measures need.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    clicks : DataFrame, optional
        frame, view, point, u, v: what a person has placed; it tells the size of the body.
    """
    uv = np.moveaxis(tracks["image_position"].isel(individual=0).to_numpy(), 2, -1)
    origin = tracks["image_origin"].isel(individual=0).to_numpy()
    views = tracks["view"].to_numpy().tolist()
    pictures = json.loads(tracks.attrs.get("pictures_px", "{}"))
    if "joint_angle" in tracks:
        pictures = {}  # a jointed animal is known as a whole: legs that have left are right
    sizes = {v: tuple(pictures[name]) for v, name in enumerate(views) if name in pictures}
    body = _body_px(uv, tracks, clicks)
    space = _in_space(tracks)
    clicked = _clicked_labels(tracks, clicks, uv.shape[2])
    apart = _clicked_apart(space, clicked)
    kinds = tuple(Maghsoudi2019Settings().kind(str(p)) for p in tracks["keypoint"].to_numpy())
    fps = float(tracks.attrs["fps"])
    return Labels(uv, origin, body, fps, sizes, space, apart, clicked, kinds)


def _in_space(tracks: Tracks) -> np.ndarray:
    """Return positions in space (n, P, 3); NaN where tracks are of one picture."""
    position = tracks["position"].isel(individual=0)
    n, n_points = tracks.sizes["time"], tracks.sizes["keypoint"]
    if position.sizes["space"] < 3 or tracks.sizes["view"] < 2:
        return np.full((n, n_points, 3), np.nan)
    return np.asarray(position.transpose("time", "keypoint", "space").to_numpy())


def _clicked_labels(tracks: Tracks, clicks: pd.DataFrame | None, n_points: int) -> np.ndarray:
    """Return which points (n, P) were clicked in any view: tracks pass there in the others, too."""
    here = np.zeros((tracks.sizes["time"], n_points), dtype=bool)
    if clicks is not None:
        frames, points = tracks["frame"].to_numpy(), tracks["keypoint"].to_numpy()
        for frame, clicked in clicks.groupby("frame"):
            here[frames == frame] = np.isin(points, clicked["point"])
    return here


def _clicked_apart(space: np.ndarray, here: np.ndarray) -> np.ndarray:
    """Return the smallest distance (P, P) at which two points were clicked; NaN where never."""
    at = np.where(here[..., None], space, np.nan)[here.any(axis=1)]
    apart = np.full((here.shape[1], here.shape[1]), np.inf)
    for places in at:
        apart = np.fmin(apart, np.linalg.norm(places[:, None] - places[None], axis=-1))
    return np.where(np.isfinite(apart), apart, np.nan)


def _body_px(uv: np.ndarray, tracks: Tracks, clicks: pd.DataFrame | None) -> np.ndarray:
    """Return the size of the body in each view (V,), px: where it was clicked, else as usual."""
    here = _clicked_labels(tracks, clicks, uv.shape[2])
    clicked_uv = np.where(here[:, None, :, None], uv, np.nan)[here.any(axis=1)]
    body = np.array([usual_span(clicked_uv[:, v]) for v in range(uv.shape[1])])
    usual = np.array([usual_span(uv[:, v]) for v in range(uv.shape[1])])
    return np.where(np.isfinite(body), body, usual)


def largest_distance(places: FloatArray) -> float:
    """Return the largest distance between two of some places (P, d); NaN where there is none."""
    places = places[np.isfinite(places).all(axis=-1)]
    if len(places) < 2:
        return np.nan
    away = np.linalg.norm(places[:, None] - places[None], axis=-1)
    return float(away.max()) or np.nan


def usual_span(places: FloatArray) -> float:
    """Return the median over frames of the largest distance of places (n, P, d).

    Parameters
    ----------
    places : ndarray, shape (n, P, d)
        NaN where unknown.

    Returns
    -------
    float
        In their unit; NaN where no frame has two.
    """
    # the median of so many frames is that of all of them
    few = np.unique(np.linspace(0, max(len(places) - 1, 0), _MOST_MEASURED_FRAMES).astype(int))
    spans = np.array([largest_distance(places[t]) for t in few if t < len(places)])
    known = spans[np.isfinite(spans)]
    return float(np.median(known)) if len(known) else np.nan


def measure_places(labels: Labels, limits: QualityLimits, trust: FloatArray) -> list[Measure]:
    """Measure what speaks against labels of any method: places that no animal can have.

    Parameters
    ----------
    labels : Labels
        The labels.
    limits : QualityLimits
        The limits.
    trust : ndarray, shape (n, V, P)
        What the method's own evidence leaves of each: a point is not blamed for being far from
        others that are lost.

    Returns
    -------
    list of Measure
        One for each reason.
    """
    return [
        _off_the_picture(labels, limits),
        _beyond_the_body(labels, limits, trust),
        on_one_place(labels, limits),
        on_one_place_in_space(labels, limits),
        _leaps(labels, limits),
        departs_from_clicks(labels, limits),
    ]


def measure_evidence(tracks: Tracks, labels: Labels, limits: QualityLimits) -> list[Measure]:
    """Measure what a method says of its labels, where it gives no probability.

    Parameters
    ----------
    tracks : Tracks
        The tracks.
    labels : Labels
        Their labels.
    limits : QualityLimits
        The limits.

    Returns
    -------
    list of Measure
        One for each reason.
    """
    return [
        _bridged(labels, limits),
        _not_separated(tracks, labels),
        _vague(tracks, labels, limits),
        _unsure(tracks, labels),
        _views_disagree(tracks, labels, limits),
        _hardly_recognised(tracks, labels),
        _looks_otherwise(tracks, labels),
    ]


def heaviest(measures: Sequence[Measure], of: str, labels: Labels) -> FloatArray:
    """Return what is left by those measures that are signs of one doubt: the heaviest counts.

    Parameters
    ----------
    measures : sequence of Measure
        What a method says of its labels.
    of : {"place", "name"}
        The doubt.
    labels : Labels
        The labels.

    Returns
    -------
    ndarray, shape (n, V, P)
        0 to 1.
    """
    own = [measure.left for measure in measures if measure.of == of]
    return np.asarray(np.min([np.ones(labels.origin.shape), *own], axis=0))


def falling(values: FloatArray, fall: tuple[float, float, float]) -> FloatArray:
    """Return 1 up to a value, less beyond it.

    Parameters
    ----------
    values : ndarray
        Any; unknown ones are NaN and give 1.
    fall : tuple of float
        Up to where it is 1, from where on it is less, and how much it is then (0 to 1); a line
        between.

    Returns
    -------
    ndarray
        0 to 1, as many as values.
    """
    begin, end, least = fall
    return np.where(np.isfinite(values), np.interp(values, (begin, end), (1.0, least)), 1.0)


def _off_the_picture(labels: Labels, limits: QualityLimits) -> Measure:
    left = np.ones(labels.origin.shape)
    for v, size in labels.sizes.items():
        spare = np.nan_to_num(limits.right * labels.body_px[v])
        off = np.maximum(-labels.uv[:, v], labels.uv[:, v] - (np.array(size) - 1)).max(axis=-1)
        left[:, v] = np.where(off > spare, 0.0, 1.0)
    return Measure("{point} lies off the picture", left)


def _beyond_the_body(labels: Labels, limits: QualityLimits, trust: np.ndarray) -> Measure:
    away = np.full(labels.origin.shape, np.nan)
    sound = np.where(trust[..., None] >= limits.failed, labels.uv, np.nan)
    for p in range(labels.origin.shape[2]):
        others = np.delete(sound, p, axis=2)
        middle = _middle(others)
        away[:, :, p] = np.linalg.norm(labels.uv[:, :, p] - middle, axis=-1) / labels.body_px
    far, least = QUALITY.beyond_fall
    left = falling(away, (limits.beyond, far * limits.beyond, least))
    return Measure("{point} lies further from the others than the body is long", left)


def _middle(uv: np.ndarray) -> np.ndarray:
    """Return the median over points (n, V, P, 2); NaN where there is none."""
    middle = np.full((*uv.shape[:2], 2), np.nan)
    some = np.isfinite(uv).all(axis=-1).any(axis=-1)
    middle[some] = np.nanmedian(uv[some], axis=-2)
    return middle


def _leaps(labels: Labels, limits: QualityLimits) -> Measure:
    step = np.full(labels.origin.shape, np.nan)
    if len(step) > 1:
        moved = np.linalg.norm(np.diff(labels.uv, axis=0), axis=-1) / labels.body_px[:, None]
        step[1:] = moved
        step[:-1] = np.fmax(step[:-1], moved)
    far, least = QUALITY.leap_fall
    left = falling(step, (limits.leap, far * limits.leap, least))
    return Measure("{point} leaps further than any animal moves in one frame", left)


def _bridged(labels: Labels, limits: QualityLimits) -> Measure:
    # a point that another view finds is found
    found = np.asarray(labels.found.any(axis=1))
    away = np.full(found.shape, np.inf)
    for p in np.flatnonzero(found.any(axis=0)).tolist():
        away[:, p] = distance_transform_edt(~found[:, p])
    late = away / labels.fps - limits.bridged_s / 3.0
    left = np.exp(-np.maximum(late, 0.0) / limits.bridged_s)
    return Measure("{point} was not found for long and is only guessed", in_views(left, labels))


def _not_separated(tracks: Tracks, labels: Labels) -> Measure:
    left = np.ones(labels.origin.shape)
    each = expit(_separation(tracks, labels))
    told = np.isfinite(each).sum(axis=1)
    mean = np.where(told > 0, np.nansum(each, axis=1) / np.maximum(told, 1), np.nan)
    rows = np.arange(len(mean))
    for p in np.flatnonzero((told > 0).any(axis=0)).tolist():
        at = np.flatnonzero(np.isfinite(mean[:, p]))
        # what is bridged between doubtful places is doubtful
        left[:, :, p] = np.interp(rows, at, mean[at, p])[:, None]
    left = np.where(np.isfinite(each), each, left)
    return Measure("other places fit {point} about as well", left, of="name")


def _vague(tracks: Tracks, labels: Labels, limits: QualityLimits) -> Measure:
    left = np.ones(labels.origin.shape)
    if "sd" in tracks:
        sd, size = _sd_and_size(tracks)
        for v in range(len(labels.body_px)):
            px = sd * usual_span(labels.uv[:, v]) / size
            chance = -np.expm1(-0.5 * np.square(limits.right * labels.body_px[v] / px))
            left[:, v] = np.where(np.isfinite(chance), chance, 1.0)
    return Measure("the place of {point} is only vaguely known", left)


def _unsure(tracks: Tracks, labels: Labels) -> Measure:
    left = np.ones(labels.origin.shape)
    if "passes_apart" in tracks:
        sd, size = _sd_and_size(tracks)
        # a stated deviation says how well views and frames agree, not whether all are on the paw
        offset, by_sd, by_passes = QUALITY.unsure_weights
        with np.errstate(divide="ignore"):
            odds = offset + by_sd * np.log(size / sd)
        apart = tracks["passes_apart"].isel(individual=0).to_numpy()
        odds += by_passes * np.nan_to_num(apart)
        chance = np.where(np.isfinite(size / sd), expit(odds), 1.0)
        left = in_views(chance, labels)
    return Measure("what is seen before and after agrees poorly about {point}", left)


def _sd_and_size(tracks: Tracks) -> tuple[np.ndarray, float]:
    """Return standard deviations (n, P) of positions along an axis, and the body's usual size."""
    x = np.moveaxis(tracks["position"].isel(individual=0).to_numpy(), 1, -1)
    sd = np.sqrt(np.square(tracks["sd"].isel(individual=0).to_numpy()).mean(axis=1))
    return sd, usual_span(x)


def _views_disagree(tracks: Tracks, labels: Labels, limits: QualityLimits) -> Measure:
    off = tracks["residual"].isel(individual=0).to_numpy()[:, None] / labels.body_px[:, None]
    if "image_residual" in tracks:
        off = tracks["image_residual"].isel(individual=0).to_numpy() / labels.body_px[:, None]
    far, least = QUALITY.disagree_fall
    left = falling(off, (limits.right, far * limits.right, least))
    return Measure("the picture has {point} elsewhere than the other views", left)


def _hardly_recognised(tracks: Tracks, labels: Labels) -> Measure:
    confidence = tracks["image_confidence"].isel(individual=0).to_numpy()
    left = np.where(labels.found, falling(1.0 - confidence, QUALITY.hardly_fall), 1.0)
    return Measure("{point} is hardly recognised", left, of="name")


def _looks_otherwise(tracks: Tracks, labels: Labels) -> Measure:
    left = np.ones(labels.origin.shape)
    if LIKENESS in tracks:
        alike = tracks[LIKENESS].isel(individual=0).to_numpy()
        # a method that says nothing of other places has only looks to speak for it
        alone = ~np.isfinite(_separation(tracks, labels)).any(axis=(0, 1))
        alike = np.where(labels.found, alike, np.nan)
        rows = np.arange(len(alike))
        for p in np.flatnonzero(np.isfinite(alike).any(axis=(0, 1))).tolist():
            odds = QUALITY.alike_against + QUALITY.alike * alike[:, :, p]
            if alone[p]:
                share = _share_alike(odds[np.isfinite(odds)])
                chance = np.minimum(expit(odds + logit(share)), QUALITY.alone)
            else:
                chance = expit(logit(QUALITY.sure) + np.minimum(odds, 0.0)) / QUALITY.sure
            for v in np.flatnonzero(np.isfinite(chance).any(axis=0)).tolist():
                at = np.flatnonzero(np.isfinite(chance[:, v]))
                left[:, v, p] = np.interp(rows, at, chance[at, v])
        left = np.where(labels.found, left, 1.0)
    return Measure("the picture at {point} does not look like what was clicked", left, of="name")


def _share_alike(odds: np.ndarray) -> float:
    """Return the share of labels that is most likely, by what looks add to their log-odds."""
    usual, weight = QUALITY.usual_share, QUALITY.usual_weight
    share = usual
    for _ in range(_ROUNDS):
        own = expit(odds + logit(share)).mean()
        share = float(own + weight * usual) / (1.0 + weight)
    return share


def _separation(tracks: Tracks, labels: Labels) -> np.ndarray:
    """Return the log-odds of labels that were found against other places; NaN where unknown."""
    odds = np.full(labels.origin.shape, np.nan)
    if "image_separation" in tracks:
        odds = tracks["image_separation"].isel(individual=0).to_numpy()
    return np.where(labels.found, odds, np.nan)
