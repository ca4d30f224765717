"""Plots on dark and on light pages: greys change sides, colours of legs stay."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from pawnb.figures.style import colour_legs
from pawnb.widgets.plot_theme import INK, PAPER, fit_figure, set_theme, shortened

LEGS = colour_legs([f"{side}{rank}" for side in "LR" for rank in range(1, 5)])


def luminance(colour):
    """Relative luminance as WCAG 2.1 defines it."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(first, second):
    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.fixture
def drawn():
    figure = Figure(figsize=(4, 3))
    FigureCanvasAgg(figure)
    ax = figure.add_subplot()

    def draw():
        ax.clear()
        for k, colour in enumerate(LEGS.values()):
            ax.barh(k, 1.0, color=colour)
        ax.plot([0, 1], [0, 7], color="0.3", label="grey")
        ax.plot([0.5], [3], "o", color="white", markeredgecolor="black")
        ax.annotate("", (0, 0), (1, 1), arrowprops={"arrowstyle": "-|>", "color": "black"})
        ax.set_xlabel("Time (s)")
        ax.legend()

    draw()
    return figure, ax, draw


def test_text_and_axes_can_be_read_and_legs_keep_their_colours(drawn):
    figure, ax, _ = drawn
    set_theme(figure, dark=True)
    set_theme(figure, dark=True)  # what was done stays done
    figure.canvas.draw()
    assert to_hex(figure.get_facecolor()) == to_hex(ax.get_facecolor()) == PAPER
    texts = [ax.xaxis.label, *ax.get_xticklabels(), *ax.get_legend().get_texts()]
    frame = [spine.get_edgecolor() for spine in ax.spines.values()]
    ticks = [tick.tick1line.get_color() for tick in ax.xaxis.get_major_ticks()]
    # WCAG 2.1: 4.5 for text, 3 for graphics
    assert min(contrast(text.get_color(), PAPER) for text in texts) > 4.5
    grey, ring = ax.lines
    others = [grey.get_color(), ring.get_markeredgecolor(), *frame, *ticks]
    others.append(ax.texts[0].arrow_patch.get_edgecolor())
    assert min(contrast(colour, PAPER) for colour in others) > 3
    assert to_hex(ring.get_markerfacecolor()) == PAPER
    for bar, colour in zip(ax.patches, LEGS.values(), strict=True):
        assert to_hex(bar.get_facecolor()) == colour.lower()
        seen = contrast(colour, PAPER) > 2 or to_hex(bar.get_edgecolor()) == INK
        assert seen


def test_a_light_page_looks_as_if_it_had_never_been_dark(drawn):
    figure, _, draw = drawn
    figure.canvas.draw()
    light = np.asarray(figure.canvas.buffer_rgba()).copy()
    for _ in range(2):
        set_theme(figure, dark=True)
        figure.canvas.draw()
        dark = np.asarray(figure.canvas.buffer_rgba())
        assert dark[..., :3].mean() < 0.6 * light[..., :3].mean()
        draw()
        set_theme(figure, dark=False)
        figure.canvas.draw()
        np.testing.assert_array_equal(np.asarray(figure.canvas.buffer_rgba()), light)


@pytest.mark.parametrize(
    ("room", "size"),
    [
        ((1488, 1200), (1476, 640)),  # all of it fits: the cell is filled
        ((932, 768), (920, 438)),  # 1366 x 768 with the file browser open
        ((300, 400), (420, 300)),  # no smaller: the page scrolls
    ],
)
def test_plots_are_as_large_as_the_page_has_room(drawn, room, size):
    figure, _, _ = drawn
    fit_figure(figure, room=room, highest_px=640, beside_px=330)
    assert tuple(np.round(figure.get_size_inches() * mpl.rcParams["figure.dpi"])) == size


def test_long_names_keep_both_ends():
    assert [shortened(name, 8) for name in ("R2", "12345678", "hindpaw_left", "hindpaw_right")] == [
        "R2", "12345678", "hind…eft", "hind…ght",
    ]  # fmt: skip
    assert len(shortened("a" * 300, 8)) == 8
