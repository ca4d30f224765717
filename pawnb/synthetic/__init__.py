"""Rendered scenes with exact truth: the built-in sample, tests and benchmarks.

Names are imported when they are first used: rendering needs OpenCV and PyAV.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pawnb.synthetic.mouse_trial import render_mouse_trial
    from pawnb.synthetic.scene import SceneSettings, scene_settings

_HOME = {
    "SceneSettings": "pawnb.synthetic.scene",
    "render_mouse_trial": "pawnb.synthetic.mouse_trial",
    "scene_settings": "pawnb.synthetic.scene",
}

__all__ = ["SceneSettings", "render_mouse_trial", "scene_settings"]


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'pawnb.synthetic' has no attribute {name!r}")
