"""Events of each foot: extreme positions, touch-down and lift-off.

Kernels on arrays of one foot. Samples are equally spaced; times are fractional
samples, which the caller turns into frames and seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from pawnb.errors import InputError
from pawnb.signals import find_turns, refine_extremum

_POSITIVE = (math.ulp(0.0), math.nextafter(math.inf, 0.0), "a number above 0")
_NOT_NEGATIVE = (0.0, math.nextafter(math.inf, 0.0), "0 or more")
_SHARE = (math.ulp(0.0), 1.0, "above 0 and at most 1")
_LIMITS = {
    "cutoff_hz": _POSITIVE,
    "body_cutoff_hz": _POSITIVE,
    "max_gap_s": _NOT_NEGATIVE,
    "min_excursion": _POSITIVE,
    "min_excursion_fraction": _SHARE,
    "min_stance_s": _NOT_NEGATIVE,
    "min_swing_s": _NOT_NEGATIVE,
    "max_stride_s": _POSITIVE,
    "contact_speed_fraction": (math.ulp(0.0), 0.45, "above 0 and at most 0.45"),
    "contact_height_fraction": _SHARE,
    "min_confidence": (0.0, 1.0, "0 to 1"),
    "bout_start_fraction": _SHARE,
    "bout_stop_fraction": _SHARE,
    "jump_factor": (1.0, math.nextafter(math.inf, 0.0), "1 or more, or null to keep jumps"),
}


@dataclass(frozen=True, kw_only=True)
class EventSettings:
    """Settings of the gait analysis.

    Times that are None follow the animal: they are set from its stride frequency,
    estimated from the feet, and are written in the notes.

    Parameters
    ----------
    cutoff_hz : float, optional
        Low-pass for the feet; default 10 times the stride frequency, and no filter where
        that is beyond 0.35 of the sampling rate.
    body_cutoff_hz : float, optional
        Low-pass for the mean of the feet as the path of the body; default a third of
        the stride frequency.
    max_gap_s : float, optional
        Longest gap in a track that is bridged; default a tenth of a stride.
    min_excursion : float, optional
        Least excursion between AEP and PEP, in the unit of the tracks; default
        ``min_excursion_fraction`` of the leg's usual excursion.
    min_excursion_fraction : float
        Share of the range from 5th to 95th percentile of the foot's position.
    min_stance_s, min_swing_s : float, optional
        Shortest stance and swing; default 0.06 of a stride.
    max_stride_s : float, optional
        Longest stride: longer ones are pauses and are dropped; default no limit.
    contact_speed_fraction : float
        A foot counts as landed when its speed relative to the ground or belt falls below
        this share of its peak in that swing.
    contact_height_fraction : float
        Share of the swing's usual height below which a foot can be in contact (3D).
    use_height : bool
        Whether the height of the foot is asked too (3D).
    min_confidence : float, optional
        Positions with a lower confidence count as missing; default 0.6 for tracks of
        DeepLabCut (its own cut-off), else 0.
    jump_factor : float, optional
        Positions that jump away and back within three frames, by steps this many times
        the usual large step (95th percentile), count as missing; None keeps them.
    substrate : {"auto", "treadmill", "ground"}
        What the animal runs on; ``auto``: a treadmill where a belt speed is known or
        the animal gets nowhere, else the ground.
    stride_events : {"auto", "AEP", "TD"}
        Event that begins a stride; ``auto``: AEP where there are any, else TD.
    bouts : bool
        Whether an animal on the ground that stops and goes is looked at in its bouts only; on
        a treadmill it has to keep going.
    bout_start_fraction, bout_stop_fraction : float
        A bout begins above the one and ends below the other share of the animal's fast speed
        (95th percentile).
    """

    cutoff_hz: float | None = None
    body_cutoff_hz: float | None = None
    max_gap_s: float | None = None
    min_excursion: float | None = None
    min_excursion_fraction: float = 0.3
    min_stance_s: float | None = None
    min_swing_s: float | None = None
    max_stride_s: float | None = None
    contact_speed_fraction: float = 0.2
    contact_height_fraction: float = 0.25
    use_height: bool = True
    min_confidence: float | None = None
    jump_factor: float | None = 3.0
    substrate: Literal["auto", "treadmill", "ground"] = "auto"
    stride_events: Literal["auto", "AEP", "TD"] = "auto"
    bouts: bool = True
    bout_start_fraction: float = 0.35
    bout_stop_fraction: float = 0.2

    def __post_init__(self) -> None:
        for name, (low, high, words) in _LIMITS.items():
            value = getattr(self, name)
            if value is not None and not (low <= value <= high):
                raise InputError(f"setting {name!r} is {value}; expected {words}.")
        if self.bout_stop_fraction > self.bout_start_fraction:
            raise InputError(
                f"bout_stop_fraction is {self.bout_stop_fraction:g}, above bout_start_fraction "
                f"{self.bout_start_fraction:g}; a bout ends at the lower speed."
            )


class Extreme(NamedTuple):
    """An extreme position of a foot.

    Attributes
    ----------
    sample : float
        When, in fractional samples.
    kind : int
        +1 anterior (AEP), -1 posterior (PEP).
    position : float
        Where, along forward.
    """

    sample: float
    kind: int
    position: float


class Rejected(NamedTuple):
    """A pair of extremes that was taken out again.

    Attributes
    ----------
    start, end : float
        Fractional samples of the two.
    why : str
        The reason, in words.
    """

    start: float
    end: float
    why: str


class Contact(NamedTuple):
    """A change of ground contact.

    Attributes
    ----------
    sample : float
        When, in fractional samples.
    kind : str
        ``"TD"`` or ``"LO"``.
    """

    sample: float
    kind: str


def find_extremes(
    position: np.ndarray, *, min_excursion: float, min_stance: float, min_swing: float
) -> tuple[list[Extreme], list[Rejected]]:
    """Find AEP and PEP in the fore-aft position of a foot.

    Turns of at least ``min_excursion`` on both sides are placed between samples by a
    parabola. Where a stance (AEP to PEP) or swing (PEP to AEP) is too short, the pair
    with the smallest excursion is taken out first; of its neighbours the further ones
    stay. Events alternate within every stretch without gap.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Position along forward; NaN where missing.
    min_excursion : float
        Least excursion, in the unit of ``position``.
    min_stance, min_swing : float
        Shortest stance and swing, in samples.

    Returns
    -------
    extremes : list of Extreme
        In order of time.
    rejected : list of Rejected
        What was too short.
    """
    extremes: list[Extreme] = []
    rejected: list[Rejected] = []
    turns = find_turns(position, min_excursion=min_excursion)
    missing = np.cumsum(~np.isfinite(position))
    for run in np.unique(missing[turns[:, 0]]):
        found = []
        for index, kind in turns[missing[turns[:, 0]] == run]:
            sample, value = refine_extremum(position, int(index))
            found.append(Extreme(sample, int(kind), value))
        kept, out = _remove_short(found, min_stance, min_swing)
        extremes += kept
        rejected += out
    return extremes, rejected


def _remove_short(
    found: list[Extreme], min_stance: float, min_swing: float
) -> tuple[list[Extreme], list[Rejected]]:
    """Take out pairs that follow each other too fast, smallest excursion first."""
    kept = list(found)
    out: list[Rejected] = []
    while True:
        short = [
            (abs(b.position - a.position), i)
            for i, (a, b) in enumerate(pairwise(kept))
            if b.sample - a.sample < (min_stance if a.kind > 0 else min_swing)
        ]
        if not short:
            return kept, out
        _, i = min(short)
        a, b = kept[i], kept[i + 1]
        what, least = ("stance", min_stance) if a.kind > 0 else ("swing", min_swing)
        lasted = b.sample - a.sample
        why = f"{what} of {lasted:.1f} frames is shorter than {least:.1f}"
        out.append(Rejected(a.sample, b.sample, why))
        before = kept[i - 1] if i > 0 else None
        after = kept[i + 2] if i + 2 < len(kept) else None
        if before is not None and b.kind * b.position > b.kind * before.position:
            kept[i - 1] = b
        if after is not None and a.kind * a.position > a.kind * after.position:
            kept[i + 2] = a
        del kept[i : i + 2]


def stance_velocity(velocity: np.ndarray, extremes: Sequence[Extreme]) -> float:
    """Measure how fast a foot moves in the middle of its stances.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Velocity along forward.
    extremes : sequence of Extreme
        AEP and PEP in order.

    Returns
    -------
    float
        Median velocity over the middle half of every stance; NaN without a stance.
    """
    parts = [part for _, part in _mid_stances(velocity, extremes)]
    return float(np.median(np.concatenate(parts))) if parts else math.nan


def stance_velocity_over_time(velocity: np.ndarray, extremes: Sequence[Extreme]) -> np.ndarray:
    """Measure how fast a foot moves in stance, from stance to stance.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Velocity along forward.
    extremes : sequence of Extreme
        AEP and PEP in order.

    Returns
    -------
    ndarray, shape (n,)
        Median velocity over the middle half of each stance, straight lines between; NaN
        without a stance.
    """
    found = [(middle, float(np.median(part))) for middle, part in _mid_stances(velocity, extremes)]
    if not found:
        return np.full(len(velocity), np.nan)
    middles, medians = np.array(found).T
    return np.asarray(np.interp(np.arange(len(velocity)), middles, medians))


def _mid_stances(
    velocity: np.ndarray, extremes: Sequence[Extreme]
) -> Iterator[tuple[float, np.ndarray]]:
    """Yield the middle of each stance and the known velocities in its middle half."""
    for a, b in pairwise(extremes):
        if a.kind > 0 and b.kind < 0:
            quarter = (b.sample - a.sample) / 4.0
            first, last = math.ceil(a.sample + quarter), math.floor(b.sample - quarter)
            part = velocity[first : last + 1]
            part = part[np.isfinite(part)]
            if len(part):
                yield (a.sample + b.sample) / 2.0, part


class Height(NamedTuple):
    """Height of a foot and what it means.

    Attributes
    ----------
    up : ndarray, shape (n,)
        Height.
    ground : float
        Its level in stance.
    limit : float
        How far above that level a foot can still be in contact.
    """

    up: np.ndarray
    ground: float
    limit: float


def measure_height(
    up: np.ndarray, extremes: Sequence[Extreme], *, fraction: float
) -> Height | None:
    """Find the height below which a foot can touch the ground.

    Parameters
    ----------
    up : ndarray, shape (n,)
        Height of the foot.
    extremes : sequence of Extreme
        AEP and PEP in order.
    fraction : float
        Share of the usual height of a swing.

    Returns
    -------
    Height or None
        Ground is the median height in stance. The limit is ``fraction`` of the median
        rise in swing, at least two standard deviations of the height in stance. None
        where the feet do not rise clear of that scatter (four standard deviations).
    """
    low: list[float] = []
    tops: list[float] = []
    for a, b in pairwise(extremes):
        part = up[math.ceil(a.sample) : math.floor(b.sample) + 1]
        part = part[np.isfinite(part)]
        if a.kind > 0:
            low += part.tolist()
        elif len(part):
            tops.append(float(part.max()))
    if len(low) < 4 or not tops:
        return None
    ground = float(np.median(low))
    scatter = 1.4826 * float(np.median(np.abs(np.array(low) - ground)))
    rise = float(np.median(tops)) - ground
    if not rise > 4.0 * scatter:
        return None
    return Height(up, ground, max(fraction * rise, 2.0 * scatter))


def find_contacts(
    speed: np.ndarray,
    extremes: Sequence[Extreme],
    *,
    fraction: float,
    rise: float = 2.0,
    height: Height | None = None,
) -> list[Contact]:
    """Find lift-off and touch-down about each swing from the foot's speed.

    From the fastest moment of a swing (PEP to AEP) one goes forwards to where the foot
    is slow (and low), and backwards likewise. A threshold alone would come early before
    landing and late after lift-off, because a foot slows down before it lands; so the
    passage of ``fraction`` and of twice that are both found, between samples, and the
    straight line through them is followed to zero. What differentiating and filtering
    alone would put between the two passages, were the landing abrupt, is taken off
    first, and the line is not followed beyond where the foot has come to rest (a
    quarter of ``fraction``). A stance never holds a swing, and the events alternate.

    Parameters
    ----------
    speed : ndarray, shape (n,)
        Speed of the foot forwards relative to the ground or belt.
    extremes : sequence of Extreme
        AEP and PEP in order.
    fraction : float
        Share of the swing's peak speed, below one half.
    rise : float
        How many samples an abrupt change of speed is spread over; two for central
        differences.
    height : Height, optional
        Height of the foot; the same is done with its limit.

    Returns
    -------
    list of Contact
        In order of time. A change that does not come before the foot moves on to its
        next extreme, or before a gap, is left out, and so is a swing that never gets faster
        than ``fraction`` of the usual peak: the foot is carried along on the ground.
    """
    contacts = []
    peaks = _swing_peaks(speed, extremes)
    usual = float(np.median([speed[peak] for peak in peaks.values()])) if peaks else 0.0
    for i, peak in peaks.items():
        if not speed[peak] > max(0.0, fraction * usual):
            continue  # it never went faster than a foot that has landed: no swing
        before = extremes[i - 1].sample if i > 0 else 0.0
        after = extremes[i + 2].sample if i + 2 < len(extremes) else len(speed) - 1.0
        for kind, stop, step in (("LO", math.floor(before), -1), ("TD", math.ceil(after), 1)):
            far, near, rest = (
                _first_below(_excess(speed, share * fraction * speed[peak], height, share),
                             peak, stop, step)
                for share in (2.0, 1.0, 0.25)
            )  # fmt: skip
            if near is None or far is None:
                continue
            further = max(0.0, abs(near - far) - fraction * rise)
            if rest is not None:
                further = min(further, abs(rest - near))
            contacts.append(Contact(float(np.clip(near + step * further, before, after)), kind))
    return contacts


def _swing_peaks(speed: np.ndarray, extremes: Sequence[Extreme]) -> dict[int, int]:
    """Return the fastest sample of each swing without a gap, by the place of its PEP."""
    peaks = {}
    for i, (a, b) in enumerate(pairwise(extremes)):
        swing = speed[math.ceil(a.sample) : math.floor(b.sample) + 1]
        if a.kind < 0 and len(swing) and np.isfinite(swing).all():
            peaks[i] = math.ceil(a.sample) + int(np.argmax(swing))
    return peaks


def _excess(
    speed: np.ndarray, threshold: float, height: Height | None, share: float
) -> list[np.ndarray]:
    """Return how far speed and height are above their thresholds."""
    over = [speed - threshold]
    if height is not None:
        over.append(height.up - height.ground - share * height.limit)
    return over


def _first_below(over: list[np.ndarray], start: int, stop: int, step: int) -> float | None:
    """Go from ``start`` to ``stop`` until all signals are below 0; interpolate the last one."""
    for i in range(start + step, stop + step, step):
        here = [float(x[i]) for x in over]
        if not all(math.isfinite(v) for v in here):
            return None
        if all(v < 0.0 for v in here):
            before = [float(x[i - step]) for x in over]
            # the signal that crossed last decides
            back = [v / (v - w) for v, w in zip(here, before, strict=True) if w >= 0.0]
            return i - step * min(back)
    return None
