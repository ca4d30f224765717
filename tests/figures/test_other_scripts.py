"""Names in scripts that the font of the figures has no signs for."""

from __future__ import annotations

import re

import pandas as pd
import pytest

from pawnb import figures
from pawnb.errors import InputWarning
from pawnb.figures.other_scripts import set_fonts_of_names, signs_as_boxes, warn_of_boxes

# of the fonts that matplotlib brings along, only STIXGeneral has U+2315
RECORDER = "\u2315"


@pytest.fixture
def diagram():
    """Return a function that draws a gait diagram of a leg of some name."""

    def draw(leg):
        table = pd.DataFrame(
            [(leg, 0.0, 1.0, "stance", "")], columns=["leg", "start_s", "end_s", "phase", "cut"]
        )
        with figures.style():
            figure = figures.plot_gait_diagram(table).get_figure(root=True)
            figure.draw_without_rendering()
        return figure

    return draw


def families(figure, word):
    texts = [text for text in figure.findobj() if getattr(text, "get_text", str)() == word]
    return [text.get_fontfamily() for text in texts]


@pytest.mark.filterwarnings("ignore:Glyph .* missing:UserWarning")
def test_a_word_takes_another_font_that_has_its_signs(diagram):
    figure = diagram(f"leg {RECORDER}")
    assert signs_as_boxes(figure) == RECORDER
    assert set_fonts_of_names(figure, further=["No Such Font", "STIXGeneral"])
    assert ["DejaVu Sans", "STIXGeneral"] in families(figure, f"leg {RECORDER}")
    assert families(figure, "Time (s)") == [["sans-serif"]]
    assert signs_as_boxes(figure) == ""


def test_a_figure_whose_font_has_all_signs_is_left_as_it_is(diagram):
    figure = diagram("Pfote größer µ")
    assert not set_fonts_of_names(figure, further=["STIXGeneral"])
    assert signs_as_boxes(figure) == ""
    assert {*map(tuple, families(figure, "Pfote größer µ"))} == {("sans-serif",)}


@pytest.mark.filterwarnings("ignore:Glyph .* missing:UserWarning")
def test_what_no_font_has_is_said_in_one_sentence(diagram):
    figure = diagram("前足")
    assert not set_fonts_of_names(figure, further=["STIXGeneral"])
    with pytest.warns(InputWarning, match=re.escape("DejaVu Sans has no sign for '前足'")):
        warn_of_boxes(signs_as_boxes(figure))
