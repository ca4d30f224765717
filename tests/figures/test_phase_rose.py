"""Phase rose: counts by hand, sectors whose area is the count, the mean vector."""

from __future__ import annotations

import math

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.errors import InputError
from pawnb.figures import build_phase_rose_table, plot_phase_rose
from pawnb.figures.phases_shown import interval_length, say_interval

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def phases(values, leg="FL", reference="FR", animals=None):
    return pd.DataFrame(
        {
            "animal": animals or ["m"] * len(values),
            "trial": "t",
            "leg": leg,
            "reference": reference,
            "stride": np.arange(len(values)),
            "phase": values,
        }
    )


VALUES = [0.0, 0.26, 0.3, 0.49, 0.5, 0.99]


def test_counts_by_hand():
    table = build_phase_rose_table(phases(VALUES, animals=list("aabbbb")), bins=4)
    assert table["count"].tolist() == [1, 3, 1, 1]
    assert table["bin_start"].tolist() == [0.0, 0.25, 0.5, 0.75]
    assert table["bin_end"].tolist() == [0.25, 0.5, 0.75, 1.0]
    assert (table["n"] == 6).all()
    assert (table["n_animals"] == 2).all()
    # mean vector by hand
    vector = np.exp(2j * np.pi * np.array(VALUES)).mean()
    np.testing.assert_allclose(table["r"], abs(vector))
    np.testing.assert_allclose(table["mean"], np.angle(vector) / 2 / np.pi % 1)


@pytest.mark.slow
@settings(deadline=None)
@given(st.lists(st.floats(0, 1, exclude_max=True), min_size=1, max_size=50), st.integers(4, 72))
def test_every_phase_is_counted_once(values, bins):
    table = build_phase_rose_table(phases(values), bins=bins)
    assert table["count"].sum() == len(values) == table["n"].iloc[0]
    assert len(table) == bins


def test_area_is_the_count_and_the_arrow_the_mean_vector():
    table = build_phase_rose_table(phases([0.3] * 4 + [0.6]), bins=10)
    ax = plot_phase_rose(table)
    heights = np.array([bar.get_height() for bar in ax.patches])
    np.testing.assert_allclose(heights**2, table["count"] / 4)
    arrow = next(t for t in ax.texts if getattr(t, "arrow_patch", None) is not None)
    np.testing.assert_allclose(arrow.xy, (2 * np.pi * table["mean"].iloc[0], table["r"].iloc[0]))
    assert ax.get_ylim() == (0.0, 1.0)
    assert ax.get_title() == "FL relative to FR"
    lines = ax.get_xlabel().split("\n")
    assert lines[0] == f"mean {table['mean'].iloc[0]:.2f} cycle, r {table['r'].iloc[0]:.2f}"
    assert lines[1:] == ["5 strides, 1 animal", "fullest sector: 4"]


def test_several_animals_count_once_each_and_have_an_interval():
    """Animal a has one phase of 0.1, b three of 0.3: over animals the mean is 0.2."""
    values = phases([0.1, 0.3, 0.3, 0.3], animals=list("abbb"))
    table = build_phase_rose_table(values)
    assert set(table["basis"]) == {"animals"}
    np.testing.assert_allclose(table["basis_mean"], 0.2)
    assert (table["mean"] > 0.22).all()
    summary = pd.DataFrame(
        [{"leg": "FL", "reference": "FR", "mean": 0.2, "r": 0.8, "ci_low": 0.95, "ci_high": 0.45,
          "pattern": "in-phase"}]
    )  # fmt: skip
    ax = plot_phase_rose(build_phase_rose_table(values, summary=summary))
    arrow = next(t for t in ax.texts if getattr(t, "arrow_patch", None) is not None)
    np.testing.assert_allclose(arrow.xy, (2 * np.pi * 0.2, 0.8))
    arc = ax.lines[0].get_xdata() / 2 / np.pi
    assert (arc[0], arc[-1]) == pytest.approx((0.95, 1.45))  # half a cycle, across 0
    assert ax.get_xlabel().startswith("mean 0.20 [0.95, 0.45] cycle, r 0.80\n4 strides, 2 animals")


def test_phase_zero_is_on_top_and_runs_clockwise():
    ax = plot_phase_rose(build_phase_rose_table(phases([0.3])))
    assert ax.get_theta_offset() == pytest.approx(np.pi / 2)
    assert ax.get_theta_direction() == -1
    assert [t.get_text() for t in ax.get_xticklabels()] == ["0", "0.25", "0.5", "0.75"]


def test_opposite_phases_have_no_arrow():
    ax = plot_phase_rose(build_phase_rose_table(phases([0.1, 0.6])))
    assert not any(getattr(t, "arrow_patch", None) for t in ax.texts)
    assert ax.get_xlabel().startswith("no mean, r 0.00\n2 strides")


def test_several_pairs_have_a_panel_each():
    both = pd.concat([phases(VALUES), phases([0.1], "HL", "HR"), phases([0.2], "FR", "HR")])
    first = plot_phase_rose(build_phase_rose_table(both))
    panels = first.figure.axes
    assert [p.get_title() for p in panels] == [
        "FL relative to FR", "HL relative to HR", "FR relative to HR",
    ]  # fmt: skip
    assert panels[0] is first
    assert first.figure.get_size_inches()[0] * 25.4 == pytest.approx(170.0)
    one = plot_phase_rose(build_phase_rose_table(phases(VALUES)))
    assert one.figure.get_size_inches()[0] * 25.4 == pytest.approx(85.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: build_phase_rose_table(phases([])), r"^phase rose: no phases; .* a longer"),
        (lambda: build_phase_rose_table(phases([0.2]), bins=3), r"^bins is 3; expected 4 or more"),
        (lambda: build_phase_rose_table(phases([120.0])), r"give phases in cycles\.$"),
        (lambda: plot_phase_rose(build_phase_rose_table(phases([0.1])).iloc[:0]),
         r"^phase rose: the table is empty\.$"),
        (lambda: plot_phase_rose(
            build_phase_rose_table(pd.concat([phases([0.1]), phases([0.1], "HL")])),
            ax=plt.subplot(projection="polar")), r"^phase rose: 2 pairs of legs for one axes"),
    ],
)  # fmt: skip
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_an_interval_of_the_whole_cycle_goes_all_the_way_round():
    # two animals half a cycle apart have no mean: 0 to 1
    assert interval_length(0.0, 1.0) == 1.0
    assert interval_length(0.95, 0.05) == pytest.approx(0.1)
    assert say_interval(0.0, 1.0) == "[0.00, 1.00]"
    assert say_interval(0.95, 0.999) == "[0.95, 0.00]"
    assert say_interval(math.nan, math.nan) == ""
    ax = plot_phase_rose(build_phase_rose_table(phases([0.25, 0.75], animals=["a", "b"])))
    arc = max((line.get_xdata() for line in ax.lines), key=len)
    assert np.ptp(arc) == pytest.approx(2.0 * math.pi)
    assert ax.get_xlabel().startswith("no mean")


def test_one_stride_has_no_mean_and_no_r():
    # r of a single phase is 1 by arithmetic, and was written as if it said something
    phases = pd.DataFrame(
        [{"animal": "m1", "trial": "t", "leg": "FL", "reference": "FR", "stride": 1, "phase": 0.4}]
    )
    said = plot_phase_rose(build_phase_rose_table(phases)).get_xlabel()
    assert said.startswith("0.40 cycle\n1 stride, 1 animal")
