"""Long names of groups and animals: in lines, beside each other, on the paper."""

from __future__ import annotations

import itertools
import warnings

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb import figures
from pawnb.figures.long_names import wrap_name

mpl.use("Agg")

GROUPS = (
    "Prrxl1-Cre;R26-LSL-tdTomato knock-out (8 weeks)",
    "C57BL/6J wild-type littermates, vehicle",
    "sham-operated contrôles",
)
MEASURES = ["frequency_hz", "duty_factor", "stride_length", "swing_s", "speed"]


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


@pytest.fixture
def strides():
    """Ten animals of each group, with names as labs give them."""
    rng = np.random.default_rng(2)
    rows = [
        {"animal": f"C57BL6J_cage{k // 5:02d}_mouse{k:03d}_rightEarNotch", "group": GROUPS[k % 3],
         "leg": "FR", **dict(zip(MEASURES, rng.normal(1.0, 0.1, 5), strict=True))}
        for k in range(30)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def drawn(ax):
    """Lay the figure out; a layout that collapses is an error."""
    figure = ax.get_figure(root=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure.draw_without_rendering()
    return figure


def boxes(texts):
    return [text.get_window_extent() for text in texts if text.get_text().strip()]


def check_apart(texts):
    for one, other in itertools.combinations(boxes(texts), 2):
        assert not one.overlaps(other)


def check_on_paper(figure):
    for text in figure.findobj(mpl.text.Text):
        if text.get_visible() and text.get_text().strip():
            box = text.get_window_extent()
            assert box.x0 >= figure.bbox.x0 - 2, text.get_text()
            assert box.x1 <= figure.bbox.x1 + 2, text.get_text()


@pytest.mark.parametrize(
    ("name", "letters", "lines"),
    [
        ("control", 8, ["control"]),
        ("wild-type littermates", 12, ["wild-type", "littermates"]),
        ("R26-LSL-tdTomato", 9, ["R26-LSL-", "tdTomato"]),
        ("Verhaltensforschung", 8, ["Verhalte", "nsforsch", "ung"]),
    ],
)
def test_names_are_broken_behind_blanks_and_marks_else_within_words(name, letters, lines):
    assert wrap_name(name, letters).split("\n") == lines


def test_names_of_groups_stand_beside_each_other_below_an_estimation_plot(strides):
    table = figures.build_estimation_table(strides, "duty_factor")
    figure = drawn(figures.plot_estimation(table, label="Duty factor (fraction)"))
    below = figure.axes[1]
    check_apart(below.get_xticklabels())
    check_apart([text for text in below.texts if text.get_text().startswith("less")])
    check_on_paper(figure)
    assert below.get_position().width > 0.5


def test_a_heat_map_has_room_for_its_colours(strides):
    of = dict(zip(strides["animal"], strides["group"], strict=True))
    table = figures.build_measure_heat_map_table(strides, MEASURES, groups=of)
    ax = figures.plot_measure_heat_map(table)
    figure = drawn(ax)
    check_apart(ax.texts)
    check_apart(ax.get_yticklabels())
    check_on_paper(figure)


def test_a_legend_covers_none_of_many_animals(strides):
    of = dict(zip(strides["animal"], strides["group"], strict=True))
    table = figures.build_measure_components_table(strides, MEASURES, groups=of)
    ax = figures.plot_measure_components(table)
    figure = drawn(ax)
    assert ax.get_legend() is None
    (legend,) = figure.legends
    check_apart(legend.get_texts())
    assert not legend.get_window_extent().overlaps(ax.get_window_extent())


@pytest.mark.slow
def test_curves_of_groups_with_long_names(strides):
    percent = np.arange(0.0, 101.0, 5.0)
    rows = [
        pd.DataFrame({"animal": one.animal, "trial": "t", "group": one.group, "leg": leg,
                      "stride": 1, "signal": "leg angle", "unit": "deg", "percent": percent,
                      "value": one.speed * np.sin(percent / 16.0)})
        for one in strides.itertuples() for leg in ("FL", "FR")
    ]  # fmt: skip
    table = figures.build_cycle_comparison_table(pd.concat(rows, ignore_index=True))
    figure = drawn(figures.plot_cycle_comparison(table))
    check_on_paper(figure)
    check_apart([text for ax in figure.axes for text in ax.texts])
    (legend,) = figure.legends
    panels = [ax.get_tightbbox() for ax in figure.axes]
    assert not any(legend.get_window_extent().overlaps(box) for box in panels)
