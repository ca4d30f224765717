"""Settings of the fit in space."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.schema import check_ranges


@dataclass(frozen=True, kw_only=True)
class SpaceSettings:
    """What is known of an animal in space; lengths as shares of its leg span.

    The values were set by hand.

    Parameters
    ----------
    across_share, tip_along_share, joint_along_share : float
        Standard deviation of a place in the first view: across the leg, along it at the tip, and
        along it at the joints, which a straight leg hardly shows.
    length_sd : float
        Standard deviation of a segment's length about its own, as a share of it.
    bend_sd : float
        Standard deviation of the change of direction from one segment to the next, radians.
    root_share : float
        Standard deviation of the height of a body-coxa joint about the body's.
    ground_share : float
        How near to the ground a foot stands; a lifted one costs little.
    height_step_share : float
        Standard deviation of a height about that expected from the frames beside.
    evidence_share : float
        Weight of the second picture: neighbouring pixels do not err independently.
    correct_first : bool
        Whether the pose in the first view is corrected by the joints in space.
    angle_sd_deg : float
        Then: standard deviation of a joint's angle about that of the first view alone, degrees.
    least_support : float
        Then: least share of a leg that the second view must show.
    blur_px, soft_error, unexplained_sd, working_span_px
        As in :class:`pawnb.core.pose.fit.settings.PoseSettings`.
    """

    across_share: float = 0.004
    tip_along_share: float = 0.006
    joint_along_share: float = 0.02
    length_sd: float = 0.02
    bend_sd: float = 1.0
    root_share: float = 0.01
    ground_share: float = 0.01
    height_step_share: float = 0.008
    evidence_share: float = 0.3
    correct_first: bool = True
    angle_sd_deg: float = 2.0
    least_support: float = 0.5
    blur_px: float = 0.8
    soft_error: float = 0.45
    unexplained_sd: float = 0.12
    working_span_px: float = 150.0

    def __post_init__(self) -> None:
        check_ranges(
            self,
            above_0=(
                "across_share", "tip_along_share", "joint_along_share", "length_sd", "bend_sd",
                "root_share", "ground_share", "height_step_share", "evidence_share",
                "angle_sd_deg", "soft_error", "unexplained_sd", "working_span_px",
            ),
            least_0=("least_support", "blur_px"),
        )  # fmt: skip
