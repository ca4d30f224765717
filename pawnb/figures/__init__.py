"""Figures from tables, one a file: ``build_..._table`` makes the numbers, ``plot_...`` draws."""

from pawnb.figures.animal_presence import (
    build_animal_presence_table,
    plot_animal_presence,
)
from pawnb.figures.compare_methods import build_compare_methods_table, plot_compare_methods
from pawnb.figures.gait_diagram import build_gait_diagram_table, plot_gait_diagram
from pawnb.figures.leg_angles import plot_leg_angles
from pawnb.figures.phase_rose import build_phase_rose_table, plot_phase_rose
from pawnb.figures.pose_overlay import build_pose_overlay_table, plot_pose_overlay
from pawnb.figures.style import StyleOptions, get_style, set_style, style

__all__ = [
    "StyleOptions",
    "build_animal_presence_table",
    "build_compare_methods_table",
    "build_gait_diagram_table",
    "build_phase_rose_table",
    "build_pose_overlay_table",
    "get_style",
    "plot_animal_presence",
    "plot_compare_methods",
    "plot_gait_diagram",
    "plot_leg_angles",
    "plot_phase_rose",
    "plot_pose_overlay",
    "set_style",
    "style",
]
