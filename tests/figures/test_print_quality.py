"""Every figure at print size: letters of 6 pt and more, units on the axes, nothing cut off."""

from __future__ import annotations

import re

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest
from walking import Walk

from pawnb import figures
from pawnb.errors import InputError
from pawnb.gait import analyse, pool
from pawnb.trial import Animal, Trial
from pawnb.workflow.gait.drawing.drawings import gait_drawings
from pawnb.workflow.gait.drawing.overview_drawings import overview_drawings

pytestmark = pytest.mark.slow

mpl.use("Agg")

NO_UNIT = {"", "Frame", "Strides", "Animal", "Foot in stance"}
"""Names of axes that count or name things."""


@pytest.fixture(scope="module")
def tables():
    """Five mice, two trials each, at speeds and rhythms of their own."""
    parts = []
    for k in range(5):
        for t in range(2):
            speed = 150.0 + 50.0 * k + 80.0 * t
            lags = {"FR": 0.0, "HR": 0.5 + 0.02 * k, "FL": 0.5 - 0.01 * k, "HL": 0.02 * t}
            walk = Walk(speed=speed, period=0.4 - 0.0005 * speed, phases=lags)
            trial = Trial(kind="tracks", name=f"t{t}", fps=250.0, animal=Animal(id=f"mouse{k}"),
                          belt_speed=speed, tracks_file="x.nc")  # fmt: skip
            parts.append(analyse(walk.tracks(duration=1.5, noise=0.2, seed=k), trial=trial))
    return pool(parts)


def every_drawing(tables):
    """Return the figures of an analysis, with reference lines, and those of two groups."""
    groups = {(f"mouse{k}", f"t{t}"): "ab"[k % 2] for k in range(5) for t in range(2)}
    references = {
        "duty_factor": (0.75, "unstable below (McGhee 1968)"),
        "frequency_hz": (7.3, "trot-gallop\n(Heglund 1974)"),
        "speed": (500.0, "trot-gallop\n(Heglund 1974)"),
    }
    own = gait_drawings(tables, references=references)
    return [*own, *overview_drawings(tables, groups=groups)]


def letters(figure):
    """Return every text that is seen."""
    return [t for t in figure.findobj(mpl.text.Text) if t.get_visible() and t.get_text().strip()]


KINDS = (
    "gait_diagram", "stepping_pattern", "phase_rose", "phase_histogram", "phase_speed",
    "hildebrand_diagram", "support_shares", "pattern_distances", "stride_average", "phase_plane",
    "aligned_acceleration", "regression", "summary_page", "phase_density", "measure_heat_map",
    "measure_components", "cycle_comparison",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_figures_can_be_read_in_print(tables, kind):
    drawing = next(one for one in every_drawing(tables) if one.kind == kind)
    try:
        with figures.style():
            _, ax = drawing.draw()
            figure = ax.get_figure(root=True)
            figure.draw_without_rendering()
            check_letters(figure)
            check_units(figure)
            check_width(figure, kind)
    finally:
        plt.close("all")


def check_letters(figure):
    """No text is below 6 pt or reaches beyond the paper."""
    paper, gone = figure.bbox, undrawn(figure)
    for text in letters(figure):
        assert text.get_fontsize() >= 6.0, text.get_text()
        box = text.get_window_extent()
        # a pixel is 0.17 mm here
        inside = (
            box.x0 >= paper.x0 - 2 and box.x1 <= paper.x1 + 2
            and box.y0 >= paper.y0 - 2 and box.y1 <= paper.y1 + 2
        )  # fmt: skip
        assert inside or id(text) in gone, (text.get_text(), box.extents, paper.extents)


def undrawn(figure):
    """Return the labels of ticks beyond the limits of their axis: they are not drawn."""
    found = []
    for ax in figure.findobj(plt.Axes):
        for axis in ax._axis_map.values():
            low, high = sorted(axis.get_view_interval())
            ticks = [*axis.majorTicks, *axis.minorTicks]
            away = [t for t in ticks if not low <= t.get_loc() <= high]
            found += [label for t in away for label in (t.label1, t.label2)]
    return {id(label) for label in found}


def check_units(figure):
    """Every named axis has its unit in brackets, or counts something."""
    for ax in figure.findobj(plt.Axes):
        if ax.name == "polar":
            continue  # the rose writes its numbers in words
        for name in (ax.get_xlabel(), ax.get_ylabel()):
            scale = re.fullmatch(r"[\d.]+ s", name)
            assert name in NO_UNIT or scale or re.search(r"\(.+\)", name), name


def check_width(figure, kind):
    """One column, two columns, or a page."""
    width = figure.get_size_inches()[0] * 25.4
    allowed = (210.0,) if kind == "summary_page" else (85.0, 170.0)
    assert any(width == pytest.approx(one) for one in allowed)


def test_every_kind_of_figure_was_looked_at(tables):
    assert {one.kind for one in every_drawing(tables)} == set(KINDS)


def test_a_figure_that_cannot_be_drawn_says_so(tables):
    without = pool([tables])
    object.__setattr__(without, "strides", without.strides.assign(speed=float("nan")))
    speed = next(one for one in gait_drawings(without) if one.kind == "phase_speed")
    with pytest.raises(InputError, match="no stride has a speed"):
        speed.draw()
