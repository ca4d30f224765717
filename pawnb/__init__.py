"""pawnb: high-speed video of a running animal to gait statistics.

The work in its order, one name a step:

================================================  =================================================
:class:`Workbench`                                the whole work on one page, for a folder of trials
:func:`load_trial`, :class:`Trial`                what was filmed, and how
:func:`check_trial`                               what is there, what is missing, what looks wrong
:func:`propose_start`                             where the points seem to be, without a click
:class:`~pawnb.widgets.ClickInitialiser`          click, or accept what is proposed
:func:`track`                                     video to Tracks
:func:`assess_quality`                            how many labels are expected to be right
:func:`suggest_frames`                            where a further click helps most
:class:`~pawnb.widgets.TrackReviewer`             look, correct, track again (:func:`retrack`)
:func:`~pawnb.gait.analyse`, :func:`run_gait`     Tracks to events, strides, phases and statistics
:mod:`pawnb.figures`                              figures that are fit to print
================================================  =================================================

:func:`draw_figure` saves one with its table and its recipe; :func:`reproduce` makes a figure or a
table again from the recipe that it carries;
:func:`selfcheck` checks the installation.

Tracks of other programs enter at :func:`run_gait`, or through the readers of :mod:`pawnb.io`.

Names are imported when they are first used, so that ``import pawnb`` is quick and has no side
effects.

Examples of functions go on from here: a small synthetic mouse, rendered once, and its tracks.

>>> import pandas as pd
>>> import pawnb
>>> trial = pawnb.sample_trial("sample", frames=60, scale=0.2)
>>> tracks = pawnb.track(trial, out="sample/results")
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "Animal": "pawnb.trial",
    "Calibration": "pawnb.trial",
    "CalibrationDigitiser": "pawnb.widgets.calibration_digitiser",
    "InputError": "pawnb.errors",
    "PawnbError": "pawnb.errors",
    "Trial": "pawnb.trial",
    "View": "pawnb.trial",
    "Workbench": "pawnb.widgets.workbench",
    "assess_quality": "pawnb.workflow.reviewing.quality",
    "batch": "pawnb.workflow.batch.run",
    "check_trial": "pawnb.workflow.checking.check",
    "convert_tracks": "pawnb.workflow.conversion.convert",
    "count_errors": "pawnb.workflow.evaluation.errors",
    "draw_figure": "pawnb.workflow.gait.drawing.draw_figure",
    "evaluate": "pawnb.workflow.evaluation.evaluate",
    "export_film": "pawnb.workflow.export.film",
    "export_page": "pawnb.widgets.page",
    "export_sheet": "pawnb.workflow.export.sheet",
    "load_tracks": "pawnb.io.formats",
    "load_trial": "pawnb.trial",
    "propose_start": "pawnb.workflow.start.propose_start",
    "read_tracks": "pawnb.io.native",
    "reproduce": "pawnb.workflow.provenance.reproduce",
    "selfcheck": "pawnb.workflow.checking.selfcheck",
    "retrack": "pawnb.workflow.tracking.track",
    "run_gait": "pawnb.workflow.gait.run",
    "sample_trial": "pawnb.workflow.sample",
    "save_trial": "pawnb.trial",
    "suggest_frames": "pawnb.workflow.reviewing.suggest",
    "track": "pawnb.workflow.tracking.track",
    "tracks_table": "pawnb.io.native",
}
_ROOMS = (
    "core", "figures", "gait", "io", "schema", "signals", "synthetic", "trial", "widgets",
    "workflow",
)  # fmt: skip

__all__ = ["__version__", *_HOME, *_ROOMS]


def _lazy(
    package: str,
    public: Sequence[str],
    homes: Mapping[str, str] | None = None,
    *,
    modules: Mapping[str, str] | None = None,
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return the ``__getattr__`` and the ``__dir__`` of a package that imports on first use.

    Parameters
    ----------
    package : str
        Its ``__name__``.
    public : sequence of str
        Its ``__all__``: what ``dir()`` lists, imported or not. Other modules of the package are
        there by their names, but not listed.
    homes : mapping of str to str, optional
        The module of each name that is not a module itself.
    modules : mapping of str to str, optional
        The full name of each module that lies elsewhere than in the package itself.

    Returns
    -------
    load : callable
        Imports a name, or a module of the package.
    listed : callable
        Lists the public names.
    """
    homes, modules = homes or {}, modules or {}

    def load(name: str) -> Any:
        if name in homes:
            return getattr(importlib.import_module(homes[name]), name)
        full = modules.get(name, f"{package}.{name}")
        try:
            return importlib.import_module(full)
        except ModuleNotFoundError as error:
            if error.name != full:
                raise  # the module is there, but not what it needs
            raise AttributeError(f"module {package!r} has no attribute {name!r}") from None

    def listed() -> list[str]:
        return sorted(public)

    return load, listed


__getattr__, __dir__ = _lazy(__name__, __all__, _HOME)
