"""Gait statistics on tracks or events from any source; this part knows no video.

:func:`analyse` makes every gait table of a trial, :func:`pool` joins trials. The modules listed
hold what goes beyond: ``circular`` and its kin (phases), ``animals``, ``groups``, ``mixed`` and
``bootstrap`` (animals, not strides), ``regression`` and ``scaling`` (against speed and size),
``residuals`` (the cut-off of a filter).

Examples of functions go on from here: two synthetic spiders whose truth is known, a run each.

>>> import numpy as np
>>> import pandas as pd
>>> import pawnb
>>> study = pawnb.synthetic.simulate_spider_study(animals=2, trials=1, seed=3)
>>> run = study.runs[0]
>>> tracks = run.tracks()
"""

from pawnb import _lazy
from pawnb.gait.analysis.run import analyse, analyse_events
from pawnb.gait.analysis.tables import GaitTables, pool
from pawnb.gait.body_angles import body_angles
from pawnb.gait.event_detection.event_edits import replay_event_edits
from pawnb.gait.event_detection.event_settings import EventSettings
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

__getattr__, __dir__ = _lazy(__name__, __all__)
