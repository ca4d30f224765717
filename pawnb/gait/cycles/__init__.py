"""Signals of legs over the stride: cut, averaged, compared.

Comes in: signals over time, and strides. Goes out: curves over the stride with bands, and p-values.
What most work needs is here itself (from ``leg_signals``): cut into strides, averages with bands,
aligned acceleration. ``joint_signals`` makes signals of joint angles, ``tests`` says whether curves
differ between groups (cluster permutation; Maris and Oostenveld 2007).
"""

from pawnb import _lazy
from pawnb.gait.cycles.leg_signals import (
    ALIGNED_COLUMNS,
    AVERAGE_COLUMNS,
    CYCLE_COLUMNS,
    HEIGHT,
    LATERAL,
    LEG_ANGLE,
    POSITION,
    LegSignals,
    align_acceleration,
    average_cycles,
    centre_signals,
    cut_cycles,
)

__all__ = [
    "ALIGNED_COLUMNS",
    "AVERAGE_COLUMNS",
    "CYCLE_COLUMNS",
    "HEIGHT",
    "LATERAL",
    "LEG_ANGLE",
    "POSITION",
    "LegSignals",
    "align_acceleration",
    "average_cycles",
    "centre_signals",
    "cut_cycles",
    "joint_signals",
    "tests",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
