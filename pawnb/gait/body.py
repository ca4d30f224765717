"""The body of one animal: what it runs on, its frame, its bouts, and the scales of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.gait.bouts import Bouts, find_bouts
from pawnb.gait.direction import choose_direction, find_up
from pawnb.gait.event_settings import EventSettings
from pawnb.gait.paths import FootPaths
from pawnb.gait.scales import Scales, choose_scales, say_scales, stepping_frequency
from pawnb.kinematics import (
    BodyFrame,
    body_frame_from_points,
    body_frame_of_feet,
    is_travelling,
    is_wandering,
    smooth_path,
    stride_frequency,
)
from pawnb.signals import dominant_frequency, find_runs
from pawnb.trial import Trial

_BODY_CUTOFF_STRIDES = 3.0
"""Low-pass of points of the body, in stride frequencies: a body moves twice in a stride, what is
faster is how well its points were tracked, and every foot would share it."""

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

    points: np.ndarray
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
    standing: np.ndarray
    from_points: bool
    notes: list[str]


def find_body(
    feet: FootPaths,
    fs: float,
    *,
    trial: Trial | None,
    belt: np.ndarray | None,
    body: BodyPoints | None,
    forward: np.ndarray | None,
    settings: EventSettings,
) -> FoundBody:
    """Find what the animal runs on, its body frame, its bouts, and the scales of time.

    The stride frequency is guessed from the spectrum first, which suffices for the path
    of the body; in the body's frame the steps can be counted.

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
    guess = _guess_frequency(feet, body, fs)
    scales = choose_scales(settings, guess, fs)
    path = smooth_path(feet.positions, cutoff_hz=scales.body_cutoff_hz, fs_hz=fs)
    treadmill = settings.substrate == "treadmill"
    if settings.substrate == "auto":
        wanders = body is not None and is_wandering(body.points)
        travels = wanders or is_travelling(feet.positions, path)
        treadmill = belt is not None or not travels
    direction = None
    if body is None:
        direction, said = choose_direction(
            feet, path, trial=trial, forward=forward, treadmill=treadmill, fs_hz=fs
        )
        notes += said
    frame = _frame(feet, trial, body, direction, scales, fs, treadmill=treadmill, stride_hz=guess)
    bouts = None
    if settings.bouts and not treadmill:
        bouts = _bouts(_body_speed(frame, guess, fs), settings, guess, fs)
    elif settings.bouts and belt is None:
        bouts = _bouts(_stepping_speed(feet, guess, fs), settings, guess, fs)
    standing = np.zeros(len(path), dtype=bool)
    for start, stop in bouts.pauses if bouts is not None else ():
        standing[start:stop] = True
    fore_aft = np.where(standing[:, None], np.nan, frame.fore_aft(feet.positions))
    frequency = stepping_frequency(fore_aft, settings, fs_hz=fs, guess=guess)
    scales = choose_scales(settings, frequency, fs)
    notes.append(say_scales(feet, scales, frequency))
    if bouts is not None and len(bouts.pauses):
        notes.append(_say_bouts(feet, bouts, standing, fs))
    frame = _frame(
        feet, trial, body, direction, scales, fs, treadmill=treadmill, stride_hz=frequency
    )
    return FoundBody(
        treadmill=treadmill,
        frame=frame,
        scales=scales,
        standing=standing,
        from_points=body is not None,
        notes=notes,
    )


def _usable(
    body: BodyPoints | None,
    belt: np.ndarray | None,
    forward: np.ndarray | None,
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


def _guess_frequency(feet: FootPaths, body: BodyPoints | None, fs: float) -> float:
    """Guess how often the feet step, in the body's frame where there is one."""
    if body is None:
        return stride_frequency(feet.positions, fs_hz=fs)
    frame = body_frame_from_points(body.points, cutoff_hz=None, fs_hz=fs)
    return dominant_frequency(frame.fore_aft(feet.positions), fs_hz=fs)


def _frame(
    feet: FootPaths,
    trial: Trial | None,
    body: BodyPoints | None,
    direction: np.ndarray | None,
    scales: Scales,
    fs: float,
    *,
    treadmill: bool,
    stride_hz: float,
) -> BodyFrame:
    """Return the body frame, from the body's points or else from the feet."""
    if body is not None:
        cutoff = _BODY_CUTOFF_STRIDES * (stride_hz if np.isfinite(stride_hz) else 1.0)
        return body_frame_from_points(
            body.points,
            cutoff_hz=cutoff if cutoff < 0.4 * fs else None,
            fs_hz=fs,
            up=find_up(trial, feet),
        )
    path = smooth_path(feet.positions, cutoff_hz=scales.body_cutoff_hz, fs_hz=fs)
    if direction is None:
        raise AssertionError("a body without points has a direction")
    return body_frame_of_feet(path, direction, treadmill=treadmill)


def _body_speed(frame: BodyFrame, frequency: float, fs: float) -> np.ndarray:
    """Return the speed of the body over the ground, smoothed over about a stride."""
    path = smooth_path(frame.path[:, :, None], cutoff_hz=0.5 * _stride_hz(frequency), fs_hz=fs)
    return np.asarray(np.linalg.norm(np.gradient(path, axis=0), axis=1) * fs)


def _stepping_speed(feet: FootPaths, frequency: float, fs: float) -> np.ndarray:
    """Return how fast the feet move on the whole, smoothed over about a stride.

    A belt that runs carries every foot that stands, so that all of them are never slow. Where
    they are, what the animal runs on stands with it, as a ball does under a tethered fly.
    """
    step = np.linalg.norm(np.diff(feet.positions, axis=0), axis=1) * fs
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


def _bouts(speed: np.ndarray, settings: EventSettings, frequency: float, fs: float) -> Bouts:
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


def _say_bouts(feet: FootPaths, bouts: Bouts, standing: np.ndarray, fs: float) -> str:
    """Put the bouts in one sentence."""
    going = float((~standing).sum()) / fs
    n = len(find_runs(~standing))
    bout = "bout" if n == 1 else "bouts"
    return (
        f"{feet.label}: {n} {bout} of locomotion, {going:.3g} of {len(standing) / fs:.3g} s: "
        f"faster than {bouts.start_speed:.3g} {feet.unit}/s until slower than "
        f"{bouts.stop_speed:.3g}; strides that reach into a pause are dropped."
    )
