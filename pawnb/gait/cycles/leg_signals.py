"""Signals of legs cut into strides: averages with bands, phase planes, aligned acceleration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.inference.checks import check_level
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import differentiate

CYCLE_COLUMNS = (
    "animal", "trial", "leg", "stride", "percent", "value", "velocity", "acceleration", "signal",
    "unit",
)  # fmt: skip
ALIGNED_COLUMNS = (
    "animal", "trial", "leg", "stride", "phase", "percent", "acceleration", "peak_velocity",
    "signal", "unit",
)  # fmt: skip
AVERAGE_COLUMNS = (
    "leg", "percent", "mean", "low", "high", "n_animals", "n_strides", "band", "signal", "unit",
)  # fmt: skip
LEG_ANGLE, POSITION, HEIGHT = "leg angle", "fore-aft position", "height"
LATERAL = "lateral position"
_STRIDES = ("animal", "trial", "leg", "stride", "start_s", "period_s", "stance_s")
_FEWEST_SAMPLES = 4


@dataclass(frozen=True, kw_only=True, eq=False)
class LegSignals:
    """One signal of the legs of one animal in one trial, smoothed.

    Parameters
    ----------
    animal, trial : str
        Whose it is.
    legs : tuple of str
        Names of the legs.
    time_s : ndarray, shape (n,)
        Times of the samples, equally spaced.
    samples : ndarray, shape (n, k)
        The signal of each leg, growing forwards (or upwards); NaN where missing.
    signal : str
        What it is: ``"leg angle"``, ``"fore-aft position"``, ``"height"``, or another name.
    unit : str
        Its unit: ``"deg"``, ``"mm"``, ``"px"``, ...
    """

    animal: str
    trial: str
    legs: tuple[str, ...]
    time_s: FloatArray
    samples: FloatArray
    signal: str = LEG_ANGLE
    unit: str = "deg"

    def __post_init__(self) -> None:
        """Refuse shapes that do not belong together, and times that are not equally spaced."""
        expected = (len(self.time_s), len(self.legs))
        if self.samples.shape != expected or len(self.time_s) < 3:
            raise InputError(
                f"signals of trial {self.trial!r}: samples of shape {self.samples.shape} for "
                f"{expected[0]} times and {expected[1]} legs; expected {expected}, and 3 times "
                "or more."
            )
        steps = np.diff(self.time_s)
        if not (steps > 0).all() or np.ptp(steps) > 0.02 * steps.mean():
            raise InputError(
                f"signals of trial {self.trial!r}: the times are not equally spaced and rising; "
                "put them on a regular grid first."
            )

    @property
    def dt_s(self) -> float:
        """Time between two samples."""
        return float((self.time_s[-1] - self.time_s[0]) / (len(self.time_s) - 1))


@checked_arguments
def cut_cycles(
    signals: Sequence[LegSignals], strides: pd.DataFrame, *, n_points: int = 101
) -> pd.DataFrame:
    """Cut signals into strides, each at equal steps of its own duration.

    Parameters
    ----------
    signals : sequence of LegSignals
        One kind of signal, of one or more trials.
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``.
    n_points : int
        Points a stride, both ends included.

    Returns
    -------
    pandas.DataFrame
        ``CYCLE_COLUMNS``: one row for stride and point. ``percent`` of the stride from its AEP
        (TD), 0 to 100; ``value`` in ``unit``, ``velocity`` and ``acceleration`` per second and
        per second squared (finite differences, Pullar 2009, Eq. 3.19 and 3.20, interpolated
        linearly). Strides whose signal is not complete are there with NaN.

    Raises
    ------
    InputError
        If the signals are of several kinds, a column is missing, or there are fewer than two
        points.
    """
    if n_points < 2:
        raise InputError(f"n_points is {n_points}; expected 2 or more.")
    percent = np.linspace(0.0, 100.0, n_points)
    parts = []
    for one, own, column in _legs_with_strides(signals, strides):
        start, period = (own[c].to_numpy(dtype=float) for c in ("start_s", "period_s"))
        at = start[:, None] + period[:, None] * percent[None, :] / 100.0
        found = {
            name: _sample(one.time_s, column, at, dt=one.dt_s, order=order)
            for order, name in enumerate(("value", "velocity", "acceleration"))
        }
        part = own.loc[own.index.repeat(n_points), ["animal", "trial", "leg", "stride"]]
        parts.append(part.assign(percent=np.tile(percent, len(own)), **found))
    return _stack(parts, CYCLE_COLUMNS, signals)


@checked_arguments
def centre_signals(signals: Sequence[LegSignals]) -> list[LegSignals]:
    """Take the place of the animal out of positions, so that trials can be put together.

    On a treadmill positions along forward are counted from the laboratory's origin, and animals
    run further in front or further back. The mean over all legs and times of a trial is
    subtracted; how the legs lie to each other stays.

    Parameters
    ----------
    signals : sequence of LegSignals
        Positions of one or more trials.

    Returns
    -------
    list of LegSignals
        The same, each about the mean of its legs.
    """
    centred = []
    for one in signals:
        legs = one.samples[:, np.isfinite(one.samples).any(axis=0)]
        middle = float(np.nanmean(legs, axis=0).mean()) if legs.size else 0.0
        centred.append(replace(one, samples=one.samples - middle))
    return centred


@checked_arguments
def align_acceleration(
    signals: Sequence[LegSignals],
    strides: pd.DataFrame,
    *,
    phase: str = "swing",
    step_percent: float = 2.0,
) -> pd.DataFrame:
    """Align the acceleration of a leg at its greatest speed in swing or stance.

    Pullar 2009, Figs. 4.13 and 4.14: time in percent of the swing (stance), 0 at the greatest
    angular speed, so that acceleration lies before 0 and deceleration after it.

    Parameters
    ----------
    signals : sequence of LegSignals
        One kind of signal, of one or more trials.
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``.
    phase : {"swing", "stance"}
        Which part of the stride: AEP to PEP (TD to LO) is stance, the rest swing.
    step_percent : float
        Steps at which the acceleration is given.

    Returns
    -------
    pandas.DataFrame
        ``ALIGNED_COLUMNS``: one row for stride and step inside the phase; ``peak_velocity`` is
        the greatest forward velocity in swing, the greatest backward one in stance. A phase
        with fewer than 4 samples, or samples missing, is left out.

    Raises
    ------
    InputError
        If the phase is unknown, the step not above 0, the signals are of several kinds, or a
        column is missing.
    """
    if phase not in ("swing", "stance"):
        raise InputError(f"phase is {phase!r}; expected 'swing' or 'stance'.")
    if not step_percent > 0:
        raise InputError(f"step_percent is {step_percent}; expected more than 0.")
    parts = []
    for one, own, column in _legs_with_strides(signals, strides):
        velocity = differentiate(column, dt=one.dt_s)
        acceleration = differentiate(column, dt=one.dt_s, order=2)
        spans = _spans(own, phase)
        keys = own[["animal", "trial", "leg", "stride"]].to_dict("records")
        for key, (start, end) in zip(keys, spans, strict=True):
            first, last = np.searchsorted(one.time_s, (start, end))
            inside = velocity[first:last]
            if len(inside) < _FEWEST_SAMPLES or not np.isfinite(inside).all():
                continue
            peak = int(first) + int(np.argmax(inside) if phase == "swing" else np.argmin(inside))
            scale = 100.0 / (end - start)
            ends = scale * (one.time_s[[first, last - 1]] - one.time_s[peak]) / step_percent
            percent = step_percent * np.arange(np.ceil(ends[0]), np.floor(ends[1]) + 1.0)
            at = one.time_s[peak] + percent / scale
            found: dict[str, Any] = {
                **{str(name): value for name, value in key.items()},
                "phase": phase,
                "percent": percent,
                "acceleration": np.interp(at, one.time_s, acceleration),
                "peak_velocity": velocity[peak],
            }
            parts.append(pd.DataFrame(found))
    return _stack(parts, ALIGNED_COLUMNS, signals)


@checked_arguments
def average_cycles(
    cycles: pd.DataFrame, *, value: str = "value", level: float = 0.95
) -> pd.DataFrame:
    """Average strides at every step, animals counting once each, with a band.

    Parameters
    ----------
    cycles : pandas.DataFrame
        From :func:`cut_cycles` or :func:`align_acceleration`.
    value : str
        Column to average.
    level : float
        Level of the interval.

    Returns
    -------
    pandas.DataFrame
        ``AVERAGE_COLUMNS``: one row for leg and percent. ``mean`` is the mean of the animals'
        means; with two animals or more ``low`` and ``high`` are the interval of that mean
        (Student's t over animals, at each step for itself), with one animal the mean plus and
        minus one SD of its strides, and NaN with a single stride; ``band`` says which in words.

    Raises
    ------
    InputError
        If a column is missing or the level is not between 0 and 1.
    """
    names = ("animal", "leg", "stride", "percent", value, "signal", "unit")
    check_columns(cycles, names, where="cycles")
    check_level(level)
    known = cycles[cycles[value].notna()]
    by_animal = known.groupby(["leg", "percent", "animal"], sort=True)[value]
    animals = by_animal.agg(["mean", "std", "size"]).reset_index()
    groups = animals.groupby(["leg", "percent"], sort=True)
    table = groups.agg(
        mean=("mean", "mean"), sd=("mean", "std"), within=("std", "first"),
        n_animals=("mean", "size"), n_strides=("size", "sum"),
    ).reset_index()  # fmt: skip
    many = (table["n_animals"] > 1).to_numpy()
    n = np.maximum(table["n_animals"].to_numpy(), 2)
    half = np.where(
        many,
        student.ppf(0.5 + level / 2.0, n - 1) * table["sd"] / np.sqrt(n),
        table["within"],
    )
    band = np.where(many, f"{100 * level:g} % interval of the mean of animals", "SD of strides")
    about = {name: cycles[name].iloc[0] if len(cycles) else "" for name in ("signal", "unit")}
    table = table.assign(low=table["mean"] - half, high=table["mean"] + half, band=band, **about)
    return table[list(AVERAGE_COLUMNS)]


def _legs_with_strides(
    signals: Sequence[LegSignals], strides: pd.DataFrame
) -> Iterator[tuple[LegSignals, pd.DataFrame, FloatArray]]:
    """Yield each leg of each signal with its strides and its samples."""
    check_columns(strides, _STRIDES, where="strides")
    kinds = sorted({f"{one.signal} ({one.unit})" for one in signals})
    if len(kinds) > 1:
        raise InputError(f"the signals are of several kinds, {' and '.join(kinds)}; choose one.")
    groups = {
        tuple(map(str, key)): own.reset_index(drop=True)
        for key, own in strides.groupby(["animal", "trial", "leg"], sort=False)
    }
    for one in signals:
        for k, leg in enumerate(one.legs):
            own = groups.get((one.animal, one.trial, leg))
            if own is not None:
                yield one, own, one.samples[:, k]


def _spans(strides: pd.DataFrame, phase: str) -> FloatArray:
    """Return start and end of swing or stance, shape (n, 2)."""
    start, period, stance = (
        strides[name].to_numpy(dtype=float) for name in ("start_s", "period_s", "stance_s")
    )
    turn = start + stance
    ends = (start, turn) if phase == "stance" else (turn, start + period)
    return np.column_stack(ends)


def _sample(
    time_s: FloatArray, column: FloatArray, at: FloatArray, *, dt: float, order: int
) -> FloatArray:
    """Return a signal or a derivative at times, in one row; NaN outside and where missing."""
    if order == 1:
        column = differentiate(column, dt=dt)
    elif order == 2:
        column = differentiate(column, dt=dt, order=2)
    return np.interp(at.ravel(), time_s, column, left=np.nan, right=np.nan)


def _stack(
    parts: list[pd.DataFrame], columns: Sequence[str], signals: Sequence[LegSignals]
) -> pd.DataFrame:
    """Put the parts below each other and say what the signal is."""
    if not parts:
        return pd.DataFrame(columns=list(columns))
    table = pd.concat(parts, ignore_index=True)
    return table.assign(signal=signals[0].signal, unit=signals[0].unit)[list(columns)]
