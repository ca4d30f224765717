"""Trial to tracks to gait, each step one call.

The everyday functions of these modules are names of :mod:`pawnb` itself.
"""

from pawnb import _lazy

__all__ = [
    "batch", "calibrate", "check", "compare", "convert", "evaluate", "evaluate_pose",
    "evaluation", "gait", "propose", "quality", "reproject", "sample", "save_figures", "scale",
    "stride_template", "suggest", "track",
]  # fmt: skip

__getattr__, __dir__ = _lazy(__name__, __all__)
