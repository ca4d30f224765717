"""Style: a context without side effects, files that are equal and carry their fonts."""

from __future__ import annotations

import io
from itertools import combinations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgb

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


@pytest.mark.slow
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


SPIDER = [f"{side}{rank}" for side in "LR" for rank in range(1, 5)]
# how the three kinds of colour blindness see linear RGB: Machado, Oliveira & Fernandes 2009,
# IEEE Trans. Vis. Comput. Graph. 15, 1291-1298, severity 1.0
SEEN_AS = {
    "normal": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                   [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                     [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
                   [0.004733, 0.691367, 0.303900]],
}  # fmt: skip


def lab(colour, kind):
    """CIELAB of a colour as somebody sees it: sRGB, IEC 61966-2-1, white D65."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(SEEN_AS[kind]) @ linear, 0, 1)
    xyz = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                    [0.0193339, 0.1191920, 0.9503041]]) @ seen / [0.95047, 1, 1.08883]  # fmt: skip
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("kind", SEEN_AS)
def test_legs_of_a_spider_differ_for_everybody_and_show_on_white(kind):
    colours = colour_legs(SPIDER)
    assert len(set(colours.values())) == 8
    seen = [lab(colour, kind) for colour in colours.values()]
    # a difference of 2.3 in CIELAB can just be seen; six times as much is told at a glance
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 15
    assert max(place[0] for place in seen) < 80  # white is 100


def test_a_leg_has_one_colour_whichever_others_there_are():
    spider, insect = colour_legs(SPIDER), colour_legs(["LF", "LM", "LH", "RF", "RM", "RH"])
    mouse = colour_legs(["FR", "HR", "FL", "HL"])
    assert colour_legs(["L3"])["L3"] == spider["L3"]
    assert [mouse[leg] for leg in ("FR", "HR", "FL", "HL")] == [
        spider[leg] for leg in ("R1", "R3", "L1", "L3")
    ]
    assert insect["LH"] == spider["L3"]
    # what is picked is yellow
    assert OKABE_ITO["yellow"] not in {*spider.values(), *mouse.values(), *insect.values()}
    many = [f"{side}{rank}" for side in "LR" for rank in range(1, 8)]  # a crayfish, and more
    assert colour_legs(many)["R5"] == spider["R1"]
    assert len(set(colour_legs(list("abcdefgh")).values())) == 8
    assert len(set(colour_legs(["FR", "HR", "a", "b"]).values())) == 4


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


def test_blocks_of_two_threads_leave_matplotlib_as_it_was_in_whichever_order_they_end():
    """An analysis draws in a thread while a notebook draws, too."""
    before = mpl.rcParams.copy()
    first, second = style(font_size_pt=8.0), style(font_size_pt=9.0)
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert get_style().font_size_pt == 9.0
    assert mpl.rcParams["font.size"] == 9.0  # of the block that goes on
    second.__exit__(None, None, None)
    assert mpl.rcParams == before
    assert get_style() == StyleOptions()
