"""Trials of jointed animals: tracked, put in space by a second view, tracked again.

Comes in: a trial with its start pose. Goes out: Tracks of joints. ``track_pose`` tracks,
``pose_in_space`` adds the second view, ``retrack_pose`` begins again at corrected frames.
"""

from pawnb import _lazy

__all__ = ["pose_in_space", "retrack_pose", "track_pose"]

__getattr__, __dir__ = _lazy(__name__, __all__)
