"""The smoothest path of a side's legs through the candidates of a recording (Viterbi).

A state is one candidate for every leg of the side. What the picture says of a state is a sum over
legs and pairs of legs; what the step between two frames costs is a sum over legs, so the best
predecessors are found leg by leg, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi_kernels import step_costs


@dataclass(frozen=True, eq=False)
class ViterbiTrellis:
    """The best paths of one side's legs to every state of a frame.

    Attributes
    ----------
    cost : ndarray, one axis a leg
        Of the best path to each state, less that of the best of all.
    back : tuple of ndarray
        Of each leg, the candidate before on the best path.
    joints, velocity : tuple of ndarray, shape (candidates, n_joints, 2)
        Of each leg, where its candidates put its joints, and how these go on moving, px.
    before : ViterbiTrellis or None
        Of the frame before.
    """

    cost: FloatArray
    back: tuple[IntArray, ...]
    joints: tuple[FloatArray, ...]
    velocity: tuple[FloatArray, ...]
    before: ViterbiTrellis | None

    def best(self) -> tuple[int, ...]:
        """Return the best state of the frame."""
        return tuple(int(i) for i in np.unravel_index(int(np.argmin(self.cost)), self.cost.shape))

    def marginals(self) -> list[FloatArray]:
        """Return, for each leg, the cost of the best path to each of its candidates."""
        axes = range(self.cost.ndim)
        return [self.cost.min(axis=tuple(k for k in axes if k != a)) for a in axes]

    def path(self) -> list[tuple[int, ...]]:
        """Return the best state of every frame, first to last."""
        state, moment = self.best(), self
        states = [state]
        while moment.before is not None:
            parents = list(state)
            for axis in range(len(state) - 1, -1, -1):
                parents[axis] = int(moment.back[axis][tuple(parents)])
            state, moment = tuple(parents), moment.before
            states.append(state)
        return states[::-1]


def extend_trellis(
    before: ViterbiTrellis | None,
    energy: FloatArray,
    joints: tuple[FloatArray, ...],
    *,
    jump_px: float,
) -> ViterbiTrellis:
    """Return the trellis of the next frame.

    Parameters
    ----------
    before : ViterbiTrellis or None
        Of the frame before; None for the first.
    energy : ndarray, one axis a leg
        What the picture says of each state.
    joints : tuple of ndarray, shape (candidates, n_joints, 2)
        Of each leg, where its candidates put its joints.
    jump_px : float
        Standard deviation of how far joints stray from their predicted places.

    Returns
    -------
    ViterbiTrellis
        A new one.
    """
    if before is None:
        still = tuple(np.zeros_like(j) for j in joints)
        return ViterbiTrellis(energy - energy.min(), (), joints, still, None)
    cost, back, velocity = before.cost, [], []
    for axis, now in enumerate(joints):
        known = before.joints[axis]
        if len(known) == 1 and len(now) == 1:  # all paths take this step: it decides nothing
            velocity.append(_velocity(now - known, jump_px))
            back.append(np.zeros(cost.shape, dtype=int))
            continue
        steps = step_costs(known + before.velocity[axis], now, jump_px, CANDIDATES.most_step)
        others = tuple(k for k in range(before.cost.ndim) if k != axis)
        marginal = before.cost.min(axis=others) if others else before.cost
        parent = np.argmin(marginal[:, None] + steps, axis=0)
        velocity.append(_velocity(now - known[parent], jump_px))
        # axis of the candidates before becomes that of the candidates now
        moved_cost = np.moveaxis(cost, axis, 0)[:, None]
        tall = steps.reshape(*steps.shape, *([1] * (cost.ndim - 1)))
        total = moved_cost + tall
        back.append(np.moveaxis(np.argmin(total, axis=0), 0, axis))
        cost = np.moveaxis(total.min(axis=0), 0, axis)
    cost = cost + energy
    return ViterbiTrellis(cost - cost.min(), tuple(back), joints, tuple(velocity), before)


def _velocity(moved: FloatArray, jump_px: float) -> FloatArray:
    """Return how joints go on moving, that moved so; those of a leg that leapt do not."""
    # comparisons with the NaN beyond the tip of a short leg are False
    leap: np.ndarray = np.any(np.abs(moved) > CANDIDATES.leap_sds * jump_px, axis=(1, 2))
    return np.where(leap[:, None, None], 0.0, CANDIDATES.viterbi_keep_velocity * moved)
