"""Panels: how many, how wide, lettered; notes that can be read; legs that share a panel."""

from __future__ import annotations

import inspect
import warnings

import matplotlib as mpl
import matplotlib.pyplot as plt
import pandas as pd
import pytest

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.panels import (
    add_animal_legend,
    add_heading,
    add_letter,
    add_note,
    group_legs,
    make_panels,
    new_axes,
    say_phase,
)
from pawnb.figures.style import figure_size, mark_animals, style

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


@pytest.mark.slow
@pytest.mark.parametrize(("n", "width_mm"), [(1, 85.0), (4, 85.0), (5, 170.0), (7, 170.0)])
def test_panels_fill_one_or_two_columns(n, width_mm):
    with style():
        panels = make_panels(n, where="test")
    figure = panels[0].figure
    assert len(panels) == n == len(figure.axes)
    assert figure.get_size_inches()[0] * 25.4 == pytest.approx(width_mm)
    letters = [panel.get_title(loc="left") for panel in panels]
    assert letters == ([""] if n == 1 else list("abcdefg"[:n]))


def test_letters_go_on_after_z():
    ax = plt.subplot()
    add_letter(ax, 27)
    assert ax.get_title(loc="left") == "ab"


def test_notes_can_be_read():
    with style():
        ax = plt.subplot()
        add_note(ax, "note")
        assert ax.texts[0].get_fontsize() == 6.0
    with style(font_size_pt=9):
        add_note(ax, "note")
    assert ax.texts[1].get_fontsize() == 8.0


def test_one_animal_or_too_many_have_no_legend():
    ax = plt.subplot()
    add_animal_legend(ax, mark_animals(["a"]))
    add_animal_legend(ax, mark_animals(map(str, range(13))))
    assert ax.figure.legends == []
    with style():
        ax = plt.figure(layout="constrained").add_subplot()
        add_animal_legend(ax, mark_animals(["b", "a"]))
    assert [t.get_text() for t in ax.figure.legends[0].get_texts()] == ["a", "b"]


def test_left_and_right_share_a_panel():
    assert group_legs(["R2", "L1", "R1"]) == [("Legs 1", ["L1", "R1"]), ("Legs 2", ["R2"])]
    assert group_legs(["HL", "FR", "FL"]) == [("Fore legs", ["FL", "FR"]), ("Hind legs", ["HL"])]
    assert group_legs(["paw"]) == [("paw", ["paw"])]


def test_phases_are_never_written_as_one():
    assert [say_phase(p) for p in (0.996, 0.994, 0.0)] == ["0.00", "0.99", "0.00"]


def test_nothing_or_too_much_is_refused():
    with pytest.raises(InputError, match=r"^test: the table is empty\.$"):
        make_panels(0, where="test")
    with pytest.raises(InputError, match=r"^test: 2 panels for one axes; choose one of them"):
        make_panels(2, where="test", ax=plt.subplot())


@pytest.mark.parametrize("kind", ["compare_methods", "estimation", "paths_3d", "template_fit"])
def test_figures_of_unlike_panels_take_the_place_they_are_given(kind):
    import test_same_bytes as made

    if kind == "estimation":
        rows = [(f"{g}{k}", g, 0.5 + 0.1 * k) for g in "ab" for k in range(3)]
        strides = pd.DataFrame(rows, columns=["animal", "group", "duty_factor"])
        table = figures.build_estimation_table(strides, "duty_factor")
    else:
        table = made.OTHERS[kind](None)
    figure, (own, place) = plt.subplots(1, 2, layout="constrained")
    drawn = getattr(figures, f"plot_{kind}")(table, ax=place)
    assert drawn.figure is figure
    assert own in figure.axes
    assert place not in figure.axes
    figure.draw_without_rendering()
    # the panels lie in the right half, where the axes were
    assert all(ax.get_position().x0 > 0.4 for ax in figure.axes if ax is not own)
    loose = plt.figure().add_axes((0.1, 0.1, 0.8, 0.8))
    with pytest.raises(InputError, match=r"these have none; make them with plt\.subplots"):
        getattr(figures, f"plot_{kind}")(table, ax=loose)
    plt.close("all")


def test_every_figure_of_a_table_takes_axes():
    # the summary page is a whole page of subfigures and takes none
    plots = [name for name in figures.__all__ if name.startswith("plot_")]
    without = [n for n in plots if "ax" not in inspect.signature(getattr(figures, n)).parameters]
    assert without == ["plot_summary_page"]


def test_long_names_of_animals_take_no_place_from_the_panel():
    heights = []
    for names in ("ab", [f"PCCD3_Mouse{k}_25mm_run3-6" for k in range(14, 24)]):
        with style(), warnings.catch_warnings():
            warnings.simplefilter("error")  # of a layout that is given up
            figure, ax = new_axes(figsize=figure_size(1, 40.0))
            ax.set_xlabel("Speed (px/s)")
            add_heading(ax, "FR to HR", "slope 0.1 [0, 1]\np 0.9, 5 animals")
            add_animal_legend(ax, mark_animals(names))
            figure.draw_without_rendering()
            heights.append(ax.get_window_extent().height)
    assert heights[1] > 0.8 * heights[0]
