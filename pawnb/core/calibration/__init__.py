"""Cameras from a board, a wand or known points: corners, lenses, arrangement, bundle adjustment."""

from pawnb import _lazy

__all__ = [
    "arrangement",
    "bundle",
    "corners",
    "intrinsics",
    "optics",
    "rig_from_boards",
    "rig_from_points",
    "rig_from_wand",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
