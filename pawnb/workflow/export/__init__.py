"""Tracks over their pictures for others to look at: a film, a sheet of frames.

Comes in: tracks and their trial. Goes out: a file. ``film`` and ``sheet`` are the calls; ``tiles``
reads and lays out the views of a frame, ``marks`` draws the points over one, ``colours`` chooses
their colours.
"""

from pawnb import _lazy

__all__ = ["colours", "film", "marks", "sheet", "tiles"]

__getattr__, __dir__ = _lazy(__name__, __all__)
