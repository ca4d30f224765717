"""Pixels as they are decoded: colour planes, Bayer patterns, colours, grey levels.

Comes in: planes of a decoded frame. Goes out: arrays in red, green, blue, or grey levels; ``masks``
marks parts of a picture.
"""

from pawnb import _lazy

__all__ = ["bayer", "colour", "grey", "masks", "planes", "yuv"]

__getattr__, __dir__ = _lazy(__name__, __all__)
