"""Regression, scaling, agreement and joint figures: tables by hand, and what is drawn."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures.bland_altman import build_bland_altman_table, plot_bland_altman
from pawnb.figures.joint_ranges import build_joint_ranges_table, plot_joint_ranges
from pawnb.figures.regression import build_regression_table, plot_regression
from pawnb.figures.scaling import build_scaling_table, plot_scaling
from pawnb.gait.joints import get_joint_angles
from pawnb.gait.regression import fit_line, fit_power
from pawnb.gait.repeatability import bland_altman

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def study():
    """Frequency falls with speed over animals and rises with it within each."""
    rng = np.random.default_rng(0)
    rows = [
        (f"a{a}", f"t{t}", 20 + 3 * a + t, 12 - a + 0.8 * t + rng.normal(0, 0.05), 1.0 + a)
        for a in range(6)
        for t in range(3)
        for _ in range(4)
    ]
    return pd.DataFrame(rows, columns=["animal", "trial", "speed", "frequency_hz", "mass"])


def test_points_are_animals_with_the_spread_of_their_trials():
    table = build_regression_table(study(), [("speed", "mass")], kind="power")
    points = table[table["row"] == "point"]
    assert points["animal"].tolist() == [f"a{k}" for k in range(6)]
    np.testing.assert_allclose(points["y"], 21 + 3 * np.arange(6.0))
    np.testing.assert_allclose(points["y_sd"], 1.0)  # of 20, 21, 22
    law = fit_power(points["x"].to_numpy(), points["y"].to_numpy())
    drawn = table[table["row"] == "line"]
    again = law.predict(drawn["x"].to_numpy())
    np.testing.assert_allclose(drawn[["y", "low", "high"]], again[["fit", "low", "high"]])
    assert table["n"].eq(6).all()
    assert table["b_animals"].isna().all()


def test_trials_keep_their_animals():
    table = build_regression_table(study(), [("frequency_hz", "speed")], points="trial")
    first = table.iloc[0]
    assert (first["n"], first["n_animals"]) == (18, 6)
    assert first["b"] < 0
    assert first["b_animals"] == pytest.approx(0.8, abs=0.05)
    own = table[(table["row"] == "animal") & (table["animal"] == "a2")]
    points = table[(table["row"] == "point") & (table["animal"] == "a2")]
    expected = np.polyfit(points["x"], points["y"], 1)[0]
    assert np.polyfit(own["x"], own["y"], 1)[0] == pytest.approx(expected)
    assert own["y"].mean() == pytest.approx(points["y"].mean())
    assert own["x"].max() == points["x"].max()


def test_lines_of_animals_are_drawn_and_the_other_is_grey():
    pairs = [("frequency_hz", "speed"), ("speed", "mass")]
    table = build_regression_table(study(), pairs, points="trial")
    ax = plot_regression(table, names={"speed": "Speed (cm/s)"})
    figure = ax.figure
    assert ax.get_xlabel() == "Speed (cm/s)"
    dashed, *rest = ax.lines
    assert dashed.get_linestyle() == "--"
    assert [line.get_linestyle() for line in rest].count("-") == 6
    assert not ax.collections  # no band for points that are not independent
    assert "18 trials, 6 animals" in ax.get_title(loc="right")
    assert len(figure.legends[0].get_texts()) == 6


def test_band_only_where_the_interval_excludes_zero():
    rng = np.random.default_rng(1)
    table = pd.DataFrame(
        {"animal": [f"a{k}" for k in range(12)], "x": np.arange(12.0), "y": rng.normal(0, 1, 12)}
    )
    flat = build_regression_table(table, [("y", "x")])
    assert not flat["significant"].any()
    ax = plot_regression(flat)
    assert not ax.collections
    assert ax.lines[0].get_linestyle() == "--"
    steep = build_regression_table(table.assign(y=lambda t: t["y"] + t["x"]), [("y", "x")])
    ax = plot_regression(steep)
    assert len(ax.collections) == 1
    line = fit_line(table["x"], table["y"] + table["x"])
    assert f"r² = {line.r2:.2f}" in ax.get_title(loc="right")
    axis = build_regression_table(table.assign(y=lambda t: t["y"] + t["x"]), [("y", "x")],
                                  method="RMA")  # fmt: skip
    assert axis.loc[axis["row"] == "line", "low"].isna().all()
    assert "(RMA)" in plot_regression(axis, log=False).get_title(loc="right")


def test_words_of_a_fit_are_short_and_plain():
    x = np.linspace(0.1, 0.2, 12)
    table = pd.DataFrame({"animal": [f"a{k}" for k in range(12)], "x": x, "y": 1500 - 5678 * x})
    table["y"] += np.tile([0.1, -0.1], 6)
    ax = plot_regression(build_regression_table(table, [("y", "x")]))
    assert ax.get_title(loc="right").startswith("y = 1500 − 5678 x, r² = 1.00")
    table["y"] = 2e-5 * x + np.tile([1e-9, -1e-9], 6)
    ax = plot_regression(build_regression_table(table, [("y", "x")]))
    assert " + 2e−5 x" in ax.get_title(loc="right")


@pytest.mark.slow
def test_logarithmic_axes_have_plain_numbers():
    power = species().assign(animal=lambda t: t["name"])
    ax = plot_regression(build_regression_table(power, [("speed", "mass")], kind="power"), log=True)
    ax.figure.canvas.draw()
    assert {"0.01", "0.1", "1", "10"} <= {t.get_text() for t in ax.get_xticklabels()}
    # five decades of mass, but little more than one of speed: there 2 and 5 are said
    assert {t.get_text() for t in ax.get_xticklabels(minor=True)} == {""}
    minor = {t.get_text() for t in ax.get_yticklabels(minor=True)}
    assert {"2", "5"} <= minor
    assert "3" not in minor


def species():
    rng = np.random.default_rng(2)
    mass = 10 ** rng.uniform(-3, 2, 30)
    group = np.where(mass > 1, "mammals", "spiders")
    speed = 5 * mass**0.2 * np.exp(rng.normal(0, 0.1, 30))
    names = [f"s{k}" for k in range(30)]
    return pd.DataFrame({"name": names, "group": group, "mass": mass, "speed": speed})


def test_own_species_among_others():
    own = pd.DataFrame({"name": ["mine"], "group": ["spiders"], "mass": [0.01], "speed": [0.4]})
    table = build_scaling_table(species(), own, size="mass", value="speed", without=["mammals"])
    laws = table[table["row"] == "line"].groupby("line", sort=False).first()
    assert laws.index.tolist() == ["reference", "with own", "without mammals"]
    few = int((species()["group"] == "spiders").sum())
    assert laws["n"].tolist() == [30, 31, few]
    assert laws.loc["reference", "ci_low"] < 0.2 < laws.loc["reference", "ci_high"]
    ax = plot_scaling(table, size_name="Mass (kg)")
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    filled = [line for line in ax.lines if line.get_markerfacecolor() == "#D55E00"]
    assert len(filled) == 1
    np.testing.assert_array_equal(filled[0].get_xydata(), [[0.01, 0.4]])
    words = [text.get_text() for text in ax.figure.legends[0].get_texts()]
    assert words == ["mammals", "spiders", "mine"]
    with pytest.raises(InputError, match=r"^reference table: no group 'birds' to leave out\.$"):
        build_scaling_table(species(), size="mass", value="speed", without=["birds"])


def strides(shift):
    rng = np.random.default_rng(3)
    rows = [
        (animal, "t", "L1", 0.2 * k, 0.2 + rng.normal(0, 0.01), 0.6 + rng.normal(0, 0.05))
        for animal in "ab"
        for k in range(8)
    ]
    names = ["animal", "trial", "leg", "start_s", "period_s", "duty_factor"]
    return pd.DataFrame(rows, columns=names).assign(duty_factor=lambda t: t["duty_factor"] + shift)


def test_agreement_figure_shows_bias_and_limits():
    noise = np.random.default_rng(4).normal(0.02, 0.01, 16)
    table = build_bland_altman_table(strides(0.0), strides(noise), measures=["duty_factor"])
    found = bland_altman(strides(0.0)["duty_factor"], strides(noise)["duty_factor"])
    np.testing.assert_allclose(np.sort(table["difference"]), np.sort(noise))
    assert table["bias"].iloc[0] == pytest.approx(found.bias)
    ax = plot_bland_altman(table, names={"duty_factor": "Duty factor"})
    heights = [line.get_ydata()[0] for line in ax.lines[:4]]
    assert heights == pytest.approx([0.0, found.bias, found.limit_low, found.limit_high])
    assert ax.get_xlabel() == "Mean: Duty factor"
    assert "16 strides, 2 animals" in ax.get_title(loc="right")
    with pytest.raises(InputError, match=r"^Bland-Altman: no measure has three shared strides"):
        build_bland_altman_table(strides(0.0).iloc[:2], strides(0.0))


def test_joint_figure_shows_means_animals_and_share():
    poses = {
        "a": pd.DataFrame({"L1_BC": [10.0, 50.0], "L2_BC": [-10.0, 30.0], "L1_TF": [0.0, 0.0]}),
        "b": pd.DataFrame({"L1_BC": [14.0, 62.0], "L2_BC": [-6.0, 34.0], "L1_TF": [0.0, 0.0]}),
    }
    angles = pd.concat([get_joint_angles(pose, animal=name) for name, pose in poses.items()])
    whole = pd.DataFrame(
        {"joint": "BC", "pair": ["1", "2"], "range_deg": [55.0, 80.0], "natural_deg": [35.0, 14.0]}
    )
    table = build_joint_ranges_table(angles, mechanical=whole)
    assert set(table["joint"]) == {"BC"}  # a joint that never moves is left out
    means = table[table["row"] == "mean"]
    assert means["share_percent"].tolist() == [80.0, 50.0]  # 44 of 55, 40 of 80
    ax = plot_joint_ranges(table)
    assert ax.get_title(loc="right") == "Body-coxa"
    bars = [(p.get_y(), p.get_y() + p.get_height()) for p in ax.patches]
    np.testing.assert_allclose(bars, [(7.5, 62.5), (-26.0, 54.0), (12.0, 56.0), (-8.0, 32.0)])
    assert [text.get_text() for text in ax.texts] == ["80 %", "50 %"]
    low, high = ax.get_ylim()
    assert low < -26.0
    assert high > 62.5


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda t: build_regression_table(t, []), r"^regression figure: 0 pairs, points 'animal'"),
        (lambda t: build_regression_table(t, [("speed", "mass")], points="leg"), r"points 'leg'"),
        (lambda t: build_regression_table(t, [("speed", "weight")]), r"weight"),
        (
            lambda t: build_regression_table(t, [("speed", "mass")], method="MA"),
            r"^method is 'MA'; expected 'OLS' or 'RMA'\.$",
        ),
        (
            lambda t: build_regression_table(
                t.drop(columns="trial"), [("speed", "mass")], points="trial"
            ),
            r"^regression figure: measures have no column trial; use points='animal'\.$",
        ),
    ],
)
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call(study())


def test_a_p_that_takes_strides_as_independent_says_so():
    own = study().query("animal == 'a0'")
    pair = [("frequency_hz", "speed")]
    alone = plot_regression(build_regression_table(own, pair, points="row"))
    said = alone.get_title(loc="right").splitlines()
    assert said[1].endswith("if 12 strides")
    assert said[2] == "of 1 animal were independent"
    # one trial of each animal: the points are animals
    first = study().query("trial == 't0'")
    each = plot_regression(build_regression_table(first, pair, points="trial"))
    assert each.get_title(loc="right").splitlines()[1].endswith(", 6 animals")
