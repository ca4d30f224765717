"""Paths of the feet, direction of travel, and the frame of the body they are seen from.

Positions are arrays of shape (n, d, k): n samples, d = 2 or 3 coordinates, k feet;
NaN where missing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.signals import butterworth_lowpass, dominant_frequency, fill_gaps_of_points

TRAVEL_FACTOR = 2.0
"""An animal travels when it gets further than this many excursions of its feet."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyFrame:
    """Origin and heading of the body, sample by sample.

    Parameters
    ----------
    origin : ndarray, shape (n, d)
        Origin from which positions of the feet are measured.
    forward : ndarray, shape (n, d)
        Unit vectors towards the front.
    path : ndarray, shape (n, d)
        Where the body is in the laboratory: its points, or the low-passed mean of the
        feet. Seen from the laboratory, on a treadmill, the origin stays and the path drifts.
    method : str
        ``"body points"``, ``"laboratory"``, ``"other points"`` or ``"mean of the feet"``.
    """

    origin: FloatArray
    forward: FloatArray
    path: FloatArray
    method: str

    def fore_aft(self, positions: FloatArray) -> FloatArray:
        """Return how far in front of the origin each foot is.

        Parameters
        ----------
        positions : ndarray, shape (n, d, k)
            Positions of the feet.

        Returns
        -------
        ndarray, shape (n, k)
            Position along forward, in the unit of the positions.
        """
        return along(positions - self.origin[:, :, None], self.forward)

    def lateral(self, positions: FloatArray, *, up: FloatArray | None = None) -> FloatArray:
        """Return how far to the right of the origin each foot is.

        Parameters
        ----------
        positions : ndarray, shape (n, d, k)
            Positions of the feet.
        up : ndarray, shape (3,), optional
            Direction upwards, in space. In a picture the animal is taken to be seen from
            above: right is a quarter turn from forward, from u towards v.

        Returns
        -------
        ndarray, shape (n, k)
            Position across forward, positive to the animal's right.
        """
        if up is None:
            right = np.stack([-self.forward[:, 1], self.forward[:, 0]], axis=-1)
        else:
            right = np.cross(self.forward, np.broadcast_to(up, self.forward.shape))
        return along(positions - self.origin[:, :, None], right)


def along(positions: FloatArray, forward: FloatArray) -> FloatArray:
    """Project positions on a direction.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions.
    forward : ndarray, shape (n, d)
        Unit vectors.

    Returns
    -------
    ndarray, shape (n, k)
        Components along ``forward``.
    """
    return np.einsum("ndk,nd->nk", positions, forward)


def mean_path(positions: FloatArray) -> FloatArray:
    """Average feet that come and go, without jumps where one comes or goes.

    Each foot is the common path plus an offset of its own; both are fitted by
    alternating least squares. With all feet present this is their mean, up to a constant.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions; NaN where missing.

    Returns
    -------
    ndarray, shape (n, d)
        The common path; NaN where no foot was seen.
    """
    there = np.isfinite(positions)
    count = there.sum(axis=2)
    values = np.where(there, positions, 0.0)
    offset = np.zeros(positions.shape[1:])
    scale = float(np.nanmax(np.abs(positions))) if there.any() else 1.0
    path = np.full(positions.shape[:2], np.nan)
    for _ in range(200):
        path = (values - np.where(there, offset, 0.0)).sum(axis=2) / np.where(count, count, np.nan)
        residual = np.where(there, positions - path[:, :, None], 0.0)
        new = residual.sum(axis=0) / np.maximum(there.sum(axis=0), 1)
        moved = float(np.abs(new - offset).max()) if new.size else 0.0
        offset = new
        if moved <= 1e-9 * scale:
            break
    return path + offset.mean(axis=1)


def stride_frequency(positions: FloatArray, *, fs_hz: float) -> float:
    """Estimate how often the feet step, roughly: it only sets scales of time.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions of the feet in the laboratory.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    float
        Dominant frequency along the feet's main axis of motion, in Hz; NaN where
        nothing can be told.
    """
    axis = main_axis(np.diff(positions, axis=0))
    return dominant_frequency(np.einsum("ndk,d->nk", positions, axis), fs_hz=fs_hz)


def smooth_path(positions: FloatArray, *, cutoff_hz: float, fs_hz: float) -> FloatArray:
    """Low-pass the common path of several points, for a body that moves with them.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions; NaN where missing.
    cutoff_hz : float
        Cut-off. A recording shorter than its period gets a straight line instead.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    ndarray, shape (n, d)
        The path, bridged where no point was seen; NaN before the first and after the
        last sighting.
    """
    path = fill_gaps_of_points(mean_path(positions), max_gap=len(positions))
    known = np.flatnonzero(np.isfinite(path).all(axis=1))
    if len(known) * cutoff_hz >= fs_hz:
        return butterworth_lowpass(path, cutoff_hz=cutoff_hz, fs_hz=fs_hz)
    if len(known) > 1:
        path[known] = np.column_stack(
            [np.polyval(np.polyfit(known, column, 1), known) for column in path[known].T]
        )
    return path


def is_travelling(positions: FloatArray, path: FloatArray) -> bool:
    """Say whether the animal gets anywhere, or steps in one place as on a treadmill.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions of the feet in the laboratory.
    path : ndarray, shape (n, d)
        Low-passed path of the body.

    Returns
    -------
    bool
        True if the body ends further from where it began than ``TRAVEL_FACTOR`` times
        the excursion (5th to 95th percentile) of a typical foot about it.
    """
    known = np.flatnonzero(np.isfinite(path).all(axis=1))
    if len(known) < 2:
        return False
    tenth = max(1, len(known) // 10)
    gone = path[known[-tenth:]].mean(axis=0) - path[known[:tenth]].mean(axis=0)
    relative = positions - path[:, :, None]
    axis = main_axis(relative - np.nanmean(relative, axis=0))
    feet = np.einsum("ndk,d->nk", relative, axis)
    excursion = np.nanmedian(np.nanpercentile(feet, 95, axis=0) - np.nanpercentile(feet, 5, axis=0))
    return bool(np.linalg.norm(gone) > TRAVEL_FACTOR * excursion)


def is_wandering(body: FloatArray) -> bool:
    """Say whether an animal roams, so that only its body tells where its front is.

    Parameters
    ----------
    body : ndarray, shape (n, d, m)
        Points along the body, rear to front; NaN where missing.

    Returns
    -------
    bool
        True if its middle covers more than twice its length and its heading turns by more
        than 45 degrees from its mean (in a tenth of the samples or more).
    """
    known = np.isfinite(body).all(axis=(1, 2))
    if known.sum() < 2:
        return False
    seen = body[known]
    heading = seen[:, :, -1] - seen[:, :, 0]
    length = np.linalg.norm(heading, axis=1)
    covered = np.linalg.norm(np.ptp(seen.mean(axis=2), axis=0))
    unit = heading / np.where(length > 0, length, np.nan)[:, None]
    mean = np.nanmean(unit, axis=0)
    aligned = unit @ mean / max(float(np.linalg.norm(mean)), 1e-12)
    turned = np.nanmean(aligned < np.cos(np.pi / 4))
    return bool(covered > 2.0 * np.median(length) and turned > 0.1)


def travel_direction(path: FloatArray, *, up: FloatArray | None = None) -> tuple[FloatArray, float]:
    """Find the mean direction of travel.

    Parameters
    ----------
    path : ndarray, shape (n, d)
        Low-passed path of the body.
    up : ndarray, shape (d,), optional
        Direction to leave out, so that the result is level.

    Returns
    -------
    forward : ndarray, shape (d,)
        Unit vector from where the body began to where it ended.
    straightness : float
        That distance as a fraction of the length of the path: 1 for a straight run.
    """
    known = path[np.isfinite(path).all(axis=1)]
    steps = np.diff(known, axis=0)
    gone = known[-1] - known[0]
    if up is not None:
        gone = gone - (gone @ up) * up
        steps = steps - np.outer(steps @ up, up)
    length = float(np.linalg.norm(gone))
    return gone / length, length / float(np.linalg.norm(steps, axis=1).sum())


def swing_direction(positions: FloatArray, *, fs_hz: float) -> FloatArray:
    """Find the front of an animal that steps in one place, from its feet alone.

    The axis is the main axis of the feet's steps from frame to frame, which two labels that are
    exchanged for once do not turn. Its front is where feet move to
    fastest: a swinging foot starts and stops and so peaks at nearly twice its mean
    speed, while a foot in stance goes with the belt. That holds for duty factors above
    about 0.35; for faster gaits state the direction.

    Parameters
    ----------
    positions : ndarray, shape (n, d, k)
        Positions of the feet in the laboratory.
    fs_hz : float
        Sampling rate, in Hz.

    Returns
    -------
    ndarray, shape (d,)
        Unit vector.
    """
    axis = main_axis(_without_jumps(np.diff(positions, axis=0)))
    frequency = stride_frequency(positions, fs_hz=fs_hz)
    feet = np.einsum("ndk,d->nk", positions, axis)
    if math.isfinite(frequency) and 8.0 * frequency < 0.4 * fs_hz:
        feet = butterworth_lowpass(feet, cutoff_hz=8.0 * frequency, fs_hz=fs_hz, max_gap=2)
    velocity = np.diff(feet, axis=0)
    fastest = np.nanpercentile(velocity, 98), -np.nanpercentile(velocity, 2)
    return axis if fastest[0] >= fastest[1] else -axis


def _without_jumps(steps: FloatArray) -> FloatArray:
    """Return steps from frame to frame, shape (n, d, k), the longest in a hundred cut short."""
    length = np.linalg.norm(steps, axis=1, keepdims=True)
    known = length[np.isfinite(length)]
    if not known.size:
        return steps
    longest = np.percentile(known, 99)
    return steps * np.divide(longest, length, out=np.ones_like(length), where=length > longest)


def main_axis(deviations: FloatArray) -> FloatArray:
    """Find the first principal axis of deviations, pooled over the feet.

    Parameters
    ----------
    deviations : ndarray, shape (n, d, k)
        Deviations; NaN where missing.

    Returns
    -------
    ndarray, shape (d,)
        Unit vector, its largest component above 0.
    """
    pooled = np.moveaxis(deviations, 1, 2).reshape(-1, deviations.shape[1])
    pooled = pooled[np.isfinite(pooled).all(axis=1)]
    if len(pooled) == 0:
        return np.eye(deviations.shape[1])[0]
    axis = np.linalg.eigh(pooled.T @ pooled)[1][:, -1]
    return axis * np.sign(axis[np.argmax(np.abs(axis))])


def body_frame_from_points(
    body: FloatArray, *, cutoff_hz: float | None, fs_hz: float, up: FloatArray | None = None
) -> BodyFrame:
    """Make the body frame from two or more points along the body.

    Parameters
    ----------
    body : ndarray, shape (n, d, k)
        Points from rear to front; NaN where missing. Short and long gaps are bridged:
        a body does not jump.
    cutoff_hz : float or None
        Low-pass for the points; None leaves them as they are.
    fs_hz : float
        Sampling rate, in Hz.
    up : ndarray, shape (d,), optional
        Direction to leave out, so that the heading is level.

    Returns
    -------
    BodyFrame
        Origin at the mean of the points, heading from the first to the last.

    Raises
    ------
    InputError
        If there are fewer than two points or none of their samples are complete.
    """
    if body.shape[2] < 2:
        raise InputError(
            f"[animal] body names {body.shape[2]} point; expected two or more, rear to front, "
            "or none."
        )
    body = fill_gaps_of_points(body, max_gap=len(body))
    if cutoff_hz is not None:
        body = butterworth_lowpass(body, cutoff_hz=cutoff_hz, fs_hz=fs_hz)
    if not np.isfinite(body).all(axis=(1, 2)).any():
        raise InputError("the points of [animal] body are never seen together; name others.")
    heading = body[:, :, -1] - body[:, :, 0]
    if up is not None:
        heading = heading - np.outer(heading @ up, up)
    length = np.linalg.norm(heading, axis=1, keepdims=True)
    origin = body.mean(axis=2)
    return BodyFrame(
        origin=origin,
        forward=heading / np.where(length > 0, length, np.nan),
        path=origin,
        method="body points",
    )


def body_frame_of_path(
    path: FloatArray, forward: Sequence[float] | np.ndarray, *, at_rest: bool, method: str
) -> BodyFrame:
    """Make the body frame where no point of the body is named.

    Parameters
    ----------
    path : ndarray, shape (n, d)
        Path of the body, as the low-passed mean of the feet.
    forward : array_like, shape (d,) or (n, d)
        Direction towards the front, the same or that of every sample.
    at_rest : bool
        True: the origin is at rest in the laboratory, at the mean of ``path``. False: it is at
        ``path``.
    method : str
        How the frame was found.

    Returns
    -------
    BodyFrame
        The frame.
    """
    unit = np.asarray(forward, dtype=float)
    unit = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
    known = path[np.isfinite(path).all(axis=1)]
    # not the zero of the laboratory: where feet are about the body can be compared then
    # between recordings, whichever frame each is seen from
    middle = known.mean(axis=0) if len(known) else np.zeros(path.shape[1])
    return BodyFrame(
        origin=np.array(np.broadcast_to(middle, path.shape)) if at_rest else path,
        forward=np.array(np.broadcast_to(unit, path.shape)),
        path=path,
        method=method,
    )
