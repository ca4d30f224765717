"""Continuous relative phase of two legs: at every instant, not once a stride."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import hilbert

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.circular.mean import mean_vector
from pawnb.gait.inference.checks import as_numbers
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import find_runs

_SHORTEST_SERIES = 8
_LARGEST = 1e150  # whose square is finite


@dataclass(frozen=True, kw_only=True, eq=False)
class RelativePhase:
    """Continuous relative phase and its summary.

    Parameters
    ----------
    phase : ndarray, shape (n,)
        How far the leg is ahead of the reference at each sample, cycles in [0, 1); NaN where
        either is missing.
    mean : float
        Mean relative phase, cycles (circular).
    deviation_phase : float
        Circular standard deviation over the samples, cycles: small where the coupling is
        stable.
    r : float
        Length of the mean vector.
    """

    phase: FloatArray
    mean: float
    deviation_phase: float
    r: float


@checked_arguments
def phase_angle(x: FloatArray) -> FloatArray:
    """Return the phase of an oscillation at every sample, by the Hilbert transform.

    The signal is centred about the middle of its upper and lower envelope, stretch by
    stretch (Lamb & Stöckl 2014, Clin. Biomech. 29: 484: phase planes of position and velocity
    give artefacts where the movement is not sinusoidal).

    Parameters
    ----------
    x : ndarray, shape (n,)
        Position of a foot along forward, or its leg angle; NaN where missing.

    Returns
    -------
    ndarray, shape (n,)
        Cycles in [0, 1): 0 at the anterior extreme, 0.5 at the posterior one. NaN where x is
        missing and in stretches of fewer than 8 samples.
    """
    x = as_numbers(x, "signal")
    out = np.full(len(x), np.nan)
    for start, stop in find_runs(np.abs(x) < _LARGEST):
        run = x[start:stop]
        if len(run) < _SHORTEST_SERIES or not np.ptp(run) > 0:
            continue
        centred = run - (run.max() + run.min()) / 2.0
        # mirrored at both ends: the transform takes the signal to be periodic
        padded = np.concatenate((centred[::-1], centred, centred[::-1]))
        angle = np.angle(hilbert(padded))[len(run) : 2 * len(run)]
        out[start:stop] = np.mod(angle / (2.0 * np.pi), 1.0)
    return out


@checked_arguments
def continuous_relative_phase(x: FloatArray, reference: FloatArray) -> RelativePhase:
    """Compute how far one leg is ahead of another at every sample.

    Parameters
    ----------
    x, reference : ndarray, shape (n,)
        Position along forward (or leg angle) of the leg and of the reference.

    Returns
    -------
    RelativePhase
        Phase of the leg minus phase of the reference. A leg that comes a quarter of a cycle
        *later* has 0.75; its phase lag by events (Eq. 3.21 of Pullar 2009) is 1 minus this.

    Raises
    ------
    InputError
        If the signals differ in length or never overlap.
    """
    x, reference = as_numbers(x, "signal"), as_numbers(reference, "reference")
    if x.shape != reference.shape:
        raise InputError(
            f"the signals have shapes {x.shape} and {reference.shape}; expected two of one length."
        )
    phase = np.mod(phase_angle(x) - phase_angle(reference), 1.0)
    known = phase[np.isfinite(phase)]
    if not len(known):
        raise InputError("the two legs are never seen together for 8 samples.")
    mean, r, _ = mean_vector(known)
    spread = float(np.sqrt(max(0.0, -2.0 * np.log(r))) / (2.0 * np.pi)) if r > 0 else np.inf
    return RelativePhase(phase=phase, mean=mean, deviation_phase=spread, r=r)
