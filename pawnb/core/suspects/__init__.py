"""Frames of low confidence: which a person should look at, and why.

Comes in: Tracks. Goes out: a table of frames, points and reasons (``frames``), from ``evidence`` by
``limits``, with what is usual for the recording (``rates``, ``uncertainty``).
"""

from pawnb import _lazy

__all__ = ["chances", "evidence", "frames", "limits", "rates", "uncertainty"]

__getattr__, __dir__ = _lazy(__name__, __all__)
