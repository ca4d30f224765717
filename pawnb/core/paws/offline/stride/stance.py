"""Paws that stand while nothing shows them, and how they lift off.

A front paw that is about to lift off is often covered by the hind paw that lands beside it.
It still stands: it goes exactly as the ground does, at the height of the ground. What goes
with the ground above it is no paw but a wrist over one. A paw that lifts off changes its speed
at once; by how much is learnt where that was seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray, IntArray
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.motion_model import MotionModel
from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.plausibility_kernels import KinematicPrior
from pawnb.core.paws.offline.treadmill.median import median


@dataclass(frozen=True)
class Stance:
    """A time for which a point stands.

    Parameters
    ----------
    first, stop : int
        Its first frame, and one past its last.
    origin : ndarray, shape (d,)
        Where in frame 0 the ground was on which it stands.
    """

    first: int
    stop: int
    origin: FloatArray


@dataclass(frozen=True)
class Substrate:
    """What points stand on, and how they leave it.

    Parameters
    ----------
    height : ndarray, shape (P,)
        Of each point where it stands, NaN where it was never seen standing.
    substrate_velocity : ndarray, shape (d,)
        Speed of the ground.
    liftoff_velocity : ndarray, shape (P, d)
        How much the speed of each point changes at lift-off.
    motion_model : MotionModel
        How points move.
    """

    height: FloatArray
    substrate_velocity: FloatArray
    liftoff_velocity: FloatArray
    motion_model: MotionModel

    def places(self, stance: Stance, frames: IntArray) -> FloatArray:
        """Return where (n, d) what stands is in some frames (n,)."""
        return np.asarray(stance.origin + frames[:, None] * self.substrate_velocity)

    def kinematic_prior(self, point: int, *, way: int = 1) -> KinematicPrior:
        """Return what speaks against how a point may move, backwards where ``way`` is -1."""
        motion_model = self.motion_model
        forward = motion_model.axes[0]
        fastest = min(0.0, float(motion_model.substrate_velocity @ forward))
        return KinematicPrior(
            forward,
            motion_model.axes[-1],
            fastest,
            STRIDE.back_share * abs(fastest) + STRIDE.back_acceleration * motion_model.acceleration,
            float(motion_model.substrate),
            float(motion_model.paw_width),
            float(self.height[point]),
            self.substrate_velocity,
            _tolerance(self.substrate_velocity, motion_model),
            way,
            STRIDE.lifted_above,
            STRIDE.lifted_within,
            STRIDE.ride,
            STRIDE.sunk,
            STRIDE.strangest,
        )

    def stances(self, places: FloatArray) -> list[list[Stance]]:
        """Return when each point stands, given its certain places (n, P, d), NaN elsewhere."""
        n, n_points, _ = places.shape
        # in the frame of the ground nothing that stands moves
        still = places - np.arange(n)[:, None, None] * self.substrate_velocity
        slow = np.zeros((n, n_points), bool)
        if n > 2 * STRIDE.stance_half:
            step = (still[2 * STRIDE.stance_half :] - still[: -2 * STRIDE.stance_half]) / (
                2.0 * STRIDE.stance_half
            )
            slow[STRIDE.stance_half : -STRIDE.stance_half] = _length(
                step, self.motion_model
            ) < _tolerance(self.substrate_velocity, self.motion_model)
        found = [self._stances(still[:, p], slow[:, p]) for p in range(n_points)]
        for p, mine in enumerate(found):
            begun = self._begun(p, places[:, p], still[:, p])
            if begun is not None and (not mine or mine[0].first > begun.stop):
                mine.insert(0, begun)
        return found

    def _begun(self, point: int, places: FloatArray, still: FloatArray) -> Stance | None:
        """Return the stance with which a recording begins, of frames too few to tell a speed.

        What is as low there as where it stands later, and stays on its place on the ground, stands.
        """
        near = STRIDE.stance_off * self.motion_model.paw_width
        above = np.abs(places @ self.motion_model.axes[-1] - self.height[point])
        # what is not known is NaN and compares as False
        on = (_length(still - still[0], self.motion_model) < near) & (above < near)
        stop = int(np.argmin(np.append(on, False)))
        if not stop or (stop == 1 and np.isfinite(places[1:2, 0]).any()):
            return None
        return Stance(0, stop, median(still[:stop]))

    def _stances(self, still: FloatArray, slow: BoolArray) -> list[Stance]:
        """Return the stances of one point: where it is slow, and as long as it is at that place."""
        found: list[Stance] = []
        edge = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(int)))
        for first, stop in edge.reshape(-1, 2).tolist():
            known = np.isfinite(still[first:stop, 0])
            if stop - first + STRIDE.stance_half < STRIDE.stance_least or not known.any():
                continue
            if found and first <= found[-1].stop:
                continue
            origin = median(still[first:stop][known])
            on = (
                _length(still - origin, self.motion_model)
                < STRIDE.stance_off * self.motion_model.paw_width
            )
            # at a place between the two it cannot stand twice
            free = found[-1].stop if found else 0
            first -= int(np.argmin(np.append(on[free:first][::-1], False)))
            stop += int(np.argmin(np.append(on[stop:], False)))
            found.append(Stance(first, stop, origin))
        return found


def learn_substrate(
    chosen: FloatArray, motion_model: MotionModel, *, liftoff_velocity: FloatArray | None = None
) -> Substrate:
    """Learn how fast the ground goes, and at which height points stand on it.

    Parameters
    ----------
    chosen : ndarray, shape (n, P, d)
        Certain places, NaN elsewhere.
    motion_model : MotionModel
        How points move.
    liftoff_velocity : ndarray, shape (P, d), optional
        How much speeds change at lift-off, if that was learnt already.

    Returns
    -------
    Substrate
        What was learnt; no heights where the only view is from below.
    """
    n, n_points, _ = chosen.shape
    if liftoff_velocity is None:
        liftoff_velocity = np.tile(
            STRIDE.stance_up * motion_model.speed * motion_model.axes[-1], (n_points, 1)
        )
    height = np.full(n_points, np.nan)
    if not np.isfinite(motion_model.substrate) or n <= 2 * STRIDE.stance_half:
        return Substrate(height, motion_model.substrate_velocity, liftoff_velocity, motion_model)
    speed = (chosen[2 * STRIDE.stance_half :] - chosen[: -2 * STRIDE.stance_half]) / (
        2.0 * STRIDE.stance_half
    )
    standing = _length(speed - motion_model.substrate_velocity, motion_model) < _tolerance(
        motion_model.substrate_velocity, motion_model
    )
    up = chosen[STRIDE.stance_half : -STRIDE.stance_half] @ motion_model.axes[-1]
    for p in range(n_points):
        here = standing[:, p] & np.isfinite(up[:, p])
        if here.any():
            height[p] = np.median(up[here, p])
    substrate_velocity = (
        np.median(speed[standing], axis=0) if standing.any() else motion_model.substrate_velocity
    )
    return Substrate(height, substrate_velocity, liftoff_velocity, motion_model)


def learn_liftoff_velocity(
    substrate: Substrate,
    x: FloatArray,
    seen: BoolArray,
    *,
    lift_offs: Sequence[tuple[int, int]],
    frames: int,
) -> FloatArray:
    """Learn by how much the speed of each point changes at lift-off.

    Parameters
    ----------
    substrate : Substrate
        What points stand on.
    x : ndarray, shape (n, P, d)
        Tracks.
    seen : ndarray of bool, shape (n, P)
        Where a view shows the point.
    lift_offs : sequence of (int, int)
        Number of the point, and the last frame in which it stands.
    frames : int
        Frames in which a paw that lifts off goes on as it began.

    Returns
    -------
    ndarray, shape (P, d)
        The median of what was seen, drawn towards what is assumed where that was seldom; upwards
        only: forward a paw goes on with the ground and gains speed little by little.
    """
    n_points = x.shape[1]
    observed: list[list[np.ndarray]] = [[] for _ in range(n_points)]
    for p, last in lift_offs:
        later = np.flatnonzero(seen[last + 1 : last + 1 + frames, p])
        if len(later):
            since = int(later[-1]) + 1
            gone = x[last + since, p] - x[last, p] - since * substrate.substrate_velocity
            observed[p].append(gone / (since - STRIDE.half_frame))
    up = substrate.motion_model.axes[-1]
    assumed = STRIDE.stance_up * substrate.motion_model.speed * up
    liftoff_velocity = np.tile(assumed, (n_points, 1))
    for p, changes in enumerate(observed):
        if changes:
            share = len(changes) / (len(changes) + STRIDE.stance_assumed)
            liftoff_velocity[p] += share * (np.median(changes, axis=0) @ up * up - assumed)
    return liftoff_velocity


def covered(
    standing: FloatArray,
    uv: FloatArray,
    point: int,
    *,
    geometry: Projection,
    paw_width_px: FloatArray,
) -> BoolArray:
    """Tell in which views another paw covers a point.

    Parameters
    ----------
    standing : ndarray, shape (n, d)
        Where the point stands.
    uv : ndarray, shape (n, P, V, 2)
        Where all points are, px, NaN where nothing is known.
    point : int
        Its number.
    geometry : Projection
        The views.
    paw_width_px : ndarray, shape (V,)
        Width of a paw in each view.

    Returns
    -------
    ndarray of bool, shape (n, V)
        True where one does.
    """
    others = np.delete(uv, point, axis=1) - geometry.project(standing)[:, None]
    away = np.linalg.norm(others, axis=-1) / paw_width_px
    return np.asarray((away < STRIDE.stance_beside).any(axis=1))


def expected_jerks(
    lift_offs: Sequence[tuple[int, int]], liftoff_velocity: FloatArray, n: int
) -> tuple[FloatArray, BoolArray]:
    """Return the third differences (n, P, d) that lift-offs make, and where (n, P) they do.

    Parameters
    ----------
    lift_offs : sequence of tuple of int
        Point, and its last row on the ground.
    liftoff_velocity : ndarray, shape (P, d)
        How the speed changes there, a frame.
    n : int
        Rows.

    Returns
    -------
    jerk_mean : ndarray, shape (n, P, d)
        Third differences.
    near : ndarray of bool, shape (n, P)
        Where there are any.
    """
    jerk_mean = np.zeros((n, *liftoff_velocity.shape))
    near = np.zeros((n, len(liftoff_velocity)), bool)
    for p, last in lift_offs:
        if 1 <= last < n - 2:
            # of a line that bends upwards at the middle of the step after the last frame
            jerk_mean[last - 1, p] += STRIDE.half_frame * liftoff_velocity[p]
            jerk_mean[last + 1, p] += (STRIDE.half_frame - 1.0) * liftoff_velocity[p]
            near[last - 1 : last + 2, p] = True
    return jerk_mean, near


def _length(step: np.ndarray, motion_model: MotionModel) -> np.ndarray:
    """Return the length of steps (..., d) forward and up: to the side is known less well."""
    return np.asarray(np.hypot(step @ motion_model.axes[0], step @ motion_model.axes[-1]))


def _tolerance(substrate_velocity: FloatArray, motion_model: MotionModel) -> float:
    """Return by how much the speed of what stands may differ from that of the ground."""
    return (
        STRIDE.with_ground * float(np.linalg.norm(substrate_velocity))
        + STRIDE.stance_slow * motion_model.paw_width
    )
