"""Plots on a dark page, and as large as the page has room."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import Collection
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.spines import Spine
from matplotlib.text import Text

from pawnb.figures.style import style

PAPER, INK = "#1b1b1b", "#e4e4e4"
"""Background and text on a dark page."""
_WHITE, _BLACK = np.array(to_rgb(PAPER)), np.array(to_rgb(INK))
_MID_GREY = 0.08
"""Colours whose red, green and blue differ by less are greys."""
_DARK_GREY = 0.1
"""Colours of a lower relative luminance need a light edge on a dark page."""
_DONE = "_pawnb_dark"

SCREEN_PT = 9.0
"""Size of letters on the screen."""
_MARGIN_PX = 12
"""Room that the canvas leaves about itself."""

LEAST_PLOT_PX = (420, 300)
"""No plots are smaller; the page scrolls instead."""
WIDEST_PX = 1800
"""No plots are wider: the cell of a window of 1920 px is filled."""


@contextmanager
def on_screen() -> Iterator[None]:
    """Draw as a widget shows it: in its size of letters.

    Yields
    ------
    None
        What is made within it keeps to this.
    """
    with style(font_size_pt=SCREEN_PT):
        yield


def fit_figure(figure: Figure, *, room: tuple[int, int], highest_px: int, beside_px: int) -> None:
    """Make a figure as wide as its cell, and as high as the window has room.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A figure that a widget shows.
    room : tuple of int
        Width that there is, and height of the window, CSS px.
    highest_px : int
        Height of the figure where there is room for all of it, CSS px.
    beside_px : int
        Height of the window that the plots do not have: menus, buttons, words.
    """
    width = int(np.clip(room[0] - _MARGIN_PX, LEAST_PLOT_PX[0], WIDEST_PX))
    height = int(np.clip(room[1] - beside_px, LEAST_PLOT_PX[1], highest_px))
    dpi = figure.dpi / getattr(figure.canvas, "device_pixel_ratio", 1.0)
    figure.set_size_inches(width / dpi, height / dpi)


def set_theme(figure: Figure, *, dark: bool) -> None:
    """Draw a figure's greys for a dark page; leave it as it is on a light one.

    Black becomes light, white becomes dark, colours stay. What was done already stays done, so it
    can be called after every change; to go back to light, clear and draw the axes anew.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    dark : bool
        Whether the page is dark.
    """
    figure.set_facecolor(PAPER if dark else "white")
    for ax in figure.axes:
        ax.set_facecolor(PAPER if dark else "white")
        if dark:
            _darken_axes(ax)
        elif getattr(ax, _DONE, False):
            _lighten_frame(ax)


def _darken_axes(ax: Axes) -> None:
    """Draw everything in axes for a dark page."""
    setattr(ax, _DONE, True)
    for child in _inside(ax):
        if child is ax.patch or getattr(child, _DONE, False):
            continue
        if isinstance(child, Axis):
            child.set_tick_params(which="both", colors=INK)
            child.label.set_color(INK)
            child.offsetText.set_color(INK)
            continue  # its ticks are made anew at every drawing
        _darken(child)
        setattr(child, _DONE, True)


def _lighten_frame(ax: Axes) -> None:
    """Draw ticks and spines, which outlive the clearing of axes, for a light page again."""
    setattr(ax, _DONE, False)
    for child in ax.get_children():
        if isinstance(child, Axis):
            child.set_tick_params(which="both", colors="black")
        elif isinstance(child, Spine):
            child.set_edgecolor("black")
            setattr(child, _DONE, False)


def _inside(artist: Artist) -> Iterable[Artist]:
    """Return what is in an artist, and in that, down to the ticks."""
    for child in artist.get_children():
        yield child
        if not isinstance(child, Axis):
            yield from _inside(child)


def _darken(artist: Any) -> None:
    """Draw one artist for a dark page."""
    face: Any
    edge: Any
    if isinstance(artist, Text):
        artist.set_color(_on_dark(artist.get_color()))
        if (arrow := getattr(artist, "arrow_patch", None)) is not None:  # no child of its text
            _darken(arrow)
    elif isinstance(artist, Line2D):
        face, edge = artist.get_markerfacecolor(), artist.get_markeredgecolor()
        if _is_dark_colour(artist.get_color()) and not artist.get_path_effects():
            width = artist.get_linewidth() + 1.6
            artist.set_path_effects([withStroke(linewidth=width, foreground=INK)])
        artist.set_color(_on_dark(artist.get_color()))
        artist.set_markerfacecolor(_on_dark(face))
        artist.set_markeredgecolor(_on_dark(edge))
    elif isinstance(artist, Patch | Collection):
        face, edge = artist.get_facecolor(), artist.get_edgecolor()
        artist.set_facecolor(_all_on_dark(face))
        artist.set_edgecolor(_all_on_dark(edge))
        if isinstance(artist, Patch) and _is_dark_colour(face):
            artist.set_edgecolor(INK)
            artist.set_linewidth(max(0.8, artist.get_linewidth()))


def _all_on_dark(colours: Any) -> Any:
    """Return one colour, or many, for a dark page."""
    many = np.asarray(colours)
    return [_on_dark(row) for row in many] if many.ndim == 2 else _on_dark(colours)


def _on_dark(colour: Any) -> Any:
    """Return a colour for a dark page: greys between ink and paper, others as they are."""
    if isinstance(colour, str) and colour == "none":
        return colour
    *rgb, alpha = to_rgba(colour)
    if np.ptp(rgb) > _MID_GREY:
        return colour
    return (*(_BLACK + (_WHITE - _BLACK) * float(np.mean(rgb))), alpha)


def _is_dark_colour(colour: Any) -> bool:
    """Say whether a colour, that is no grey, would not be seen on a dark page."""
    if isinstance(colour, str) and colour == "none":
        return False
    rgb = np.array(to_rgba(colour)[:3])
    return bool(np.ptp(rgb) > _MID_GREY and (rgb**2.2) @ [0.2126, 0.7152, 0.0722] < _DARK_GREY)


def shortened(name: str, most: int) -> str:
    """Return a name for a plot: at most so many letters, its ends kept.

    Names of points often differ at their end (``hindpaw_left``, ``hindpaw_right``).
    """
    if len(name) <= most:
        return name
    return f"{name[: most // 2]}…{name[len(name) - (most - 1) // 2 :]}"
