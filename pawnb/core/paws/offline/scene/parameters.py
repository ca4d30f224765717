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
    unknown_speed : float
        Standard deviation of a speed of which nothing is known, in that of the fastest swings. Set
        by hand.
    around_share : float
        Side of the square that tells a grey paw's surroundings, as a share of the picture's width.
        Set by hand.
    bottom_view_apart : float
        Distance, in paw widths, at which detections of two views that may be one paw cost 1;
        farther ones are none. Set by hand.
    bottom_view_sunk_sd : float
        Standard deviation, in paw widths, of how much lower still they may be. Set by hand.
    bottom_view_height_sd : float
        Standard deviation of heights from frame to frame, in paw widths, at least. Set by hand.
    bottom_view_step_most : float
        A step of height costs no more than so many times beginning again, squared and halved. Set
        by hand.
    treadmill_long, hull_long : float
        Paws are searched so far along the animal, in distances of front from hind paws; and where
        ways to them may lead. Set by hand.
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
    unknown_speed: float = 0.4
    around_share: float = 0.06
    bottom_view_apart: float = 0.4
    bottom_view_sunk_sd: float = 0.5
    bottom_view_height_sd: float = 0.15
    bottom_view_step_most: float = 4.0
    treadmill_long: float = 1.15
    hull_long: float = 2.5


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
        Extents by which an animal gets away from where it was, farther than a point usually is
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
    extent_residual : float
        Points that views place in space tell how large the animal is where their residual is no
        more than this share of the longest side of a picture. Set by hand.
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
    body_points : float
        Clicked frames with at least this share of the points tell where the animal is: the middle
        of a few lies elsewhere on it. Set by hand.
    body_found : float
        Share of frames with a blob from which on it can tell the frame. Set by hand.
    body_centre_sd : float
        Smoothing of its centre, frames. Set by hand.
    body_angle_sd : float
        Smoothing of its direction, frames. Set by hand.
    body_elongation : float
        Blobs have a direction from this elongation on. Set by hand.
    body_clear : float
        Share of frames with a direction from which on the frame may turn. Set by hand.
    body_window : float
        Pictures of the body are compared with a Gaussian weight whose standard deviation is their
        side over this. Set by hand.
    body_compared : int
        Frames that are compared with clicked ones, at most, evenly spread. Set by hand.
    body_shown : float
        Extents that a picture of the body shows. Set by hand.
    corner_quality : float
        Corners are at least this share as good as the best (Shi & Tomasi 1994). Set by
        hand.
    camera_corners : int
        Corners of a picture from which motion of the camera is found, at most. Set by hand.
    camera_apart_px : int
        They are so far apart, px. Set by hand.
    camera_window_px : int
        Side of the window by which they are followed, px. Set by hand.
    feature_levels : int
        Pyramid levels of that, besides the picture. Set by hand.
    camera_ransac_px : float
        Distance, px, up to which a feature goes with the camera. Set by hand.
    camera_shared : float
        Share of features that go with one motion from which on the camera has it. Set by hand.
    follow_corners : int
        Corners of the animal that are followed, at most. Set by hand.
    follow_apart_px : int
        They are so far apart, px. Set by hand.
    follow_window_px : int
        Side of the window by which they are followed, px. Set by hand.
    follow_lost : float
        The animal was lost where a clicked frame has it so many extents from where it was followed
        to: the middle of other points of it may lie half an extent away. Set by hand.
    blob_blur : float
        Side of the blur of differences from the background, in extents. Set by hand.
    blob_open : float
        Diameter of what closes and opens the foreground, in extents: takes tails and limbs away.
        Set by hand.
    blob_hull : float
        What lies so far about the clicks is the animal's, in extents. Set by hand.
    blob_noise : tuple of float
        Foreground differs by so many times the noise and so many grey values. Set by hand.
    blob_share : float
        And by this share of what the animal does about the clicks. Set by hand.
    blob_most : float
        Differences count no more than so many times that limit. Set by hand.
    blob_reach : float
        Blobs so far from the last one, in extents, count half their size. Set by hand.
    blob_leap : float
        The animal's blob is no further from the last one, in extents; after frames without one
        further by the square root of their number. Set by hand, on a woman who walks past a man
        who jumps: with 1, 2, 3, 5 clicked frames, and ``follow_lost``, 53, 48, 37, 79 % right,
        without 37, 38, 29, 72; in seven other real clips the body's frame is as before but in one
        run of 28.
    background_frames : int
        Frames whose median is the background of a camera that stands. Set by hand.
    background_around : tuple of float
        Frames, from each, from which the background of a moving camera is taken. Set by hand.
    background_apart : int
        At the ends of a recording, only those of them that are so many frames away. Set by hand.
    percentiles : tuple of float
        Percentiles of grey values that become black and white. Set by hand.
    gamma : float
        Power of grey values: dark animals are seen more clearly. Set by hand.
    noise_frames : int
        Frames, evenly spread, of whose differences from the background the median is the noise. Set
        by hand.
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
    extent_residual: float = 0.02
    unknown_extent: float = 0.4
    colour_from: float = 2.0
    shrunk: float = 0.75
    flow_stride: int = 5
    body_points: float = 0.75
    body_found: float = 0.8
    body_centre_sd: float = 1.5
    body_angle_sd: float = 2.0
    body_elongation: float = 0.15
    body_clear: float = 0.5
    body_window: float = 3.2
    body_compared: int = 60
    body_shown: float = 1.5
    corner_quality: float = 0.01
    camera_corners: int = 200
    camera_apart_px: int = 6
    camera_window_px: int = 15
    feature_levels: int = 2
    camera_ransac_px: float = 0.7
    camera_shared: float = 0.5
    follow_corners: int = 150
    follow_apart_px: int = 4
    follow_window_px: int = 11
    follow_lost: float = 0.5
    blob_blur: float = 0.04
    blob_open: float = 0.1
    blob_hull: float = 0.15
    blob_noise: tuple[float, float] = (3.0, 3.0)
    blob_share: float = 0.5
    blob_most: float = 3.0
    blob_reach: float = 0.5
    blob_leap: float = 1.0
    background_frames: int = 61
    background_around: tuple[int, ...] = (-48, -40, -32, -25, -18, 18, 25, 32, 40, 48)
    background_apart: int = 8
    percentiles: tuple[float, float] = (1.0, 99.8)
    gamma: float = 0.7
    noise_frames: int = 20


CAMERA = in_force("registration", RegistrationParameters())
"""The values in force; see :func:`pawnb.core.parameters.in_force`."""
