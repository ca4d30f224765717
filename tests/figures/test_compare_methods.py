"""Comparison of methods: means and SDs by hand, and bars of that height."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_compare_methods_table, plot_compare_methods

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def trials(corrected=True):
    rows = [("a", "slic-3d", 10.0, 4.0), ("b", "slic-3d", 14.0, 2.0), ("a", "paper", 3.0, 5.0)]
    table = pd.DataFrame(rows, columns=["trial", "method", "major_per_1000", "minor_per_1000"])
    table["time_s_per_1000"] = 60.0
    for name in ("major", "minor"):
        table[f"{name}_alone_per_1000"] = table[f"{name}_per_1000"] + 1.0
        if not corrected:
            table[f"{name}_per_1000"] = np.nan
    return table


REPROJECTION = pd.DataFrame(
    [
        ("a", "paper", "cam1", "FR", "front", 10, 2.0),
        ("a", "paper", "cam1", "FL", "front", 30, 4.0),
        ("a", "paper", "cam1", "HR", "hind", 10, 1.0),
    ],
    columns=["trial", "method", "view", "point", "kind", "n", "mean_px"],
)


def test_means_and_sds_by_hand():
    table = build_compare_methods_table(trials(), REPROJECTION)
    major = table[(table["panel"] == "major") & (table["method"] == "slic-3d")]
    assert major["value"].tolist() == [10.0, 14.0]
    assert (major["mean"] == 12.0).all()
    np.testing.assert_allclose(major["sd"], np.sqrt(8.0))
    assert (major["n"] == 2).all()
    # frames count: (10 x 2 + 30 x 4) / 40
    front = table[(table["panel"] == "reprojection") & (table["kind"] == "front")]
    assert front["value"].tolist() == [3.5]
    assert np.isnan(front["sd"]).all()


def test_without_corrections_those_alone_are_shown():
    table = build_compare_methods_table(trials(corrected=False), REPROJECTION)
    assert table.loc[table["panel"] == "major", "value"].tolist() == [11.0, 15.0, 4.0]


@pytest.mark.parametrize(
    ("corrected", "word", "label"),
    [
        (True, "made", "Major errors\nper 1000 frames"),
        (False, "none", "Major errors\nper 1000 frames,\nno corrections made"),
    ],
)
def test_figure_and_table_say_whether_corrections_were_made(corrected, word, label):
    table = build_compare_methods_table(trials(corrected=corrected), REPROJECTION)
    errors = table["panel"].isin(["major", "minor"])
    assert set(table.loc[errors, "corrections"]) == {word}
    assert set(table.loc[~errors, "corrections"]) == {""}
    axes = plot_compare_methods(table).figure.axes
    assert axes[0].get_ylabel() == label
    assert "corrections" not in axes[2].get_ylabel()


def test_bars_are_the_means_and_dots_the_trials():
    ax = plot_compare_methods(build_compare_methods_table(trials(), REPROJECTION))
    axes = ax.figure.axes
    assert [round(bar.get_height(), 6) for bar in axes[0].patches] == [12.0, 3.0]
    assert [round(bar.get_height(), 6) for bar in axes[3].patches] == [3.5, 1.0]
    dots = [line.get_ydata().tolist() for line in axes[0].lines if line.get_marker() == "o"]
    assert dots == [[10.0, 14.0], [3.0]]
    assert [t.get_text() for t in axes[3].get_xticklabels()] == ["cam1 front", "cam1 hind"]
    legend = [t.get_text() for t in ax.figure.legends[0].get_texts()]
    assert legend == ["slic-3d (2 trials)", "paper (1 trial)"]


def test_nothing_to_draw_is_refused():
    with pytest.raises(InputError, match="no trials"):
        build_compare_methods_table(trials().iloc[:0], REPROJECTION)
    with pytest.raises(InputError, match="column 'kind' is missing"):
        build_compare_methods_table(trials(), REPROJECTION.drop(columns="kind"))
    table = build_compare_methods_table(trials(), REPROJECTION)
    with pytest.raises(InputError, match="the table is empty"):
        plot_compare_methods(table.iloc[:0])
