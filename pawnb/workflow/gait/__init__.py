"""Tracks or events to gait tables and figures.

Comes in: results, files of tracks or events, or a study. Goes out: a folder of tables and figures.
``run`` is the call, ``request`` what it is asked for and its record, ``study`` who was filmed,
``species`` who else is drawn; ``inputs``, ``sources`` and ``event_sources`` read what it is given,
``statistics`` makes the tables beside those of the trials, ``drawings``, ``overview_drawings``,
``source_drawings`` and ``save_figures`` the figures, ``draw_figure`` one of one's own.
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
    "draw_figure",
    "drawings",
    "event_sources",
    "inputs",
    "overview_drawings",
    "request",
    "run",
    "run_gait",
    "save_figures",
    "source_drawings",
    "sources",
    "species",
    "speed_residuals",
    "statistics",
    "study",
    "study_tables",
]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
