"""Densities of the phases of two pairs of legs at every instant, on the torus.

After DeAngelis, Zavatone-Veth & Clark (2019, eLife 8: e46409): where all gaits of an animal lie,
not only their mean once a stride. Islands are gaits apart from each other, a band is a continuum.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from pawnb.arrays import BoolArray, FloatArray
from pawnb.errors import InputError
from pawnb.gait.cycles.leg_signals import LegSignals
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.gait.phases.relative_phase import phase_angle
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

DENSITY_COLUMNS = (
    "leg_x", "reference_x", "leg_y", "reference_y", "phase_x", "phase_y", "density", "n_animals",
    "n_samples",
)  # fmt: skip
_FEWEST_BINS = 8
_MOST_HARMONICS = 24
"""Of the density of phases; fewer where a stride has so few samples that they would be aliases. Set
by hand: a foot that stands for 0.75 of the stride needs about 10."""


class Plane(NamedTuple):
    """Two pairs of legs whose phases are looked at together.

    Attributes
    ----------
    x, y : tuple of str
        Leg and its reference.
    """

    x: tuple[str, str]
    y: tuple[str, str]


@checked_arguments
def default_planes(legs: Sequence[str]) -> list[Plane]:
    """Choose pairs of legs to look at together: across the body, and along its right side.

    Parameters
    ----------
    legs : sequence of str
        Names of legs.

    Returns
    -------
    list of Plane
        For each right leg that has a partner on the left and a neighbour behind: the partner after
        it, and the neighbour after it. Of four legs that is one plane, in which every symmetrical
        gait has a place of its own: trot (0.5, 0.5), pace (0.5, 0), bound (0, 0.5).
    """
    places = {find_leg_place(leg): leg for leg in sort_legs(legs)}
    ranks = sorted({place.rank for place in places if place is not None})
    found = []
    for rank, behind in pairwise(ranks):
        by_side = {
            (place.side, place.rank): leg for place, leg in places.items() if place is not None
        }
        names = [by_side.get(key) for key in (("L", rank), ("R", rank), ("R", behind))]
        if all(names):
            left, right, hind = (str(name) for name in names)
            found.append(Plane((left, right), (hind, right)))
    return found


@checked_arguments
def phase_density(
    signals: Sequence[LegSignals],
    strides: pd.DataFrame,
    *,
    planes: Sequence[Plane | tuple[tuple[str, str], tuple[str, str]]] | None = None,
    bins: int = 48,
    bandwidth_cycles: float = 0.03,
) -> pd.DataFrame:
    """Compute how often two pairs of legs are at each pair of phases, at every instant.

    The phase of a leg at an instant is that of its analytic signal
    (:func:`pawnb.gait.phases.relative_phase.phase_angle`), made to grow evenly
    (:func:`even_phase`); a lag is the phase of the reference less that of the leg, later being
    positive, as for phases by events. Samples count where all legs of a plane are within a stride
    that counts. Each animal gives one density, and their mean is taken, so that the one that was
    filmed longest does not decide.

    Parameters
    ----------
    signals : sequence of LegSignals
        Leg angles, or positions along forward, of one or more trials.
    strides : pandas.DataFrame
        Strides that count.
    planes : sequence of Plane, optional
        Which pairs of legs; default :func:`default_planes`.
    bins : int
        Bins of each axis.
    bandwidth_cycles : float
        Standard deviation of the wrapped Gaussian with which the samples are smoothed, cycles. A
        tenth of a cycle blurs gaits into each other; below 0.02 single strides show as lines.

    Returns
    -------
    pandas.DataFrame
        ``DENSITY_COLUMNS``, a row a plane and bin: ``phase_x`` and ``phase_y`` are the middle of
        the bin, ``density`` is relative to chance, whose density is 1 everywhere.

    Raises
    ------
    InputError
        If the signals are of several kinds, a leg is not there, no plane can be chosen, an option
        makes no sense, or no sample counts.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> table = pawnb.gait.phases.density.phase_density(angles, gait.strides)
    """
    check_columns(strides, ("animal", "trial", "leg", "start_s", "period_s"), where="strides")
    kinds = sorted({f"{one.signal} ({one.unit})" for one in signals})
    if len(kinds) != 1:
        raise InputError(f"phase density: signals are {kinds}; expected those of one kind.")
    if bins < _FEWEST_BINS or not 0.0 < bandwidth_cycles < 0.5:
        raise InputError(
            f"bins is {bins}, bandwidth_cycles {bandwidth_cycles}; expected {_FEWEST_BINS} bins or "
            "more, and a bandwidth between 0 and 0.5."
        )
    legs = list(dict.fromkeys(leg for one in signals for leg in one.legs))
    chosen = default_planes(legs) if planes is None else [Plane(*plane) for plane in planes]
    if not chosen:
        raise InputError(
            f"phase density: legs {', '.join(legs)} name no two pairs that share one leg; name "
            "them with planes."
        )
    for name in (leg for plane in chosen for pair in plane for leg in pair):
        if name not in legs:
            raise InputError(f"phase density: no leg {name!r}; there are {', '.join(legs)}.")
    parts = [_of_plane(signals, strides, plane, bins, bandwidth_cycles) for plane in chosen]
    known = [part for part in parts if part is not None]
    if not known:
        raise InputError("phase density: at no instant are the legs of a plane within strides.")
    return pd.concat(known, ignore_index=True)


def _of_plane(
    signals: Sequence[LegSignals], strides: pd.DataFrame, plane: Plane, bins: int, width: float
) -> pd.DataFrame | None:
    """Return the density of one plane; None where no sample counts."""
    counts: dict[str, np.ndarray] = {}
    for one in signals:
        if not {leg for pair in plane for leg in pair} <= set(one.legs):
            continue
        lags = _lags(one, strides, plane)
        if len(lags):
            own = np.histogram2d(lags[:, 0], lags[:, 1], bins=bins, range=((0, 1), (0, 1)))[0]
            counts[one.animal] = counts.get(one.animal, 0.0) + own
    if not counts:
        return None
    mean = np.mean([own / own.sum() for own in counts.values()], axis=0) * bins**2
    density = _smooth(mean, width)
    middle = (np.arange(bins) + 0.5) / bins
    x, y = np.meshgrid(middle, middle, indexing="ij")
    found = {
        "leg_x": plane.x[0], "reference_x": plane.x[1], "leg_y": plane.y[0],
        "reference_y": plane.y[1], "phase_x": x.ravel(), "phase_y": y.ravel(),
        "density": density.ravel(), "n_animals": len(counts),
        "n_samples": int(sum(own.sum() for own in counts.values())),
    }  # fmt: skip
    return pd.DataFrame(found)[list(DENSITY_COLUMNS)]


def _lags(one: LegSignals, strides: pd.DataFrame, plane: Plane) -> FloatArray:
    """Return the two lags at every sample at which all legs are within strides, shape (n, 2)."""
    names = list(dict.fromkeys(leg for pair in plane for leg in pair))
    phases = {
        leg: even_phase(
            phase_angle(one.samples[:, one.legs.index(leg)]), _within(one, strides, leg)
        )
        for leg in names
    }
    both = [np.mod(phases[pair[1]] - phases[pair[0]], 1.0) for pair in plane]
    counts = np.isfinite(both[0]) & np.isfinite(both[1])
    lags: np.ndarray = np.column_stack(both)[counts]
    return lags


@checked_arguments
def even_phase(phase: FloatArray, counts: BoolArray) -> FloatArray:
    """Make a phase grow evenly over the stride, on average over a trial.

    A leg that swings fast and stands long runs through half of its phase in the swing, so that the
    lag of a steady gait would seem to swing to and fro within each stride. The phase is replaced by
    the integral of its density, a Fourier series (Kralemann et al. 2008, Phys. Rev. E 77: 066205);
    ranks would be off by up to a sample.

    Parameters
    ----------
    phase : ndarray, shape (n,)
        Phase at each sample, cycles in [0, 1); NaN where not known.
    counts : ndarray of bool, shape (n,)
        Samples within whole strides.

    Returns
    -------
    ndarray, shape (n,)
        Phase in [0, 1), NaN where it does not count; 0 stays 0.
    """
    even = np.full(len(phase), np.nan)
    known = counts & np.isfinite(phase)
    if known.any():
        angle = 2.0 * np.pi * phase[known]
        turns = max(1.0, float(np.abs(np.diff(np.unwrap(angle))).sum()) / (2.0 * np.pi))
        most = int(np.clip(len(angle) / turns / 2.0 - 1.0, 1.0, _MOST_HARMONICS))
        shift = np.zeros(len(angle))
        for n in range(1, most + 1):
            density = np.exp(-1j * n * angle).mean()
            shift += 2.0 / n * (density * (np.exp(1j * n * angle) - 1.0)).imag
        even[known] = np.mod((angle + shift) / (2.0 * np.pi), 1.0)
    return even


def _within(one: LegSignals, strides: pd.DataFrame, leg: str) -> BoolArray:
    """Say which samples are within a stride of a leg that counts."""
    whose = strides["animal"].astype(str) == one.animal
    own = strides[whose & (strides["trial"].astype(str) == one.trial) & (strides["leg"] == leg)]
    inside = np.zeros(len(one.time_s), dtype=bool)
    start = own["start_s"].to_numpy(dtype=float)
    for first, last in zip(start, start + own["period_s"].to_numpy(dtype=float), strict=True):
        inside[np.searchsorted(one.time_s, first) : np.searchsorted(one.time_s, last)] = True
    return inside


def _smooth(density: FloatArray, width: float) -> FloatArray:
    """Smooth on the torus by a wrapped Gaussian: its Fourier series is known."""
    bins = len(density)
    wave = np.exp(-2.0 * (np.pi * width * np.fft.fftfreq(bins, 1.0 / bins)) ** 2)
    smoothed = np.fft.ifft2(np.fft.fft2(density) * np.outer(wave, wave)).real
    return np.maximum(smoothed, 0.0)
