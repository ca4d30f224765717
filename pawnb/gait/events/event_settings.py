"""Settings of the gait analysis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from pawnb.errors import InputError

_POSITIVE = (math.ulp(0.0), math.nextafter(math.inf, 0.0), "a number above 0")
_NOT_NEGATIVE = (0.0, math.nextafter(math.inf, 0.0), "0 or more")
_SHARE_RANGE = (math.ulp(0.0), 1.0, "above 0 and at most 1")
_LIMITS = {
    "cutoff_hz": _POSITIVE,
    "body_cutoff_hz": _POSITIVE,
    "max_gap_s": _NOT_NEGATIVE,
    "min_excursion": _POSITIVE,
    "min_excursion_fraction": _SHARE_RANGE,
    "min_stance_s": _NOT_NEGATIVE,
    "min_swing_s": _NOT_NEGATIVE,
    "max_stride_s": _POSITIVE,
    "contact_speed_fraction": (math.ulp(0.0), 0.45, "above 0 and at most 0.45"),
    "contact_height_fraction": _SHARE_RANGE,
    "min_confidence": (0.0, 1.0, "0 to 1"),
    "bout_start_fraction": _SHARE_RANGE,
    "bout_stop_fraction": _SHARE_RANGE,
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

    Examples
    --------
    >>> settings = pawnb.gait.EventSettings(cutoff_hz=20.0)
    >>> gait = pawnb.gait.analyse(tracks, trial=run.trial, settings=settings)
    >>> gait.settings.cutoff_hz
    20.0
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
