"""The cut-off of a low-pass filter, chosen from the signal itself.

Comes in: positions over time. Goes out: a cut-off, Hz. Residual analysis (Winter 2009), beside
generalised cross-validation and the autocorrelation of residuals. All of it is here itself (from
``residual_analysis`` and ``cutoffs``); ``cutoff_scores`` and ``noise_band`` hold the arithmetic.
"""

from pawnb import _lazy
from pawnb.gait.residuals.cutoffs import (
    CUTOFF_COLUMNS,
    CUTOFF_METHODS,
    POOLED,
    compare_cutoffs,
    named_signals,
)
from pawnb.gait.residuals.residual_analysis import (
    CURVE_COLUMNS,
    ESTIMATE_WARNING,
    ResidualAnalysis,
    analyse_residuals,
    residual_cutoffs,
)

__all__ = [
    "CURVE_COLUMNS",
    "CUTOFF_COLUMNS",
    "CUTOFF_METHODS",
    "ESTIMATE_WARNING",
    "POOLED",
    "ResidualAnalysis",
    "analyse_residuals",
    "compare_cutoffs",
    "cutoff_scores",
    "named_signals",
    "noise_band",
    "residual_cutoffs",
]

__getattr__, __dir__ = _lazy(__name__, __all__)
