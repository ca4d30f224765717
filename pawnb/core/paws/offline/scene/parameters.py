"""Parameters of the stage ``movement``, each with unit and evidence."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.core.parameters import in_force


@dataclass(frozen=True)
class MovementParameters:
    """What is known beforehand of where paws may be and how they move.

    Parameters
    ----------
    bottom_view_upright : float
        Cosine between the line of sight and up from which a view counts as one from below. Set by
        hand.
    bottom_view_alone : float
        Cost of a detection that no other view confirms. Set by hand.
    bottom_view_sunk : float
        Paws may be lower than the lowest click by so many paw widths: not all ground is level. Set
        by hand.
    bottom_view_gap : int
        Frames over which heights are joined. Set by hand.
    bottom_view_new : float
        Cost of beginning again with another height. Set by hand.
    bottom_view_reward : float
        What a detection of another view may cost to be taken at all. Set by hand.
    least_span : float
        Least distance of front from hind paws, in paw widths. Set by hand.
    treadmill_below : float
        Paws may be this much lower than the lowest click, in spans. Set by hand.
    treadmill_broad, broad_below : float
        Paws are searched this far to either side, in spans; and in a view from below. Set by hand.
    treadmill_beside, beside_strange : float
        Paws are this far to the side of the clicks, in spans; and where one side was not clicked.
        Set by hand.
    treadmill_rows : float
        A view from below shows left and right paws in two rows this far apart, in distances of
        front from hind paws; from the side, however steep, the far ones are less high. Set by hand.
    fastest : float
        Speed of the fastest swings, in spans per second. Set by hand.
    around_share : float
        Side of the square that tells a grey paw's surroundings, as a share of the picture's width.
        Set by hand.
    """

    bottom_view_upright: float = 0.8
    bottom_view_alone: float = 0.4
    bottom_view_sunk: float = 0.7
    bottom_view_gap: int = 8
    bottom_view_new: float = 3.0
    bottom_view_reward: float = 1.5
    least_span: float = 14.0
    treadmill_below: float = 0.15
    treadmill_broad: float = 0.4
    broad_below: float = 0.7
    treadmill_beside: float = 0.35
    beside_strange: float = 0.8
    treadmill_rows: float = 0.25
    fastest: float = 12.0
    around_share: float = 0.06


MOVEMENT = in_force("movement", MovementParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
