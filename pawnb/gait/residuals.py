"""Choosing the cut-off of a low-pass filter from the signal itself (paper 2009, §3.5, Fig. 3.11).

Three ways, side by side in :func:`compare_cutoffs`: residual analysis (Winter 2009),
generalised cross-validation, and the whiteness of what the filter takes away (Challis 1999).
All of them are estimates. Look at the filtered signal and its derivatives before you use one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.signal import detrend

from pawnb.errors import InputError
from pawnb.signals import find_runs, highest_cutoff
from pawnb.signals.butterworth import filter_reach, filter_run
from pawnb.signals.gcv import effective_parameters, find_lowest, gcv_score

ESTIMATE_WARNING = (
    "An estimate, not a measurement: Yu et al. (1999) found that cut-offs from residual "
    "analysis do not follow the best ones and are too low for accelerations, most at high "
    "sampling rates. Look at the filtered signal and its derivatives."
)
"""What goes with every automatic choice."""

METHODS = ("residual", "gcv", "autocorrelation")
CURVE_COLUMNS = ("cutoff_hz", "residual", "noise_line", "in_band")
CUTOFF_COLUMNS = (
    "signal", "method", "cutoff_hz", "residual_rms", "noise_rms", "n_samples", "reason", "warning",
)  # fmt: skip
LEAST_SAMPLES = 20
POOLED = "pooled"
_STEPS = 101
_LIFETIMES = 3.0
_FLOOR = 1000.0 * float(np.finfo(float).eps)


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualAnalysis:
    """Residual analysis of one signal, or of several pooled.

    Parameters
    ----------
    cutoff_hz : float
        The cut-off; NaN where the rule finds none, and ``reason`` says why.
    noise_rms : float
        Where the noise line meets 0 Hz: the estimated RMS of the noise, in the unit of the
        signal. NaN without a line.
    band_hz : tuple of float
        Ends of the band in which the line was fitted; NaN without one.
    curve : pandas.DataFrame
        ``cutoff_hz``, ``residual`` (RMS of raw minus filtered), ``noise_line`` (NaN without
        one), ``in_band`` (whether the line was fitted to this point).
    reason : str
        How the cut-off was found, or why not.
    warning : str
        :data:`ESTIMATE_WARNING`.
    """

    cutoff_hz: float
    noise_rms: float
    band_hz: tuple[float, float]
    curve: pd.DataFrame
    reason: str
    warning: str = ESTIMATE_WARNING


def analyse_residuals(
    x: np.ndarray,
    *,
    fs_hz: float,
    order: int = 4,
    band_hz: tuple[float, float] | None = None,
) -> ResidualAnalysis:
    """Choose a cut-off by residual analysis (Winter 2009; paper 2009, §3.5).

    The signal is filtered with 101 cut-offs from a hundredth of half the sampling rate
    up to the highest there is, and the RMS of what was taken away is drawn against the
    cut-off. Where only noise is left the curve is a straight line; its height at 0 Hz
    estimates the noise. The cut-off is where the curve comes down to that height: there,
    as much signal is lost as noise is let through.

    Which part is straight is the user's to say (``band_hz``). Left out, it is found by the
    rule of Duarte's ``optcutfreq`` (version 0.0.9): an exponential decay is fitted to the
    curve's height above its 96th point, by a straight line through the logarithms; the band
    begins after three lifetimes of it and ends at that point. The logarithm of 0 at that
    point itself is replaced by a floor, which takes part in the fit. There the floor is in
    the unit of the signal; here it is a share of the signal's range, so that degrees and
    radians give the same cut-off.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, k)
        A signal, or several of one unit, which are pooled: the residual is the RMS over all
        of their samples. NaN where missing; runs between gaps are filtered one by one, and
        runs of fewer than 20 samples are left out.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the Butterworth filter, both passes together.
    band_hz : tuple of float, optional
        Ends of the straight part, in Hz.

    Returns
    -------
    ResidualAnalysis
        Cut-off, curve and line, with the reason in words.

    Raises
    ------
    InputError
        If the rate, order or band cannot be, or no run has 20 samples.
    """
    runs = _find_runs(x)
    if not runs:
        raise InputError(
            f"residual analysis: no run of {LEAST_SAMPLES} samples without a gap; expected at "
            "least one: fill the gaps or leave this signal out."
        )
    cutoffs = residual_cutoffs(fs_hz, order=order)
    residual = np.array([_residual_rms(runs, c, fs_hz=fs_hz, order=order) for c in cutoffs])
    scale = max(float(np.ptp(run, axis=0).max()) for run in runs)
    if max(float(np.abs(detrend(run, axis=0)).max()) for run in runs) <= 1e-12 * scale:
        return _nothing(cutoffs, residual, "no cut-off: the signal is a straight line")
    if band_hz is not None:
        ends = _given_band(cutoffs, band_hz)
        said = "in the band given"
    else:
        found = _noise_band(cutoffs, residual / scale)
        if isinstance(found, str):
            return _nothing(cutoffs, residual, found)
        ends = found
        said = "after three lifetimes of the curve's decay"
    return _read_off(cutoffs, residual, ends, said)


def residual_cutoffs(fs_hz: float, *, order: int = 4) -> np.ndarray:
    """Return the cut-offs at which residuals are computed.

    Parameters
    ----------
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the Butterworth filter.

    Returns
    -------
    ndarray, shape (101,)
        Cut-offs in Hz, evenly spaced; the highest possible is left out.
    """
    return np.linspace(fs_hz / 200.0, highest_cutoff(fs_hz, order=order), _STEPS, endpoint=False)


def compare_cutoffs(
    signals: pd.DataFrame | np.ndarray,
    *,
    fs_hz: float,
    order: int = 4,
    band_hz: tuple[float, float] | None = None,
) -> pd.DataFrame:
    """Choose cut-offs in three ways, for each signal and for all of them pooled.

    ``residual``: :func:`analyse_residuals`. ``gcv``: the least generalised cross-validation
    score (Craven & Wahba 1979), for noise without memory. ``autocorrelation``: where what
    the filter takes away is most like white noise, by the sum of its squared
    autocorrelations over all lags (Challis 1999). Where the three are far apart the noise
    is not white, or the record is too short to tell.

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
    table = signals if isinstance(signals, pd.DataFrame) else _named(np.asarray(signals))
    if table.shape[1] == 0 or not table.columns.is_unique:
        raise InputError("signals: expected at least one column, each with its own name.")
    parts = {str(name): table[[name]].to_numpy(dtype=float) for name in table}
    if len(parts) > 1:
        parts[POOLED] = table.to_numpy(dtype=float)
    rows = []
    for name, values in parts.items():
        n = sum(run.size for run in _find_runs(values))
        for method in METHODS:
            choice = _choose(values, method, fs_hz=fs_hz, order=order, band_hz=band_hz)
            rows.append((name, method, *choice[:3], n, choice[3], ESTIMATE_WARNING))
    return pd.DataFrame(rows, columns=list(CUTOFF_COLUMNS))


def _named(values: np.ndarray) -> pd.DataFrame:
    """Return signals without names as a table."""
    if values.ndim > 2:
        raise InputError(f"signals have {values.ndim} dimensions; expected time and signal.")
    flat = values.reshape(len(values), -1)
    return pd.DataFrame(flat, columns=[f"signal {k + 1}" for k in range(flat.shape[1])])


def _choose(
    x: np.ndarray,
    method: str,
    *,
    fs_hz: float,
    order: int,
    band_hz: tuple[float, float] | None,
) -> tuple[float, float, float, str]:
    """Return cut-off, residual and noise at it, and the reason, of one method."""
    runs = _find_runs(x)
    nan = math.nan
    if not runs:
        return nan, nan, nan, f"no cut-off: no run of {LEAST_SAMPLES} samples without a gap"
    if method == "residual":
        analysis = analyse_residuals(x, fs_hz=fs_hz, order=order, band_hz=band_hz)
        cutoff, noise, reason = analysis.cutoff_hz, analysis.noise_rms, analysis.reason
    else:
        low, high = fs_hz / 200.0, 0.95 * highest_cutoff(fs_hz, order=order)
        if method == "gcv":
            cutoff = find_lowest(lambda c: _gcv(runs, c / fs_hz, order), low, high)
            noise = _gcv_noise(runs, cutoff / fs_hz, order)
            reason = "least cross-validation score"
        else:
            cutoff = find_lowest(lambda c: _colour(runs, c, fs_hz, order), low, high)
            noise = nan
            reason = "what is taken away is most like white noise"
        if cutoff <= low or cutoff >= high:
            end = "lowest" if cutoff <= low else "highest"
            reason = f"no cut-off: {reason} only at the {end} cut-off tried, {cutoff:.3g} Hz"
            cutoff = noise = nan
    if not math.isfinite(cutoff):
        return nan, nan, noise, reason
    return cutoff, _residual_rms(runs, cutoff, fs_hz=fs_hz, order=order), noise, reason


def _find_runs(x: np.ndarray) -> list[np.ndarray]:
    """Return the runs of all signals that are long enough, those of one length side by side."""
    flat = np.asarray(x, dtype=float).reshape(len(x), -1)
    by_length: dict[int, list[np.ndarray]] = {}
    for column in flat.T:
        for start, stop in find_runs(np.isfinite(column)):
            if stop - start >= LEAST_SAMPLES:
                by_length.setdefault(stop - start, []).append(column[start:stop])
    return [np.column_stack(runs) for runs in by_length.values()]


def _square_sum(runs: list[np.ndarray], cutoff_hz: float, *, fs_hz: float, order: int) -> float:
    """Return the sum of the squares of raw minus filtered over all runs."""
    return sum(
        float(np.sum((run - filter_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order)) ** 2))
        for run in runs
    )


def _residual_rms(runs: list[np.ndarray], cutoff_hz: float, *, fs_hz: float, order: int) -> float:
    """Return the RMS of raw minus filtered over all runs."""
    squares = _square_sum(runs, cutoff_hz, fs_hz=fs_hz, order=order)
    return math.sqrt(squares / sum(run.size for run in runs))


def _noise_band(cutoffs: np.ndarray, residual: np.ndarray) -> tuple[int, int] | str:
    """Find the straight part of a residual curve (in shares of the range), or say why not."""
    last = int(0.95 * (len(cutoffs) - 1))
    height = np.log(np.abs(residual[: last + 1] - residual[last]) + _FLOOR)
    rate = float(np.polyfit(cutoffs[: last + 1], height, 1)[0])
    if rate >= 0.0:
        return "no cut-off: the residual does not fall with the cut-off"
    first = int(np.searchsorted(cutoffs, -_LIFETIMES / rate))
    if last - first < 3:
        return (
            f"no cut-off: the residual still falls at {cutoffs[last]:.3g} Hz, so no band is "
            "noise alone; film faster, or give the band (band_hz)"
        )
    return first, last


def _given_band(cutoffs: np.ndarray, band_hz: tuple[float, float]) -> tuple[int, int]:
    """Return first and one past the last point within a band given in Hz."""
    low, high = band_hz
    first, last = (int(k) for k in np.searchsorted(cutoffs, [low, high]))
    if not 0.0 <= low < high or last - first < 3:
        raise InputError(
            f"band_hz is {low:g} to {high:g}; expected two frequencies, the lower one first, "
            f"with at least three cut-offs between them (steps of "
            f"{cutoffs[1] - cutoffs[0]:.2g} Hz up to {cutoffs[-1]:.3g} Hz)."
        )
    return first, last


def _read_off(
    cutoffs: np.ndarray, residual: np.ndarray, ends: tuple[int, int], said: str
) -> ResidualAnalysis:
    """Fit the noise line and find where the curve first comes down to its height at 0 Hz."""
    first, last = ends
    slope, noise = (float(v) for v in np.polyfit(cutoffs[first:last], residual[first:last], 1))
    band = float(cutoffs[first]), float(cutoffs[last - 1])
    where = f"line fitted from {band[0]:.3g} to {band[1]:.3g} Hz, {said}"
    above = residual - noise
    down = np.flatnonzero((above[:-1] > 0.0) & (above[1:] <= 0.0))
    curve = pd.DataFrame(
        {
            "cutoff_hz": cutoffs,
            "residual": residual,
            "noise_line": noise + slope * cutoffs,
            "in_band": (np.arange(len(cutoffs)) >= first) & (np.arange(len(cutoffs)) < last),
        }
    )
    if noise <= 0.0 or len(down) == 0:
        reason = f"no cut-off: the curve does not cross the noise of {noise:.3g} ({where})"
        return ResidualAnalysis(
            cutoff_hz=math.nan, noise_rms=noise, band_hz=band, curve=curve, reason=reason
        )
    k = int(down[0])
    cutoff = float(brentq(CubicSpline(cutoffs, above), cutoffs[k], cutoffs[k + 1]))
    reason = f"the residual equals the noise of {noise:.3g} RMS at {cutoff:.3g} Hz ({where})"
    return ResidualAnalysis(
        cutoff_hz=cutoff, noise_rms=noise, band_hz=band, curve=curve, reason=reason
    )


def _nothing(cutoffs: np.ndarray, residual: np.ndarray, reason: str) -> ResidualAnalysis:
    """Return an analysis without a choice."""
    nan = math.nan
    curve = pd.DataFrame(
        {"cutoff_hz": cutoffs, "residual": residual, "noise_line": nan, "in_band": False}
    )
    return ResidualAnalysis(
        cutoff_hz=nan, noise_rms=nan, band_hz=(nan, nan), curve=curve, reason=reason
    )


@lru_cache(maxsize=8192)
def _spent(n: int, share: float, order: int) -> float:
    """Return the parameters that the filter spends on a run of n samples."""
    return effective_parameters(
        lambda pulses: filter_run(pulses, cutoff_hz=share, fs_hz=1.0, order=order),
        n,
        reach=filter_reach(share, fs_hz=1.0),
    )


def _all_spent(runs: list[np.ndarray], share: float, order: int) -> float:
    """Return the parameters spent on all runs."""
    return sum(_spent(len(run), share, order) * run.shape[1] for run in runs)


def _gcv(runs: list[np.ndarray], share: float, order: int) -> float:
    """Return the cross-validation score of all runs together."""
    squares = _square_sum(runs, share, fs_hz=1.0, order=order)
    n = sum(run.size for run in runs)
    return gcv_score(squares, spent=_all_spent(runs, share, order), n=n)


def _gcv_noise(runs: list[np.ndarray], share: float, order: int) -> float:
    """Return the RMS of the noise: the residual with the parameters spent taken off n."""
    n = sum(run.size for run in runs)
    left = n - _all_spent(runs, share, order)
    return math.sqrt(_square_sum(runs, share, fs_hz=1.0, order=order) / left)


def _colour(runs: list[np.ndarray], cutoff_hz: float, fs_hz: float, order: int) -> float:
    """Return how far the residuals are from white: mean sum of squared autocorrelations."""
    total, n = 0.0, 0
    for run in runs:
        left = run - filter_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order)
        power = np.abs(np.fft.rfft(left - left.mean(axis=0), 2 * len(left), axis=0)) ** 2
        products = np.fft.irfft(power, axis=0)[: len(left)]
        moved = products[0] > 0.0
        shares = products[1:, moved] / products[0, moved]
        total += len(left) * float(np.sum(shares**2))
        n += len(left) * int(moved.sum())
    return total / n if n else math.inf
