"""Circular statistics of phases.

Comes in: phases, 0 to 1, of one sample or more. Goes out: means, spreads, p-values, intervals.
What most work needs is here itself: mean, spread, Rayleigh's p, interval of the mean (from
``mean`` and ``rayleigh``). ``describe`` has further measures of one sample, ``tests`` its tests,
``groups`` tests of several samples, ``correlation`` phases with numbers or other phases,
``second_order`` samples of mean vectors. After Fisher (1993) and Zar (2010).
"""

from pawnb import _lazy
from pawnb.gait.circular.mean import (
    MeanVector,
    check_phases,
    check_r,
    circular_sd,
    mean_interval,
    mean_vector,
    widest_interval,
    wrap,
)
from pawnb.gait.circular.rayleigh import length_of_kappa, rayleigh_p, resultant_p

__all__ = [
    "MeanVector",
    "check_phases",
    "check_r",
    "circular_sd",
    "correlation",
    "describe",
    "groups",
    "length_of_kappa",
    "mean_interval",
    "mean_vector",
    "rayleigh_p",
    "resultant_p",
    "second_order",
    "tests",
    "widest_interval",
    "wrap",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
