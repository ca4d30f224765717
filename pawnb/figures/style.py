"""How figures look: sizes, fonts and colours, in one place.

The style is a context. Outside it matplotlib is as the user left it. Save inside it
too: embedded fonts and reproducible SVG are decided when a file is written.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl

from pawnb.gait.legs import find_leg_place, sort_legs

COLUMN_MM = 85.0
"""Width of one column of a journal."""

PAGE_MM = 174.0
"""Width of two columns."""

OKABE_ITO = {
    "black": "#000000",
    "orange": "#E69F00",
    "sky blue": "#56B4E9",
    "bluish green": "#009E73",
    "yellow": "#F0E442",
    "blue": "#0072B2",
    "vermillion": "#D55E00",
    "reddish purple": "#CC79A7",
}
"""Colours that people with any common colour blindness can tell apart (Okabe & Ito 2008)."""

_MOUSE = {"FR": "blue", "HR": "sky blue", "FL": "vermillion", "HL": "orange"}
_BY_RANK = ("blue", "orange", "bluish green", "reddish purple", "vermillion", "sky blue", "black")

_STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib, so it is the same everywhere
    "font.size": 7.0,
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.0,
    "patch.linewidth": 0.6,
    "hatch.linewidth": 0.4,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150.0,
    "savefig.dpi": 300.0,
    "pdf.fonttype": 42,  # TrueType: text stays text and can be edited
    "ps.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "pawnb",  # equal figures give equal bytes
}


@contextmanager
def style() -> Iterator[None]:
    """Apply the style inside a ``with`` block; nothing stays changed after it."""
    with mpl.rc_context(_STYLE):
        yield
        # the first figure loads the notebook's backend, which turns interactive mode on: that
        # must outlive the block, or no later figure of the notebook is shown
        interactive = mpl.is_interactive()
    mpl.interactive(interactive)


def size_mm(width: float, height: float) -> tuple[float, float]:
    """Return a size in inches, as matplotlib wants it.

    Parameters
    ----------
    width, height : float
        Size in mm.

    Returns
    -------
    tuple of float
        Width and height in inches.
    """
    return width / 25.4, height / 25.4


def colour_legs(legs: list[str]) -> dict[str, str]:
    """Choose a colour for every leg.

    Parameters
    ----------
    legs : list of str
        Names of legs.

    Returns
    -------
    dict
        Leg to ``#rrggbb``. The four paws have their own; the two legs of a pair of other
        animals share one, by their place from the front (their names tell them
        apart); other names take colours in turn.
    """
    colours = {}
    spare = 0
    for leg in sort_legs(legs):
        place = find_leg_place(leg)
        if leg in _MOUSE:
            name = _MOUSE[leg]
        elif place is not None:
            name = _BY_RANK[(place.rank - 1) % len(_BY_RANK)]
        else:
            name = _BY_RANK[spare % len(_BY_RANK)]
            spare += 1
        colours[leg] = OKABE_ITO[name]
    return colours
