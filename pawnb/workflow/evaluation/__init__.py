"""Tracks against truth, tracks made by hand, or another run.

Comes in: tracks, and what they are compared with. Goes out: errors in px and in the unit of the
calibration, and tables of methods. ``evaluate`` is the call; ``against_truth`` knows points and
poses, which ``errors`` and ``pose_errors`` measure; ``event_errors`` times events,
``evaluate_pose`` and ``pose_spread`` need no truth; ``compare``, ``compare_cameras`` and
``compare_pose`` tabulate methods over trials, which ``compared`` opens, with ``corrected_run`` as a
person would correct.
"""

from pawnb import _lazy

_HOME = {
    "ERROR_COLUMNS": "pawnb.workflow.evaluation.errors",
    "ErrorReport": "pawnb.workflow.evaluation.errors",
    "HIDDEN_PX": "pawnb.workflow.evaluation.errors",
    "RECOVERY_FRAMES": "pawnb.workflow.evaluation.errors",
    "REFERENCE_WIDTH_PX": "pawnb.core.paws.maghsoudi2019.settings",
    "SETTLED_FRAMES": "pawnb.workflow.evaluation.errors",
    "THRESHOLD_PX": "pawnb.workflow.evaluation.errors",
    "TRUTH_COLUMNS": "pawnb.workflow.evaluation.errors",
    "count_errors": "pawnb.workflow.evaluation.errors",
    "limits_for_width": "pawnb.workflow.evaluation.errors",
    "poisson_limit": "pawnb.workflow.evaluation.errors",
}

__all__ = [
    "ERROR_COLUMNS",
    "HIDDEN_PX",
    "RECOVERY_FRAMES",
    "REFERENCE_WIDTH_PX",
    "SETTLED_FRAMES",
    "THRESHOLD_PX",
    "TRUTH_COLUMNS",
    "ErrorReport",
    "against_truth",
    "compare",
    "compare_cameras",
    "compare_pose",
    "compared",
    "corrected_run",
    "count_errors",
    "errors",
    "evaluate",
    "evaluate_pose",
    "event_errors",
    "limits_for_width",
    "poisson_limit",
    "pose_errors",
    "pose_spread",
]

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
