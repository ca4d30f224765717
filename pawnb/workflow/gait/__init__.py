"""Tracks or events to gait tables and figures.

Comes in: results, files of tracks or events, or a study. Goes out: a folder of tables and figures.
``run`` is the call, ``request`` what it is asked for and its record, ``study`` who was filmed,
``species`` who else is drawn; ``inputs``, ``sources`` and ``event_sources`` read what it is given,
``notes`` say what is odd in it, ``statistics`` makes the tables beside those of the trials,
``drawing`` the figures.
"""

from pawnb import _lazy

_HOME = {
    "GaitRun": "pawnb.workflow.gait.run",
    "Legs": "pawnb.workflow.gait.request",
    "TABLES": "pawnb.workflow.gait.run",
    "analyse_source": "pawnb.workflow.gait.inputs",
    "run_gait": "pawnb.workflow.gait.run",
}

__all__ = [
    "TABLES",
    "GaitRun",
    "Legs",
    "analyse_source",
    "drawing",
    "event_sources",
    "inputs",
    "notes",
    "request",
    "run",
    "run_gait",
    "sources",
    "species",
    "speed_residuals",
    "statistics",
    "study",
    "study_tables",
]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
