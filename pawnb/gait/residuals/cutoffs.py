"""The three ways of choosing a cut-off, side by side (paper 2009, §3.5).

Residual analysis (Winter 2009), generalised cross-validation, and the whiteness of what the filter
takes away (Challis 1999).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.residuals.cutoff_scores import (
    NO_CUTOFF,
    STRAIGHT_LINE,
    Choice,
    are_straight,
    cross_validate,
    find_long_runs,
    find_whitest,
    residual_rms,
    why_no_runs,
)
from pawnb.gait.residuals.residual_analysis import (
    DOUBT,
    ESTIMATE_WARNING,
    analyse_runs,
    residual_cutoffs,
    say_instead,
)
from pawnb.schema.arguments import checked_arguments

CUTOFF_METHODS = ("residual", "gcv", "autocorrelation")
CUTOFF_COLUMNS = (
    "signal", "method", "cutoff_hz", "residual_rms", "noise_rms", "n_samples", "reason", "warning",
)  # fmt: skip
POOLED = "pooled"

Signals = pd.DataFrame | pd.Series | FloatArray | Sequence[Any]
"""Signals as they come: one column each, all in one unit."""
_UNLIKE = 2.0
"""Set by hand: how many times higher or lower than the pooled cut-off one signal's own must be
before it is said. Paws of a rat, a mouse from below and two mice on beams and belts: 0.8 to 1.5
times by residual analysis; where one of three paws had 30 times the noise: 2.4 and 6.4."""


@checked_arguments
def compare_cutoffs(
    signals: Signals,
    *,
    fs_hz: float,
    order: int = 4,
    band_hz: tuple[float, float] | None = None,
) -> pd.DataFrame:
    """Choose cut-offs in three ways, for each signal and for all of them pooled.

    ``residual``: :func:`~pawnb.gait.residuals.analyse_residuals`. ``gcv``: the least generalised
    cross-validation score (Craven & Wahba 1979), for noise without memory. ``autocorrelation``:
    where what the filter takes away is most like white noise, by the sum of its squared
    autocorrelations over all lags (Challis 1999). Where the three are far apart the noise is not
    white, or the record is too short to tell.

    Parameters
    ----------
    signals : pandas.DataFrame, pandas.Series, ndarray (n,) or (n, k), or list
        One column a signal, all in one unit; NaN where missing. Angles must be unwrapped.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the Butterworth filter, both passes together.
    band_hz : tuple of float, optional
        Straight part of the residual curve, in Hz; default: found.

    Returns
    -------
    pandas.DataFrame
        ``CUTOFF_COLUMNS``: three rows a signal, then three named ``pooled`` where there are
        several. ``cutoff_hz`` is NaN where no choice was possible, and ``reason`` says why;
        ``residual_rms`` is what the filter takes away at that cut-off, ``noise_rms`` the
        noise estimated by the method itself (NaN for autocorrelation). The reason of a pooled
        cut-off names the signals for which it is far too low or too high.

    Raises
    ------
    InputError
        If the rate, order or band cannot be, there is no signal, or two have one name.
    """
    residual_cutoffs(fs_hz, order=order)  # refuses rates and orders that cannot be
    table = named_signals(signals)
    if table.shape[1] == 0 or not table.columns.is_unique:
        raise InputError("signals: expected at least one column, each with its own name.")
    parts = {name: table[[name]].to_numpy() for name in table}
    if len(parts) > 1:
        parts[POOLED] = table.to_numpy()
    rows: list[tuple[Any, ...]] = []
    for name, values in parts.items():
        runs = find_long_runs(values)
        n = sum(run.size for run in runs)
        found = _choose_all(values, runs, fs_hz=fs_hz, order=order, band_hz=band_hz)
        for method in CUTOFF_METHODS:
            choice, left = _kept(found[method], runs, fs_hz=fs_hz, order=order)
            own = {row[0]: row[2] for row in rows if row[1] == method}
            unlike = say_unlike(own, choice.cutoff_hz) if name == POOLED else ""
            reason = f"{choice.reason}; but {unlike}" if unlike else choice.reason
            given = (choice.cutoff_hz, left, choice.noise_rms, n, reason)
            rows.append((name, method, *given, ESTIMATE_WARNING))
    return pd.DataFrame(rows, columns=list(CUTOFF_COLUMNS))


def say_unlike(own_hz: Mapping[str, float], pooled_hz: float) -> str:
    """Name the signals for which a cut-off pooled over all is far too low or too high.

    Parameters
    ----------
    own_hz : mapping of str to float
        The cut-off of each signal by itself, in Hz; NaN where it has none.
    pooled_hz : float
        The cut-off of all of them pooled, in Hz; NaN where there is none.

    Returns
    -------
    str
        The sentence, without its end; empty where it suits all.
    """
    odd = {
        name: hz
        for name, hz in own_hz.items()
        if hz >= _UNLIKE * pooled_hz or hz * _UNLIKE <= pooled_hz
    }
    if not odd:
        return ""
    named = ", ".join(f"{name} {hz:.3g} Hz" for name, hz in odd.items())
    return (
        f"by itself {named}: one cut-off does not suit all of these signals, so leave "
        "out the noisy ones or filter them apart"
    )


@checked_arguments
def named_signals(signals: Signals) -> pd.DataFrame:
    """Return signals as a table of numbers, a column each, named where they have no names.

    Parameters
    ----------
    signals : pandas.DataFrame, pandas.Series, ndarray or list
        One column a signal; an array is (n,) or (n, k).

    Returns
    -------
    pandas.DataFrame
        Numbers; columns are named by text, ``signal 1`` and so on where they had no name.

    Raises
    ------
    InputError
        If these are no numbers, or there are more than two dimensions, or none.
    """
    if isinstance(signals, pd.Series):
        signals = signals.to_frame("signal 1" if signals.name is None else str(signals.name))
    try:
        if isinstance(signals, pd.DataFrame):
            # a column is found by its name, whatever type that has
            return signals.set_axis([str(name) for name in signals], axis=1).astype(float)
        values = np.asarray(signals, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            "these signals are no table of numbers; give an array (n,) or (n, k), a list of "
            "numbers, a Series or a DataFrame."
        ) from None
    if values.ndim not in (1, 2):
        raise InputError(f"signals have {values.ndim} dimensions; expected time and signal.")
    flat = values.reshape(len(values), -1)
    return pd.DataFrame(flat, columns=[f"signal {k + 1}" for k in range(flat.shape[1])])


def _choose_all(
    values: FloatArray,
    runs: list[FloatArray],
    *,
    fs_hz: float,
    order: int,
    band_hz: tuple[float, float] | None,
) -> dict[str, Choice]:
    """Return the choice of every method."""
    none = "" if runs else why_no_runs(values)
    if runs and are_straight(runs):
        none = STRAIGHT_LINE
    if none:
        return dict.fromkeys(CUTOFF_METHODS, Choice(math.nan, math.nan, f"{NO_CUTOFF}{none}"))
    validated = cross_validate(runs, fs_hz=fs_hz, order=order)
    found = analyse_runs(runs, fs_hz=fs_hz, order=order, band_hz=band_hz, validated=validated)
    return {
        "residual": Choice(found.cutoff_hz, found.noise_rms, found.reason),
        "gcv": validated,
        "autocorrelation": _checked_whitest(runs, validated, fs_hz=fs_hz, order=order),
    }


def _checked_whitest(
    runs: list[FloatArray], validated: Choice, *, fs_hz: float, order: int
) -> Choice:
    """Return the whitest cut-off, unless it takes away far more than the noise."""
    choice = find_whitest(runs, fs_hz=fs_hz, order=order)
    left = residual_rms(runs, choice.cutoff_hz, fs_hz=fs_hz, order=order)
    if choice.reason.startswith(NO_CUTOFF) or left <= DOUBT * validated.noise_rms:
        return choice
    return choice._replace(
        reason=f"{NO_CUTOFF}{choice.reason} at {choice.cutoff_hz:.3g} Hz, where it takes away "
        f"{left / validated.noise_rms:.2g} times the noise of cross-validation; "
        f"{say_instead(validated)}"
    )


def _kept(
    choice: Choice, runs: list[FloatArray], *, fs_hz: float, order: int
) -> tuple[Choice, float]:
    """Return a choice with the residual at it; NaN for both where it is none."""
    if choice.reason.startswith(NO_CUTOFF):
        return Choice(math.nan, math.nan, choice.reason), math.nan
    return choice, residual_rms(runs, choice.cutoff_hz, fs_hz=fs_hz, order=order)
