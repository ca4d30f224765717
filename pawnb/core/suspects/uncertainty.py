"""What speaks against the tracks of a tracker that decides over the whole recording.

Such tracks are smooth and their views agree, also where they are wrong: jumps and residuals tell
little. They carry their uncertainty (``sd``) instead, and what they say of themselves tells
more: points that are hardly recognised for a while, that are only vaguely known, that another
point passes, that are not where they are at the same moment of other strides, that were
moved once the stride was known, whose candidates are hardly ahead of others, or that a pass
forwards through the recording expects elsewhere than one backwards. Most errors are brief
and happen where a paw lifts off or lands beside another.

Everything is measured in sizes of a paw, shares and paces, so that one set of curves serves
all recordings (:mod:`pawnb.core.suspects.rates`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.maghsoudi2019.settings import Maghsoudi2019Settings
from pawnb.core.paws.offline.association.network_flow.priors.positional_prior import follow_body
from pawnb.core.paws.offline.landmarks.tracks import choose_landmarks
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.stride.cycle import learn_cycle
from pawnb.core.rig import Rig
from pawnb.core.suspects.evidence import PAW_SHARE, distance_between, find_nearest, image_positions
from pawnb.schema import ORIGIN_CODE, Tracks

_WHILE_S = 0.035
"""Time over which confidence is averaged: a third of a mouse's shortest stride."""
_SOON_S = 0.02
"""So long before and after is looked at whether a point stands or swings."""
_FASTEST = 1.5
"""Speeds beyond this many times that of the fast tenth count no more."""
_SIZE_SD = 12.0
"""Usual standard deviations of a place in the size of a paw, where there is one point only."""
_VAGUE_STRIDE = 4.0
"""Tracks this many times vaguer than usual count half where the stride is learnt."""
_PLAIN_ODDS = 1000
"""Odds above this are not written out."""


@dataclass(frozen=True)
class Doubt:
    """One reason to doubt points.

    Parameters
    ----------
    measures : mapping
        What was measured, (n, P) each, by the names of the curves that weigh it; NaN where
        it is not known.
    words : callable
        ``words(row, point)`` says it.
    is_circumstance : bool
        Whether it says when errors happen rather than what is wrong.
    """

    measures: Mapping[str, np.ndarray]
    words: Callable[[int, int], str]
    is_circumstance: bool = False


def states_uncertainty(tracks: Tracks) -> bool:
    """Tell whether tracks carry the uncertainty of their positions."""
    return "sd" in tracks and bool(np.isfinite(tracks["sd"].to_numpy()).any())


def collect_doubts(
    tracks: Tracks, *, rig: Rig | None, other: Tracks | None, paw_px: float | None
) -> list[Doubt]:
    """Measure every reason to doubt tracks that state their uncertainty.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions and ``sd``.
    rig : Rig, optional
        The calibrated views: what is forward and up.
    other : xarray.Dataset, optional
        Tracks of the same recording made another way.
    paw_px : float, optional
        Size of a paw in px.

    Returns
    -------
    list of Doubt
        In a fixed order.

    Raises
    ------
    InputError
        If ``other`` shares no view and point with the tracks.
    """
    uv = image_positions(tracks)
    size = paw_size(tracks)
    near, who, size_px = find_nearest(uv, paw_px)
    points = tracks["keypoint"].to_numpy().tolist()
    # an ear is always near the other one, and never lifts off
    marks = choose_landmarks(points, [Maghsoudi2019Settings().kind(point) for point in points])
    return [
        _hardly_recognised(tracks),
        _vague(tracks, size),
        _decided_otherwise(tracks, size),
        _not_separated(tracks),
        _passes_apart(tracks),
        *([] if other is None else [_passes_disagree(tracks, other, size_px)]),
        _off_cycle(tracks, rig),
        _crossing(np.where(marks, np.nan, near / size_px[:, None]), near, who, points),
        _starting_and_stopping(tracks, marks),
    ]


def paw_size(tracks: Tracks) -> float:
    """Return about the size of a paw: a quarter of the usual distance between two points.

    A single point has none; then it is as large as is usual for the standard deviation.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    float
        In the unit of space; NaN where nothing is known.
    """
    x = positions(tracks)
    away = np.linalg.norm(x[:, :, None] - x[:, None], axis=-1)
    pairs = away[:, *np.triu_indices(x.shape[1], 1)]
    known = pairs[np.isfinite(pairs) & (pairs > 0)]
    if len(known):
        return PAW_SHARE * float(np.median(known))
    return _SIZE_SD * _usual(_uncertainty(tracks))


def _usual(values: FloatArray) -> float:
    """Return the median of what is known."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.nan


def recognised(tracks: Tracks) -> BoolArray:
    """Return which labels (n, V, P) were found in the picture, or placed by hand."""
    origin = tracks["image_origin"].isel(individual=0).to_numpy()
    return np.asarray((origin == ORIGIN_CODE["measured"]) | (origin == ORIGIN_CODE["edited"]))


def positions(tracks: Tracks) -> FloatArray:
    """Return positions (n, P, d) of the first individual.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.

    Returns
    -------
    ndarray
        In the unit of space; NaN where nothing is known.
    """
    return np.moveaxis(tracks["position"].isel(individual=0).to_numpy(), 1, -1)


def _uncertainty(tracks: Tracks) -> FloatArray:
    """Return the standard deviations (n, P) of positions, over all directions together."""
    sd = tracks["sd"].isel(individual=0).to_numpy()
    return np.asarray(np.sqrt(np.square(sd).sum(axis=1)))


def _hardly_recognised(tracks: Tracks) -> Doubt:
    """Doubt points of which no view is sure for a while."""
    seen = recognised(tracks)
    count = seen.sum(axis=1)
    confidence = tracks["image_confidence"].isel(individual=0).to_numpy()
    confidence = np.where(seen, confidence, 0.0).sum(axis=1) / np.maximum(count, 1)
    # a point that is out of sight is neither right nor wrong
    unsure = np.where(count > 0, 1.0 - confidence, 0.5)
    frames = max(1, round(_WHILE_S * float(tracks.attrs["fps"])))
    lasting = uniform_filter1d(unsure, frames, axis=0, mode="nearest")

    def words(t: int, p: int) -> str:
        if count[t, p] == 0:
            return "no view shows it and it is only predicted"
        return f"it is hardly recognised here (confidence {1.0 - lasting[t, p]:.2f})"

    return Doubt({"unrecognised": lasting}, words)


def _vague(tracks: Tracks, size: float) -> Doubt:
    """Doubt points that are only vaguely known."""
    sd = _uncertainty(tracks)
    usual, unit = _usual(sd), tracks.attrs["units"]

    def words(t: int, p: int) -> str:
        return f"its place is only known to {sd[t, p]:.1f} {unit} (usually {usual:.1f})"

    with np.errstate(divide="ignore"):
        return Doubt({"vague": np.log(sd / size)}, words)


def _decided_otherwise(tracks: Tracks, size: float) -> Doubt:
    """Doubt points that the tracker moved when it knew the stride."""
    moved = np.full(tracks["confidence"].isel(individual=0).shape, np.nan)
    if "revision" in tracks:
        moved = tracks["revision"].isel(individual=0).to_numpy()
    unit = tracks.attrs["units"]

    def words(t: int, p: int) -> str:
        return f"a first look, before the stride was known, had it {moved[t, p]:.1f} {unit} away"

    return Doubt({"revision": moved / size}, words)


def _not_separated(tracks: Tracks) -> Doubt:
    """Doubt points for which another candidate of some view fits about as well."""
    names = ("time", "view", "keypoint")
    each = np.full(tuple(tracks.sizes[name] for name in names), np.nan)
    if "image_separation" in tracks:
        each = tracks["image_separation"].isel(individual=0).transpose(*names).to_numpy()
    worst = np.where(np.isnan(each), np.inf, each).argmin(axis=1)
    least = np.take_along_axis(each, worst[:, None], axis=1)[:, 0]
    views = tracks["view"].to_numpy().tolist()

    def words(t: int, p: int) -> str:
        view, odds = views[worst[t, p]], np.exp(abs(least[t, p]))
        ratio = f"{odds:.0f} to 1" if odds < _PLAIN_ODDS else f"over {_PLAIN_ODDS} to 1"
        if least[t, p] < 0:
            return f"in {view} another candidate fits it better by itself ({ratio})"
        return f"in {view} its candidate is little ahead of another ({ratio})"

    return Doubt({"separation": least}, words)


def _passes_apart(tracks: Tracks) -> Doubt:
    """Doubt points that the frames before expect elsewhere than the frames after."""
    apart = np.full(tracks["confidence"].isel(individual=0).shape, np.nan)
    if "passes_apart" in tracks:
        apart = tracks["passes_apart"].isel(individual=0).to_numpy()
    usual = _usual(apart)

    def words(t: int, p: int) -> str:
        return (
            f"passes forwards and backwards are {apart[t, p]:.1f} standard deviations apart "
            f"(usually {usual:.1f})"
        )

    return Doubt({"apart": apart}, words)


def _passes_disagree(tracks: Tracks, other: Tracks, size_px: FloatArray) -> Doubt:
    """Doubt points that another pass put elsewhere: as a revision, and as one of two is wrong."""
    away = distance_between(tracks, other)
    share = away / size_px[:, None]
    known = np.isfinite(share).any(axis=1)
    worst = np.where(known, np.nan_to_num(share, nan=-1.0).argmax(axis=1), 0)
    most = np.take_along_axis(share, worst[:, None], axis=1)[:, 0]

    def words(t: int, p: int) -> str:
        return f"two passes through the recording disagree by {away[t, worst[t, p], p]:.0f} px"

    return Doubt({"revision": most, "passes": most}, words)


def _off_cycle(tracks: Tracks, rig: Rig | None) -> Doubt:
    """Doubt points that are not where they usually are at that moment."""
    away, off = off_cycle(tracks, rig)
    unit = tracks.attrs["units"]

    def words(t: int, p: int) -> str:
        return f"it is {off[t, p]:.1f} {unit} from where it is in other strides"

    return Doubt({"off_cycle": away}, words)


def off_cycle(tracks: Tracks, rig: Rig | None) -> tuple[FloatArray, FloatArray]:
    """Measure how far points are from where they are at the same moment of other strides.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with positions and ``sd``.
    rig : Rig, optional
        The calibrated views.

    Returns
    -------
    ndarray, shape (n, P)
        Distances in standard deviations of the stride; NaN for all where the points do not
        move in cycles, and for points seen too rarely.
    ndarray, shape (n, P)
        The same in the unit of space.
    """
    x = positions(tracks)
    n, n_points, d = x.shape
    away = np.full((n, n_points), np.nan)
    off = away.copy()
    often = np.isfinite(x[..., 0]).mean(axis=0) > 0.5
    if not often.any():
        return away, off
    x = x[:, often]
    axes = np.eye(d)
    if d == 3 and rig is not None:
        forward, up = np.asarray(rig.forward, float), np.asarray(rig.up, float)
        axes = np.stack([forward, np.cross(up, forward), up])
    sd = _uncertainty(tracks)[:, often]
    usual = _usual(sd)
    if not usual > 0:
        return away, off
    fps, usually = float(tracks.attrs["fps"]), OfflineSettings()
    cycle = learn_cycle(
        x, follow_body(x, max(1, round(2.0 * usually.body_s * fps))), axes=axes,
        frames=(usually.shortest_stride_s * fps, usually.longest_stride_s * fps), noise=usual / 2.0,
        trust=np.nan_to_num(1.0 / (1.0 + (sd / (_VAGUE_STRIDE * usual)) ** 2)),
    )  # fmt: skip
    if cycle is not None:
        rows = np.arange(n)
        for k, p in enumerate(np.flatnonzero(often).tolist()):
            away[:, p] = np.sqrt(cycle.square(rows, k, x[:, k]))
            off[:, p] = np.linalg.norm(x[:, k] - cycle.mean[:, k], axis=-1)
    return away, off


def _crossing(share: FloatArray, near: FloatArray, who: IntArray, points: list[str]) -> Doubt:
    """Doubt points that are close to another point in some view."""
    filled = np.where(np.isfinite(share), share, np.inf)
    closest = filled.argmin(axis=1)
    least = np.take_along_axis(filled, closest[:, None], axis=1)[:, 0]

    def words(t: int, p: int) -> str:
        v = closest[t, p]
        return f"it is {near[t, v, p]:.0f} px from {points[who[t, v, p]]}: they may be mistaken"

    return Doubt({"near": np.where(np.isfinite(least), least, np.nan)}, words)


def _starting_and_stopping(tracks: Tracks, marks: BoolArray) -> Doubt:
    """Doubt paws that are about to lift off, or have just landed; ``marks`` (P,) are none."""
    pace = np.where(marks, np.nan, _pace(tracks, marks))
    rows = np.arange(len(pace), dtype=float)
    soon = _SOON_S * float(tracks.attrs["fps"])
    before, after = (
        np.stack([np.interp(rows + step, rows, column) for column in pace.T], axis=1)
        for step in (-soon, soon)
    )

    def words(t: int, p: int) -> str:
        return "it lifts off about here" if after[t, p] > before[t, p] else "it lands about here"

    measures = {"pace_before": before, "pace": pace, "pace_after": after}
    return Doubt(measures, words, is_circumstance=True)


def _pace(tracks: Tracks, marks: BoolArray) -> FloatArray:
    """Return how fast points (n, P) move from the ground, 1 where a tenth of paws are faster."""
    x = positions(tracks)
    frames = tracks["frame"].to_numpy().astype(float)
    if len(frames) < 2:
        return np.zeros(x.shape[:2])
    velocity = np.gradient(x, frames, axis=0)
    known = np.isfinite(velocity).all(axis=-1) & ~marks
    if not known.any():
        return np.zeros(x.shape[:2])
    # standing paws go with the ground, and most paws stand
    speed = np.linalg.norm(velocity - np.median(velocity[known], axis=0), axis=-1)
    fast = float(np.percentile(speed[known], 90.0))
    if not fast > 0:
        return np.zeros(x.shape[:2])
    return np.minimum(np.where(known, speed, 0.0) / fast, _FASTEST)
