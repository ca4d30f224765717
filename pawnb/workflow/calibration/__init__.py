"""Cameras and scales of a trial, made and read.

Comes in: clicks, pictures of a board or a wand, or another program's file. Goes out: the
calibration of a trial, with its errors. ``calibrate`` fits DLT coefficients to clicked points,
``calibrate_file`` reads another program's calibration, ``scale`` finds px per unit of a single
view, ``real_units`` applies it.
"""

from pawnb import _lazy

__all__ = ["calibrate", "calibrate_file", "real_units", "scale"]

__getattr__, __dir__ = _lazy(__name__, __all__)
