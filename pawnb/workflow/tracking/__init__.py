"""Trial to Tracks, and Tracks again from a corrected frame.

``track`` is the call for both kinds of animal; ``methods`` names the trackers and their settings;
``track_pose``, ``pose_in_space`` and ``retrack_pose`` serve jointed animals; ``placed``,
``predicted`` and ``kept_candidates`` bring what is known already, ``unfinished`` goes on with a run
that was interrupted.
"""

from pawnb import _lazy

__all__ = [
    "kept_candidates",
    "methods",
    "placed",
    "pose_in_space",
    "predicted",
    "published_names",
    "retrack_pose",
    "track",
    "track_pose",
    "trial_views",
    "unfinished",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
