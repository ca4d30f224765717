"""Phase histograms: counts by hand, the mean that is meant, intervals that wrap."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_phase_histogram_table, plot_phase_histogram

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def phases(values, leg="FL", reference="FR", animals=None, trials="t"):
    return pd.DataFrame(
        {
            "animal": animals or ["m"] * len(values),
            "trial": trials,
            "leg": leg,
            "reference": reference,
            "stride": np.arange(1, len(values) + 1),
            "phase": values,
        }
    )


def summary(mean=0.98, low=0.9, high=0.05):
    return pd.DataFrame(
        [
            {
                "leg": "FL",
                "reference": "FR",
                "mean": mean,
                "r": 0.9,
                "ci_low": low,
                "ci_high": high,
                "pattern": "in-phase",
            }
        ]
    )


VALUES = [0.0, 0.26, 0.3, 0.49, 0.5, 0.99]


def test_counts_by_hand_and_the_mean_of_one_animal():
    table = build_phase_histogram_table(phases(VALUES), bins=4)
    assert table["count"].tolist() == [1, 3, 1, 1]
    assert table["bin_start"].tolist() == [0.0, 0.25, 0.5, 0.75]
    vector = np.exp(2j * np.pi * np.array(VALUES)).mean()
    np.testing.assert_allclose(table["mean"], np.angle(vector) / 2 / np.pi % 1)
    assert set(table["basis"]) == {"strides"}
    assert table[["ci_low", "pattern"]].isna().all(axis=None)


def test_the_mean_of_several_animals_is_that_of_the_summary():
    table = build_phase_histogram_table(phases(VALUES, animals=list("aabbbb")), summary=summary())
    first = table.iloc[0]
    assert (first["mean"], first["ci_low"], first["ci_high"]) == (0.98, 0.9, 0.05)
    assert (first["basis"], first["n"], first["n_animals"]) == ("animals", 6, 2)


def test_bars_line_and_an_interval_that_wraps():
    made = build_phase_histogram_table(phases(VALUES, animals=list("aabbbb")), summary=summary())
    ax = plot_phase_histogram(made)
    heights = [bar.get_height() for bar in ax.patches if bar.get_width() < 0.1]
    assert heights == made["count"].tolist()
    zone = next(bar for bar in ax.patches if bar.get_width() > 0.1)
    assert (zone.get_x(), zone.get_width()) == pytest.approx((0.4, 0.2))
    mean, *pieces = ax.lines
    assert set(mean.get_xdata()) == {0.98}
    assert mean.get_linestyle() == "--"
    assert [list(piece.get_xdata()) for piece in pieces] == [[0.9, 1.0], [0.0, 0.05]]
    assert ax.get_title() == "FL to FR"
    assert ax.texts[0].get_text() == "0.98 [0.90, 0.05] in-phase\n6 strides, 2 animals"
    legend = [t.get_text() for t in ax.figure.legends[0].get_texts()]
    assert legend == ["anti-phase", "mean over animals", "95 % interval over animals"]


def test_a_mean_just_below_one_is_written_as_zero():
    ax = plot_phase_histogram(build_phase_histogram_table(phases([0.998])))
    assert ax.texts[0].get_text().startswith("0.00\n1 stride")


def test_pairs_are_chosen_and_each_has_a_panel():
    both = pd.concat([phases(VALUES), phases([0.1], "HL", "HR"), phases([0.2], "FR", "HR")])
    table = build_phase_histogram_table(both, pairs=[("FR", "HR"), ("FL", "FR")])
    axes = plot_phase_histogram(table).figure.axes
    assert [ax.get_title() for ax in axes] == ["FR to HR", "FL to FR"]
    assert [ax.get_title(loc="left") for ax in axes] == ["a", "b"]
    assert [ax.get_ylabel() for ax in axes] == ["Strides", ""]


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"^phase histogram: no phases; expected"):
        build_phase_histogram_table(phases([]))
    with pytest.raises(InputError, match=r"^bins is 3; expected 4 or more"):
        build_phase_histogram_table(phases([0.2]), bins=3)
    with pytest.raises(InputError, match=r"give phases in cycles"):
        build_phase_histogram_table(phases([1.0]))
    with pytest.raises(InputError, match=r"no phase of L1 to L2; there are FL to FR"):
        build_phase_histogram_table(phases([0.2]), pairs=[("L1", "L2")])
    with pytest.raises(InputError, match=r"has 0 rows of FL to FR; expected one"):
        build_phase_histogram_table(phases([0.1, 0.2], animals=["a", "b"]),
                                    summary=summary().iloc[:0])  # fmt: skip
