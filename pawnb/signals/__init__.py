"""Filters, derivatives, splines, gaps and extremes of sampled signals.

Every function works along the first axis, treats further axes as separate signals,
and respects gaps: a stretch of NaN parts a signal into runs that never mix. Nothing
here knows what the numbers mean.
"""

from pawnb.signals.butterworth import (
    butterworth_lowpass,
    one_pass_cutoff,
    two_pass_correction,
)
from pawnb.signals.derivatives import differentiate, unwrap_angles
from pawnb.signals.frequency import dominant_frequency
from pawnb.signals.motion import SmoothedMotion, smooth_motion
from pawnb.signals.runs import fill_gaps, fill_gaps_of_points, find_runs
from pawnb.signals.splines import smooth_spline, spline_cutoff
from pawnb.signals.turns import find_jumps, find_turns, refine_extremum

__all__ = [
    "SmoothedMotion",
    "butterworth_lowpass",
    "differentiate",
    "dominant_frequency",
    "fill_gaps",
    "fill_gaps_of_points",
    "find_jumps",
    "find_runs",
    "find_turns",
    "one_pass_cutoff",
    "refine_extremum",
    "smooth_motion",
    "smooth_spline",
    "spline_cutoff",
    "two_pass_correction",
    "unwrap_angles",
]


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
