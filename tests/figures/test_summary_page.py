"""Summary page: the table by hand, A4, and a word where something cannot be shown."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_summary_page_table, plot_summary_page
from pawnb.gait import analyse_events

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def tables(legs=("L1", "R1")):
    events = pd.DataFrame(
        [
            {"animal": "a", "trial": "t", "leg": leg, "event": event,
             "time_s": (0.2 + 0.01 * (k > 2)) * k + late + 0.1 * leg.startswith("R")}
            for leg in legs
            for k in range(6)
            for event, late in (("TD", 0.0), ("LO", 0.12))
        ]
    )  # fmt: skip
    return analyse_events(events)


def page(made):
    return plot_summary_page(
        build_summary_page_table(made.strides, animal="a"), events=made.events,
        strides=made.strides, phases=made.phases, unit="mm",
    )  # fmt: skip


def test_table_by_hand():
    table = build_summary_page_table(tables().strides, animal="a")
    # landings at 0, 0.2, 0.4, 0.63, 0.84, 1.05 s: periods 0.2, 0.2, 0.23, 0.21, 0.21
    frequency = 1.0 / np.array([0.2, 0.2, 0.23, 0.21, 0.21])
    np.testing.assert_allclose(table["frequency_hz_mean"], frequency.mean())
    np.testing.assert_allclose(table["frequency_hz_sd"], frequency.std(ddof=1))
    np.testing.assert_allclose(table["stance_s_mean"], 0.12)
    assert table["leg"].tolist() == ["L1", "R1"]
    assert (table["n_strides"] == 5).all()
    assert table["speed_mean"].isna().all()


def texts(figure):
    return [t.get_text() for t in figure.findobj(mpl.text.Text) if t.get_text()]


def test_the_page_is_a4_and_says_what_it_lacks():
    figure = page(tables()).get_figure(root=True)
    np.testing.assert_allclose(figure.get_size_inches() * 25.4, (210.0, 297.0))
    words = texts(figure)
    assert "Animal a: 10 strides of 2 legs in 1 trial" in words
    assert "no speeds: they need tracks, or a belt speed" in words
    assert "L1 relative to R1" in words
    assert "4.77 (0.27)" in words  # mean and SD of the frequencies above
    alone = texts(page(tables(("L1",))).get_figure(root=True))
    assert "no phases: fewer than two legs with strides at the same time" in alone


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"^summary page: no strides of animal 'x'"):
        build_summary_page_table(tables().strides, animal="x")
