"""Animals, not strides: groups and conditions compared, means and slopes of animals.

Comes in: a table of strides with their animals and groups. Goes out: means, differences and effect
sizes with intervals that count animals. The comparison is here itself (from ``comparison``);
``differences`` holds the intervals and effect sizes that it gives. ``animals`` has means and slopes
of animals, ``animal_summary`` summarises every measure, ``bootstrap`` serves statistics without a
formula.
"""

from pawnb import _lazy
from pawnb.gait.groups.comparison import (
    CORRECTIONS,
    GROUP_COLUMNS,
    adjust_p,
    compare_groups,
    mean_by_animal,
)

__all__ = [
    "CORRECTIONS",
    "GROUP_COLUMNS",
    "adjust_p",
    "animal_summary",
    "animals",
    "bootstrap",
    "compare_groups",
    "differences",
    "mean_by_animal",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
