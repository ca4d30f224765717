"""Names in scripts that the font of the figures has no signs for, such as Chinese."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.text import Text

from pawnb.errors import InputWarning
from pawnb.figures.style import get_style
from pawnb.input_warnings import warn_of_input

FURTHER_FONTS = (
    "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans CJK KR", "Noto Sans SC", "Noto Sans JP",
    "Noto Sans KR", "Source Han Sans SC", "Source Han Sans JP", "Microsoft YaHei", "PingFang SC",
    "SimHei", "WenQuanYi Zen Hei", "WenQuanYi Micro Hei", "Yu Gothic", "Hiragino Sans",
    "MS Gothic", "Malgun Gothic", "Apple SD Gothic Neo", "Arial Unicode MS",
)  # fmt: skip
"""Fonts without serifs that Windows, macOS and Linux have for East Asian scripts."""


def set_fonts_of_names(figure: Figure, *, further: Sequence[str] = FURTHER_FONTS) -> bool:
    """Give words that the figure's font cannot write a font that has their signs.

    Other words, and figures without such words, are left as they are.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure; draw it before, so that its axes have their labels, and again if this changes
        it.
    further : sequence of str
        Fonts that are tried; those that are not installed are passed over.

    Returns
    -------
    bool
        Whether any word has another font now.
    """
    own, changed = get_style().font, False
    for text in _texts(figure):
        lacking = [sign for sign in text.get_text() if not _has(own, sign)]
        if not lacking:
            continue
        installed = {*fontManager.get_font_names()}
        fonts = [f for f in further if f in installed and any(_has(f, sign) for sign in lacking)]
        if fonts:
            text.set_fontfamily([own, *fonts])
            changed = True
    return changed


def signs_as_boxes(figure: Figure) -> str:
    """Return the signs for which none of its fonts has a form, each once: boxes are drawn for them.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A figure that was drawn.

    Returns
    -------
    str
        The signs.
    """
    own, boxes = get_style().font, ""
    for text in _texts(figure):
        fonts = {own, *text.get_fontfamily()} - {"sans-serif"}
        boxes += "".join(s for s in text.get_text() if not any(_has(font, s) for font in fonts))
    return "".join(dict.fromkeys(boxes))


def warn_of_boxes(signs: str, *, stacklevel: int = 2) -> None:
    """Warn of signs for which boxes are drawn, if there are any.

    Parameters
    ----------
    signs : str
        As :func:`signs_as_boxes` gives them.
    stacklevel : int
        As for :func:`warnings.warn`.
    """
    if signs:
        warn_of_input(
            f"figures: {get_style().font} has no sign for {signs!r}, nor has another font that is "
            "installed here, so boxes stand for them; install one, such as Noto Sans CJK, or "
            "choose one with pawnb.figures.set_style(font=...).",
            InputWarning,
            stacklevel=stacklevel + 1,
        )


def _texts(figure: Figure) -> list[Text]:
    return [text for text in figure.findobj(Text) if isinstance(text, Text) and text.get_visible()]


def _has(font: str, sign: str) -> bool:
    """Tell whether a font has a sign; line breaks and the like need none."""
    return not sign.isprintable() or ord(sign) in _signs(font)


@functools.cache
def _signs(font: str) -> frozenset[int]:
    """Return the signs of a font."""
    return frozenset(get_font(findfont(FontProperties(family=[font]))).get_charmap())
