"""Notes on what a gait run was given.

Comes in: its sources, their tracks and trials. Goes out: sentences for ``notes.csv``.
``source_notes`` are on files, units and films, ``identity_notes`` on which animal is which,
``tracking_notes`` on verdicts of tracks, ``group_notes`` on groups and names.
"""

from pawnb import _lazy

__all__ = ["group_notes", "identity_notes", "source_notes", "tracking_notes"]

__getattr__, __dir__ = _lazy(__name__, __all__)
