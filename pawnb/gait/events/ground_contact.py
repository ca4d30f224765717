"""Touch-down and lift-off of one foot, told from its speed and height.

Kernels on arrays; times are fractional samples, as in :mod:`pawnb.gait.events`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.gait.events.extremes import Extreme
from pawnb.signals.robust import MAD_TO_SD


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
    up: FloatArray, extremes: Sequence[Extreme], *, fraction: float
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
    scatter = MAD_TO_SD * float(np.median(np.abs(np.array(low) - ground)))
    rise = float(np.median(tops)) - ground
    if not rise > 4.0 * scatter:
        return None
    return Height(up, ground, max(fraction * rise, 2.0 * scatter))


def find_contacts(
    speed: FloatArray,
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


def _swing_peaks(speed: FloatArray, extremes: Sequence[Extreme]) -> dict[int, int]:
    """Return the fastest sample of each swing without a gap, by the place of its PEP."""
    peaks = {}
    for i, (a, b) in enumerate(pairwise(extremes)):
        swing = speed[math.ceil(a.sample) : math.floor(b.sample) + 1]
        if a.kind < 0 and len(swing) and np.isfinite(swing).all():
            peaks[i] = math.ceil(a.sample) + int(np.argmax(swing))
    return peaks


def _excess(
    speed: FloatArray, threshold: float, height: Height | None, share: float
) -> list[FloatArray]:
    """Return how far speed and height are above their thresholds."""
    over = [speed - threshold]
    if height is not None:
        over.append(height.up - height.ground - share * height.limit)
    return over


def _first_below(over: list[FloatArray], start: int, stop: int, step: int) -> float | None:
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
