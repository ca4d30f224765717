"""What speaks against how a point moves, compiled: positions and speeds in columns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pawnb.core.compiled import compiled


class KinematicPrior(NamedTuple):
    """What is known of how a point moves.

    Parameters
    ----------
    forward, up : ndarray, shape (d,)
        Unit vectors.
    fastest_back, back_sd : float
        Speed forward of what goes back as fast as the ground does, and how much faster is
        strange.
    lowest, paw_width : float
        Height of the lowest click, and width of a paw.
    height : float
        Of the point where it stands, NaN where it was never seen standing.
    substrate_velocity : ndarray, shape (d,)
        Speed of the ground.
    tolerance : float
        By how much the speed of what stands may differ from it.
    way : int
        +1, or -1 where speeds are taken backwards in time.
    above, within, ride, below, strangest : float
        ``lifted_above``, ``lifted_within``, ``ride``, ``sunk`` and ``strangest`` of
        :class:`.stride.parameters.StrideParameters`.
    """

    forward: np.ndarray
    up: np.ndarray
    fastest_back: float
    back_sd: float
    lowest: float
    paw_width: float
    height: float
    substrate_velocity: np.ndarray
    tolerance: float
    way: int
    above: float
    within: float
    ride: float
    below: float
    strangest: float


@compiled
def add_kinematic_cost(
    x: np.ndarray, speed: np.ndarray, recent: np.ndarray, known: KinematicPrior, cost: np.ndarray
) -> None:
    """Add what speaks against positions and speeds to costs.

    Parameters
    ----------
    x, speed : ndarray, shape (d, b)
        Where points may be, and how fast they may move.
    recent : ndarray of bool, shape (b,)
        Whether they have just lifted off: then they are lifted, however high they are.
    known : KinematicPrior
        What is known of how they move.
    cost : ndarray, shape (b,)
        Costs, added to.
    """
    for b in range(len(cost)):
        ahead, high, off_ahead, off_up = 0.0, 0.0, 0.0, 0.0
        for i in range(len(x)):
            v = known.way * speed[i, b]
            ahead += v * known.forward[i]
            high += x[i, b] * known.up[i]
            off_ahead += (v - known.substrate_velocity[i]) * known.forward[i]
            off_up += (v - known.substrate_velocity[i]) * known.up[i]
        cost[b] += _strangeness(ahead, high, known)
        if not np.isnan(known.height):
            cost[b] += _riding(np.hypot(off_ahead, off_up), high, recent[b], known)


@compiled
def _strangeness(ahead: float, high: float, known: KinematicPrior) -> float:
    """Return the cost of a speed and a height.

    No paw moves back faster than the ground does, and none goes below it.
    """
    back = max(known.fastest_back - ahead, 0.0) / known.back_sd
    low = max(known.lowest - known.below * known.paw_width - high, 0.0) / (0.5 * known.paw_width)
    return 0.5 * min(back * back, known.strangest) + 0.5 * low * low


@compiled
def _riding(off: float, high: float, recent: bool, known: KinematicPrior) -> float:
    """Return the cost of going with the ground, but for ``off``, though lifted."""
    above = (high - known.height) / known.paw_width
    lifted = 1.0 if recent else min(max((above - known.above) / known.within, 0.0), 1.0)
    if lifted == 0.0:
        return 0.0
    return known.ride * lifted * np.exp(-0.5 * (off / known.tolerance) ** 2)
