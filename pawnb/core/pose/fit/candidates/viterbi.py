"""The smoothest path of a side's legs through the candidates of a recording (Viterbi).

A state is one candidate for every leg of the side. What the picture says of a state is a sum over
legs and pairs of legs; what the step between two frames costs is a sum over legs, so the best
predecessors are found leg by leg, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi_kernels import step_costs


@dataclass
class _Moment:
    """One frame of a trellis: cost of the best path to each state, and its predecessors."""

    cost: FloatArray
    back: list[np.ndarray]
    joints: list[np.ndarray]
    velocity: list[np.ndarray]


class ViterbiTrellis:
    """Paths of one side's legs, frame by frame.

    Parameters
    ----------
    jump_px : float
        Standard deviation of how far joints stray from their predicted places.
    """

    def __init__(self, jump_px: float) -> None:
        self.jump_px = jump_px
        self._moments: list[_Moment] = []

    def __len__(self) -> int:
        return len(self._moments)

    def push(self, energy: np.ndarray, joints: list[np.ndarray]) -> tuple[int, ...]:
        """Add a frame; return the best state there by what is known so far.

        Parameters
        ----------
        energy : ndarray, one axis a leg
            What the picture says of each state.
        joints : list of ndarray, shape (candidates, n_joints, 2)
            Of each leg, where its candidates put its joints.
        """
        if not self._moments:
            still = [np.zeros_like(j) for j in joints]
            self._moments.append(_Moment(energy - energy.min(), [], joints, still))
            return self.best()
        last = self._moments[-1]
        cost, back, velocity = last.cost, [], []
        for axis, now in enumerate(joints):
            before = last.joints[axis]
            if len(before) == 1 and len(now) == 1:  # all paths take this step: it decides nothing
                velocity.append(self._velocity(now - before))
                back.append(np.zeros(cost.shape, dtype=int))
                continue
            steps = self._steps(before, last.velocity[axis], now)
            others = tuple(k for k in range(last.cost.ndim) if k != axis)
            marginal = last.cost.min(axis=others) if others else last.cost
            parent = np.argmin(marginal[:, None] + steps, axis=0)
            velocity.append(self._velocity(now - before[parent]))
            # axis of the candidates before becomes that of the candidates now
            moved_cost = np.moveaxis(cost, axis, 0)[:, None]
            tall = steps.reshape(*steps.shape, *([1] * (cost.ndim - 1)))
            total = moved_cost + tall
            back.append(np.moveaxis(np.argmin(total, axis=0), 0, axis))
            cost = np.moveaxis(total.min(axis=0), 0, axis)
        cost = cost + energy
        self._moments.append(_Moment(cost - cost.min(), back, joints, velocity))
        return self.best()

    def best(self) -> tuple[int, ...]:
        """Return the best state of the last frame."""
        last = self._moments[-1].cost
        return tuple(int(i) for i in np.unravel_index(int(np.argmin(last)), last.shape))

    def marginals(self) -> list[np.ndarray]:
        """Return, for each leg, the cost of the best path to each of its last candidates."""
        cost = self._moments[-1].cost
        axes = range(cost.ndim)
        return [cost.min(axis=tuple(k for k in axes if k != a)) for a in axes]

    def velocities(self) -> list[np.ndarray]:
        """Return, for each leg, how its last candidates' joints move, px a frame."""
        return self._moments[-1].velocity

    def path(self) -> list[tuple[int, ...]]:
        """Return the best state of every frame, first to last."""
        state = self.best()
        states = [state]
        for moment in reversed(self._moments[1:]):
            before = list(state)
            for axis in range(len(state) - 1, -1, -1):
                before[axis] = int(moment.back[axis][tuple(before)])
            state = tuple(before)
            states.append(state)
        return states[::-1]

    def _velocity(self, moved: np.ndarray) -> np.ndarray:
        """Return how joints go on moving, that moved so; those of a leg that leapt do not."""
        # comparisons with the NaN beyond the tip of a short leg are False
        leap = (np.abs(moved) > 6 * self.jump_px).any(axis=(1, 2))
        return np.where(leap[:, None, None], 0.0, CANDIDATES.viterbi_keep_velocity * moved)

    def _steps(self, before: np.ndarray, velocity: np.ndarray, now: np.ndarray) -> np.ndarray:
        """Return the cost of each step, shape (candidates before, candidates now)."""
        return step_costs(before + velocity, now, self.jump_px, CANDIDATES.most_step)
