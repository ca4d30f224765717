"""Gait statistics on tracks or events from any source; this part knows no video.

:func:`analyse` makes every gait table of a trial, :func:`pool` joins trials. What goes
beyond has subpackages: ``events``, ``strides``, ``cycles`` (signals over the stride), ``phases``;
``circular`` (statistics of phases), ``groups`` (animals, not strides) and ``regression`` (against
speed and size); ``residuals`` (the cut-off of a filter). Their modules are found here by
their own names too, so that ``pawnb.gait.mixed`` is ``pawnb.gait.regression.mixed``.

Examples of functions go on from here: two synthetic spiders whose truth is known, a run each.

>>> import numpy as np
>>> import pandas as pd
>>> import pawnb
>>> study = pawnb.synthetic.simulate_spider_study(animals=2, trials=1, seed=3)
>>> run = study.runs[0]
>>> tracks = run.tracks()
"""

from pawnb import _lazy
from pawnb.gait import _former
from pawnb.gait.analysis.run import analyse, analyse_events
from pawnb.gait.analysis.tables import GaitTables, pool
from pawnb.gait.body_angles import body_angles
from pawnb.gait.events.event_edits import rename_event_edits, replay_event_edits
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.locomotion.pose_body import leg_angles

__all__ = [
    "EventSettings",
    "GaitTables",
    "analyse",
    "analyse_events",
    "animal_summary",
    "animals",
    "body_angles",
    "bootstrap",
    "bouts",
    "circular",
    "circular_correlation",
    "circular_describe",
    "circular_groups",
    "circular_tests",
    "contacts",
    "coordination",
    "coupling",
    "covariates",
    "cycle_tests",
    "cycles",
    "differences",
    "durations",
    "events",
    "groups",
    "joint_signals",
    "joints",
    "leg_angles",
    "legs",
    "mixed",
    "overview",
    "patterns",
    "phase_density",
    "phase_slopes",
    "phases",
    "pool",
    "reference_lines",
    "regression",
    "relative_phase",
    "rename_event_edits",
    "repeatability",
    "replay_event_edits",
    "residuals",
    "scaling",
    "second_order",
    "selection",
    "strides",
    "support",
    "symmetry",
]

_MODULES = {
    "animal_summary": "pawnb.gait.groups.animal_summary",
    "animals": "pawnb.gait.groups.animals",
    "bootstrap": "pawnb.gait.groups.bootstrap",
    "bouts": "pawnb.gait.strides.bouts",
    "circular_correlation": "pawnb.gait.circular.correlation",
    "circular_describe": "pawnb.gait.circular.describe",
    "circular_groups": "pawnb.gait.circular.groups",
    "circular_tests": "pawnb.gait.circular.tests",
    "contacts": "pawnb.gait.events.contacts",
    "coupling": "pawnb.gait.phases.coupling",
    "covariates": "pawnb.gait.regression.covariates",
    "cycle_tests": "pawnb.gait.cycles.tests",
    "differences": "pawnb.gait.groups.differences",
    "durations": "pawnb.gait.strides.durations",
    "joint_signals": "pawnb.gait.cycles.joint_signals",
    "mixed": "pawnb.gait.regression.mixed",
    "patterns": "pawnb.gait.phases.patterns",
    "phase_density": "pawnb.gait.phases.density",
    "phase_slopes": "pawnb.gait.regression.phase_slopes",
    "reference_lines": "pawnb.gait.regression.reference_lines",
    "relative_phase": "pawnb.gait.phases.relative_phase",
    "scaling": "pawnb.gait.regression.scaling",
    "second_order": "pawnb.gait.circular.second_order",
    "symmetry": "pawnb.gait.strides.symmetry",
}
"""Modules that are found here by these names, and the subpackages in which they lie."""

_former.answer_imports({f"{__name__}.{name}": home for name, home in _MODULES.items()})
__getattr__, __dir__ = _lazy(__name__, __all__, modules=_MODULES)
