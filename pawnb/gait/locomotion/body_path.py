"""Where the body of an animal is that nobody named points of, and whether it runs on a belt.

A belt carries back every foot that stands on it; the ground carries none. And an animal on a
belt that falls back and catches up again moves its feet through the picture by more than a
stride does: then they must be seen from something that moves with it. Several such paths are
tried, and the one in which most of the recording is regular strides is taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.time_scales import least_excursion, least_excursions
from pawnb.kinematics import main_axis, smooth_path
from pawnb.signals import butterworth_lowpass, fill_gaps, fill_gaps_of_points, find_turns

Source = Literal["laboratory", "points", "feet"]

SLOW = 1 / 3
"""Low-pass of a path that takes no part in the strides, in stride frequencies."""

_TRIED: tuple[tuple[Source, float], ...] = (
    ("points", 3.0), ("points", 1.0), ("feet", SLOW), ("feet", 0.5),
)  # fmt: skip
"""Paths and their low-passes, in stride frequencies, the better ones first. Points of the body may
follow what it does in a stride; the mean of the feet must not, for it moves as they do."""

_CLEARLY = 0.05
"""A path is clearly better when it makes more of the recording regular strides by this share."""

_REGULAR = 1.5
"""A stride is regular when it lasts between the usual time divided and multiplied by this."""

_OF_THE_BODY = 0.5
"""Points are of the body where, against the feet, they swing and go astray by less than this."""

_CARRIED = 0.5
"""Share of its speed against the body at which a carried foot goes through the picture: 1 on a
belt, 0 on the ground, and below that where an ankle is tracked, which goes on with the body."""

_ROAMS = 4.0
"""Width of a path in distances of the feet from the body (by hand). Measured: a mouse in an open
field 9.7, a made insect on a circle of 10 mm 10; four rats on a belt 0.00 to 0.19, a fly on a ball
0.10."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyPath:
    """A path that feet can be seen from.

    Parameters
    ----------
    source : {"laboratory", "points", "feet"}
        What it is made of: nothing, other tracked points, or the mean of the feet.
    band : float
        Its low-pass, in stride frequencies.
    regular : float
        Share of the recording, over all feet, that is regular strides when seen from it.
    """

    source: Source
    band: float = SLOW
    regular: float = 0.0


def follow_body(
    feet: FootPaths,
    chosen: BodyPath,
    others: FootPaths | None,
    *,
    frequency_hz: float,
    fs_hz: float,
) -> FloatArray:
    """Compute a path of the body.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    chosen : BodyPath
        Of what the path is made.
    others : FootPaths or None
        Points that move with the body.
    frequency_hz : float
        Stride frequency; NaN where unknown, and then 1 Hz is assumed.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    ndarray, shape (n, d)
        The low-passed mean of the other points, or of the feet.
    """
    stride = frequency_hz if math.isfinite(frequency_hz) else 1.0
    points = others if chosen.source == "points" and others is not None else feet
    cutoff = min(chosen.band * stride, 0.4 * fs_hz)
    return smooth_path(points.positions, cutoff_hz=cutoff, fs_hz=fs_hz)


def choose_body_path(
    feet: FootPaths,
    others: FootPaths | None,
    settings: EventSettings,
    *,
    forward: FloatArray,
    frequency_hz: float,
    fs_hz: float,
) -> BodyPath:
    """Choose what the feet of an animal on a belt are seen from.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    others : FootPaths or None
        Points that move with the body; see :func:`points_of_body`.
    settings : EventSettings
        Settings.
    forward : ndarray, shape (d,)
        Direction towards the front.
    frequency_hz : float
        Stride frequency; NaN where unknown.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    BodyPath
        The laboratory, unless another path makes clearly more of the recording regular
        strides; then the first, other points before feet, that comes near the best.
    """
    unit = forward / np.linalg.norm(forward)
    share = _regular_share(feet.positions, unit, settings)
    laboratory = BodyPath(source="laboratory", regular=share)
    if not math.isfinite(frequency_hz):
        return laboratory
    tried = []
    for source, band in _TRIED:
        if source == "points" and others is None:
            continue
        if source == "feet" and band != SLOW and settings.body_cutoff_hz is not None:
            continue  # the low-pass of the feet's mean is what was asked for
        one = BodyPath(source=source, band=band)
        path = follow_body(feet, one, others, frequency_hz=frequency_hz, fs_hz=fs_hz)
        share = _regular_share(feet.positions - path[:, :, None], unit, settings)
        tried.append(replace(one, regular=share))
    best = max(one.regular for one in tried)
    if best <= (1.0 + _CLEARLY) * laboratory.regular:
        return laboratory
    return next(one for one in tried if one.regular >= (1.0 - _CLEARLY) * best)


def points_of_body(
    feet: FootPaths, others: FootPaths | None, *, frequency_hz: float, fs_hz: float
) -> FootPaths | None:
    """Choose of other tracked points those that move with the body.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    others : FootPaths or None
        Points that are no feet, in the same space.
    frequency_hz : float
        Stride frequency; NaN where unknown.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    FootPaths or None
        Those that are seen at least half as often as a foot, move within a stride by less than
        half of what the feet do (an ankle moves more), and follow the slow path of the feet to
        within half of its extent or of theirs (a corner of the belt does not, where the
        animal drifts). None where there are none.
    """
    if others is None or not math.isfinite(frequency_hz):
        return None
    slow = _slow(feet.positions, frequency_hz, fs_hz)
    swing = float(np.median(_spread(feet.positions - slow)))
    way = smooth_path(feet.positions, cutoff_hz=SLOW * frequency_hz, fs_hz=fs_hz)[:, :, None]
    most = _OF_THE_BODY * max(float(_spread(way)[0]), swing)
    path = _slow(others.positions, frequency_hz, fs_hz)
    often, feet_often = (
        np.isfinite(x).all(axis=1).sum(axis=0) for x in (others.positions, feet.positions)
    )
    seen = often >= 0.5 * np.median(feet_often)
    moves = _spread(others.positions - path)
    kept = np.flatnonzero(seen & (moves < _OF_THE_BODY * swing) & (_spread(path - way) < most))
    if not len(kept):
        return None
    return replace(
        others, legs=tuple(others.legs[k] for k in kept), positions=others.positions[:, :, kept]
    )


def is_roaming(feet: FootPaths, path: FloatArray) -> bool:
    """Say whether an animal's path fills a plane, for which no treadmill has the room.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    path : ndarray, shape (n, d)
        Low-passed path of the body.

    Returns
    -------
    bool
        True if the path is wider across its main axis than four times the feet's distance from
        it (95th percentile, median of feet).
    """
    centred = path[np.isfinite(path).all(axis=1)]
    if len(centred) < 2:
        return False
    centred = centred - centred.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    from_body = np.linalg.norm(feet.positions - path[:, :, None], axis=1)
    reach = float(np.nanmedian(np.nanpercentile(from_body, 95, axis=0)))
    return bool(np.ptp(centred @ axes[1]) > _ROAMS * reach)


def is_carried(feet: FootPaths, path: FloatArray, settings: EventSettings) -> bool | None:
    """Say whether feet in stance are carried along by what they stand on, as by a belt.

    Parameters
    ----------
    feet : FootPaths
        The feet.
    path : ndarray, shape (n, d)
        Path of the body.
    settings : EventSettings
        Settings.

    Returns
    -------
    bool or None
        Whether, in that half of a stride in which they move least, feet go through the picture
        at more than half of their speed against the body: all of it on a belt, none on the
        ground. None where there are too few strides to tell.
    """
    relative = feet.positions - path[:, :, None]
    axis = main_axis(relative - np.nanmean(relative, axis=0))
    against, through = (np.einsum("ndk,d->nk", x, axis) for x in (relative, feet.positions))
    ratios: dict[int, list[float]] = {1: [], -1: []}
    for own, lab in zip(against.T, through.T, strict=True):
        least = least_excursion(own, settings)
        if not least > 0.0:
            continue
        own, lab = (fill_gaps(x, max_gap=len(x)) for x in (own, lab))
        turns = find_turns(own, min_excursion=least)
        for (a, kind), (b, _) in pairwise(turns.tolist()):
            quarter = (b - a) // 4
            first, last = a + quarter, b - quarter
            if own[first] != own[last]:
                ratios[kind].append((lab[last] - lab[first]) / (own[last] - own[first]))
    if min(len(one) for one in ratios.values()) < 2:
        return None
    return min(float(np.median(one)) for one in ratios.values()) > _CARRIED


def _regular_share(positions: FloatArray, forward: FloatArray, settings: EventSettings) -> float:
    """Return which share of the time of all feet is strides of about the usual time."""
    fore_aft = np.einsum("ndk,d->nk", positions, forward)
    times: list[float] = []
    for column, least in zip(fore_aft.T, least_excursions(fore_aft, settings), strict=True):
        if least > 0.0:
            turns = find_turns(fill_gaps(column, max_gap=len(column)), min_excursion=least)
            times += np.diff(turns[turns[:, 1] > 0, 0]).tolist()
    if not times:
        return 0.0
    lasted = np.array(times)
    usual = float(np.median(lasted))
    regular = (lasted > usual / _REGULAR) & (lasted < usual * _REGULAR)
    return float(lasted[regular].sum() / fore_aft.size)


def _slow(positions: FloatArray, frequency_hz: float, fs_hz: float) -> FloatArray:
    """Return each point without what it does in a stride, shape (n, d, k)."""
    filled = fill_gaps_of_points(positions, max_gap=len(positions))
    return butterworth_lowpass(filled, cutoff_hz=min(SLOW * frequency_hz, 0.4 * fs_hz), fs_hz=fs_hz)


def _spread(positions: FloatArray) -> FloatArray:
    """Return the standard deviation, over all directions, of each point; shape (k,)."""
    out = np.full(positions.shape[2], np.inf)
    seen = np.isfinite(positions).any(axis=0).all(axis=0)
    out[seen] = np.sqrt(np.nanvar(positions[:, :, seen], axis=0).sum(axis=0))
    return out
