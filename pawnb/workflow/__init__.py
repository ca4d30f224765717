"""Trial to tracks to gait, each step one call.

The everyday functions of these modules are names of :mod:`pawnb` itself. The subpackages, in the
order of the work: ``calibration``, ``checking``, ``start`` (clicks proposed), ``tracking``,
``reviewing``, ``evaluation``, ``conversion``, ``gait``, ``batch`` and ``provenance``. Their modules
are names here too: ``pawnb.workflow.track`` is :mod:`pawnb.workflow.tracking.track`.
"""

import importlib
from typing import Any

from pawnb import _lazy

_ROOM_OF = {
    "calibrate": "calibration",
    "calibrate_file": "calibration",
    "check": "checking",
    "compare": "evaluation",
    "compare_cameras": "evaluation",
    "compare_pose": "evaluation",
    "convert": "conversion",
    "corrected_run": "evaluation",
    "evaluate": "evaluation",
    "evaluate_pose": "evaluation",
    "foreign_tracks": "conversion",
    "manifest": "provenance",
    "methods": "tracking",
    "propose": "start",
    "propose_pose": "start",
    "quality": "reviewing",
    "reproject": "reviewing",
    "results": "provenance",
    "save_figures": "gait.drawing",
    "scale": "calibration",
    "suggest": "reviewing",
    "track": "tracking",
    "track_pose": "tracking",
}
"""The subpackage of each module that is a name of the workflow."""

__all__ = [
    "batch", "calibrate", "calibration", "check", "checking", "compare", "conversion", "convert",
    "evaluate", "evaluate_pose", "evaluation", "gait", "propose", "provenance", "quality",
    "reproject", "reviewing", "sample", "save_figures", "scale", "start", "stride_template",
    "suggest", "track", "tracking", "workbench",
]  # fmt: skip

_load, __dir__ = _lazy(__name__, __all__)


def __getattr__(name: str) -> Any:
    if name in _ROOM_OF:
        return importlib.import_module(f"{__name__}.{_ROOM_OF[name]}.{name}")
    return _load(name)
