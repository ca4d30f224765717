"""pawnb: high-speed video of a running animal to gait statistics.

The everyday names are here and are imported when they are first used, so that
``import pawnb`` is quick and has no side effects.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Animal": "pawnb.trial",
    "Calibration": "pawnb.trial",
    "InputError": "pawnb.errors",
    "PawnbError": "pawnb.errors",
    "Trial": "pawnb.trial",
    "View": "pawnb.trial",
    "assess_quality": "pawnb.workflow.quality",
    "batch": "pawnb.workflow.batch",
    "check_trial": "pawnb.workflow.check",
    "convert_tracks": "pawnb.workflow.convert",
    "count_errors": "pawnb.workflow.evaluation",
    "evaluate": "pawnb.workflow.evaluate",
    "load_tracks": "pawnb.io.formats",
    "load_trial": "pawnb.trial",
    "propose_start": "pawnb.workflow.propose",
    "read_tracks": "pawnb.io.native",
    "retrack": "pawnb.workflow.track",
    "run_gait": "pawnb.workflow.gait",
    "sample_trial": "pawnb.workflow.sample",
    "save_trial": "pawnb.trial",
    "suggest_frames": "pawnb.workflow.suggest",
    "track": "pawnb.workflow.track",
    "tracks_table": "pawnb.io.native",
}
_MODULES = (
    "core", "errors", "figures", "gait", "io", "kinematics", "schema", "signals", "synthetic",
    "trial", "widgets", "workflow",
)  # fmt: skip

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    """Import a name of the public list, or a part of the package, on first use."""
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    if name in _MODULES:
        return importlib.import_module(f"pawnb.{name}")
    raise AttributeError(f"module 'pawnb' has no attribute {name!r}")


def _submodules(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package whose modules are imported on first use."""

    def load(name: str) -> Any:
        full = f"{package}.{name}"
        try:
            return importlib.import_module(full)
        except ModuleNotFoundError as error:
            if error.name != full:
                raise  # the module is there, but not what it needs
            raise AttributeError(f"module {package!r} has no attribute {name!r}") from None

    return load


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted([*__all__, *_MODULES])
