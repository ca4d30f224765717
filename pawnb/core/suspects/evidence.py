"""What speaks against labels, each kind by itself, in units of the trial's own level.

Arrays are (n frames, V views, P points). A score of 0 is ordinary; 1 and more is out of
the ordinary; scores level off, so that no single kind of evidence drowns the others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter, minimum_filter1d, uniform_filter1d

from pawnb.arrays import FloatArray, IntArray, Points2D
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks
from pawnb.signals.robust import MAD_TO_SD

CAP = 6.0
"""What the score of one kind of evidence approaches."""

_WEAK = 0.5
"""Weight of evidence that sound tracks show too: a crossing, a paw off its usual place."""

_USUAL_PERCENT = 90.0
"""What this share of frames stays below is usual."""
_STEADY_S = 0.1
"""Time over which confidence is steady, and a paw of a runner is on the ground once: 0.1 s."""

PAW_SHARE = 0.25
"""Size of a paw, in the usual distance between two points."""
_LONG_FRAMES = 4.0
"""A point that was only predicted is doubted more with every so many frames in a row."""


@dataclass(frozen=True)
class LabelEvidence:
    """One kind of evidence against every label.

    Parameters
    ----------
    score : ndarray, shape (n, V, P)
        0 where it does not speak against the label, below :data:`CAP`.
    words : callable
        ``words(key)`` says it for the label ``(row, view, point)``.
    """

    score: FloatArray
    words: Callable[[tuple[int, int, int]], str]


def collect_evidence(
    tracks: Tracks, *, rig: Rig | None, other: Tracks | None, paw_px: float | None
) -> list[LabelEvidence]:
    """Measure every kind of evidence that the tracks allow.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    rig : Rig, optional
        The calibrated views.
    other : xarray.Dataset, optional
        Tracks of the same recording made another way.
    paw_px : float, optional
        Size of a paw in px.

    Returns
    -------
    list of LabelEvidence
        In a fixed order.

    Raises
    ------
    InputError
        If ``other`` shares no view and point with the tracks.
    """
    uv = image_positions(tracks)
    xyz = np.moveaxis(tracks["position"].isel(individual=0).to_numpy(), 1, -1)
    span = max(3, round(_STEADY_S * float(tracks.attrs["fps"])))
    found = [
        _views_disagree(tracks, uv, xyz, rig=rig, span=span),
        *_motion(uv),
        _confidence(tracks["image_confidence"].isel(individual=0).to_numpy(), uv, span),
        _crossing(uv, tracks["keypoint"].to_numpy().tolist(), paw_px),
        _not_measured(tracks["image_origin"].isel(individual=0).to_numpy()),
    ]
    if xyz.shape[-1] == 3 and np.isfinite(xyz).any():
        up, forward = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)) if rig is None else (rig.up, rig.forward)
        across = np.cross(up, forward)
        found.append(_out_of_place(xyz @ across, uv, span=span, unit=tracks.attrs["units"]))
        found.append(_off_the_ground(xyz @ np.asarray(up), uv, span))
    if other is not None:
        found.append(passes_disagree(tracks, other))
    return found


def image_positions(tracks: Tracks) -> FloatArray:
    """Return image positions (n, V, P, 2) in px of the first individual."""
    return np.moveaxis(tracks["image_position"].isel(individual=0).to_numpy(), 2, -1)


def _doubt(values: FloatArray, usual: float, spread: float) -> FloatArray:
    """Return by how many spreads values are above the usual, levelling off; 0 where unknown."""
    if not (np.isfinite(usual) and np.isfinite(spread) and spread > 0):
        return np.zeros(values.shape)
    return level_off(np.nan_to_num((values - usual) / spread, nan=0.0))


def level_off(score: FloatArray) -> FloatArray:
    """Return scores of 0 or more that approach :data:`CAP` and keep their order.

    Parameters
    ----------
    score : ndarray
        Of any size; below 0 counts as 0.
    """
    return CAP * -np.expm1(-np.clip(score, 0.0, None) / CAP)


def _robust_level(values: FloatArray) -> tuple[float, float]:
    """Return median and robust standard deviation of the finite values."""
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return np.nan, np.nan
    middle = float(np.median(known))
    return middle, MAD_TO_SD * float(np.median(np.abs(known - middle)))


def _views_disagree(
    tracks: Tracks, uv: Points2D, xyz: FloatArray, *, rig: Rig | None, span: int
) -> LabelEvidence:
    """Doubt labels that are far from where the 3D point appears."""
    views = tracks["view"].to_numpy().tolist()
    if rig is not None and xyz.shape[-1] == 3 and set(views) <= set(rig.names):
        seen = np.moveaxis(rig.subset(views).project(xyz), 1, 2)
        error = np.linalg.norm(seen - uv, axis=-1)
    else:
        residual = tracks["residual"].isel(individual=0).to_numpy()[:, None, :]
        error = np.where(np.isfinite(uv[..., 0]), residual, np.nan)
    usual, spread = _robust_level(error)
    # tracks without any error of their own have no level: a quarter px is the least that counts
    spread = max(spread, 0.25) if np.isfinite(spread) else spread
    lasting = _running_mean(error, span)
    score = np.hypot(_doubt(error, usual, spread), _doubt(lasting, usual, spread)) / np.sqrt(2)

    def words(key: tuple[int, int, int]) -> str:
        if lasting[key] > error[key]:
            return f"the views disagree for a while (by {lasting[key]:.0f} px, usually {usual:.1f})"
        return f"the views disagree by {error[key]:.0f} px (usually {usual:.1f})"

    return LabelEvidence(score, words)


def _running_mean(values: FloatArray, span: int) -> FloatArray:
    """Return the mean over a span of frames about each, of what is known there."""
    known = np.isfinite(values)
    total = uniform_filter1d(np.where(known, values, 0.0), span, axis=0, mode="constant")
    count = uniform_filter1d(known.astype(float), span, axis=0, mode="constant")
    return np.divide(total, count, out=np.full(values.shape, np.nan), where=known)


def _motion(uv: Points2D) -> list[LabelEvidence]:
    """Doubt steps, and turns, that are large for the point and view they happen in."""
    step = np.full(uv.shape[:3], np.nan)
    turn = step.copy()
    out = np.zeros(uv.shape[:3], dtype=bool)
    if len(uv) > 2:
        length = np.linalg.norm(np.diff(uv, axis=0), axis=-1)
        step[1:] = length
        step[:-1] = np.fmax(step[:-1], length)
        turn[1:-1] = np.linalg.norm(uv[2:] - 2 * uv[1:-1] + uv[:-2], axis=-1) / 2
        back = np.linalg.norm(uv[2:] - uv[:-2], axis=-1)
        out[1:-1] = back < 0.5 * turn[1:-1]
    fast = _against_own(step)
    sharp = _against_own(turn)

    def words_fast(key: tuple[int, int, int]) -> str:
        return f"it moves {step[key]:.0f} px in one frame, faster than it usually does"

    def words_sharp(key: tuple[int, int, int]) -> str:
        if out[key]:
            return f"it is {turn[key]:.0f} px off in this one frame only"
        return f"it jumps by {turn[key]:.0f} px from its path"

    return [LabelEvidence(fast, words_fast), LabelEvidence(sharp, words_sharp)]


def _against_own(values: FloatArray) -> FloatArray:
    """Compare with the fast tenth of the same point in the same view: 1 is twice as much."""
    score = np.zeros(values.shape)
    for v, p in np.ndindex(values.shape[1:]):
        known = values[:, v, p][np.isfinite(values[:, v, p])]
        if len(known):
            usual = max(float(np.percentile(known, _USUAL_PERCENT)), 1.0)
            score[:, v, p] = _doubt(values[:, v, p], usual, usual)
    return score


def _confidence(confidence: FloatArray, uv: Points2D, span: int) -> LabelEvidence:
    """Doubt labels whose confidence has dropped below that of the frames around them."""
    steady = median_filter(confidence, size=(2 * span + 1, 1, 1), mode="nearest")
    drop = np.where(np.isfinite(uv[..., 0]), steady - confidence, np.nan)
    _, spread = _robust_level(drop)
    score = _WEAK * _doubt(drop, 3.0 * spread, spread)

    def words(key: tuple[int, int, int]) -> str:
        return f"confidence drops to {confidence[key]:.2f} (around it {steady[key]:.2f})"

    return LabelEvidence(score, words)


def find_nearest(uv: Points2D, paw_px: float | None) -> tuple[FloatArray, IntArray, FloatArray]:
    """Find the nearest other point of the same view.

    Parameters
    ----------
    uv : ndarray, shape (n, V, P, 2)
        Image positions, NaN where unknown.
    paw_px : float, optional
        Size of a paw in px; default: a quarter of the usual distance between two points.

    Returns
    -------
    ndarray, shape (n, V, P)
        Distance in px; NaN in views with fewer than two points, else infinite where unknown.
    ndarray of int, shape (n, V, P)
        Number of the nearest point.
    ndarray, shape (V,)
        Size of a paw in each view, px.
    """
    n, n_views, n_points = uv.shape[:3]
    near = np.full((n, n_views, n_points), np.nan)
    who = np.zeros((n, n_views, n_points), dtype=int)
    size = np.ones(n_views)
    for v in range(n_views):
        away = np.linalg.norm(uv[:, v, :, None] - uv[:, v, None, :], axis=-1)
        away[:, np.arange(n_points), np.arange(n_points)] = np.nan
        if not np.isfinite(away).any():
            continue
        # points that lie on each other in most frames tell no size: then 1 px
        size[v] = paw_px or PAW_SHARE * float(np.nanmedian(away)) or 1.0
        filled = np.where(np.isnan(away), np.inf, away)
        near[:, v], who[:, v] = filled.min(axis=-1), filled.argmin(axis=-1)
    return near, who, size


def _crossing(uv: Points2D, points: list[str], paw_px: float | None) -> LabelEvidence:
    """Doubt points that are nearer to another point of their view than a paw is large."""
    near, who, size = find_nearest(uv, paw_px)
    share = near / size[:, None]
    score = _WEAK * 2.0 * np.nan_to_num(np.clip(1.0 - share, 0.0, None), nan=0.0)

    def words(key: tuple[int, int, int]) -> str:
        return f"it is {near[key]:.0f} px from {points[who[key]]}: they may have been mistaken"

    return LabelEvidence(score, words)


def _not_measured(origin: IntArray) -> LabelEvidence:
    """Doubt stretches in which a point was only predicted, most at their ends."""
    predicted = origin == ORIGIN_CODE["predicted"]
    length = np.zeros(origin.shape)
    for t in range(len(origin)):
        length[t] = np.where(predicted[t], (length[t - 1] if t else 0.0) + 1.0, 0.0)
    score = _WEAK * level_off(length / _LONG_FRAMES)

    def words(key: tuple[int, int, int]) -> str:
        n = int(length[key])
        return f"it was not found for {n} frame{'s' * (n != 1)} and is only predicted"

    return LabelEvidence(score, words)


def _out_of_place(coordinate: FloatArray, uv: Points2D, *, span: int, unit: str) -> LabelEvidence:
    """Doubt points (n, P) far from the usual value of a coordinate of their own."""
    score = np.zeros(coordinate.shape)
    off = np.full(coordinate.shape, np.nan)
    spreads = [_robust_level(coordinate[:, p]) for p in range(coordinate.shape[1])]
    common = _robust_level(np.array([spread for _, spread in spreads]))[0]
    for p, (usual, _) in enumerate(spreads):
        off[:, p] = np.abs(coordinate[:, p] - usual)
        score[:, p] = _WEAK * _doubt(_running_mean(off[:, p], span), common, common)

    def words(key: tuple[int, int, int]) -> str:
        away = off[key[0], key[2]]
        return f"it is {away:.0f} {unit} to one side of where it usually is"

    return LabelEvidence(in_views(score, uv), words)


def _off_the_ground(height: FloatArray, uv: Points2D, span: int) -> LabelEvidence:
    """Doubt points (n, P) that stay high for longer than a swing, or lie below the ground."""
    known = height[np.isfinite(height)]
    ground = float(np.percentile(known, 15.0)) if len(known) else np.nan
    _, spread = _robust_level(height)
    filled = np.where(np.isnan(height), np.inf, height)
    lowest = minimum_filter1d(filled, 2 * span + 1, axis=0, mode="nearest")
    lowest = np.where(np.isfinite(height), lowest, np.nan)
    high = _doubt(lowest, ground + spread, spread)
    low = _doubt(ground - height, 2.0 * spread, spread)
    score = _WEAK * np.maximum(high, low)

    def words(key: tuple[int, int, int]) -> str:
        t, _, p = key
        if low[t, p] > high[t, p]:
            return "it is below the ground on which the others stand"
        return "it does not touch the ground for longer than a step takes"

    return LabelEvidence(in_views(score, uv), words)


def in_views(score: FloatArray, uv: Points2D) -> FloatArray:
    """Give the score of a point in space to each view that has a label of it.

    Parameters
    ----------
    score : ndarray, shape (n, P)
        One score for all views.
    uv : ndarray, shape (n, V, P, 2)
        Image positions, NaN where there is no label.
    """
    return np.where(np.isfinite(uv[..., 0]), score[:, None, :], 0.0)


def passes_disagree(tracks: Tracks, other: Tracks) -> LabelEvidence:
    """Doubt labels far from where another pass through the recording put them.

    Parameters
    ----------
    tracks, other : xarray.Dataset
        Both passes.

    Raises
    ------
    InputError
        If both share no view and point.
    """
    away = distance_between(tracks, other)
    usual, spread = _robust_level(away)
    score = _doubt(away, usual, max(spread, 1.0) if np.isfinite(spread) else spread)

    def words(key: tuple[int, int, int]) -> str:
        return f"two passes through the recording disagree by {away[key]:.0f} px"

    return LabelEvidence(score, words)


def distance_between(tracks: Tracks, other: Tracks) -> FloatArray:
    """Return how far apart (n, V, P), px, two passes through a recording put each label.

    Parameters
    ----------
    tracks, other : xarray.Dataset
        Both passes.

    Returns
    -------
    ndarray
        For the frames, views and points of ``tracks``; NaN where either has no label.

    Raises
    ------
    InputError
        If both share no view and point.
    """
    names = ("view", "keypoint")
    shared = {name: [x for x in tracks[name].to_numpy() if x in other[name].to_numpy()]
              for name in names}  # fmt: skip
    if "image_position" not in other or not all(shared.values()):
        raise InputError(
            "the other tracks share no view and point with these; give tracks of the same trial."
        )
    there = (
        other["image_position"]
        .isel(individual=0)
        .swap_dims(time="frame")
        .reindex(
            frame=tracks["frame"].to_numpy(),
            view=tracks["view"].to_numpy(),
            keypoint=tracks["keypoint"].to_numpy(),
        )
        .transpose("frame", "view", "keypoint", "image_space")
        .to_numpy()
    )
    return np.asarray(np.linalg.norm(there - image_positions(tracks), axis=-1))
