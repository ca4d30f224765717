"""Figures from tables, one a file: ``build_..._table`` makes the numbers, ``plot_...`` draws."""

from pawnb.figures.animal_presence import (
    build_animal_presence_table,
    plot_animal_presence,
)
from pawnb.figures.compare_methods import build_compare_methods_table, plot_compare_methods
from pawnb.figures.gait_diagram import build_gait_diagram_table, plot_gait_diagram
from pawnb.figures.phase_rose import build_phase_rose_table, plot_phase_rose
from pawnb.figures.style import StyleOptions, get_style, set_style, style

__all__ = [
    "StyleOptions",
    "build_animal_presence_table",
    "build_compare_methods_table",
    "build_gait_diagram_table",
    "build_phase_rose_table",
    "get_style",
    "plot_animal_presence",
    "plot_compare_methods",
    "plot_gait_diagram",
    "plot_phase_rose",
    "set_style",
    "style",
]
