"""Trials of jointed animals: tracked, put in space by a second view, tracked again."""

from pawnb import _lazy

__all__ = ["pose_in_space", "retrack_pose", "track_pose"]

__getattr__, __dir__ = _lazy(__name__, __all__)
