"""Strides, and what is read off them.

Comes in: events and paths of feet. Goes out: a row for each stride: period, duty factor, length,
speed. The table is here itself (from ``stride_table``). ``bouts`` says where an animal is going,
``durations`` compares the rhythm of legs, ``symmetry`` left with right.
"""

from pawnb import _lazy
from pawnb.gait.strides.stride_table import (
    EXTRA_COLUMNS,
    PARTNER,
    Motion,
    build_strides,
    choose_stride_event,
)

__all__ = [
    "EXTRA_COLUMNS",
    "PARTNER",
    "Motion",
    "bouts",
    "build_strides",
    "choose_stride_event",
    "durations",
    "symmetry",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
