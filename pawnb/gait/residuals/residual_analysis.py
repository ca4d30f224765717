"""Choosing the cut-off of a low-pass filter from the signal itself (paper 2009, §3.5, Fig. 3.11).

By residual analysis (Winter 2009); :mod:`pawnb.gait.residuals.cutoffs` has two further ways beside
it. All of them are estimates. Look at the filtered signal and its derivatives before you use one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.residuals.cutoff_scores import (
    LEAST_SAMPLES,
    NO_CUTOFF,
    STRAIGHT_LINE,
    Choice,
    are_straight,
    cross_validate,
    find_long_runs,
    residual_rms,
    why_no_runs,
)
from pawnb.gait.residuals.noise_band import find_noise_band, given_band
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import two_pass_correction
from pawnb.signals.butterworth import check_rate

ESTIMATE_WARNING = (
    "An estimate, not a measurement: Yu et al. (1999) found that cut-offs from residual "
    "analysis do not follow the best ones and are too low for accelerations, most at high "
    "sampling rates. Look at the filtered signal and its derivatives."
)
"""What goes with every automatic choice."""

CURVE_COLUMNS = ("cutoff_hz", "residual", "noise_line", "in_band")
_CUTOFF_STEPS = 101
_ALL_NOISE = 0.95
DOUBT = 1.6
"""Set by hand: how many times the noise of cross-validation, or of the band's other half, is too
much. Real tracks of a mouse (400 Hz) and a rat (250 Hz): up to 1.1 as filmed; the same with fewer
frames, which does not change the noise: above 1.6 it came out 3 to 17 times too large."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualAnalysis:
    """Residual analysis of one signal, or of several pooled.

    Parameters
    ----------
    cutoff_hz : float
        The cut-off; NaN where none can be had this way, and ``reason`` says why.
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


@checked_arguments
def analyse_residuals(
    x: FloatArray,
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
    point itself is replaced by a floor, which takes part in the fit.

    Three things differ from there on purpose. The cut-off is exact, see
    :func:`~pawnb.signals.butterworth_lowpass`: without that the cut-offs near half the sampling
    rate are not what they are called, and the residual of white noise is no straight line. The
    floor is a share of the signal's range, not of its unit, so that degrees and radians give the
    same cut-off. Ends are continued over three periods of the cut-off, not over nine samples.
    On five harmonics with white noise of known size (2 % of the first and 40 to 500 frames a
    period; 0.2 % and 125 to 500; 2 to 20 periods) the line gives 94 to 100 % of the noise, and
    the cut-off is within 10 % of that at which the residual of an endless recording equals the
    noise. ``optcutfreq`` chooses 4 to 40 % below that, the more the more frames make a period.

    No cut-off can be had this way where the tail of the curve is not noise alone, as where few
    frames make a period of the movement: the line then measures signal. It is seen by the
    height of the line at 0 Hz, more than 1.6 times the noise that cross-validation finds, or
    more than 1.6 times as high through the lower half of the band as through the upper. A cut-off
    read in a band that was given is kept, and ``reason`` says so.

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
    found = analyse_what_is_there(x, fs_hz=fs_hz, order=order, band_hz=band_hz)
    if found.curve["residual"].isna().all():
        raise InputError(
            f"residual analysis: {why_no_runs(x)}; expected at least one run of {LEAST_SAMPLES}: "
            "fill the gaps or leave this signal out."
        )
    return found


def analyse_what_is_there(
    x: FloatArray,
    *,
    fs_hz: float,
    order: int = 4,
    band_hz: tuple[float, float] | None = None,
) -> ResidualAnalysis:
    """Choose a cut-off as :func:`analyse_residuals` does; say so where there is too little of it.

    Parameters
    ----------
    x, fs_hz, order, band_hz
        As there.

    Returns
    -------
    ResidualAnalysis
        The same; where no run is long enough the residual is NaN and ``reason`` says why, so
        that one signal that is hardly ever seen does not keep the others from being looked at.
    """
    cutoffs = residual_cutoffs(fs_hz, order=order)
    runs = find_long_runs(x)
    if not runs:
        nothing = np.full(len(cutoffs), math.nan)
        return _nothing(cutoffs, nothing, f"{NO_CUTOFF}{why_no_runs(x)}")
    return analyse_runs(runs, fs_hz=fs_hz, order=order, band_hz=band_hz, validated=None)


def analyse_runs(
    runs: list[FloatArray],
    *,
    fs_hz: float,
    order: int,
    band_hz: tuple[float, float] | None,
    validated: Choice | None,
) -> ResidualAnalysis:
    """Choose a cut-off for runs without gaps, as :func:`analyse_residuals` does.

    Parameters
    ----------
    runs : list of ndarray, shape (n,) or (n, k)
        The runs.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the filter, both passes together.
    band_hz : tuple of float or None
        Ends of the straight part, in Hz; None where it is to be found.
    validated : Choice or None
        What cross-validation finds in these runs; computed where it is not given.

    Returns
    -------
    ResidualAnalysis
        Cut-off, curve and line.
    """
    cutoffs = residual_cutoffs(fs_hz, order=order)
    residual = np.array([residual_rms(runs, c, fs_hz=fs_hz, order=order) for c in cutoffs])
    scale = max(float(np.ptp(run, axis=0).max()) for run in runs)
    if are_straight(runs):
        return _nothing(cutoffs, residual, f"{NO_CUTOFF}{STRAIGHT_LINE}")
    if band_hz is not None:
        ends = given_band(cutoffs, band_hz)
        said = "in the band given"
    else:
        found = find_noise_band(cutoffs, residual / scale)
        if isinstance(found, str):
            return _nothing(cutoffs, residual, found)
        ends = found
        said = "after three lifetimes of the curve's decay"
    read = _read_off(cutoffs, residual, ends, said)
    if validated is None:
        validated = cross_validate(runs, fs_hz=fs_hz, order=order)
    doubt = _doubt(read, ends, validated)
    if not doubt or not math.isfinite(read.cutoff_hz):
        return read
    if band_hz is not None:
        return replace(read, reason=f"{read.reason}; but {doubt}")
    return _nothing(cutoffs, residual, f"{NO_CUTOFF}{doubt}")


def _doubt(read: ResidualAnalysis, ends: tuple[int, int], validated: Choice) -> str:
    """Say why the line that was fitted is not that of noise alone; empty where it may be."""
    what = ""
    if read.noise_rms > DOUBT * validated.noise_rms:
        times = read.noise_rms / validated.noise_rms
        what = (
            f"the line's noise of {read.noise_rms:.3g} is {times:.2g} times the "
            f"{validated.noise_rms:.3g} of cross-validation"
        )
    else:
        first, last = ends
        middle = (first + last) // 2
        x, y = (read.curve[name].to_numpy() for name in ("cutoff_hz", "residual"))
        lower, upper = (
            float(np.polyfit(x[a:b], y[a:b], 1)[1])
            for a, b in ((first, middle + 1), (middle, last))
        )
        if lower > DOUBT * upper:
            what = (
                f"the curve has no straight tail: a line through its lower half starts at "
                f"{lower:.3g}, one through its upper half at {upper:.3g}"
            )
    if not what:
        return ""
    return f"{what}, so that signal reaches to the end of the curve; {say_instead(validated)}"


def say_instead(validated: Choice) -> str:
    """Say what to do where residual analysis has no answer."""
    if validated.reason.startswith(NO_CUTOFF):
        return "filter only lightly, or film faster"
    return f"take that of cross-validation, {validated.cutoff_hz:.3g} Hz, or film faster"


@checked_arguments
def residual_cutoffs(fs_hz: float, *, order: int = 4) -> FloatArray:
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
        Cut-offs in Hz, evenly spaced up to, and without, half the sampling rate times
        :func:`~pawnb.signals.two_pass_correction`, as in ``optcutfreq``.

    Raises
    ------
    InputError
        If the sampling rate is not above 0 or the order is odd or below 2.
    """
    check_rate(fs_hz)
    highest = two_pass_correction(order) * fs_hz / 2.0
    return np.linspace(fs_hz / 200.0, highest, _CUTOFF_STEPS, endpoint=False)


def _read_off(
    cutoffs: FloatArray, residual: FloatArray, ends: tuple[int, int], said: str
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
    if noise > _ALL_NOISE * residual[0]:
        return _nothing(
            cutoffs,
            residual,
            f"{NO_CUTOFF}the noise line starts at {noise:.3g}, where the curve itself does: "
            "there is nothing but noise",
        )
    if noise <= 0.0 or len(down) == 0:
        reason = f"{NO_CUTOFF}the curve does not cross the noise of {noise:.3g} ({where})"
        return ResidualAnalysis(
            cutoff_hz=math.nan, noise_rms=noise, band_hz=band, curve=curve, reason=reason
        )
    k = int(down[0])
    cutoff = float(brentq(CubicSpline(cutoffs, above), cutoffs[k], cutoffs[k + 1]))
    reason = f"the residual equals the noise of {noise:.3g} RMS at {cutoff:.3g} Hz ({where})"
    return ResidualAnalysis(
        cutoff_hz=cutoff, noise_rms=noise, band_hz=band, curve=curve, reason=reason
    )


def _nothing(cutoffs: FloatArray, residual: FloatArray, reason: str) -> ResidualAnalysis:
    """Return an analysis without a choice."""
    nan = math.nan
    curve = pd.DataFrame(
        {"cutoff_hz": cutoffs, "residual": residual, "noise_line": nan, "in_band": False}
    )
    return ResidualAnalysis(
        cutoff_hz=nan, noise_rms=nan, band_hz=(nan, nan), curve=curve, reason=reason
    )
