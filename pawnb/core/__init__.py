"""The engine: frames, calibration, filters and trackers; it knows no gait and no widget."""

from pawnb import _submodules

__getattr__ = _submodules(__name__)
