"""Figures of a gait run.

Comes in: the tables of a run, or one of one's own. Goes out: PNG, SVG and PDF, each with its table
and its recipe. ``drawings`` are those of legs and groups, ``overview_drawings`` those of a study,
``source_drawings`` those of tracks; ``save_figures`` writes them, ``draw_figure`` one of one's own.
"""

from pawnb import _lazy

__all__ = [
    "draw_figure",
    "drawings",
    "overview_drawings",
    "save_figures",
    "source_drawings",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
