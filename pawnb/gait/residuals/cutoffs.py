"""The three ways of choosing a cut-off, side by side (paper 2009, §3.5).

Residual analysis (Winter 2009), generalised cross-validation, and the whiteness of what the filter
takes away (Challis 1999).
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.residuals.cutoff_scores import (
    LEAST_SAMPLES,
    NO_CUTOFF,
    Choice,
    cross_validate,
    find_long_runs,
    find_whitest,
    residual_rms,
)
from pawnb.gait.residuals.residual_analysis import (
    DOUBT,
    ESTIMATE_WARNING,
    analyse_runs,
    residual_cutoffs,
    say_instead,
)

CUTOFF_METHODS = ("residual", "gcv", "autocorrelation")
CUTOFF_COLUMNS = (
    "signal", "method", "cutoff_hz", "residual_rms", "noise_rms", "n_samples", "reason", "warning",
)  # fmt: skip
POOLED = "pooled"


def compare_cutoffs(
    signals: pd.DataFrame | FloatArray,
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
    signals : pandas.DataFrame or ndarray, shape (n,) or (n, k)
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
        noise estimated by the method itself (NaN for autocorrelation).

    Raises
    ------
    InputError
        If the rate, order or band cannot be, there is no signal, or two have one name.
    """
    residual_cutoffs(fs_hz, order=order)  # refuses rates and orders that cannot be
    table = signals if isinstance(signals, pd.DataFrame) else named_signals(np.asarray(signals))
    if table.shape[1] == 0 or not table.columns.is_unique:
        raise InputError("signals: expected at least one column, each with its own name.")
    parts = {str(name): table[[name]].to_numpy(dtype=float) for name in table}
    if len(parts) > 1:
        parts[POOLED] = table.to_numpy(dtype=float)
    rows = []
    for name, values in parts.items():
        runs = find_long_runs(values)
        n = sum(run.size for run in runs)
        found = _choose_all(runs, fs_hz=fs_hz, order=order, band_hz=band_hz)
        for method in CUTOFF_METHODS:
            choice, left = _kept(found[method], runs, fs_hz=fs_hz, order=order)
            given = (choice.cutoff_hz, left, choice.noise_rms, n, choice.reason)
            rows.append((name, method, *given, ESTIMATE_WARNING))
    return pd.DataFrame(rows, columns=list(CUTOFF_COLUMNS))


def named_signals(values: FloatArray) -> pd.DataFrame:
    """Return signals without names as a table.

    Parameters
    ----------
    values : ndarray, shape (n,) or (n, k)
        The signals.

    Returns
    -------
    pandas.DataFrame
        ``signal 1`` and so on.

    Raises
    ------
    InputError
        If there are more than two dimensions, or none.
    """
    if values.ndim not in (1, 2):
        raise InputError(f"signals have {values.ndim} dimensions; expected time and signal.")
    flat = values.reshape(len(values), -1)
    return pd.DataFrame(flat, columns=[f"signal {k + 1}" for k in range(flat.shape[1])])


def _choose_all(
    runs: list[FloatArray], *, fs_hz: float, order: int, band_hz: tuple[float, float] | None
) -> dict[str, Choice]:
    """Return the choice of every method."""
    if not runs:
        none = f"{NO_CUTOFF}no run of {LEAST_SAMPLES} samples without a gap"
        return dict.fromkeys(CUTOFF_METHODS, Choice(math.nan, math.nan, none))
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
