"""Settings of the whole-recording tracker; lengths are relative to what the clicks show."""

from __future__ import annotations

from dataclasses import dataclass

from pawnb.errors import InputError
from pawnb.schema import check_ranges

EVIDENCE = ("auto", "colour", "strides", "learnt")

FORMER_NAMES = {
    "hide_cost": "occlusion_onset_cost",
    "stay_cost": "occlusion_rate_cost",
    "longest_gap_s": "max_occlusion_s",
    "looks": "n_iterations",
    "places": "max_hypotheses",
    "links": "max_successors",
}
"""What settings were called before, and their names: tracks that were made then say the former."""


@dataclass(frozen=True)
class OfflineSettings:
    """Settings of :func:`pawnb.core.paws.offline.treadmill.tracker.track_treadmill`.

    Nothing here is in pixels: sizes come from the clicks. The *span* is the largest
    distance between two points clicked in one frame, about the distance of front
    from hind paws; a *paw width* is that of a paw's picture at the clicks. The values were set by
    hand.

    Parameters
    ----------
    acceleration : float
        Standard deviation of a paw's acceleration in spans per second squared. A swing
        reaches about twice this.
    jerk : float
        Standard deviation of the change of acceleration in spans per second cubed.
    noise : float
        Standard deviation of a place in space, in paw widths.
    height : float
        Paws are not lifted higher than this above the lowest click, in spans.
    occlusion_onset_cost, occlusion_rate_cost : float
        Cost of becoming occluded and of each second of it, in units of half a squared
        standard deviation: a paw is occluded for a share of its stride, however many pictures
        are taken of it.
    max_occlusion_s : float
        Longest time, s, for which a point may be occluded.
    body_s : float
        Time, s, over which the middle of the body is followed: about two strides.
    shortest_stride_s, longest_stride_s : float
        Strides are looked for between these, s.
    n_iterations : int
        Times that everything is decided again with the stride learnt from the last time; once
        more where tracks still change.
    max_hypotheses : int
        Places in space considered in each frame.
    max_successors : int
        Tracklets considered after each.
    landmarks : tuple of str
        Points that are no paws and are followed by their own picture (nose, ears, a mark on
        the back). Points whose names tell no paw are landmarks without being named where
        other names do (``FR``, ``LH``, ``hind_left``).
    evidence : {"auto", "colour", "strides", "learnt"}
        What points are found by: their colour, with strides and stance; the same with a look of
        paws that is learnt in the recording; motion and an appearance of each point that is learnt
        there; or the first of these that serves.
    """

    acceleration: float = 500.0
    jerk: float = 100000.0
    noise: float = 0.25
    height: float = 0.3
    occlusion_onset_cost: float = 3.0
    occlusion_rate_cost: float = 1750.0
    max_occlusion_s: float = 0.24
    body_s: float = 0.4
    shortest_stride_s: float = 1.0 / 15.0
    longest_stride_s: float = 1.0
    n_iterations: int = 2
    max_hypotheses: int = 16
    max_successors: int = 16
    landmarks: tuple[str, ...] = ()
    evidence: str = "auto"

    def __post_init__(self) -> None:
        check_ranges(
            self,
            above_0=(
                "acceleration",
                "jerk",
                "noise",
                "height",
                "body_s",
                "shortest_stride_s",
                "longest_stride_s",
                "max_hypotheses",
                "max_successors",
            ),
            least_0=(
                "occlusion_onset_cost",
                "occlusion_rate_cost",
                "max_occlusion_s",
                "n_iterations",
            ),
        )
        if self.evidence not in EVIDENCE:
            raise InputError(
                f"setting 'evidence' is {self.evidence!r}; expected {', '.join(EVIDENCE)}."
            )
        if self.shortest_stride_s >= self.longest_stride_s:
            raise InputError(
                f"setting 'shortest_stride_s' is {self.shortest_stride_s:g}, not below "
                f"'longest_stride_s' {self.longest_stride_s:g}; strides lie between them."
            )
