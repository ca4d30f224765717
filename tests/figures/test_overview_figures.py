"""Figures of a whole study: what they draw is what their tables say."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.measure_heat_map import say_measure

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def cycles(*, bump=3.0):
    """Five animals a group; the second is higher from 90 percent on and over the end to 5."""
    rng = np.random.default_rng(2)
    percent = np.linspace(0.0, 100.0, 41)
    late = (percent >= 90.0) | (percent <= 5.0)
    parts = []
    for i in range(10):
        values = np.sin(2 * np.pi * percent / 100) + rng.normal(0, 0.3, len(percent))
        values[-1] = values[0]
        group = "ab"[i >= 5]
        values = values + bump * late * (group == "b")
        parts.append(
            pd.DataFrame({"percent": percent, "value": values}).assign(
                animal=f"m{i}", trial="t", leg="L2", stride=1, signal="leg angle", unit="deg",
                group=group,
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)


def strides(n=6):
    rng = np.random.default_rng(0)
    rows = [(f"m{i}", leg, 5.0 + i + rng.normal(0, 0.1), 0.6 - 0.01 * i, rng.normal(), 7.0)
            for i in range(n) for leg in ("FR", "HR")]  # fmt: skip
    columns = ["animal", "leg", "frequency_hz", "duty_factor", "noise", "same"]
    return pd.DataFrame(rows, columns=columns)


MEASURES = ["frequency_hz", "duty_factor", "noise", "same"]
GROUPS = {f"m{i}": "ab"[i % 2] for i in range(6)}


def test_curves_have_a_bar_where_they_differ_also_over_the_end_of_the_stride():
    table = figures.build_cycle_comparison_table(cycles())
    found = table[(table["row"] == "cluster") & (table["p"] <= 0.05)]
    assert len(found) == 1
    assert found[["start_percent", "stop_percent"]].to_numpy().tolist() == [[90.0, 5.0]]
    ax = figures.plot_cycle_comparison(table)
    bars = [line.get_xdata().tolist() for line in ax.lines if line.get_color() == "black"]
    assert bars == [[90.0, 100.0], [0.0, 5.0]]
    assert "p 0.008" in "".join(text.get_text() for text in ax.texts)  # 2 of 252
    assert [text.get_text() for text in ax.figure.legends[0].get_texts()] == ["a", "b"]


def test_bars_of_several_comparisons_are_those_of_the_adjusted_p():
    table = figures.build_cycle_comparison_table(cycles())
    for adjusted, said in ((0.024, "adj. p 0.024"), (0.09, "")):
        table.loc[table["row"] == "cluster", "p_adjusted"] = adjusted
        ax = figures.plot_cycle_comparison(table)
        bars = [line for line in ax.lines if line.get_color() == "black"]
        assert bool(bars) == bool(said)
        words = "".join(text.get_text() for text in ax.texts)
        assert said in words
        assert ("p 0" in words) == bool(said)


def test_curves_without_a_difference_have_no_bar():
    ax = figures.plot_cycle_comparison(figures.build_cycle_comparison_table(cycles(bump=0.0)))
    assert not [line for line in ax.lines if line.get_color() == "black"]


def test_heat_map_shows_standard_deviations_group_by_group():
    table = figures.build_measure_heat_map_table(strides(), MEASURES, groups=GROUPS)
    assert table["animal"].iloc[:6].tolist() == ["m0", "m2", "m4", "m1", "m3", "m5"]
    assert "same" not in set(table["measure"])
    own = table[table["measure"] == "duty_factor"].set_index("animal")["z"]
    # six numbers in equal steps: the outer ones are 2.5 / sqrt(3.5) from the mean
    assert own["m0"] == pytest.approx(2.5 / np.sqrt(3.5))
    ax = figures.plot_measure_heat_map(table)
    shown = ax.images[0].get_array()
    assert shown.shape == (3, 6)
    assert shown[1, 0] == pytest.approx(own["m0"])
    assert [text.get_text() for text in ax.texts] == ["a", "b"]
    assert ax.get_yticklabels()[0].get_text() == "frequency (Hz)"


def test_components_show_scores_and_loadings():
    table = figures.build_measure_components_table(strides(), MEASURES, groups=GROUPS)
    ax = figures.plot_measure_components(table)
    assert len([line for line in ax.lines if line.get_marker() not in ("None", None, "")]) == 6
    first = table[table["row"] == "loading"].query("component == 'PC1'").set_index("measure")
    # frequency rises and duty factor falls from animal to animal: one component holds both
    assert abs(first.loc["frequency_hz", "value"] - first.loc["duty_factor", "value"]) > 1.2
    right = ax.figure.axes[1]
    drawn = next(line for line in right.lines if line.get_label() == "PC1")
    np.testing.assert_allclose(sorted(drawn.get_xdata()), sorted(first["value"]))


@pytest.mark.parametrize(
    ("column", "words"),
    [("swing_s", "swing (s)"), ("frequency_hz", "frequency (Hz)"), ("step_width", "step width"),
     ("swing_peak_acceleration_deg_s2", "swing peak acceleration (deg/s²)"),
     ("excursion_deg", "excursion (deg)"), ("stance_velocity_deg_s", "stance velocity (deg/s)")],
)  # fmt: skip
def test_columns_in_words(column, words):
    assert say_measure(column) == words


def test_empty_tables_are_refused():
    for name in ("cycle_comparison", "measure_heat_map", "measure_components", "phase_density"):
        module = __import__(f"pawnb.figures.{name}", fromlist=["COLUMNS"])
        columns = getattr(module, "COLUMNS", None) or module.DENSITY_COLUMNS
        with pytest.raises(InputError, match="the table is empty"):
            getattr(figures, f"plot_{name}")(pd.DataFrame(columns=list(columns)))


def test_reference_lines_are_drawn_where_they_are_near():
    points = pd.DataFrame(
        {"animal": list("abcd"), "trial": "t", "duty_factor": [0.6, 0.65, 0.7, 0.72],
         "speed": [100.0, 150.0, 200.0, 260.0]}
    )  # fmt: skip
    table = figures.build_regression_table(points, [("duty_factor", "speed")], points="animal")
    references = {"duty_factor": (0.75, "unstable below"), "speed": (9000.0, "far away")}
    ax = figures.plot_regression(table, references=references)
    said = [text.get_text() for text in ax.texts]
    assert "unstable below" in said
    assert "far away" not in said
    assert any(list(line.get_ydata()) == [0.75, 0.75] for line in ax.lines)


@pytest.mark.parametrize("high", ["duty_factor", "speed"])
def test_words_of_a_reference_line_touch_no_point(high):
    """Points fall towards the line, so that it is free at one end of one side of it only."""
    slow = np.linspace(20.0, 40.0, 24)
    duty = 0.83 - 0.005 * (slow - 20.0) + 0.004 * (-1.0) ** np.arange(24)
    points = pd.DataFrame(
        {"animal": [f"m{k}" for k in range(24)], "trial": "t", "duty_factor": duty, "speed": slow}
    )
    low = "speed" if high == "duty_factor" else "duty_factor"
    table = figures.build_regression_table(points, [(high, low)], points="animal")
    ax = figures.plot_regression(table, references={"duty_factor": (0.75, "unstable below (X)")})
    ax.figure.canvas.draw()
    (words,) = (text for text in ax.texts if "unstable" in text.get_text())
    box = words.get_window_extent()
    at = ax.transData.transform(points[[low, high]].to_numpy(float))
    assert not any(box.contains(u, v) for u, v in at)
    inside = ax.get_window_extent()
    assert inside.x0 - 2 <= box.x0
    assert box.x1 <= inside.x1 + 2
