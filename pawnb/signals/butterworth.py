"""Zero-lag Butterworth filter."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.signal import butter, sosfiltfilt

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.signals.runs import each_run, fill_gaps

_LEAST_BEND = 5
_BEND_PERIODS = 0.75


def two_pass_correction(order: int) -> float:
    """Compute the ratio between the cut-off of a two-pass filter and that of each pass.

    One pass of order m leaves ``1 / (1 + (w / w0)^(2m))`` of the power, two leave its square.
    That is one half where ``w / w0 = (sqrt(2) - 1)^(1 / (2m))``: 0.8022 for m = 2
    (Winter 2009; Robertson & Dowling 2003). In a digital filter w stands for
    ``tan(pi f / fs)``, so it is this that is divided by the ratio, and not the frequency;
    see :func:`one_pass_cutoff`.

    Parameters
    ----------
    order : int
        Total order, both passes together: 2, 4, 6, ...

    Returns
    -------
    float
        The ratio, below 1.

    Raises
    ------
    InputError
        If the order is odd or below 2: each pass has half of it.
    """
    if order < 2 or order % 2:
        raise InputError(
            f"order is {order}; expected an even number from 2 on, for each of the two passes "
            "has half of it (4: two passes of second order)."
        )
    return (math.sqrt(2.0) - 1.0) ** (1.0 / order)


def one_pass_cutoff(cutoff_hz: float, *, fs_hz: float, order: int = 4) -> float:
    """Compute the cut-off of each pass that gives a two-pass filter its own (Winter 2009).

    Parameters
    ----------
    cutoff_hz : float
        Cut-off of the whole filter, above 0 and below half the sampling rate, in Hz.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Total order, both passes together.

    Returns
    -------
    float
        Where one pass, of half the order, leaves half the power:
        ``fs / pi * atan(tan(pi cutoff / fs) / two_pass_correction(order))``, in Hz. It is below
        half the sampling rate, whatever the cut-off.
    """
    warped = math.tan(math.pi * cutoff_hz / fs_hz) / two_pass_correction(order)
    return math.atan(warped) * fs_hz / math.pi


def check_rate(fs_hz: float) -> None:
    """Refuse a sampling rate that cannot be.

    Parameters
    ----------
    fs_hz : float
        Sampling rate, in Hz.

    Raises
    ------
    InputError
        If it is not a number above 0.
    """
    if not (isinstance(fs_hz, int | float | np.number) and 0.0 < fs_hz < math.inf):
        raise InputError(f"fs_hz is {fs_hz!r}; expected a sampling rate above 0 Hz.")


def check_cutoff(cutoff_hz: float, *, fs_hz: float) -> None:
    """Refuse rates and cut-offs that cannot be.

    Parameters
    ----------
    cutoff_hz : float
        Cut-off, in Hz.
    fs_hz : float
        Sampling rate, in Hz.

    Raises
    ------
    InputError
        If the rate is not above 0 or the cut-off not between 0 and half of it.
    """
    check_rate(fs_hz)
    if not 0.0 < cutoff_hz < fs_hz / 2.0:
        raise InputError(
            f"cutoff_hz is {cutoff_hz:g}; expected above 0 and below {fs_hz / 2.0:g} Hz at a "
            f"sampling rate of {fs_hz:g} Hz."
        )


def filter_reach(cutoff_hz: float, *, fs_hz: float) -> int:
    """Return over how many samples a run is continued beyond its ends.

    Parameters
    ----------
    cutoff_hz : float
        Cut-off frequency, in Hz.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    int
        Three periods of the cut-off, in samples, and at least nine.
    """
    return max(9, math.ceil(3.0 * fs_hz / cutoff_hz))


def butterworth_lowpass(
    x: FloatArray, *, cutoff_hz: float, fs_hz: float, order: int = 4, max_gap: int = 0
) -> FloatArray:
    """Low-pass with a zero-lag Butterworth filter, of fourth order (paper 2009, Eq. 3.18).

    ``order`` is the total order: a filter of half of it (4: of second order) runs forwards and
    backwards, so nothing is delayed. The power that is left is one half (-3 dB) at
    ``cutoff_hz`` after both passes. One pass alone leaves half the power at a higher frequency
    (:func:`one_pass_cutoff`) and 0.707 of it, -1.5 dB, at ``cutoff_hz``. This is Winter's (2009)
    correction, made on the warped frequency of the digital filter; dividing the frequency
    itself by 0.802 gives 21.5 Hz where 20 are asked for at 100 Hz.

    Runs between gaps are filtered one by one; how their ends are continued is said at
    :func:`extend_run`. Values within about half a period of the cut-off from an end lean
    on that continuation, and derivatives there more so. A run of one sample stays as it is.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signals; NaN where missing.
    cutoff_hz : float
        Cut-off frequency of the whole filter, in Hz.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Total order, both passes together: 2, 4, 6, ...
    max_gap : int
        Gaps up to this many samples are interpolated first; see :func:`fill_gaps`.

    Returns
    -------
    ndarray, shape (n, ...)
        Filtered signals; NaN in the gaps that were not filled.

    Raises
    ------
    InputError
        If the order is odd or below 2, or the cut-off is not above 0 and below half the
        sampling rate.
    """
    two_pass_correction(order)
    check_cutoff(cutoff_hz, fs_hz=fs_hz)
    return each_run(
        fill_gaps(x, max_gap=max_gap),
        lambda run: filter_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz, order=order),
    )


def filter_run(run: FloatArray, *, cutoff_hz: float, fs_hz: float, order: int = 4) -> FloatArray:
    """Filter one run, or several of the same length, as :func:`butterworth_lowpass` does.

    Parameters
    ----------
    run : ndarray, shape (n,) or (n, k)
        Values without gaps.
    cutoff_hz, fs_hz : float
        Cut-off of the whole filter and sampling rate, in Hz.
    order : int
        Total order.

    Returns
    -------
    ndarray of the same shape
        Filtered values.
    """
    sections = _sections(cutoff_hz / fs_hz, order)
    longer, reach = extend_run(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz)
    out = sosfiltfilt(sections, longer, axis=0, padlen=0)
    return np.asarray(out[reach : reach + len(run)])


def extend_run(run: FloatArray, *, cutoff_hz: float, fs_hz: float) -> tuple[FloatArray, int]:
    """Continue a run beyond both ends, so that a smoother has something to lean on there.

    The run is reflected at the point at its end (odd extension) over three periods of the
    cut-off, so that a trend goes on. A reflected signal has no curvature at the end, and
    smoothed accelerations would go to 0 there whatever the signal does. So the curvature of the
    parabola through the last three quarters of a period of the cut-off (least squares, at least
    five samples) is taken off before and put back after: a parabola is continued exactly. A
    run that is shorter than that tells no curvature, and none is assumed.

    Parameters
    ----------
    run : ndarray, shape (n,) or (n, k)
        Values without gaps.
    cutoff_hz, fs_hz : float
        Cut-off of the smoother and sampling rate, in Hz.

    Returns
    -------
    longer : ndarray, shape (n + 2 reach,) or (n + 2 reach, k)
        The run with its continuations.
    reach : int
        Samples added at each end.
    """
    reach = filter_reach(cutoff_hz, fs_hz=fs_hz) if len(run) > 1 else 0
    bends = end_bends(run, cutoff_hz=cutoff_hz, fs_hz=fs_hz)
    before = _continuation(run, reach, bends[0])[::-1]
    after = _continuation(run[::-1], reach, bends[1])
    return np.concatenate((before, run, after)), reach


def end_bends(run: FloatArray, *, cutoff_hz: float, fs_hz: float) -> tuple[FloatArray, FloatArray]:
    """Return how a run bends at its ends.

    Parameters
    ----------
    run : ndarray, shape (n,) or (n, k)
        Values without gaps.
    cutoff_hz, fs_hz : float
        Cut-off of the smoother and sampling rate, in Hz.

    Returns
    -------
    first, last : ndarray, shape () or (k,)
        Half the second derivative, per sample squared, of the parabola through the three quarters
        of a period of the cut-off at that end (least squares, at least five samples); 0 where the
        run is shorter.
    """
    window = max(_LEAST_BEND, math.ceil(_BEND_PERIODS * fs_hz / cutoff_hz))
    if len(run) < window:
        return np.zeros(run.shape[1:]), np.zeros(run.shape[1:])
    weights = _bend_weights(window)
    return (
        np.tensordot(weights, run[:window], axes=1),
        np.tensordot(weights, run[::-1][:window], axes=1),
    )


def _continuation(run: FloatArray, reach: int, bend: FloatArray) -> FloatArray:
    """Continue a run that bends at its first sample beyond it; outwards."""
    one_axis = [1] * (run.ndim - 1)
    since = np.arange(float(len(run))).reshape(-1, *one_axis)
    widths = [(reach, 0), *[(0, 0)] * len(one_axis)]
    straight = np.pad(run - bend * since**2, widths, mode="reflect", reflect_type="odd")
    away = np.arange(1.0, reach + 1.0).reshape(-1, *one_axis)
    return np.asarray(straight[:reach][::-1] + bend * away**2)


@lru_cache(maxsize=256)
def _bend_weights(m: int) -> FloatArray:
    """Return the weights of m samples in the quadratic term of their parabola."""
    return np.asarray(np.linalg.pinv(np.vander(np.arange(m) / m, 3))[0] / m**2)


@lru_cache(maxsize=1024)
def _sections(share: float, order: int) -> FloatArray:
    """Return one pass of the filter; the cut-off is a share of the sampling rate."""
    return butter(order // 2, one_pass_cutoff(share, fs_hz=1.0, order=order), fs=1.0, output="sos")
