"""Events of each foot: extreme positions, touch-down and lift-off.

Kernels on arrays of one foot. Samples are equally spaced; times are fractional
samples, which the caller turns into frames and seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from pawnb.errors import InputError
from pawnb.signals import find_turns, refine_extremum


@dataclass(frozen=True, kw_only=True)
class EventSettings:
    """Settings of the gait analysis.

    Times that are None follow the animal: they are set from its stride frequency,
    estimated from the feet, and are written in the notes.

    Parameters
    ----------
    cutoff_hz : float, optional
        Low-pass for the feet; default 8 times the stride frequency, and no filter where
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
    min_confidence : float
        Positions with a lower confidence count as missing.
    jump_factor : float, optional
        Positions that jump away and back within three frames, by steps this many times
        the usual large step (95th percentile), count as missing; None keeps them.
    substrate : {"auto", "treadmill", "ground"}
        What the animal runs on; ``auto``: a treadmill where a belt speed is known or
        the animal gets nowhere, else the ground.
    stride_events : {"auto", "AEP", "TD"}
        Event that begins a stride; ``auto``: AEP where there are any, else TD.
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
    min_confidence: float = 0.0
    jump_factor: float | None = 3.0
    substrate: Literal["auto", "treadmill", "ground"] = "auto"
    stride_events: Literal["auto", "AEP", "TD"] = "auto"

    def __post_init__(self) -> None:
        zero_allowed = {"max_gap_s", "min_stance_s", "min_swing_s", "min_confidence"}
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            top = 1.0 if "fraction" in f.name or f.name == "min_confidence" else math.inf
            low_ok = value >= 0 if f.name in zero_allowed else value > 0
            if f.name == "jump_factor":
                low_ok = value >= 1
            if not (low_ok and value <= top and math.isfinite(value)):
                least = "0 or more" if f.name in zero_allowed else "above 0"
                least = "1 or more" if f.name == "jump_factor" else least
                most = " and at most 1" if top == 1.0 else ""
                raise InputError(f"setting {f.name!r} is {value}; expected {least}{most}.")


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
    values: list[float] = []
    for a, b in pairwise(extremes):
        if a.kind > 0 and b.kind < 0:
            quarter = (b.sample - a.sample) / 4.0
            first, last = math.ceil(a.sample + quarter), math.floor(b.sample - quarter)
            values += velocity[first : last + 1].tolist()
    known = np.array(values, dtype=float)
    known = known[np.isfinite(known)]
    return float(np.median(known)) if len(known) else math.nan


def height_threshold(
    height: np.ndarray, extremes: Sequence[Extreme], *, fraction: float
) -> float | None:
    """Find the height below which a foot can touch the ground.

    Parameters
    ----------
    height : ndarray, shape (n,)
        Height of the foot.
    extremes : sequence of Extreme
        AEP and PEP in order.
    fraction : float
        Share of the usual height of a swing.

    Returns
    -------
    float or None
        Level of the foot in stance (median) plus ``fraction`` of the median rise in
        swing, at least two standard deviations of the height in stance above it. None
        where the feet do not rise clear of that scatter (four standard deviations).
    """
    low: list[float] = []
    tops: list[float] = []
    for a, b in pairwise(extremes):
        part = height[math.ceil(a.sample) : math.floor(b.sample) + 1]
        part = part[np.isfinite(part)]
        if a.kind > 0:
            low += part.tolist()
        elif len(part):
            tops.append(float(part.max()))
    if len(low) < 4 or not tops:
        return None
    level = float(np.median(low))
    scatter = 1.4826 * float(np.median(np.abs(np.array(low) - level)))
    rise = float(np.median(tops)) - level
    return level + max(fraction * rise, 2.0 * scatter) if rise > 4.0 * scatter else None


def find_contacts(
    speed: np.ndarray,
    extremes: Sequence[Extreme],
    *,
    fraction: float,
    height: np.ndarray | None = None,
    max_height: float = math.inf,
) -> list[Contact]:
    """Find lift-off and touch-down about each swing from the foot's speed.

    From the fastest moment of a swing (PEP to AEP) one goes forwards to the first
    sample at which the foot is slow (and low), and backwards likewise; the time is
    interpolated between samples. A stance therefore never holds a swing, and the events
    alternate.

    Parameters
    ----------
    speed : ndarray, shape (n,)
        Speed of the foot forwards relative to the ground or belt.
    extremes : sequence of Extreme
        AEP and PEP in order.
    fraction : float
        Slow means below this share of the swing's peak.
    height : ndarray, shape (n,), optional
        Height of the foot.
    max_height : float
        Low means below this.

    Returns
    -------
    list of Contact
        In order of time. A change that does not come before the foot moves on to its
        next extreme, or before a gap, is left out.
    """
    contacts = []
    for i, (a, b) in enumerate(pairwise(extremes)):
        swing = speed[math.ceil(a.sample) : math.floor(b.sample) + 1]
        if a.kind > 0 or len(swing) == 0 or not np.isfinite(swing).all():
            continue  # a gap lies between the two, or it is a stance
        peak = math.ceil(a.sample) + int(np.argmax(swing))
        over = [speed - fraction * speed[peak]]
        if height is not None:
            over.append(height - max_height)
        first = math.floor(extremes[i - 1].sample) if i > 0 else 0
        last = math.ceil(extremes[i + 2].sample) if i + 2 < len(extremes) else len(speed) - 1
        lift = _first_below(over, peak, first, -1)
        land = _first_below(over, peak, last, 1)
        contacts += [Contact(lift, "LO")] if lift is not None else []
        contacts += [Contact(land, "TD")] if land is not None else []
    return contacts


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
