"""Settings of the pose tracker ``pawnb``."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.schema import check_ranges


@dataclass(frozen=True, kw_only=True)
class PoseSettings:
    """What can be set of ``method="pawnb"``; lengths in working pixels (see ``working_span_px``).

    The values were set by hand.

    Parameters
    ----------
    working_span_px : float
        The view is reduced by the greatest whole factor that leaves the leg span at least this
        long, working pixels.
    blur_px : float
        Standard deviation of the picture's blur, from which that of the start frame is found.
    unexplained_sd : float
        Standard deviation of the darkness that a well fitted animal leaves unexplained.
    soft_error : float
        Darkness error beyond which a pixel counts less and less.
    angle_step_deg : float
        Standard deviation of a joint's angle about its predicted place from frame to frame.
    foreshortening_sd : float
        Standard deviation of the logarithm of a link's projected length about its mean, where
        the other links of its leg have theirs; a whole leg may be shorter, as it is raised.
    candidates : int
        Most poses of one leg that are kept in a frame.
    evidence_share : float
        Weight of the picture against smoothness when the path through the candidates is chosen:
        neighbouring pixels do not err independently.
    jump_px : float
        Standard deviation of how far a leg's joints stray from their predicted places, at least;
        more where the middle leg is seen to stray further.
    choose_path : bool
        Whether candidates are kept and the smoothest path through the recording chosen; without
        it, each frame takes the pose nearest to the prediction.
    """

    working_span_px: float = 150.0
    blur_px: float = 0.8
    unexplained_sd: float = 0.12
    soft_error: float = 0.45
    angle_step_deg: float = 8.0
    foreshortening_sd: float = 0.12
    candidates: int = 6
    evidence_share: float = 0.1
    jump_px: float = 4.0
    choose_path: bool = True

    def __post_init__(self) -> None:
        check_ranges(
            self,
            above_0=(
                "working_span_px", "unexplained_sd", "soft_error", "angle_step_deg",
                "foreshortening_sd", "candidates", "evidence_share", "jump_px",
            ),
            least_0=("blur_px",),
        )  # fmt: skip
