"""The gallery: every figure is drawn while the documentation is built, from a synthetic study.

A Sphinx extension. Each ``draw_...`` function below is one figure: its docstring is the caption,
its body the code that is shown beneath the picture.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd

FOLDER = "_generated"
SETUP = '''
import numpy as np
import pandas as pd

import pawnb
from pawnb import figures

study = pawnb.synthetic.simulate_spider_study(animals=6, trials=2, seed=3)
gait = pawnb.gait.pool(
    [pawnb.gait.analyse(run.tracks(), trial=run.trial) for run in study.runs]
)
'''


def draw_gait_diagram(gait, study, figures):
    """Gait diagram: when each foot is on the ground."""
    table = figures.build_gait_diagram_table(gait.events, dropped=gait.dropped)
    first = table[table["trial"] == table["trial"].iloc[0]]
    return figures.plot_gait_diagram(first)


def draw_stepping_pattern(gait, study, figures):
    """Stepping pattern: steps of each leg, with how the body went."""
    table = figures.build_stepping_pattern_table(gait.events, gait.strides, dropped=gait.dropped)
    return figures.plot_stepping_pattern(table, unit="mm")


def draw_phase_rose(gait, study, figures):
    """Phase rose: phases of a pair of legs around the cycle; the mean counts animals."""
    pairs = [("L2", "R2"), ("L2", "L3")]
    table = figures.build_phase_rose_table(gait.phases, summary=gait.phase_summary, pairs=pairs)
    return figures.plot_phase_rose(table)


def draw_phase_histogram(gait, study, figures):
    """Phase histogram: the same phases on a straight axis."""
    pairs = [("L2", "R2"), ("L2", "L3")]
    table = figures.build_phase_histogram_table(
        gait.phases, summary=gait.phase_summary, pairs=pairs
    )
    return figures.plot_phase_histogram(table)


def draw_phase_speed(gait, study, figures):
    """Phase against speed: the slope is that within animals."""
    pairs = [("L2", "R2"), ("L2", "L3")]
    table = figures.build_phase_speed_table(gait.phases, gait.strides, pairs=pairs)
    return figures.plot_phase_speed(table, unit="mm")


def draw_regression(gait, study, figures):
    """A measure against speed, one point a trial, with its band."""
    l2 = gait.strides[gait.strides["leg"] == "L2"]
    table = figures.build_regression_table(l2, [("frequency_hz", "speed")], points="trial")
    names = {"frequency_hz": "Stride frequency (Hz)", "speed": "Speed (mm/s)"}
    return figures.plot_regression(table, names=names)


def draw_estimation(gait, study, figures):
    """Two groups of animals: each animal, the difference of means, and its interval."""
    animals = sorted(gait.strides["animal"].unique())
    group = dict(zip(animals, ["control"] * 3 + ["treated"] * 3, strict=True))
    strides = gait.strides.assign(group=gait.strides["animal"].map(group))
    table = figures.build_estimation_table(
        strides, ["duty_factor"], reference="control", id_columns=("leg",)
    )
    return figures.plot_estimation(table, names={"duty_factor": "Duty factor"})


def draw_leg_angles(gait, study, figures):
    """Leg angles of a jointed animal, with AEP (up) and PEP (down)."""
    run = study.runs[0]
    angles = pawnb_gait().leg_angles(run.tracks())
    events = gait.events[gait.events["trial"] == run.trial.name]
    return figures.plot_leg_angles(angles[angles["leg"].isin(["L2", "R2"])], events=events)


def draw_summary_page(gait, study, figures):
    """One page about an animal."""
    animal = gait.strides["animal"].iloc[0]
    table = figures.build_summary_page_table(gait.strides, animal=animal)
    return figures.plot_summary_page(
        table, events=gait.events, strides=gait.strides, phases=gait.phases, unit="mm"
    )
