"""Corrections by hand, as records that are applied, undone and replayed.

Comes in: Tracks and a correction. Goes out: corrected Tracks and a journal of what was done
(``log``); ``records`` says what a correction is, ``effects`` what it does.
"""

from pawnb import _lazy

__all__ = ["effects", "log", "records"]

__getattr__, __dir__ = _lazy(__name__, __all__)
