"""Style: a context without side effects, files that are equal and carry their fonts."""

from __future__ import annotations

import io

import matplotlib as mpl
import matplotlib.pyplot as plt
import pandas as pd
import pytest

from pawnb.errors import InputError
from pawnb.figures import build_gait_diagram_table, get_style, plot_gait_diagram, set_style, style
from pawnb.figures.style import OKABE_ITO, StyleOptions, colour_legs, mark_animals, size_mm

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
    set_style()
    plt.close("all")


def draw():
    rows = [("FR", "AEP", 0.1), ("FR", "PEP", 0.4), ("HL", "AEP", 0.2), ("HL", "PEP", 0.5)]
    return plot_gait_diagram(
        build_gait_diagram_table(pd.DataFrame(rows, columns=["leg", "event", "time_s"]))
    )


def test_nothing_stays_changed():
    with mpl.rc_context():
        mpl.rcdefaults()
        before = mpl.rcParams.copy()
        with style():
            assert mpl.rcParams["pdf.fonttype"] == 42
        draw()
        assert mpl.rcParams == before


def test_text_has_its_size():
    ax = draw()
    assert ax.xaxis.label.get_size() == 8.0
    assert {t.get_size() for t in ax.get_xticklabels()} == {7.0}
    assert all(t.get_size() >= 6.0 for t in ax.texts)


@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_equal_figures_give_equal_bytes(kind):
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}[kind]
    files = []
    for _ in range(2):
        with style():
            file = io.BytesIO()
            draw().figure.savefig(file, format=kind, metadata=metadata)
            files.append(file.getvalue())
    assert files[0] == files[1]
    if kind == "pdf":
        assert b"/Subtype /Type0" in files[0] or b"/CIDFontType2" in files[0]
        assert b"/Type3" not in files[0]


def test_legs_have_colours_of_okabe_and_ito():
    mouse = colour_legs(["FR", "HR", "FL", "HL"])
    assert len(set(mouse.values())) == 4
    spider = colour_legs([f"{s}{k}" for s in "LR" for k in range(1, 5)])
    assert len(set(spider.values())) == 4
    assert spider["L2"] == spider["R2"]
    assert set(mouse.values()) | set(spider.values()) <= set(OKABE_ITO.values())
    assert len(set(colour_legs(["a", "b", "c"]).values())) == 3


def test_sizes_are_in_mm():
    assert size_mm(25.4, 50.8) == (1.0, 2.0)


def test_interactive_mode_that_a_backend_turns_on_outlives_the_style():
    # notebooks show a figure at the end of its cell only in interactive mode
    before = mpl.is_interactive()
    try:
        mpl.interactive(False)
        with style():
            mpl.interactive(True)
        assert mpl.is_interactive()
    finally:
        mpl.interactive(before)


def test_a_style_is_set_once_and_every_figure_follows():
    set_style(font_size_pt=9, column_mm=120, leg_colours={"FR": "#123456"})
    ax = draw()
    assert ax.xaxis.label.get_size() == 10.0
    assert {t.get_size() for t in ax.get_xticklabels()} == {9.0}
    assert ax.figure.get_size_inches()[0] * 25.4 == pytest.approx(120.0)
    assert mpl.colors.to_hex(ax.patches[0].get_facecolor()) == "#123456"
    # the leg that was not named keeps its colour
    assert mpl.colors.to_hex(ax.patches[1].get_facecolor()).upper() == OKABE_ITO["orange"]
    assert set_style(dpi=600).font_size_pt == 9
    assert set_style() == StyleOptions()
    assert draw().figure.get_size_inches()[0] * 25.4 == pytest.approx(85.0)


def test_options_of_a_block_end_with_it():
    with style(font_size_pt=8):
        assert get_style().font_size_pt == 8
        with style():
            assert mpl.rcParams["font.size"] == 8
    assert get_style() == StyleOptions()
    with pytest.raises(ZeroDivisionError), style(font_size_pt=8):
        _ = 1 / 0
    assert get_style() == StyleOptions()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"font_size_pt": 5}, r"^font_size_pt is 5; text below 6 pt cannot be read in print"),
        ({"column_mm": 0}, r"^column_mm is 0; expected more than 0\.$"),
        ({"leg_colours": {"FR": "reddy"}}, r"^leg_colours: 'reddy' of leg FR is no colour"),
        ({"font": "No Such Font"}, r"^font 'No Such Font' is not installed"),
        ({"fontsize": 7}, r"^style: no option 'fontsize'.*there are font_size_pt, font,"),
    ],
)
def test_options_that_cannot_be_printed_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        set_style(**options)
    assert get_style() == StyleOptions()


def test_every_animal_has_its_own_mark():
    marks = mark_animals([f"m{i:02d}" for i in range(24)] * 2)
    assert len(marks) == 24 == len(set(marks.values()))
    assert marks["m00"] == ("o", True)
    assert marks["m12"] == ("o", False)


def test_svg_keeps_its_text():
    with style():
        file = io.BytesIO()
        draw().figure.savefig(file, format="svg")
    assert b">Time (s)</text>" in file.getvalue()
