"""Tracks made elsewhere, and tracks into other formats.

Comes in: a file of tracks of any program. Goes out: Tracks, or a file that another program reads.
``convert`` is the call; ``foreign_tracks`` reads any program's tracks with the calibration of their
trial, ``files_of_views`` one file a view, ``file_pixels`` moves pixels that are counted otherwise.
"""

from pawnb import _lazy

__all__ = ["convert", "file_pixels", "files_of_views", "foreign_tracks"]

__getattr__, __dir__ = _lazy(__name__, __all__)
