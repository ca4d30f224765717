"""pawnb: high-speed video of a running animal to gait statistics.

The everyday names are here and are imported when they are first used, so that
``import pawnb`` is quick and has no side effects.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Animal": "pawnb.trial",
    "Calibration": "pawnb.trial",
    "InputError": "pawnb.errors",
    "PawnbError": "pawnb.errors",
    "Trial": "pawnb.trial",
    "View": "pawnb.trial",
    "batch": "pawnb.workflow.batch",
    "check_trial": "pawnb.workflow.check",
    "count_errors": "pawnb.workflow.evaluation",
    "evaluate": "pawnb.workflow.evaluate",
    "load_trial": "pawnb.trial",
    "propose_start": "pawnb.workflow.propose",
    "read_tracks": "pawnb.io.native",
    "retrack": "pawnb.workflow.track",
    "run_gait": "pawnb.workflow.gait",
    "sample_trial": "pawnb.workflow.sample",
    "save_trial": "pawnb.trial",
    "track": "pawnb.workflow.track",
    "tracks_table": "pawnb.io.native",
}
_MODULES = ("core", "figures", "gait", "io", "synthetic", "widgets", "workflow")

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    """Import a name of the public list, or a part of the package, on first use."""
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    if name in _MODULES:
        return importlib.import_module(f"pawnb.{name}")
    raise AttributeError(f"module 'pawnb' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted([*__all__, *_MODULES])
