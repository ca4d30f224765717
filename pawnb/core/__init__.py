"""The engine: frames, calibration, filters and trackers; it knows no gait and no widget."""

from pawnb import _lazy

__all__ = ["dlt", "edits", "kalman", "lens", "paws", "pose", "rig", "suspects", "video"]

__getattr__, __dir__ = _lazy(__name__, __all__)
