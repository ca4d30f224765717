"""Cameras from a board, a wand or known points: corners, lenses, arrangement, bundle adjustment.

Comes in: pictures of a board, clicks of a wand or of points whose places are known. Goes out:
a camera for each view, and how well the views agree. Lenses by Zhang (2000), arrangement by
relative poses, refined together by bundle adjustment (Triggs et al. 2000).
"""

from pawnb import _lazy

__all__ = [
    "arrangement",
    "bundle",
    "corners",
    "doubts",
    "intrinsics",
    "optics",
    "rig_from_boards",
    "rig_from_points",
    "rig_from_wand",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
