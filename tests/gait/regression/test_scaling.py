"""Tables 4.3, 4.4 and 4.5 on animals whose laws are known."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.gait.regression import fit_power
from pawnb.gait.regression.scaling import (
    EXPECTED_COLUMNS,
    EXPECTED_EXPONENTS,
    SCALING_COLUMNS,
    SPEED_COLUMNS,
    expected_slopes_table,
    per_animal,
    scaling_table,
    speed_table,
)


def strides_of_many(*, animals=15, trials=3, strides=8, seed=0):
    """Stride length = 3 mass^0.4; within animals frequency rises by 0.2 with speed."""
    rng = np.random.default_rng(seed)
    mass = np.exp(rng.uniform(-1, 1, animals))
    rows = []
    for a in range(animals):
        level = rng.normal(0, 1.0)
        for k in range(trials):
            speed = 20 + 8 * mass[a] + 3 * k + rng.normal(0, 0.3)
            for _ in range(strides):
                rows.append(
                    {
                        "animal": f"a{a:02d}", "trial": f"t{k}", "mass": mass[a],
                        "body_length": mass[a] ** (1 / 3), "speed": speed,
                        "frequency_hz": 4 + 0.2 * (speed - 8 * mass[a]) + level,
                        "stride_length": 3 * mass[a] ** 0.4 * np.exp(rng.normal(0, 0.1)),
                    }
                )  # fmt: skip
    return pd.DataFrame(rows)


def test_one_point_an_animal():
    table = pd.DataFrame(
        {
            "animal": ["a", "a", "a", "b", "b"],
            "trial": ["1", "1", "2", "1", "1"],
            "speed": [1.0, 3.0, 8.0, 4.0, 6.0],
        }
    )
    found = per_animal(table, ["speed"]).set_index(["animal", "statistic"])["speed"]
    # strides are averaged in trials first: trials of a are 2 and 8
    assert found["a", "mean"] == 5.0
    assert found["a", "min"] == 2.0
    assert found["a", "max"] == 8.0
    assert found["b", "max"] == 5.0
    plain = per_animal(table.drop(columns="trial"), ["speed"], statistics=["max"])
    assert plain["speed"].tolist() == [8.0, 6.0]
    assert plain["n"].tolist() == [3, 2]


def test_known_scaling_is_recovered_and_animals_are_counted():
    strides = strides_of_many()
    table = scaling_table(strides, ["stride_length"], ["mass", "body_length"])
    assert tuple(table.columns) == SCALING_COLUMNS
    assert len(table) == 6
    assert set(table["n_animals"]) == {15}
    assert set(table["df"]) == {13}
    mean = table[(table["statistic"] == "mean") & (table["size"] == "mass")].iloc[0]
    assert mean["ci_low"] < 0.4 < mean["ci_high"]
    assert mean["a"] == pytest.approx(3.0, rel=0.03)
    length = table[(table["statistic"] == "mean") & (table["size"] == "body_length")].iloc[0]
    assert length["b"] == pytest.approx(3 * mean["b"])  # mass goes as length cubed
    assert table["significant"].all()
    # strides as points would have an interval several times too narrow
    naive = fit_power(strides["mass"], strides["stride_length"])
    assert naive.df > 300
    axis = scaling_table(strides, ["stride_length"], ["mass"], method="RMA")
    assert (axis["b"] > table[table["size"] == "mass"]["b"].to_numpy()).all()


def test_size_is_the_mean_of_what_was_estimated():
    # body length estimated anew in each trial, 10 % up or down about the same mean
    strides = strides_of_many(trials=2)
    up = np.where(strides["trial"] == "t0", 0.9, 1.1)
    one = scaling_table(strides, ["stride_length"], ["body_length"], statistics=["max"])
    two = scaling_table(
        strides.assign(body_length=strides["body_length"] * up),
        ["stride_length"], ["body_length"], statistics=["max"],
    )  # fmt: skip
    assert two["a"].iloc[0] == pytest.approx(one["a"].iloc[0])


def test_expected_exponents():
    strides = strides_of_many().assign(relative_speed=lambda t: t["speed"] / t["body_length"])
    table = expected_slopes_table(strides)
    assert tuple(table.columns) == EXPECTED_COLUMNS
    assert len(table) == len(EXPECTED_EXPONENTS) == 11
    rows = [("stride_length", "mass", 0.4, "truth"), ("stride_length", "mass", 0.6, "nobody")]
    assert expected_slopes_table(strides, rows)["differs"].tolist() == [False, True]
    assert (table["differs"] == (table["p"] < 0.05)).all()
    inside = table["expected"].between(table["ci_low"], table["ci_high"])
    assert (table["differs"] == ~inside).all()


def test_speed_between_animals_is_not_speed_within():
    table = speed_table(strides_of_many(), ["frequency_hz"], ["speed"]).iloc[0]
    assert tuple(table.index) == SPEED_COLUMNS
    assert (table["n_points"], table["n_animals"]) == (45, 15)
    # heavy animals are fast at no higher frequency, which flattens the line through all points
    assert table["b"] < 0.12
    assert table["b_animals"] == pytest.approx(0.2, abs=1e-6)
    assert table["n_slopes"] == 15
    assert table["significant"]


def test_one_trial_an_animal_has_no_slope_within():
    strides = strides_of_many(trials=1)
    table = speed_table(strides, ["stride_length", "speed"], ["speed"])
    assert len(table) == 1  # speed on speed is left out
    assert np.isnan(table["b_animals"].iloc[0])
    assert table["p"].iloc[0] == table["p_if_independent"].iloc[0]
    assert table["n_points"].iloc[0] == table["n_animals"].iloc[0] == 15
    excludes = (table["ci_low"] > 0) | (table["ci_high"] < 0)
    assert (table["significant"] == excludes).all()


def test_one_animal_with_several_trials_says_nothing_of_animals():
    strides = strides_of_many(animals=6)
    some = strides[(strides["trial"] == "t0") | (strides["animal"] == "a00")]
    table = speed_table(some, ["frequency_hz"]).iloc[0]
    assert (table["n_points"], table["n_animals"], table["n_slopes"]) == (8, 6, 0)
    assert np.isnan(table["p"])
    assert not table["significant"]


@pytest.mark.slow
def test_false_alarms_where_animals_differ_in_slope():
    # no effect over animals; slopes of single animals vary about 0
    rng = np.random.default_rng(0)
    naive = counted = 0
    for _ in range(300):
        animal = np.repeat(np.arange(8), 5)
        x = rng.normal(0, 1, 40)
        y = rng.normal(0, 1, 8)[animal] + rng.normal(0, 0.6, 8)[animal] * x
        y += rng.normal(0, 0.3, 40)
        points = pd.DataFrame({"animal": animal, "speed": x, "y": y})
        row = speed_table(points, ["y"]).iloc[0]
        naive += row["p_if_independent"] < 0.05
        counted += row["significant"]
    # nominally 0.05; 300 studies have a standard error of 0.013
    assert counted / 300 < 0.09
    assert naive / 300 > 0.12


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda t: per_animal(t, ["weight"]), r"weight"),
        (lambda t: per_animal(t, ["speed"], statistics=["mode"]), r"^measures: statistic 'mode';"),
        (lambda t: per_animal(t.iloc[:0], ["speed"]), r"^measures: no row; expected at least one"),
        (lambda t: scaling_table(t, ["speed"], ["mass"], method="MA"), r"^method is 'MA'; exp"),
    ],
)
def test_bad_arguments_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call(strides_of_many())


def test_trials_of_one_speed_but_for_rounding_have_no_slope_within():
    """A belt of one speed: means of as many strides of it differ in their last digit."""
    rows = [
        ("a", 300.0, 4.0),
        ("a", float(np.nextafter(300.0, 301.0)), 4.1),
        ("b", 200.0, 3.0),
        ("b", 250.0, 3.4),
    ]
    assert rows[1][1] > 300.0
    points = pd.DataFrame(rows, columns=["animal", "speed", "y"])
    row = speed_table(points, ["y"]).iloc[0]
    assert (row["n_points"], row["n_animals"], row["n_slopes"]) == (4, 2, 0)
    assert np.isnan(row["p"])
