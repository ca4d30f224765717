"""Parameters of the stages ``movement`` and ``registration``, each with unit and evidence."""

from __future__ import annotations

import math
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


@dataclass(frozen=True)
class RegistrationParameters:
    """How pictures are brought into the frame of a body that moves before a camera that may move.

    Parameters
    ----------
    body_side_px : int
        Side of the pictures of the body that are compared, px. Set by hand.
    body_step : float
        The body's frame is held until the animal has moved so many extents: while it rests, its
        pictures are exactly those of the video and flow does not drift. Set by hand.
    body_turn_rad : float
        Or until it has turned so far, rad. Set by hand.
    body_away : float
        Extents by which an animal gets away from where it was, farther than a point is wont to be
        from its click. Set by hand.
    body_alike : float
        Then a frame that follows may be so much less alike (correlation) than one that stays. Set
        by hand.
    camera_still_px : float
        A feature that moves less, px, has not moved. Set by hand.
    camera_most_still : float
        A camera of which more features stay, in half of the frames, stands. Set by hand.
    camera_tried : int
        Frames that are looked at first, evenly spread: a camera that stands in them does so in all.
        Set by hand.
    camera_fewest : int
        Features without which nothing is said of the camera. Set by hand.
    follow_rows : int
        Frames over which features are followed before it is asked whether they moved. Set by hand.
    follow_moved_px : float
        A feature that moves less in a frame, px, beside the camera's own motion, is of the scene.
        Set by hand.
    follow_fewest : int
        With fewer moving features the animal is taken to stay. Set by hand.
    follow_reach : float
        Features are looked for so far from the centre, in extents. Set by hand.
    follow_return_px : float
        Forward-backward distance, px, up to which a feature counts. Set by hand.
    unknown_extent : float
        Extent where no frame has two points, in shorter sides of the picture. Set by hand.
    colour_from : float
        Mean distance of red and blue, grey values, from which a view is in colour. Set by hand.
    shrunk : float
        Pictures are shrunk before they are turned where the working scale is below this. Set by
        hand.
    flow_stride : int
        Patches of flow lie so far apart, px at half the working size, and are not refined between
        them. Measured: where pictures move they differ from those that flow carries by 5.6, 9.3 and
        6.3 grey values (rendered mouse, horse, camel) in 5.6 ms; with a stride of 3 and refinement
        by 5.6, 9.5 and 6.1 in 22 ms, and at a quarter of the size, in 5.6 ms, by 7.2, 10.9 and 7.1.
    """

    body_side_px: int = 48
    body_step: float = 0.03
    body_turn_rad: float = math.radians(3.0)
    body_away: float = 0.25
    body_alike: float = 0.05
    camera_still_px: float = 0.25
    camera_most_still: float = 0.4
    camera_tried: int = 40
    camera_fewest: int = 12
    follow_rows: int = 4
    follow_moved_px: float = 0.2
    follow_fewest: int = 8
    follow_reach: float = 0.75
    follow_return_px: float = 1.0
    unknown_extent: float = 0.4
    colour_from: float = 2.0
    shrunk: float = 0.75
    flow_stride: int = 5


CAMERA = in_force("registration", RegistrationParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
