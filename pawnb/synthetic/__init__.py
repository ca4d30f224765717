"""Rendered scenes with exact truth: the built-in sample, tests and benchmarks.

Names are imported when they are first used: rendering needs OpenCV and PyAV.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pawnb.synthetic.deeplabcut_sample import write_deeplabcut_sample
    from pawnb.synthetic.mouse_trial import render_mouse_trial
    from pawnb.synthetic.scene import SceneSettings, scene_settings
    from pawnb.synthetic.spider_scene import SpiderScene, spider_scene
    from pawnb.synthetic.spider_study import simulate_spider_study
    from pawnb.synthetic.spider_trial import render_spider_trial

_HOME = {
    "write_deeplabcut_sample": "pawnb.synthetic.deeplabcut_sample",
    "SceneSettings": "pawnb.synthetic.scene",
    "SpiderScene": "pawnb.synthetic.spider_scene",
    "render_mouse_trial": "pawnb.synthetic.mouse_trial",
    "render_spider_trial": "pawnb.synthetic.spider_trial",
    "scene_settings": "pawnb.synthetic.scene",
    "simulate_spider_study": "pawnb.synthetic.spider_study",
    "spider_scene": "pawnb.synthetic.spider_scene",
}

__all__ = [
    "SceneSettings",
    "SpiderScene",
    "render_mouse_trial",
    "render_spider_trial",
    "scene_settings",
    "simulate_spider_study",
    "spider_scene",
    "write_deeplabcut_sample",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'pawnb.synthetic' has no attribute {name!r}")
