"""Tracks in and out: our own files and other programs', one file each.

Readers return Tracks, or what their name says. :func:`read_any_tracks` recognises the format by
what is in the file. Names are imported when they are first used.

Examples of functions go on from here: two synthetic mice, written as DeepLabCut writes them.

>>> from pathlib import Path
>>> import numpy as np
>>> import pandas as pd
>>> import pawnb
>>> files = pawnb.synthetic.write_deeplabcut_sample("sample", animals=2)
>>> tracks = pawnb.io.read_any_tracks(files[0], fps=200.0)
"""

from pawnb import _lazy

_HOME = {
    "from_movement": "pawnb.io.movement",
    "points3d_table": "pawnb.io.native",
    "read_anipose": "pawnb.io.anipose",
    "read_any_tracks": "pawnb.io.formats",
    "read_belt_speed": "pawnb.io.belt",
    "read_coefs": "pawnb.io.coefs",
    "read_deeplabcut": "pawnb.io.deeplabcut",
    "read_dltdv_points": "pawnb.io.dltdv",
    "read_dltdv_points3d": "pawnb.io.dltdv",
    "read_points3d_table": "pawnb.io.track_tables",
    "read_sleap": "pawnb.io.sleap",
    "read_start": "pawnb.io.start",
    "read_tracks": "pawnb.io.native",
    "read_tracks_table": "pawnb.io.track_tables",
    "read_wide_table": "pawnb.io.wide",
    "recognise_format": "pawnb.io.formats",
    "to_movement": "pawnb.io.movement",
    "tracks_table": "pawnb.io.native",
    "write_any_tracks": "pawnb.io.formats",
    "write_coefs": "pawnb.io.coefs",
    "write_start": "pawnb.io.start",
    "write_tracks": "pawnb.io.native",
}

__all__ = [*_HOME]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
