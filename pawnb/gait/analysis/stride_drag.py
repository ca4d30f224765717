"""The share of each swing in which a foot is dragged: it moves on while it is near the floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.gait.cycles.leg_signals import HEIGHT, LegSignals
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.strides.stride_table import Motion
from pawnb.signals import differentiate
from pawnb.signals.robust import MAD_TO_SD


def drag_fractions(
    strides: pd.DataFrame,
    *,
    motion: Mapping[str, Motion] | None,
    signals: Sequence[LegSignals],
    settings: EventSettings,
) -> pd.Series:
    """Compute the share of each swing in which the foot is dragged.

    Near the floor and moving are what ground contact is told by: a foot is near the floor below
    ``contact_height_fraction`` of the usual lift, at least two standard deviations of its height in
    the stance before; it moves where its speed over the ground is above
    ``contact_speed_fraction`` of the greatest in that swing. The usual lift is the median of all
    legs of the trial, so that a leg that drags in every stride is judged by those that do not.
    (ALMA takes 1 mm, Aljovic et al. 2022; a quarter of a mouse's usual lift of 6 mm is 1.5 mm.)

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides of one animal and trial, with ``swing_height``.
    motion : mapping or None
        Motion by the name of the leg.
    signals : sequence of LegSignals
        Signals of the legs; heights are used.
    settings : EventSettings
        Settings.

    Returns
    -------
    pandas.Series
        0 to 1, by the index of the strides; NaN where height or motion is not known. A foot that
        is lifted as a half sine is near the floor in 0.16 of its swing, so that a sound leg is not
        at 0.
    """
    found = pd.Series(np.nan, index=strides.index, dtype=float)
    lifts = strides["swing_height"].dropna()
    if lifts.empty or not motion:
        return found
    limit = settings.contact_height_fraction * float(lifts.median())
    for signal in signals:
        if signal.signal != HEIGHT:
            continue
        for k, leg in enumerate(signal.legs):
            moved = motion.get(leg)
            own = strides[strides["leg"] == leg]
            if moved is None or leg not in moved.feet or own.empty:
                continue
            speed = np.abs(differentiate(moved.feet[leg], dt=_step(moved.time_s)))
            at = np.interp(signal.time_s, moved.time_s, speed)
            rows = _samples(own, signal.time_s)
            shares = [
                _share(signal.samples[:, k], at, row, limit, settings.contact_speed_fraction)
                for row in rows
            ]
            found = found.fillna(pd.Series(shares, index=own.index, dtype=float))
    return found


def _step(time_s: FloatArray) -> float:
    """Return the time between two samples."""
    return float((time_s[-1] - time_s[0]) / (len(time_s) - 1))


def _samples(strides: pd.DataFrame, time_s: FloatArray) -> list[list[int]]:
    """Return the first sample of the stance, of the swing, and beyond it, of each stride."""
    start, stance, period = (
        strides[name].to_numpy(dtype=float) for name in ("start_s", "stance_s", "period_s")
    )
    found: list[list[int]] = np.searchsorted(
        time_s, np.array((start, start + stance, start + period))
    ).T.tolist()
    return found


def _share(
    height: FloatArray, speed: FloatArray, samples: list[int], limit: float, slow: float
) -> float:
    """Return the share of one swing in which the foot is near the floor and moves."""
    a, b, c = samples
    stance, swing, moving = height[a:b], height[b:c], speed[b:c]
    if not len(stance) or not len(swing):
        return float("nan")
    if not (np.isfinite(stance).all() and np.isfinite(swing).all() and np.isfinite(moving).all()):
        return float("nan")
    ground = float(np.median(stance))
    scatter = MAD_TO_SD * float(np.median(np.abs(stance - ground)))
    low = swing - ground < max(limit, 2.0 * scatter)
    return float((low & (moving > slow * moving.max())).mean())
