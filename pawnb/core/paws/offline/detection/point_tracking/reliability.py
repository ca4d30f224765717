r"""How far paths of a network are believed: by where they are at clicks that had no part in them.

A path from a click ends at the next click of its point, with the network's own probability
:math:`p` there, at a distance :math:`d`. It is right where :math:`d` is small enough
(``run.weighing_near``). The share of paths that are right is first estimated of all points of a
view, then of each, every time with :math:`\nu` pseudo-counts of what was known before:

.. math:: r = \frac{\nu r_0 + \sum_i p_i [d_i \text{ small}]}{\nu + \sum_i p_i}

Where a path is wrong it is so for many rows, on another leg as a rule. One that is wrong as often
as right must therefore say nothing at all: the ratio of likelihoods at a place is
:math:`1 + G p \max(0, 2 r - 1)`, with the gain :math:`G` of optical flow. For the same reason
nothing is said before any path has ended at a click (:math:`r_0 = 0.5`), nor much farther from a
click than paths were right: as to that a network is as sure of what is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.offline.detection.parameters import POINT_TRACKER


@dataclass(frozen=True)
class PathEnd:
    """Where a path is in the row of a click from which it was not followed.

    Parameters
    ----------
    point : int
        Its point.
    probability : float
        What the network says of itself there.
    off_px : float
        Distance from the click, working px.
    rows : int
        How many rows it is away from the click from which it was followed.
    """

    point: int
    probability: float
    off_px: float
    rows: int


@dataclass(frozen=True)
class Reliability:
    """How far paths are believed.

    Parameters
    ----------
    trust : mapping
        Number of the point to the share by which paths are right more often than wrong; 0 at
        least.
    sd_px : float
        Standard deviation of those that are right, along each axis, working px.
    rows : int
        So many rows away from a click they are believed at most.
    """

    trust: dict[int, float]
    sd_px: float
    rows: int


def find_reliability(
    ends: Sequence[PathEnd], points: Sequence[int], *, near_px: float
) -> Reliability:
    """Return how far paths are believed.

    Parameters
    ----------
    ends : sequence of PathEnd
        Where paths end at clicks.
    points : sequence of int
        All points that are clicked.
    near_px : float
        A path that is no farther off than this is right, working px.

    Returns
    -------
    Reliability
        What was found, for each of the points.
    """
    of_all = _share_right(ends, POINT_TRACKER.right, near_px)
    trust = {}
    for point in points:
        right = _share_right([end for end in ends if end.point == point], of_all, near_px)
        trust[point] = max(0.0, 2 * right - 1)
    near = [end for end in ends if end.off_px <= near_px]
    worth = POINT_TRACKER.worth_clicks
    total = worth * POINT_TRACKER.sd_px**2 + sum(e.probability * e.off_px**2 / 2 for e in near)
    weight = worth + sum(end.probability for end in near)
    rows = int(POINT_TRACKER.reach * max((end.rows for end in near), default=0))
    return Reliability(trust, float(np.sqrt(total / weight)), rows)


def _share_right(ends: Sequence[PathEnd], before: float, near_px: float) -> float:
    """Return the share of paths that are right, from what was known before and from clicks."""
    worth = POINT_TRACKER.worth_clicks
    right = sum(end.probability for end in ends if end.off_px <= near_px)
    return (worth * before + right) / (worth + sum(end.probability for end in ends))
