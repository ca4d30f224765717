"""Thin faces over the workflow, for notebooks."""

from __future__ import annotations

import importlib
from typing import Any

_HOME = {
    "ClickInitialiser": "pawnb.widgets.click_initialiser",
    "FrameCanvas": "pawnb.widgets.frame_canvas",
    "GaitExplorer": "pawnb.widgets.gait_explorer",
    "PoseReviewer": "pawnb.widgets.pose_reviewer",
    "ResidualExplorer": "pawnb.widgets.residual_explorer",
    "StickPoser": "pawnb.widgets.stick_poser",
    "TrackReviewer": "pawnb.widgets.track_reviewer",
}

__all__ = [
    "ClickInitialiser", "FrameCanvas", "GaitExplorer", "PoseReviewer", "ResidualExplorer",
    "StickPoser", "TrackReviewer",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a widget on first use: they need Jupyter, which the rest of pawnb does not."""
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
