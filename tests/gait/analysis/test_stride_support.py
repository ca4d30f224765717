"""Feet on the ground and stability of each stride: a trot and a wave gait of known footfalls."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from walking import Walk

from pawnb.gait import analyse, analyse_events
from pawnb.gait.analysis.stride_support import SUPPORT_MEASURES, measure_support
from pawnb.gait.cycles.leg_signals import LATERAL, POSITION, LegSignals

WALK_PHASES = {"FR": 0.0, "HL": 0.25, "FL": 0.5, "HR": 0.75}


def footfalls(phases, duty, period=0.4, strides=6):
    rows = []
    for leg, phase in phases.items():
        for k in range(strides):
            down = (k + phase) * period
            rows += [(leg, "TD", down), (leg, "LO", down + duty * period)]
    return pd.DataFrame(rows, columns=["leg", "event", "time_s"])


@pytest.mark.parametrize("duty", [0.6, 0.8])
def test_mean_number_of_feet_down_is_legs_times_duty_factor(duty):
    strides = analyse_events(footfalls(WALK_PHASES, duty)).strides
    known = strides["feet_down"].dropna()
    # the first and last strides reach beyond those of another leg
    assert 0 < len(known) < len(strides)
    # every moment of a stride is as often met: four legs, each down for duty of the time
    np.testing.assert_allclose(known, 4 * duty, atol=0.1)
    # Pullar 2009, appendix A: n / 4 duty - 3 / 4
    np.testing.assert_allclose(strides["wave_gait_margin"], duty - 0.75)
    assert strides["support_area"].isna().all()  # events have no places


def test_two_legs_have_no_wave_gait():
    strides = analyse_events(footfalls({"L1": 0.0, "R1": 0.5}, 0.6)).strides
    assert strides["wave_gait_margin"].isna().all()
    np.testing.assert_allclose(strides["feet_down"].dropna(), 1.2, atol=0.1)


def test_one_leg_and_one_stride():
    strides = analyse_events(footfalls({"L1": 0.0}, 0.6, strides=2)).strides
    assert len(strides) == 1
    assert strides["feet_down"].iloc[0] == pytest.approx(0.6, abs=0.05)


@pytest.mark.slow
def test_a_walk_on_three_feet_is_stable_and_a_trot_is_not():
    options = {"noise": 0.0, "duration": 3.0}
    walk = Walk(duty=0.85, phases=WALK_PHASES, period=0.5, speed=100.0).tracks(**options)
    trot = Walk(duty=0.55, period=0.5, speed=100.0).tracks(**options)
    slow, fast = (analyse(one, belt_speed=100.0).strides for one in (walk, trot))
    assert list(slow.columns[-len(SUPPORT_MEASURES) :]) == list(SUPPORT_MEASURES)
    known = slow.dropna(subset=["stable_share"])
    assert len(known) > 4
    assert (known["feet_down"] > 3.0).all()
    assert (known["support_area"] > fast["support_area"].mean()).all()
    # a trot stands on two feet for most of its stride: a line supports nothing
    assert fast["stable_share"].mean() < 0.4 < known["stable_share"].mean()


def test_the_centre_lies_between_the_first_and_the_last_pair_of_six_legs():
    """Every foot stands, the middle pair far to the front: by hand, along the heading.

    Feet at x = 10, 8 and 0, left and right of the line: the centre is at 5, so the shorter way
    to an edge is 5. The mean of all feet, at 6, would leave 4.
    """
    legs = [f"{side}{k}" for side in "LR" for k in (1, 2, 3)]
    places = {leg: np.array([{1: 10.0, 2: 8.0, 3: 0.0}[int(leg[1])], {"L": 4.0, "R": -4.0}[leg[0]]])
              for leg in legs}  # fmt: skip
    events = pd.DataFrame(
        [(leg, kind, at) for leg in legs for kind, at in (("TD", 0.0), ("LO", 0.999), ("TD", 1.0))],
        columns=["leg", "event", "time_s"],
    ).assign(animal="m1", trial="t1")
    strides = pd.DataFrame(
        {"leg": legs, "start_s": 0.0, "period_s": 1.0, "duty_factor": 0.999}
    ).assign(animal="m1", trial="t1")
    time_s = np.linspace(-0.1, 1.1, 13)
    signals = [
        LegSignals(animal="m1", trial="t1", time_s=time_s, signal=name, legs=tuple(legs),
                   samples=np.tile([places[leg][axis] for leg in legs], (len(time_s), 1)))
        for axis, name in enumerate((POSITION, LATERAL))
    ]  # fmt: skip
    found = measure_support(strides, events, signals=signals)
    np.testing.assert_allclose(found["longitudinal_margin"], 5.0)
    np.testing.assert_allclose(found["support_area"], 80.0)
