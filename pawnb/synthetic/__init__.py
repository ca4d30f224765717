"""Rendered scenes with exact truth: the built-in sample, tests and benchmarks.

Names are imported when they are first used: rendering needs OpenCV and PyAV.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pawnb import _lazy

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

__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
