"""How figures look: sizes, fonts and colours, in one place.

The style is a context. Outside it matplotlib is as the user left it. Save inside it
too: embedded fonts and reproducible SVG are decided when a file is written. What a user
may choose (:class:`StyleOptions`) is set once by :func:`set_style`, and every figure
follows it.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.colors import is_color_like, to_hex
from matplotlib.font_manager import FontProperties, findfont

from pawnb.errors import InputError, did_you_mean
from pawnb.gait.legs import find_leg_place, sort_legs

COLUMN_MM = 85.0
"""Width of one column of a journal, where nothing else is set."""

PAGE_MM = 170.0
"""Width of two columns, where nothing else is set."""

SMALLEST_PT = 6.0
"""No text is smaller than this when printed at its size."""

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

_LEGS = {
    "R": (OKABE_ITO["blue"], OKABE_ITO["bluish green"], OKABE_ITO["sky blue"], "#332288"),
    "L": (OKABE_ITO["vermillion"], OKABE_ITO["reddish purple"], OKABE_ITO["orange"], "#661100"),
}
"""Legs of each side from the front (hind legs of four are the third): right ones are cool, left
ones warm, so that a left leg taken for the right one shows. An indigo and a dark brown stand in
for the yellow and the black of Okabe and Ito: yellow marks what is picked, black is axes."""
_IN_TURN = tuple(_LEGS[side][k] for k, side in enumerate("RLRL")) + tuple(
    _LEGS[side][k] for k, side in enumerate("LRLR")
)
"""For legs whose names say no place: neighbours are of either kind."""
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", "p", ">", "h", "*")


@dataclass(frozen=True, kw_only=True)
class StyleOptions:
    """What a user may choose of the style.

    Parameters
    ----------
    font_size_pt : float
        Size of numbers and notes at print size, 6 or more; names of axes and titles of panels
        are 1 pt larger.
    font : str
        Font family. The default comes with matplotlib, so it is the same everywhere.
    column_mm, page_mm : float
        Width of figures of one and of two columns.
    leg_colours : mapping
        Leg to a colour that matplotlib knows; legs that are not named keep theirs.
    dpi : float
        Resolution of PNG files.

    Examples
    --------
    >>> figures.StyleOptions(font_size_pt=8.0).column_mm
    85.0
    """

    font_size_pt: float = 7.0
    font: str = "DejaVu Sans"
    column_mm: float = COLUMN_MM
    page_mm: float = PAGE_MM
    leg_colours: Mapping[str, str] | None = None
    dpi: float = 300.0

    def __post_init__(self) -> None:
        """Refuse what cannot be printed."""
        if self.font_size_pt < SMALLEST_PT:
            raise InputError(
                f"font_size_pt is {self.font_size_pt:g}; text below {SMALLEST_PT:g} pt cannot be "
                "read in print, give 6 or more."
            )
        for name in ("column_mm", "page_mm", "dpi"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} is {getattr(self, name)}; expected more than 0.")
        for leg, colour in (self.leg_colours or {}).items():
            if not is_color_like(colour):
                raise InputError(
                    f"leg_colours: {colour!r} of leg {leg} is no colour; give a name or #rrggbb."
                )
        try:
            findfont(FontProperties(family=[self.font]), fallback_to_default=False)
        except ValueError:
            raise InputError(
                f"font {self.font!r} is not installed; install it or leave font out."
            ) from None


_DEFAULT = StyleOptions()
_in_force = [_DEFAULT]
"""The options of each ``with`` block inside the other; the last count. No context variable: those
do not outlive the cell of a notebook."""

_open: list[list[AbstractContextManager[None]]] = []
"""The blocks in which matplotlib has other settings, in the order in which they began, each with
what gives back the settings from before it. Blocks of other threads are among them."""
_one_at_a_time = threading.Lock()

_FIXED: dict[str, Any] = {
    "font.family": "sans-serif",
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.0,
    "patch.linewidth": 0.6,
    "hatch.linewidth": 0.4,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150.0,
    "text.parse_math": False,  # names of animals and legs may have dollar signs
    "pdf.fonttype": 42,  # TrueType: text stays text and can be edited
    "ps.fonttype": 42,
    "svg.fonttype": "none",  # likewise
    "svg.hashsalt": "pawnb",  # equal figures give equal bytes
}


def get_style() -> StyleOptions:
    """Return the options in force.

    Returns
    -------
    StyleOptions
        Those of :func:`set_style` or of the innermost ``with style(...)``.

    Examples
    --------
    >>> figures.get_style().column_mm
    85.0
    """
    return _in_force[-1]


def set_style(**options: Any) -> StyleOptions:
    """Set options of the style for all figures from here on; without any, go back to defaults.

    Parameters
    ----------
    **options
        Fields of :class:`StyleOptions`; those not named keep what is in force.

    Returns
    -------
    StyleOptions
        The options now in force.

    Raises
    ------
    InputError
        If an option is unknown or cannot be used.

    Examples
    --------
    >>> figures.set_style(column_mm=89.0).column_mm  # the columns of another journal
    89.0
    >>> figures.set_style().column_mm  # as before
    85.0
    """
    _in_force[-1] = _with(options) if options else _DEFAULT
    return _in_force[-1]


def _with(options: Mapping[str, Any]) -> StyleOptions:
    """Return the options in force with some of them changed."""
    known = [field.name for field in fields(StyleOptions)]
    for name in options:
        if name not in known:
            raise InputError(
                f"style: no option {name!r}{did_you_mean(name, known)}; there are "
                f"{', '.join(known)}."
            )
    return replace(get_style(), **options)


@contextmanager
def style(**options: Any) -> Iterator[None]:
    """Apply the style inside a ``with`` block; nothing stays changed after it.

    Parameters
    ----------
    **options
        Fields of :class:`StyleOptions` for this block only.

    Raises
    ------
    InputError
        If an option is unknown or cannot be used.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> with figures.style(font_size_pt=8.0):
    ...     figure, ax = plt.subplots()
    ...     ax.get_xticklabels()[0].get_fontsize()
    8.0
    """
    chosen = _with(options)
    size = chosen.font_size_pt
    sizes = dict.fromkeys(("font.size", "xtick.labelsize", "ytick.labelsize"), size)
    sizes |= {"legend.fontsize": size, "legend.title_fontsize": size}
    sizes |= {"axes.labelsize": size + 1.0, "axes.titlesize": size + 1.0}
    more: Any = {"font.sans-serif": [chosen.font, "sans-serif"], "savefig.dpi": chosen.dpi}
    if options:
        _in_force.append(chosen)
    try:
        with _settings(_FIXED | sizes | more):
            yield
            # the first figure loads the notebook's backend, which turns interactive mode on:
            # that must outlive the block, or no later figure of the notebook is shown
            interactive = mpl.is_interactive()
        mpl.interactive(interactive)
    finally:
        if options:  # that of another thread may have been put on top
            _in_force[:] = [one for one in _in_force if one is not chosen]


@contextmanager
def _settings(settings: Any) -> Iterator[None]:
    """Give matplotlib other settings inside a ``with`` block.

    Settings are those of all threads. Blocks of two threads may end in the order in which they
    began: the first then leaves it to the second to give back what was before both.
    """
    own: list[AbstractContextManager[None]] = [mpl.rc_context(settings)]
    with _one_at_a_time:
        own[0].__enter__()
        _open.append(own)
    try:
        yield
    finally:
        with _one_at_a_time:
            place = next(k for k, block in enumerate(_open) if block is own)
            del _open[place]
            if place < len(_open):
                _open[place] += own
            else:
                for before in own:
                    before.__exit__(None, None, None)


def small_pt() -> float:
    """Return the size of the smallest text: one point below the usual, never below 6 pt."""
    return max(SMALLEST_PT, get_style().font_size_pt - 1.0)


def figure_size(columns: int, height_mm: float) -> tuple[float, float]:
    """Return the size of a figure in inches, as wide as the style says.

    Parameters
    ----------
    columns : int
        1 or 2 columns of a page.
    height_mm : float
        Height, mm.

    Returns
    -------
    tuple of float
        Width and height in inches.
    """
    chosen = get_style()
    return size_mm(chosen.column_mm if columns == 1 else chosen.page_mm, height_mm)


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
        Leg to ``#rrggbb``, the same in every figure and over the video. A leg has its colour by
        side and place from the front, whichever others there are; from the fifth of a side on
        they begin again. Legs whose names say no place take, in alphabetical order, colours
        that no other leg has, as long as there are any. ``leg_colours`` of the style come first.
    """
    own = get_style().leg_colours or {}
    colours: dict[str, str] = {}
    for leg in sort_legs(legs):
        place = find_leg_place(leg)
        if leg in own:
            colours[leg] = to_hex(own[leg]).upper()
        elif place is not None:
            side = _LEGS[place.side]
            colours[leg] = side[(place.rank - 1) % len(side)]
        else:
            free = [colour for colour in _IN_TURN if colour not in colours.values()]
            colours[leg] = free[0] if free else _IN_TURN[len(colours) % len(_IN_TURN)]
    return colours


class AnimalMark(NamedTuple):
    """How the points of one animal look.

    Attributes
    ----------
    marker : str
        Shape, as matplotlib names it.
    filled : bool
        Filled, or its outline only.
    """

    marker: str
    filled: bool


def mark_animals(animals: Iterable[object]) -> dict[str, AnimalMark]:
    """Choose a shape for the points of every animal, so that individuals are told apart.

    Parameters
    ----------
    animals : iterable
        Names of animals, each counted once.

    Returns
    -------
    dict
        Name to mark, in alphabetical order: twelve filled shapes, then the same as outlines;
        beyond 24 animals they begin again.
    """
    names = sorted({str(animal) for animal in animals})
    k = len(_MARKERS)
    return {
        name: AnimalMark(_MARKERS[i % k], filled=(i // k) % 2 == 0) for i, name in enumerate(names)
    }
