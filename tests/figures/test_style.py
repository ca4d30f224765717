"""Style: a context without side effects, files that are equal and carry their fonts."""

from __future__ import annotations

import io

import matplotlib as mpl
import matplotlib.pyplot as plt
import pandas as pd
import pytest

from pawnb.figures import build_gait_diagram_table, plot_gait_diagram, style
from pawnb.figures.style import OKABE_ITO, colour_legs, size_mm

mpl.use("Agg")


@pytest.fixture(autouse=True)
def _close():
    yield
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
    assert all(t.get_size() >= 7.0 for t in ax.texts)


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
