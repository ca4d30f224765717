"""Trial to Tracks, and Tracks again from a corrected frame.

Comes in: a trial with its start. Goes out: Tracks, with the record of how they were made. ``track``
is the call for both kinds of animal; ``track_points`` and ``retrack_points`` serve points, those of
``pose`` jointed animals, with the ``options`` that are asked for and an ``opened_run``; ``methods``
names trackers and their settings; ``placed``, ``predicted`` and ``kept_candidates`` bring what is
known already, ``unfinished`` goes on with a run that was interrupted.
"""

from pawnb import _lazy

__all__ = [
    "kept_candidates",
    "methods",
    "opened_run",
    "options",
    "placed",
    "pose",
    "predicted",
    "published_names",
    "retrack_points",
    "track",
    "track_points",
    "trial_views",
    "unfinished",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
