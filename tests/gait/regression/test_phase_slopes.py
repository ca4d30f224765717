"""Slopes of phase on speed within animals: found where they are, and not where they are not."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.circular.correlation import angular_linear
from pawnb.gait.regression.phase_slopes import PHASE_SPEED_COLUMNS, phase_speed_table


def study(rng, *, shift, speeds=None, animals=6, strides=8, sd=0.05, trial_sd=0.02):
    """Six animals at three belt speeds, phases shifting by ``shift`` cycle within each."""
    speeds = np.tile([100.0, 200.0, 300.0], (animals, 1)) if speeds is None else speeds
    n = animals * 3 * strides
    place = (speeds - speeds.mean(axis=1, keepdims=True)) / np.ptp(speeds, axis=1, keepdims=True)
    level = 0.5 + rng.normal(0.0, 0.1, (animals, 1)) + shift * place
    level = np.repeat((level + rng.normal(0.0, trial_sd, level.shape)).ravel(), strides)
    key = {
        "animal": np.repeat([f"m{a}" for a in range(animals)], 3 * strides),
        "trial": np.tile(np.repeat(["t0", "t1", "t2"], strides), animals),
        "stride": np.tile(np.arange(strides), 3 * animals),
    }
    phase = np.mod(level + rng.normal(0.0, sd, n), 1.0)
    speed = np.repeat(speeds.ravel(), strides) + rng.normal(0.0, 2.0, n)
    phases = pd.DataFrame({**key, "leg": "FL", "reference": "FR", "phase": phase})
    return phases, pd.DataFrame({**key, "leg": "FR", "speed": speed})


def test_the_slope_is_the_mean_of_the_animals_slopes():
    # two animals by hand: 0.001 and 0.003 a unit, through the end of the cycle
    speed = np.tile([100.0, 150.0, 200.0], 2)
    phase = np.r_[0.95 + 0.001 * (speed[:3] - 100), 0.2 + 0.003 * (speed[3:] - 100)] % 1.0
    key = {"animal": list("aaabbb"), "trial": "t", "stride": [1, 2, 3, 1, 2, 3]}
    phases = pd.DataFrame({**key, "leg": "L1", "reference": "L2", "phase": phase})
    strides = pd.DataFrame({**key, "leg": "L2", "speed": speed})
    table = phase_speed_table(phases, strides, unit="mm/s")
    assert list(table.columns) == list(PHASE_SPEED_COLUMNS)
    row = table.iloc[0]
    assert row["slope"] == pytest.approx(0.002, rel=1e-6)
    # Student's t with 1 degree of freedom: 12.706 * 0.001
    assert row["ci_high"] - row["slope"] == pytest.approx(0.0127062, rel=1e-5)
    assert (row["n_animals"], row["n"], row["unit"]) == (2, 6, "cycle/(mm/s)")
    one = phase_speed_table(phases[:3], strides[:3]).iloc[0]
    assert one["slope"] == pytest.approx(0.001, rel=1e-6)
    assert np.isnan([one["ci_low"], one["ci_high"], one["p"]]).all()
    assert "one animal" in one["note"]


def test_names_that_are_numbers_are_the_same_in_phases_and_strides():
    """A csv of strides that is read again has animal 1 as a number."""
    phases, strides = study(np.random.default_rng(0), shift=0.2)
    names = {"m0": 0, "m1": 1, "m2": 2, "m3": 3, "m4": 4, "m5": 5}
    numbers = strides.assign(animal=strides["animal"].map(names))
    words = phases.assign(animal=phases["animal"].map(names).astype(str))
    table, as_named = phase_speed_table(words, numbers), phase_speed_table(phases, strides)
    pd.testing.assert_frame_equal(table, as_named)


@pytest.mark.slow
def test_a_shift_within_animals_is_found_where_their_means_show_none():
    # 60 studies of six animals at the same three speeds: means of animals have one speed
    rng = np.random.default_rng(1)
    found = by_means = 0
    for _ in range(60):
        phases, strides = study(rng, shift=0.2)
        found += phase_speed_table(phases, strides)["p"].iloc[0] <= 0.05
        animals = phases["animal"].tolist()
        means = angular_linear(
            phases["phase"], strides["speed"], animals=animals, n_permutations=99
        )
        by_means += means.p_permutation <= 0.05
    assert found >= 57  # 95 %
    assert by_means < 12


@pytest.mark.slow
@pytest.mark.parametrize("ranges", ["equal", "own"])
def test_no_shift_is_found_in_few(ranges):
    # 150 studies: 5 % and two and a half standard errors
    rng = np.random.default_rng(2)
    low = 0
    for _ in range(150):
        speeds = None
        if ranges == "own":
            start, span = rng.uniform(50, 250, (6, 1)), rng.uniform(40, 250, (6, 1))
            speeds = start + span * np.array([0.0, 0.5, 1.0])
        phases, strides = study(rng, shift=0.0, speeds=speeds, strides=4)
        low += phase_speed_table(phases, strides)["p"].iloc[0] <= 0.05
    assert low <= 14


def test_what_a_slope_does_not_say_is_noted():
    rng = np.random.default_rng(3)
    phases, strides = study(rng, shift=0.1)
    spread = phases.assign(phase=np.where(phases["animal"] == "m0", rng.random(len(phases)),
                                          phases["phase"]))  # fmt: skip
    note = phase_speed_table(spread, strides)["note"].iloc[0]
    assert note.startswith("phases of 1 of 6 animals are spread over much of the cycle")
    still = phase_speed_table(phases, strides.assign(speed=100.0)).iloc[0]
    assert (still["n_animals"], np.isnan(still["slope"])) == (0, True)
    assert still["note"] == "no animal has three phases at different speeds"
    with pytest.raises(InputError, match=r"^phase against speed: no stride has a speed"):
        phase_speed_table(phases, strides.assign(speed=np.nan))
