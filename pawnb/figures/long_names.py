"""Names of groups and animals that are longer than their place in a figure."""

from __future__ import annotations

import re

from pawnb.figures.style import get_style

_MM_PER_PT = 25.4 / 72.0
_LETTER = 0.6
"""Mean width of a letter, as a share of the size of the letters."""
_PIECES = re.compile(r"[^\s_\-;,/+]*[\s_\-;,/+]*")


def wrap_name(name: str, letters: int) -> str:
    """Return a name in lines: broken behind blanks and marks such as _ - ; and else within words.

    Parameters
    ----------
    name : str
        Name of a group or an animal.
    letters : int
        Most letters in a line.

    Returns
    -------
    str
        The lines; a name that fits into one is as it was.
    """
    if len(name) <= letters:
        return name
    lines = [""]
    for piece in _PIECES.findall(name):
        if lines[-1] and len(lines[-1] + piece.rstrip()) > letters:
            lines.append("")
        lines[-1] += piece
        while len(lines[-1].rstrip()) > letters:
            lines[-1:] = [lines[-1][:letters], lines[-1][letters:]]
    return "\n".join(line.strip() for line in lines if line.strip())


def letters_in(width_mm: float, *, least: int = 6, size: float = 1.0) -> int:
    """Return how many letters fit side by side.

    Parameters
    ----------
    width_mm : float
        Room, mm.
    least : int
        Never fewer than these.
    size : float
        Size of the letters, as a share of the size of the style.

    Returns
    -------
    int
        Letters.
    """
    return max(least, int(width_mm / (width_of(1, size=size))))


def width_of(letters: int, *, size: float = 1.0) -> float:
    """Return how much room letters take side by side, mm.

    Parameters
    ----------
    letters : int
        How many.
    size : float
        As for :func:`letters_in`.

    Returns
    -------
    float
        Width, mm.
    """
    return letters * _LETTER * size * get_style().font_size_pt * _MM_PER_PT
