"""Hildebrand diagram: means by hand, time on the ground falling to the right."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_hildebrand_diagram_table, plot_hildebrand_diagram

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def tables():
    """Lags of 95 and 5 percent: their mean is 0, not 50."""
    phases, strides = [], []
    for animal, values in (("a", (0.95, 0.05)), ("b", (0.4, 0.6))):
        for k, phase in enumerate(values, start=1):
            key = {"animal": animal, "trial": "t", "stride": k}
            phases.append({**key, "leg": "FL", "reference": "HL", "phase": phase})
            strides.append({**key, "leg": "HL", "duty_factor": 0.5 + 0.1 * k})
    return pd.DataFrame(strides), pd.DataFrame(phases)


def test_means_by_hand():
    table = build_hildebrand_diagram_table(*tables())
    animals = table[table["level"] == "animal"].set_index("animal")
    assert animals.loc["a", "lag_percent"] % 100.0 == pytest.approx(0.0, abs=1e-9) or (
        animals.loc["a", "lag_percent"] == pytest.approx(100.0)
    )
    assert animals.loc["b", "lag_percent"] == pytest.approx(50.0)
    assert animals["duty_percent"].tolist() == pytest.approx([65.0, 65.0])
    assert animals["n"].tolist() == [2, 2]
    assert (table["level"] == "stride").sum() == 4


def test_points_and_names():
    table = build_hildebrand_diagram_table(*tables())
    ax = plot_hildebrand_diagram(table)
    low, high = ax.get_xlim()
    assert low > high
    points = [line for line in ax.lines if line.get_linestyle() == "None"]
    drawn = np.concatenate([p.get_xydata() for p in points])
    expected = table[["duty_percent", "lag_percent"]].to_numpy()
    np.testing.assert_allclose(drawn[np.lexsort(drawn.T)], expected[np.lexsort(expected.T)])
    words = {t.get_text(): t for t in ax.texts}
    assert words["trot"].get_position()[1] == pytest.approx(50.0, abs=2.0)
    assert {"walk", "run", "pace"} <= set(words)
    assert ax.get_xlabel() == "Hind foot on the ground (% of stride)"


def test_bad_input_is_refused():
    strides, phases = tables()
    with pytest.raises(InputError, match=r"^no phase of a fore leg relative to the hind leg"):
        build_hildebrand_diagram_table(strides, phases.assign(reference="FR"))
    with pytest.raises(InputError, match=r"^Hildebrand diagram: the table is empty"):
        plot_hildebrand_diagram(build_hildebrand_diagram_table(strides, phases).iloc[:0])


def test_time_on_the_ground_is_that_of_contact_and_without_it_no_walk_is_named():
    # a galloping horse, on the ground for a quarter of its stride, was a walk at 55 %: AEP to PEP
    strides, phases = tables()
    strides = strides.assign(method="AEP/PEP", contact_duty_factor=[0.25, 0.27, 0.24, np.nan])
    table = build_hildebrand_diagram_table(strides, phases)
    stride = table[table["level"] == "stride"]
    np.testing.assert_allclose(stride["duty_percent"], [25.0, 27.0, 24.0, np.nan])
    assert set(table["told_by"]) == {"contact"}
    assert plot_hildebrand_diagram(table).get_xlabel() == "Hind foot on the ground (% of stride)"
    table = build_hildebrand_diagram_table(strides.assign(contact_duty_factor=np.nan), phases)
    assert set(table["told_by"]) == {"AEP to PEP"}
    ax = plot_hildebrand_diagram(table)
    assert ax.get_xlabel() == "Hind stance, AEP to PEP (% of stride)"
    assert not {"walk", "run"} & {t.get_text() for t in ax.texts}
    scored = build_hildebrand_diagram_table(strides.assign(method="TD/LO"), phases)
    assert scored["duty_percent"].iloc[0] == pytest.approx(60.0)  # its own duty factor


def test_names_of_gaits_stand_at_their_lags_and_walk_on_the_left():
    # Hildebrand 1965: pace 0 and 100, trot 50, lateral sequence 25, diagonal sequence 75 percent;
    # walks have a foot on the ground for more than half of the stride, and are on the left
    ax = plot_hildebrand_diagram(build_hildebrand_diagram_table(*tables()))
    ax.figure.canvas.draw()
    lags = {"lateral sequence, single foot": 25, "trot": 50, "diagonal sequence, single foot": 75}
    words = {text.get_text(): text for text in ax.texts}
    for name, lag in lags.items():
        assert words[name].get_position()[1] == pytest.approx(lag, abs=2.0)
    paces = sorted(text.get_position()[1] for text in ax.texts if text.get_text() == "pace")
    assert paces == pytest.approx([0.0, 100.0], abs=2.0)
    half = ax.transData.transform((50.0, 0.0))[0]
    assert words["walk"].get_window_extent().x1 < half < words["run"].get_window_extent().x0
    left, right = ax.get_window_extent().x0, ax.get_window_extent().x1
    for name in lags:
        assert left < words[name].get_window_extent().x0
        assert words[name].get_window_extent().x1 < right
    assert [set(line.get_xdata()) for line in ax.lines].count({50.0}) == 1
