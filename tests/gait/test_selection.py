"""Selection of steady trials, by hand."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
from walking import Walk

from pawnb.errors import InputError
from pawnb.gait import analyse, pool
from pawnb.gait.selection import select_steady, steadiness
from pawnb.trial import Animal, Calibration, Trial


def strides(speeds, headings, leg="L2"):
    n = len(speeds)
    return pd.DataFrame(
        {"animal": "a", "trial": "t", "leg": leg, "stride": range(1, n + 1), "speed": speeds,
         "heading_deg": headings, "period_s": 0.2, "start_s": np.arange(n) * 0.2}
    )  # fmt: skip


def test_steady_straight_and_neither():
    row = steadiness(strides([10.0, 11.0, 9.0], [1.0, -1.0, 359.0])).iloc[0]
    assert row["steady"]
    # by hand: sd of 10, 11, 9 is 1, mean 10; headings 1, -1, -1 are 1.15 degrees apart (circular)
    assert row["speed_cv"] == pytest.approx(0.1)
    assert row["heading_deg"] == pytest.approx(-1 / 3, abs=1e-3)
    assert row["heading_sd_deg"] == pytest.approx(0.943, abs=1e-3)
    uneven = steadiness(strides([5.0, 15.0, 10.0], [0.0, 40.0, -40.0])).iloc[0]
    assert not uneven["steady"]
    assert "speed varies by 50%; at most 20% wanted" in uneven["why"]
    assert "heading varies by" in uneven["why"]
    assert "1 stride(s) of a leg" in steadiness(strides([1.0], [0.0])).iloc[0]["why"]
    with pytest.raises(InputError, match="max_speed_cv is 0"):
        steadiness(strides([1.0], [0.0]), max_speed_cv=0)


def test_what_is_not_known_speaks_against_nothing():
    unknown = strides([np.nan] * 3, [0.0] * 3).drop(columns="heading_deg")
    assert steadiness(unknown).iloc[0]["steady"]


def trial(name):
    return Trial(kind="tracks", name=name, fps=250.0, tracks_file="x", animal=Animal(id="a"),
                 calibration=Calibration(unit="mm"), belt_speed=300.0)  # fmt: skip


@pytest.mark.slow
def test_unsteady_trials_are_dropped_with_a_reason():
    one = analyse(Walk().tracks(), trial=trial("steady"))
    two = analyse(Walk().tracks(seed=1), trial=trial("uneven"))
    jerky = two.strides.assign(speed=two.strides["speed"] * np.linspace(0.3, 3.0, len(two.strides)))
    both = pool([one, dataclasses.replace(two, strides=jerky)])
    kept = select_steady(both)
    assert set(kept.strides["trial"]) == set(kept.phases["trial"]) == {"steady"}
    lost = kept.dropped[kept.dropped["what"] == "trial"]
    assert list(lost["trial"]) == ["uneven"]
    assert "speed varies" in lost["why"].iloc[0]
    assert kept.notes[-1] == "1 of 2 trials are steady and were kept."
    assert (kept.phase_summary["n_animals"] == 1).all()
    with pytest.raises(InputError, match="none of 2 trials is steady"):
        select_steady(both, max_speed_cv=1e-9)
