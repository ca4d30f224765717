"""Figures from tables, one a file: ``build_..._table`` makes the numbers, ``plot_...`` draws.

A figure is imported when it is first used: what needs colours of legs only, as the reviewers do,
need not have all of them, nor pyplot.

Examples of functions go on from here: a synthetic study of spiders whose truth is known, analysed.

>>> import numpy as np
>>> import pandas as pd
>>> import pawnb
>>> from pawnb import figures
>>> study = pawnb.synthetic.simulate_spider_study(animals=4, trials=2, seed=3)
>>> gait = pawnb.gait.pool(
...     [pawnb.gait.analyse(run.tracks(), trial=run.trial) for run in study.runs]
... )
"""

from typing import TYPE_CHECKING

from pawnb import _lazy

# at once: the function would else be hidden by its module, which has the same name
from pawnb.figures.style import StyleOptions, get_style, set_style, style

if TYPE_CHECKING:
    from pawnb.figures.aligned_acceleration import (
        build_aligned_acceleration_table,
        plot_aligned_acceleration,
    )
    from pawnb.figures.animal_presence import (
        build_animal_presence_table,
        plot_animal_presence,
    )
    from pawnb.figures.bland_altman import build_bland_altman_table, plot_bland_altman
    from pawnb.figures.compare_methods import build_compare_methods_table, plot_compare_methods
    from pawnb.figures.cycle_comparison import (
        build_cycle_comparison_table,
        plot_cycle_comparison,
    )
    from pawnb.figures.estimation import build_estimation_table, plot_estimation
    from pawnb.figures.filter_effect import build_filter_effect_table, plot_filter_effect
    from pawnb.figures.gait_diagram import build_gait_diagram_table, plot_gait_diagram
    from pawnb.figures.hildebrand import build_hildebrand_diagram_table, plot_hildebrand_diagram
    from pawnb.figures.joint_ranges import build_joint_ranges_table, plot_joint_ranges
    from pawnb.figures.leg_angles import plot_leg_angles
    from pawnb.figures.measure_components import (
        build_measure_components_table,
        plot_measure_components,
    )
    from pawnb.figures.measure_heat_map import build_measure_heat_map_table, plot_measure_heat_map
    from pawnb.figures.paths_3d import build_paths_3d_table, plot_paths_3d
    from pawnb.figures.pattern_distances import plot_pattern_distances
    from pawnb.figures.phase_density import plot_phase_density
    from pawnb.figures.phase_histogram import build_phase_histogram_table, plot_phase_histogram
    from pawnb.figures.phase_plane import build_phase_plane_table, plot_phase_plane
    from pawnb.figures.phase_rose import build_phase_rose_table, plot_phase_rose
    from pawnb.figures.phase_speed import build_phase_speed_table, plot_phase_speed
    from pawnb.figures.pose_overlay import build_pose_overlay_table, plot_pose_overlay
    from pawnb.figures.regression import build_regression_table, plot_regression
    from pawnb.figures.residual_analysis import (
        build_residual_analysis_table,
        plot_residual_analysis,
    )
    from pawnb.figures.scaling import build_scaling_table, plot_scaling
    from pawnb.figures.stepping_pattern import build_stepping_pattern_table, plot_stepping_pattern
    from pawnb.figures.stride_average import plot_stride_average
    from pawnb.figures.summary_page import build_summary_page_table, plot_summary_page
    from pawnb.figures.support_shares import plot_support_shares
    from pawnb.figures.template_fit import build_template_fit_table, plot_template_fit

__all__ = [
    "StyleOptions",
    "build_aligned_acceleration_table",
    "build_animal_presence_table",
    "build_bland_altman_table",
    "build_compare_methods_table",
    "build_cycle_comparison_table",
    "build_estimation_table",
    "build_filter_effect_table",
    "build_gait_diagram_table",
    "build_hildebrand_diagram_table",
    "build_joint_ranges_table",
    "build_measure_components_table",
    "build_measure_heat_map_table",
    "build_paths_3d_table",
    "build_phase_histogram_table",
    "build_phase_plane_table",
    "build_phase_rose_table",
    "build_phase_speed_table",
    "build_pose_overlay_table",
    "build_regression_table",
    "build_residual_analysis_table",
    "build_scaling_table",
    "build_stepping_pattern_table",
    "build_summary_page_table",
    "build_template_fit_table",
    "get_style",
    "plot_aligned_acceleration",
    "plot_animal_presence",
    "plot_bland_altman",
    "plot_compare_methods",
    "plot_cycle_comparison",
    "plot_estimation",
    "plot_filter_effect",
    "plot_gait_diagram",
    "plot_hildebrand_diagram",
    "plot_joint_ranges",
    "plot_leg_angles",
    "plot_measure_components",
    "plot_measure_heat_map",
    "plot_paths_3d",
    "plot_pattern_distances",
    "plot_phase_density",
    "plot_phase_histogram",
    "plot_phase_plane",
    "plot_phase_rose",
    "plot_phase_speed",
    "plot_pose_overlay",
    "plot_regression",
    "plot_residual_analysis",
    "plot_scaling",
    "plot_stepping_pattern",
    "plot_stride_average",
    "plot_summary_page",
    "plot_support_shares",
    "plot_template_fit",
    "set_style",
    "style",
]

_HOME = {
    "build_aligned_acceleration_table": "pawnb.figures.aligned_acceleration",
    "plot_aligned_acceleration": "pawnb.figures.aligned_acceleration",
    "build_animal_presence_table": "pawnb.figures.animal_presence",
    "plot_animal_presence": "pawnb.figures.animal_presence",
    "build_bland_altman_table": "pawnb.figures.bland_altman",
    "plot_bland_altman": "pawnb.figures.bland_altman",
    "build_compare_methods_table": "pawnb.figures.compare_methods",
    "plot_compare_methods": "pawnb.figures.compare_methods",
    "build_cycle_comparison_table": "pawnb.figures.cycle_comparison",
    "plot_cycle_comparison": "pawnb.figures.cycle_comparison",
    "build_estimation_table": "pawnb.figures.estimation",
    "plot_estimation": "pawnb.figures.estimation",
    "build_filter_effect_table": "pawnb.figures.filter_effect",
    "plot_filter_effect": "pawnb.figures.filter_effect",
    "build_gait_diagram_table": "pawnb.figures.gait_diagram",
    "plot_gait_diagram": "pawnb.figures.gait_diagram",
    "build_hildebrand_diagram_table": "pawnb.figures.hildebrand",
    "plot_hildebrand_diagram": "pawnb.figures.hildebrand",
    "build_joint_ranges_table": "pawnb.figures.joint_ranges",
    "plot_joint_ranges": "pawnb.figures.joint_ranges",
    "plot_leg_angles": "pawnb.figures.leg_angles",
    "build_measure_components_table": "pawnb.figures.measure_components",
    "plot_measure_components": "pawnb.figures.measure_components",
    "build_measure_heat_map_table": "pawnb.figures.measure_heat_map",
    "plot_measure_heat_map": "pawnb.figures.measure_heat_map",
    "build_paths_3d_table": "pawnb.figures.paths_3d",
    "plot_paths_3d": "pawnb.figures.paths_3d",
    "plot_pattern_distances": "pawnb.figures.pattern_distances",
    "plot_phase_density": "pawnb.figures.phase_density",
    "build_phase_histogram_table": "pawnb.figures.phase_histogram",
    "plot_phase_histogram": "pawnb.figures.phase_histogram",
    "build_phase_plane_table": "pawnb.figures.phase_plane",
    "plot_phase_plane": "pawnb.figures.phase_plane",
    "build_phase_rose_table": "pawnb.figures.phase_rose",
    "plot_phase_rose": "pawnb.figures.phase_rose",
    "build_phase_speed_table": "pawnb.figures.phase_speed",
    "plot_phase_speed": "pawnb.figures.phase_speed",
    "build_pose_overlay_table": "pawnb.figures.pose_overlay",
    "plot_pose_overlay": "pawnb.figures.pose_overlay",
    "build_regression_table": "pawnb.figures.regression",
    "plot_regression": "pawnb.figures.regression",
    "build_residual_analysis_table": "pawnb.figures.residual_analysis",
    "plot_residual_analysis": "pawnb.figures.residual_analysis",
    "build_scaling_table": "pawnb.figures.scaling",
    "plot_scaling": "pawnb.figures.scaling",
    "build_stepping_pattern_table": "pawnb.figures.stepping_pattern",
    "plot_stepping_pattern": "pawnb.figures.stepping_pattern",
    "plot_stride_average": "pawnb.figures.stride_average",
    "build_summary_page_table": "pawnb.figures.summary_page",
    "plot_summary_page": "pawnb.figures.summary_page",
    "plot_support_shares": "pawnb.figures.support_shares",
    "build_template_fit_table": "pawnb.figures.template_fit",
    "plot_template_fit": "pawnb.figures.template_fit",
}

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
