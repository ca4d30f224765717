"""Figures from tables, one a file: ``build_..._table`` makes the numbers, ``plot_...`` draws."""

from pawnb.figures.gait_diagram import build_gait_diagram_table, plot_gait_diagram
from pawnb.figures.phase_rose import build_phase_rose_table, plot_phase_rose
from pawnb.figures.style import style

__all__ = [
    "build_gait_diagram_table",
    "build_phase_rose_table",
    "plot_gait_diagram",
    "plot_phase_rose",
    "style",
]
