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


def tables(legs=("L1", "R1"), n=6):
    events = pd.DataFrame(
        [
            {"animal": "a", "trial": "t", "leg": leg, "event": event,
             "time_s": (0.2 + 0.01 * (k > 2)) * k + late + 0.1 * leg.startswith("R")}
            for leg in legs
            for k in range(n)
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


def test_what_is_not_known_is_hatched_on_the_page():
    made = tables()
    # L1 is in the air from 0.52 to 0.63 s
    gone = pd.DataFrame(
        [("a", "t", "L1", 0.55, 0.6, "pause")],
        columns=["animal", "trial", "leg", "start_s", "end_s", "what"],
    )
    table = build_summary_page_table(made.strides, animal="a")
    ax = plot_summary_page(
        table, events=made.events, strides=made.strides, phases=made.phases, dropped=gone
    )
    hatched = [bar for bar in ax.patches if bar.get_hatch()]
    assert [(bar.get_x(), bar.get_width()) for bar in hatched] == [pytest.approx((0.52, 0.11))]


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


def test_stances_that_the_stretch_cuts_are_pale():
    """The line above the diagram says that pale ones go on beyond what is shown."""
    ax = page(tables(n=40))
    low, high = ax.get_xlim()
    bars = [(bar.get_x(), bar.get_x() + bar.get_width(), bar.get_alpha()) for bar in ax.patches]
    bars = [bar for bar in bars if bar[1] > bar[0]]
    assert all(low - 1e-9 <= start and end <= high + 1e-9 for start, end, _ in bars)
    lasts_s = 0.12  # from TD to LO, as the events say
    for start, end, alpha in bars:
        assert (alpha < 1) == (end - start < lasts_s - 1e-6)
    assert {alpha < 1 for _, _, alpha in bars} == {False, True}


def test_bad_input_is_refused():
    with pytest.raises(InputError, match=r"^summary page: no strides of animal 'x'"):
        build_summary_page_table(tables().strides, animal="x")


@pytest.mark.slow
def test_every_note_stands_below_on_a_page_as_long_as_they_need():
    made = tables()
    table = build_summary_page_table(made.strides, animal="a")
    few = ["one thing to know.", "costs $1 and $2"]
    more = [f"note {i} " + "with many words " * 14 + f"end {i}" for i in range(12)]
    for notes, last in ((few, few[-1]), (more, "end 11")):
        ax = plot_summary_page(
            table, events=made.events, strides=made.strides, phases=made.phases, notes=notes
        )
        page_figure = ax.get_figure(root=True)
        shown = texts(page_figure)
        assert "e  Notes" in shown
        words = next(t for t in shown if t.startswith(f"- {notes[0][:6]}"))
        assert words.splitlines()[-1].endswith(last)
        assert words.count("\n- ") + 1 == len(notes)
        # the rest of the page keeps its size: 2 x 12 lines, of which nine find room on A4
        grown = page_figure.get_size_inches()[1] * 25.4 - 297.0
        assert grown == 0.0 if notes is few else 15 * 3.0 < grown < 15 * 5.0
        page_figure.draw_without_rendering()
        box = next(t for t in page_figure.findobj(mpl.text.Text) if t.get_text() == words)
        inside = box.get_window_extent()
        page_box = page_figure.bbox
        assert inside.x1 <= page_box.x1
        assert inside.y0 >= page_box.y0
    plain = page(made)
    assert "e  Notes" not in texts(plain.get_figure(root=True))


def test_a_spread_of_rounding_takes_no_room():
    made = tables()
    # five strides a second to the last bits but one: an SD of 1e-15 would need 16 decimals
    strides = made.strides.assign(
        frequency_hz=[5.0 + 1e-15 * (k % 3) for k in range(len(made.strides))]
    )
    ax = plot_summary_page(
        build_summary_page_table(strides, animal="a"), events=made.events, strides=strides,
        phases=made.phases,
    )  # fmt: skip
    assert "5 (0)" in texts(ax.get_figure(root=True))
