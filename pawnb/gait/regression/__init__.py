"""Measures against speed, size and other terms.

Comes in: tables of strides or animals. Goes out: lines and models with their intervals.
Lines are here itself (from ``lines``): least squares, power laws, reduced major axis. ``scaling``
has the tables against size and speed, ``phase_slopes`` phases against speed within animals,
``covariates`` several terms at once, ``mixed`` mixed models, ``reference_lines`` what theory
expects.
"""

from pawnb import _lazy
from pawnb.gait.regression.lines import (
    LEAST_POINTS,
    AnimalSlopes,
    Line,
    SlopeTest,
    compare_slope,
    fit_line,
    fit_power,
    fit_rma,
    fit_within_animals,
    slope_over_animals,
    sprugel_factor,
)

__all__ = [
    "LEAST_POINTS",
    "AnimalSlopes",
    "Line",
    "SlopeTest",
    "compare_slope",
    "covariates",
    "fit_line",
    "fit_power",
    "fit_rma",
    "fit_within_animals",
    "mixed",
    "phase_slopes",
    "reference_lines",
    "scaling",
    "slope_over_animals",
    "sprugel_factor",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
