"""Thin faces over the workflow, for notebooks.

Names are imported when they are first used: they need Jupyter, which the rest of pawnb does not.
"""

from pawnb import _lazy

__all__ = [
    "CalibrationDigitiser", "ClickInitialiser", "FrameCanvas", "GaitExplorer", "PoseReviewer",
    "ResidualExplorer", "StickPoser", "TrackReviewer", "TrialForm", "Workbench",
]  # fmt: skip

_HOME = {
    "CalibrationDigitiser": "pawnb.widgets.calibration_digitiser",
    "ClickInitialiser": "pawnb.widgets.click_initialiser",
    "FrameCanvas": "pawnb.widgets.frame_canvas",
    "GaitExplorer": "pawnb.widgets.gait_explorer",
    "PoseReviewer": "pawnb.widgets.pose_reviewer",
    "ResidualExplorer": "pawnb.widgets.residual_explorer",
    "StickPoser": "pawnb.widgets.stick_poser",
    "TrackReviewer": "pawnb.widgets.track_reviewer",
    "TrialForm": "pawnb.widgets.trial_form",
    "Workbench": "pawnb.widgets.workbench",
}

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
