"""The stride as a cycle: where each point is expected at each moment of the animal's stride.

Learnt from the recording itself. The phase of the stride is common to all points and is
read from their motion along the animal (complex demodulation, then correction against the
learnt cycle); the cycle of each point is the smoothest closed curve through where it was
seen, relative to the slowly moving body. A point that is occluded, or whose tracklets could
belong to another, is expected where it is in other strides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len
from scipy.ndimage import correlate1d, gaussian_filter1d

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.stride.parameters import STRIDE

_FINER = 5
"""Numerics: the periodogram has so many times the frequencies that frames tell, so that its highest
peak lies near one of them."""
_TRUNCATED = 4.0
"""Numerics: standard deviations at which a Gaussian window ends, as in SciPy."""


@dataclass(frozen=True)
class Cycle:
    """Where points are expected.

    Parameters
    ----------
    mean : ndarray, shape (n, P, d)
        Expected positions.
    sd : ndarray, shape (n, P, d)
        Their standard deviations along the axes.
    axes : ndarray, shape (d, d)
        Unit vectors: forward, across, up.
    phase : ndarray, shape (n,)
        Phase of the stride in cycles; it grows by one with every stride.
    stride : float
        Mean length of a stride in frames.
    """

    mean: FloatArray
    sd: FloatArray
    phase: FloatArray
    axes: FloatArray
    stride: float

    def square(self, frames: IntArray | int, point: int, x: FloatArray) -> FloatArray:
        """Return the squared distance of positions (..., d), in standard deviations.

        Parameters
        ----------
        frames : ndarray of int or int
            Rows.
        point : int
            Number of the point.
        x : ndarray, shape (..., d)
            Positions.

        Returns
        -------
        ndarray, shape (...)
            Squared distances.
        """
        step = (x - self.mean[frames, point]) @ self.axes.T
        return np.asarray(((step / self.sd[frames, point]) ** 2).sum(axis=-1))


def learn_cycle(
    x: FloatArray,
    body: FloatArray,
    *,
    axes: FloatArray,
    frames: tuple[float, float],
    noise: float,
    trust: FloatArray,
) -> Cycle | None:
    """Learn the cycle of every point.

    Parameters
    ----------
    x : ndarray, shape (n, P, d)
        Tracks, NaN where occluded.
    body : ndarray, shape (n, d)
        The slowly moving middle of the body.
    axes : ndarray, shape (d, d)
        Unit vectors: forward, across, up.
    frames : tuple of float
        Shortest and longest stride considered, frames.
    noise : float
        Standard deviation of a place: expectations are never surer.
    trust : ndarray, shape (n, P)
        How much each place counts, 0 to 1.

    Returns
    -------
    Cycle or None
        None where the points do not move in cycles or the recording is too short.
    """
    relative = (x - body[:, None]) @ axes.T
    along = relative[..., 0]
    seen = np.isfinite(along)
    if (seen.sum(axis=0) < 2 * STRIDE.cycle_bins).any():
        return None
    along = np.where(seen, along - np.nanmean(along, axis=0), 0.0)
    stride = _stride(along, seen, frames)
    if stride is None or len(x) < STRIDE.least_strides * stride:
        return None
    phase = _common_phase(along, seen, stride)
    for k in range(STRIDE.cycle_rounds):
        curves = [
            _closed_curve(phase, relative[:, p], seen[:, p], trust[:, p]) for p in range(x.shape[1])
        ]
        if k < STRIDE.cycle_rounds - 1:
            later, moved = _correction(phase, curves, relative, seen, stride)
            phase, body = phase + later, body + moved @ axes
            relative = relative - moved[:, None]
    mean = np.stack([_at(curve, phase) for curve, _ in curves], axis=1)
    away = np.where(seen[..., None], (relative - mean) ** 2, 0.0)
    left = away[..., 0]
    # medians: a few wrong tracklets do not unmake a cycle
    explained = 1.0 - np.median(left[seen]) / max(np.median(along[seen] ** 2), 1e-12)
    if not along.any() or explained < STRIDE.least_share:
        return None
    unsure = [_how_unsure(phase, relative[:, p], seen[:, p], *curves[p]) for p in range(x.shape[1])]
    sd = np.stack(
        [_spread(phase, away[:, p], seen[:, p], unsure[p], noise) for p in range(x.shape[1])],
        axis=1,
    )
    return Cycle(mean @ axes + body[:, None], sd, phase, axes, stride)


def _stride(along: FloatArray, seen: BoolArray, frames: tuple[float, float]) -> float | None:
    """Return the commonest length of a stride, frames, from the periodogram of all points."""
    n = len(along)
    low, high = 1.0 / min(frames[1], n / 2.0), 1.0 / frames[0]
    if low >= high:
        return None
    size = next_fast_len(_FINER * n)
    frequency = np.arange(size // 2 + 1) / size
    wave = np.abs(np.fft.rfft(np.where(seen, along, 0.0), size, axis=0)) ** 2
    within = (frequency >= low) & (frequency <= high)
    power = np.where(within, (wave / seen.sum(axis=0)).sum(axis=1), -1.0)
    return float(1.0 / frequency[int(np.argmax(power))])


def _common_phase(along: FloatArray, seen: BoolArray, stride: float) -> FloatArray:
    """Return the phase (n,) of the stride, cycles, by demodulation at its mean frequency."""
    time = np.arange(len(along))
    carrier = np.exp(-2j * np.pi * time / stride)[:, None]
    width = STRIDE.cycle_window * stride
    part = np.where(seen, along, 0.0) * carrier
    weight = gaussian_filter1d(seen.astype(float), width, axis=0, mode="constant") + 1e-9
    real = gaussian_filter1d(part.real, width, axis=0, mode="constant") / weight
    imaginary = gaussian_filter1d(part.imag, width, axis=0, mode="constant") / weight
    own = (real + 1j * imaginary) * np.minimum(weight * STRIDE.cycle_full, 1.0)
    common = own[:, :1]
    for _ in range(STRIDE.cycle_phase_rounds):
        lag = (own * common.conj()).sum(axis=0)
        common = (own * np.exp(-1j * np.angle(lag))).sum(axis=1, keepdims=True)
    return np.asarray(time / stride + np.unwrap(np.angle(common[:, 0])) / (2 * np.pi))


def _weights(phase: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the two bins beside each phase and the weight of the second."""
    at = (phase % 1.0) * STRIDE.cycle_bins
    first = np.floor(at).astype(int) % STRIDE.cycle_bins
    return first, (first + 1) % STRIDE.cycle_bins, at - np.floor(at)


def _at(curve: FloatArray, phase: FloatArray) -> FloatArray:
    """Return a closed curve (bins, d) at some phases."""
    a, b, w = _weights(phase)
    return np.asarray(curve[a] * (1 - w[:, None]) + curve[b] * w[:, None])


def _basis(phase: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what each bin weighs at some phases (n, bins), and third differences (bins, bins)."""
    a, b, w = _weights(phase)
    basis = np.zeros((len(a), STRIDE.cycle_bins))
    rows = np.arange(len(a))
    basis[rows, a] += 1 - w
    basis[rows, b] += w
    eye = np.eye(STRIDE.cycle_bins)
    return basis, np.roll(eye, -2, 1) - 3 * np.roll(eye, -1, 1) + 3 * eye - np.roll(eye, 1, 1)


def _closed_curve(
    phase: np.ndarray, x: np.ndarray, seen: np.ndarray, trust: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the smoothest closed curve (bins, d) through places, and what each place weighed.

    The third differences along the curve are kept small; places far from the curve count
    less and less.
    """
    basis, third = _basis(phase[seen])
    places, trust = x[seen], trust[seen]
    weight = trust
    stiff = STRIDE.cycle_stiff * len(places)
    for _ in range(STRIDE.cycle_curve_rounds):
        N = (
            basis.T @ (basis * weight[:, None])
            + stiff * (third.T @ third)
            + 1e-6 * np.eye(STRIDE.cycle_bins)
        )
        curve = np.linalg.solve(N, basis.T @ (places * weight[:, None]))
        square = ((places - basis @ curve) ** 2).mean(axis=1)
        scale = max(float(np.median(square)), 1e-12)
        weight = trust / (1.0 + square / (STRIDE.cycle_tail * scale))
    return curve, weight


def _how_unsure(
    phase: FloatArray, x: FloatArray, seen: BoolArray, curve: FloatArray, weight: FloatArray
) -> FloatArray:
    """Return the standard error (bins, d) of a closed curve."""
    basis, third = _basis(phase[seen])
    scale = np.median((x[seen] - basis @ curve) ** 2, axis=0) + 1e-12
    # where nothing was seen the curve is only as sure as its usual bends are small
    observed = gaussian_filter1d(basis.sum(axis=0), 1.0, mode="wrap") > 1.0
    bend = ((third @ curve) ** 2)[observed].mean(axis=0) + 1e-12
    unsure = []
    for s2, j2 in zip(scale, bend, strict=True):
        N = basis.T @ (basis * weight[:, None]) / (STRIDE.cycle_alike * s2) + third.T @ third / j2
        unsure.append(
            np.sqrt(np.diag(np.linalg.inv(N + 1e-9 * np.eye(STRIDE.cycle_bins) * N.max())))
        )
    return np.stack(unsure, axis=1)


def _correction(
    phase: FloatArray,
    curves: list[tuple[np.ndarray, np.ndarray]],
    relative: FloatArray,
    seen: BoolArray,
    stride: float,
) -> tuple[FloatArray, FloatArray]:
    """Return by how much the phase (n,) and the body (n, d) must change.

    With that the points lie on their cycles, by least squares within a window. The middle of
    the body as it was followed before moves with the stride wherever the window over which it
    was averaged holds no whole number of strides, most of all at both ends.
    """
    n, _, d = relative.shape
    normal = np.zeros((n, 1 + d, 1 + d))
    target = np.zeros((n, 1 + d))
    for p, (curve, _) in enumerate(curves):
        slope = (np.roll(curve, -1, 0) - np.roll(curve, 1, 0)) * (STRIDE.cycle_bins / 2.0)
        # what the place changes with: the phase, and the body along each axis
        by = np.concatenate([_at(slope, phase)[:, None], np.tile(np.eye(d), (n, 1, 1))], axis=1)
        step = np.where(seen[:, p, None], relative[:, p] - _at(curve, phase), 0.0)
        square = (step**2).sum(axis=1)
        scale = np.median(square[seen[:, p]]) + 1e-12
        weight = seen[:, p] / (1.0 + square / (STRIDE.cycle_tail * scale))
        normal += weight[:, None, None] * (by @ by.transpose(0, 2, 1))
        target += weight[:, None] * (by @ step[..., None])[..., 0]
    change = _local_line(normal, target, STRIDE.cycle_window * stride)
    return np.clip(change[:, 0], -STRIDE.cycle_most_shift, STRIDE.cycle_most_shift), change[:, 1:]


def _local_line(normal: np.ndarray, target: np.ndarray, width: float) -> np.ndarray:
    """Return what solves equations (n, k, k) and (n, k) about each frame, (n, k).

    The unknowns are straight lines in time within a Gaussian window: at both ends, where half
    of it is missing, a mean would lag behind.
    """
    n, k = target.shape
    time = np.arange(-(m := int(_TRUNCATED * width + 0.5)), m + 1) / width
    window = np.exp(-0.5 * time**2) / (width * np.sqrt(2.0 * np.pi))
    big, right = np.empty((n, 2 * k, 2 * k)), np.empty((n, 2 * k))
    for i in range(2):
        rows = slice(i * k, i * k + k)
        right[:, rows] = correlate1d(target, window * time**i, axis=0, mode="constant")
        for j in range(2):
            big[:, rows, j * k : j * k + k] = correlate1d(
                normal, window * time ** (i + j), axis=0, mode="constant"
            )
    usual = np.tile(big[:, :k, :k].mean(axis=0).diagonal(), 2)
    return np.linalg.solve(big + STRIDE.cycle_ridge * np.diag(usual), right[..., None])[:, :k, 0]


def _spread(
    phase: FloatArray, away: FloatArray, seen: BoolArray, unsure: FloatArray, noise: float
) -> FloatArray:
    """Return the standard deviations (n, d) of expectations, by phase."""
    a, _, _ = _weights(phase[seen])
    # a few wrong tracklets must not make every expectation vague
    part = np.minimum(away[seen], STRIDE.cycle_farthest * np.median(away[seen], axis=0))
    total = np.stack([np.bincount(a, column, STRIDE.cycle_bins) for column in part.T], axis=1)
    count = np.bincount(a, minlength=STRIDE.cycle_bins).astype(float)[:, None]
    total = gaussian_filter1d(total, STRIDE.cycle_sd_bins, axis=0, mode="wrap")
    count = gaussian_filter1d(count, STRIDE.cycle_sd_bins, axis=0, mode="wrap")
    typical = total.sum(axis=0) / max(count.sum(), 1e-9)
    square = (total + STRIDE.cycle_typical * typical) / (count + STRIDE.cycle_typical)
    square = square + unsure**2 + noise**2
    return np.sqrt(_at(square, phase))
