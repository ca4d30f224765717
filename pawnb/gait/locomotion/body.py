"""The body of one animal: what it runs on, its frame, its bouts, and the scales of time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.locomotion.body_path import (
    SLOW,
    BodyPath,
    choose_body_path,
    follow_body,
    is_carried,
    is_roaming,
    points_of_body,
)
from pawnb.gait.locomotion.direction import choose_direction, doubt_up, find_up
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.frequency_guess import guess_frequency
from pawnb.gait.locomotion.time_scales import (
    Scales,
    choose_scales,
    say_scales,
    stepping_frequency,
    without_jitter,
)
from pawnb.gait.strides.bouts import Bouts, find_bouts
from pawnb.kinematics import (
    BodyFrame,
    body_frame_from_points,
    body_frame_of_path,
    is_travelling,
    is_wandering,
    smooth_path,
)
from pawnb.signals import find_runs
from pawnb.trial import Trial

_BODY_CUTOFF_STRIDES = 3.0
"""Low-pass of points of the body, in stride frequencies: a body moves twice in a stride, what is
faster is how well its points were tracked, and every foot would share it."""

_BODY_METHODS = {
    "laboratory": "laboratory",
    "points": "other points",
    "feet": "mean of the feet",
}
"""What the body frame is called in the method of an event."""

_BOUT_STRIDES, _PAUSE_STRIDES = 2.0, 0.5
"""Shortest bout and shortest pause, in strides."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyPoints:
    """Points along the body in one space.

    Parameters
    ----------
    points : ndarray, shape (n, d, m)
        Rear to front; NaN where missing.
    names : tuple of str
        Their names.
    guessed : bool
        Whether they were guessed from their names; such points are used only where the
        animal wanders, so that its heading turns.
    """

    points: FloatArray
    names: tuple[str, ...]
    guessed: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundBody:
    """What is found of the body before its feet are looked at one by one.

    Parameters
    ----------
    treadmill : bool
        Whether the animal runs on a treadmill.
    frame : BodyFrame
        Origin and heading at every sample.
    scales : Scales
        Cut-offs and times.
    standing : ndarray of bool, shape (n,)
        Samples in which an animal on the ground does not get on.
    from_points : bool
        Whether the frame comes from points of the body, so that it tells right from left.
    notes : list of str
        What a reader should know.
    """

    treadmill: bool
    frame: BodyFrame
    scales: Scales
    standing: BoolArray
    from_points: bool
    notes: list[str]


def find_body(
    feet: FootPaths,
    fs: float,
    *,
    trial: Trial | None,
    belt: FloatArray | None,
    body: BodyPoints | None,
    others: FootPaths | None,
    forward: FloatArray | None,
    settings: EventSettings,
) -> FoundBody:
    """Find what the animal runs on, its body frame, its bouts, and the scales of time.

    The stride frequency is guessed from the spectrum first, which suffices for the path
    of the body; in the body's frame the steps can be counted. Where no point of the body is
    named and the animal drifts on its treadmill, other tracked points stand in for it, or else
    the mean of the feet (:mod:`pawnb.gait.locomotion.body_path`).

    Parameters
    ----------
    feet : FootPaths
        The feet of one space.
    fs : float
        Samples per second.
    trial : Trial or None
        Description of the trial.
    belt : ndarray, shape (n,), or None
        Belt speed; None where unknown.
    body : BodyPoints or None
        Points along the body.
    others : FootPaths or None
        Tracked points that are no feet.
    forward : ndarray, shape (d,), or None
        Direction stated by the caller.
    settings : EventSettings
        Settings.

    Returns
    -------
    FoundBody
        The findings.
    """
    notes: list[str] = []
    body = _usable(body, belt, forward, feet, notes)
    guess = guess_frequency(feet, body=None if body is None else body.points, fs_hz=fs)
    scales = choose_scales(settings, guess, fs)
    path = smooth_path(feet.positions, cutoff_hz=scales.body_cutoff_hz, fs_hz=fs)
    others = points_of_body(feet, others, frequency_hz=guess, fs_hz=fs)
    treadmill = settings.substrate == "treadmill"
    if settings.substrate == "auto":
        treadmill = belt is not None or _runs_on_a_belt(
            feet, body, others, path, settings, guess, fs
        )
    direction, seen_from = None, BodyPath(source="feet")
    if body is None:
        direction, said = choose_direction(
            _without_drift(feet, others, guess, fs) if treadmill else feet,
            path, trial=trial, forward=forward, treadmill=treadmill,
            cutoff_hz=scales.body_cutoff_hz, fs_hz=fs,
        )  # fmt: skip
        notes += said
        if treadmill:
            seen_from = choose_body_path(
                feet, others, settings, forward=direction, frequency_hz=guess, fs_hz=fs
            )
            notes += _say_path(feet, seen_from, others)
    notes += doubt_up(feet, path, up=find_up(trial, feet), treadmill=treadmill, forward=direction)
    given = _Given(
        feet=feet, trial=trial, body=body, others=others, direction=direction, path=seen_from, fs=fs
    )
    frame = _frame(given, scales, stride_hz=guess)
    bouts = None
    if settings.bouts and not treadmill:
        bouts = _bouts(_body_speed(frame, guess, fs), settings, guess, fs)
    elif settings.bouts and (belt is None or _stops(belt, settings)):
        bouts = _bouts(_stepping_speed(feet, guess, fs), settings, guess, fs)
    standing = _standing(bouts, len(path))
    fore_aft = np.where(standing[:, None], np.nan, frame.fore_aft(feet.positions))
    frequency = stepping_frequency(fore_aft, settings, fs_hz=fs, guess=guess)
    scales = choose_scales(settings, frequency, fs)
    notes.append(say_scales(feet, scales, frequency))
    if bouts is not None and len(bouts.pauses):
        notes.append(_say_bouts(feet, bouts, standing, fs))
    frame = _frame(given, scales, stride_hz=frequency)
    return FoundBody(
        treadmill=treadmill,
        frame=frame,
        scales=scales,
        standing=standing,
        from_points=body is not None,
        notes=notes,
    )


def _stops(belt: FloatArray, settings: EventSettings) -> bool:
    """Say whether a belt of stated speed stops on its way; one that runs keeps an animal going."""
    fast = float(np.percentile(np.abs(belt), 95))
    return bool(np.abs(belt).min() < settings.bout_stop_fraction * fast)


def _standing(bouts: Bouts | None, n: int) -> BoolArray:
    """Say in which of n samples the animal pauses."""
    standing = np.zeros(n, dtype=bool)
    for start, stop in bouts.pauses if bouts is not None else ():
        standing[start:stop] = True
    return standing


def _usable(
    body: BodyPoints | None,
    belt: FloatArray | None,
    forward: FloatArray | None,
    feet: FootPaths,
    notes: list[str],
) -> BodyPoints | None:
    """Return the body's points where they are to be used, and say so where they were guessed."""
    if body is None or not body.guessed:
        return body
    if belt is not None or forward is not None or not is_wandering(body.points):
        return None
    rear, front = body.names
    notes.append(
        f"{feet.label}: the animal wanders; its heading is taken from {rear!r} to {front!r}. "
        "Name others in [animal] body."
    )
    return body


@dataclass(frozen=True, kw_only=True, eq=False)
class _Given:
    """What the body frame is made from."""

    feet: FootPaths
    trial: Trial | None
    body: BodyPoints | None
    others: FootPaths | None
    direction: FloatArray | None
    path: BodyPath
    fs: float


def _frame(given: _Given, scales: Scales, *, stride_hz: float) -> BodyFrame:
    """Return the body frame: from the body's points, from other points, or from the feet."""
    feet, fs, chosen = given.feet, given.fs, given.path
    if given.body is not None:
        cutoff = _BODY_CUTOFF_STRIDES * (stride_hz if np.isfinite(stride_hz) else 1.0)
        return body_frame_from_points(
            given.body.points,
            cutoff_hz=cutoff if cutoff < 0.4 * fs else None,
            fs_hz=fs,
            up=find_up(given.trial, feet),
        )
    if given.direction is None:
        raise AssertionError("a body without points has a direction")
    if chosen.source == "points" or chosen.band != SLOW:
        path = follow_body(feet, chosen, given.others, frequency_hz=stride_hz, fs_hz=fs)
    else:
        path = smooth_path(feet.positions, cutoff_hz=scales.body_cutoff_hz, fs_hz=fs)
    if chosen.source == "points":
        path = path + _from_points_to_feet(path, feet)
    return body_frame_of_path(
        path,
        given.direction,
        at_rest=chosen.source == "laboratory",
        method=_BODY_METHODS[chosen.source],
    )


def _from_points_to_feet(path: FloatArray, feet: FootPaths) -> FloatArray:
    """Return the mean way from a path to the mean of the feet, so that their places are about 0.

    Which points stand in for the body differs between recordings; where feet land must not.
    """
    ways = feet.positions - path[:, :, None]
    each = [way[np.isfinite(way).all(axis=1)] for way in np.moveaxis(ways, 2, 0)]
    means = [way.mean(axis=0) for way in each if len(way)]
    return np.asarray(np.mean(means, axis=0)) if means else np.zeros(path.shape[1])


def _runs_on_a_belt(
    feet: FootPaths,
    body: BodyPoints | None,
    others: FootPaths | None,
    path: FloatArray,
    settings: EventSettings,
    stride_hz: float,
    fs: float,
) -> bool:
    """Say whether an animal of which no belt speed is known runs on a treadmill or ball."""
    if is_roaming(feet, path) or (body is not None and is_wandering(body.points)):
        return False
    if body is not None:
        others = FootPaths(
            source=feet.source, unit=feet.unit, legs=body.names, positions=body.points
        )
    moving = path
    if others is not None:
        points = BodyPath(source="points", band=1.0)
        moving = follow_body(feet, points, others, frequency_hz=stride_hz, fs_hz=fs)
    # jitter goes through the picture as it goes against the body: as if it were carried
    calm = without_jitter(feet.positions, frequency_hz=stride_hz, fs_hz=fs)
    carried = is_carried(replace(feet, positions=calm), moving, settings)
    return not is_travelling(feet.positions, path) if carried is None else carried


def _without_drift(
    feet: FootPaths, others: FootPaths | None, stride_hz: float, fs: float
) -> FootPaths:
    """Return the feet as they move against the slow path of the body."""
    slow = BodyPath(source="feet" if others is None else "points")
    path = follow_body(feet, slow, others, frequency_hz=stride_hz, fs_hz=fs)
    return replace(feet, positions=feet.positions - path[:, :, None])


def _say_path(feet: FootPaths, chosen: BodyPath, others: FootPaths | None) -> list[str]:
    """Say what the feet are seen from where it is not the laboratory."""
    if chosen.source == "laboratory":
        return []
    what = "the slow mean of the feet"
    if chosen.source == "points" and others is not None:
        what = ", ".join(repr(name) for name in others.legs)
    return [
        f"{feet.label}: the animal drifts in the picture, as on a treadmill or before a camera "
        f"that follows it; the feet are seen from {what} "
        f"(low-pass {chosen.band:.2g} of the stride frequency), which makes "
        f"{chosen.regular:.0%} of the recording regular strides. Name points of the body, rear to "
        "front, in [animal] body to choose others."
    ]


def _body_speed(frame: BodyFrame, frequency: float, fs: float) -> FloatArray:
    """Return the speed of the body over the ground, smoothed over about a stride."""
    path = smooth_path(frame.path[:, :, None], cutoff_hz=0.5 * _stride_hz(frequency), fs_hz=fs)
    return np.asarray(np.linalg.norm(np.gradient(path, axis=0), axis=1) * fs)


def _stepping_speed(feet: FootPaths, frequency: float, fs: float) -> FloatArray:
    """Return how fast the feet move on the whole, smoothed over about a stride.

    A belt that runs carries every foot that stands, so that all of them are never slow. Where
    they are, what the animal runs on stands with it, as a ball does under a tethered fly.
    """
    calm = without_jitter(feet.positions, frequency_hz=frequency, fs_hz=fs)
    calm = np.where(np.isfinite(feet.positions), calm, np.nan)
    step = np.linalg.norm(np.diff(calm, axis=0), axis=1) * fs
    known = np.isfinite(step)
    total = np.where(known, step, 0.0).sum(axis=1)
    count = known.sum(axis=1)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return smooth_path(
        np.append(mean, mean[-1:])[:, None, None], cutoff_hz=0.5 * _stride_hz(frequency), fs_hz=fs
    )[:, 0]


def _stride_hz(frequency: float) -> float:
    """Return the stride frequency, or 1 Hz where it is not known."""
    return frequency if np.isfinite(frequency) else 1.0


def _bouts(speed: FloatArray, settings: EventSettings, frequency: float, fs: float) -> Bouts:
    """Find the bouts in a smoothed speed."""
    stride_s = 1.0 / _stride_hz(frequency)
    return find_bouts(
        speed,
        fs_hz=fs,
        start_fraction=settings.bout_start_fraction,
        stop_fraction=settings.bout_stop_fraction,
        min_bout_s=_BOUT_STRIDES * stride_s,
        min_pause_s=_PAUSE_STRIDES * stride_s,
    )


def _say_bouts(feet: FootPaths, bouts: Bouts, standing: BoolArray, fs: float) -> str:
    """Put the bouts in one sentence."""
    going = float((~standing).sum()) / fs
    n = len(find_runs(~standing))
    bout = "bout" if n == 1 else "bouts"
    return (
        f"{feet.label}: {n} {bout} of locomotion, {going:.3g} of {len(standing) / fs:.3g} s: "
        f"faster than {bouts.start_speed:.3g} {feet.unit}/s until slower than "
        f"{bouts.stop_speed:.3g}; strides that reach into a pause are dropped."
    )
