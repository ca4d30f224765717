"""From Tracks or events to the gait tables of a trial.

Comes in: Tracks or events, and settings. Goes out: GaitTables. ``run`` has the steps in their
order; ``tables`` makes and pools the tables, with ``stride_measures``, ``stride_support``,
``phase_patterns``, ``plausibility`` and ``notes``; ``leg_names`` finds the feet among the names of
points.
"""

from pawnb import _lazy

_HOME = {
    "analyse": "pawnb.gait.analysis.run",
    "analyse_events": "pawnb.gait.analysis.run",
}

__all__ = [
    "analyse",
    "analyse_events",
    "leg_names",
    "notes",
    "phase_patterns",
    "plausibility",
    "run",
    "stride_measures",
    "stride_support",
    "tables",
]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
