"""Feet on the ground and distances to ideal gaits: drawn is what the tables say."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import plot_pattern_distances, plot_support_shares

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


SHARES = pd.DataFrame(
    [("a", 2, 0.5), ("a", 3, 0.45), ("a", 4, 0.05), ("b", 2, 1.0)],
    columns=["animal", "n_down", "share"],
)
DISTANCES = pd.DataFrame(
    [("a", "pace", 0.3), ("a", "trot", 0.05), ("b", "trot", 0.08), ("b", "pace", 0.4)],
    columns=["animal", "pattern", "distance"],
)


def test_bars_are_the_shares():
    ax = plot_support_shares(SHARES)
    spans = [(bar.get_y() + bar.get_height() / 2, bar.get_x(), bar.get_width())
             for bar in ax.patches]  # fmt: skip
    expected = [(0, 0, 50), (0, 50, 45), (0, 95, 5), (1, 0, 100)]
    np.testing.assert_allclose(spans, expected)
    # a narrow stretch has no number; the colours below name it
    assert [t.get_text() for t in ax.texts] == ["2", "3", "2"]
    assert [t.get_text() for t in ax.figure.legends[0].get_texts()] == ["2", "3", "4"]
    assert ax.get_xlabel() == "Time (%)"


def test_dots_are_the_distances_and_the_nearest_pattern_is_on_top():
    ax = plot_pattern_distances(DISTANCES)
    assert [t.get_text() for t in ax.get_yticklabels()] == ["trot", "pace"]
    points = [line for line in ax.lines if line.get_linestyle() == "None"]
    assert [p.get_xdata().tolist() for p in points] == [[0.3, 0.05], [0.08, 0.4]]
    rows = [np.round(p.get_ydata()).tolist() for p in points]
    assert rows == [[1, 0], [0, 1]]
    # differences anywhere from -0.5 to 0.5 cycle have variance 1/12
    chance = next(line for line in ax.lines if line.get_linestyle() == "--")
    assert chance.get_xdata() == pytest.approx([12**-0.5] * 2)
    assert "cycles" in ax.get_xlabel()


def test_empty_tables_are_refused():
    with pytest.raises(InputError, match=r"^feet on the ground: the table is empty"):
        plot_support_shares(SHARES.iloc[:0])
    with pytest.raises(InputError, match=r"^distances to ideal gaits: the table is empty"):
        plot_pattern_distances(DISTANCES.iloc[:0])


@pytest.mark.slow
def test_long_names_leave_room_for_the_bars_and_many_animals_fit_on_a_page():
    # names of recordings took nine tenths of the width
    long = SHARES.replace({"animal": {"a": "Carcinus_maenas_trial_0_long_name_of_a_recording"}})
    ax = plot_support_shares(long)
    ax.figure.canvas.draw()
    assert ax.get_position().width > 0.5
    many = pd.concat([SHARES.assign(animal=f"mouse{i:02d}") for i in range(60)])
    assert plot_support_shares(many).figure.get_size_inches()[1] * 25.4 < 247.0
