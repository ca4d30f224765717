"""Panels of a figure: as many as are needed, lettered, at print size."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from pawnb.errors import InputError
from pawnb.figures.style import AnimalMark, figure_size, get_style, small_pt
from pawnb.gait.legs import find_leg_place, sort_legs

SECOND_LEG = (0, (3, 1.2))
"""Line of the second leg (the right one) of a pair that shares a panel."""

_APART: ContextVar[bool] = ContextVar("apart", default=False)
_ALPHABET = "abcdefghijklmnopqrstuvwxyz"


@contextmanager
def apart_from_pyplot() -> Iterator[None]:
    """Make new figures that pyplot does not know, inside a ``with`` block of this thread.

    A notebook draws, shows and closes every figure that pyplot knows whenever a cell or a message
    of a widget has been dealt with: one that another thread is drawing then is saved half empty.
    """
    token = _APART.set(True)
    try:
        yield
    finally:
        _APART.reset(token)


def new_figure(**options: Any) -> Figure:
    """Make a figure, as ``matplotlib.pyplot.figure`` does.

    Parameters
    ----------
    **options
        For ``matplotlib.figure.Figure``, such as ``figsize``.

    Returns
    -------
    matplotlib.figure.Figure
        The figure; pyplot does not know it inside :func:`apart_from_pyplot`.
    """
    return Figure(**options) if _APART.get() else plt.figure(**options)


def new_axes(
    rows: int = 1, columns: int = 1, *, figsize: tuple[float, float], **options: Any
) -> tuple[Figure, Any]:
    """Make a figure with axes, as ``matplotlib.pyplot.subplots`` does.

    Parameters
    ----------
    rows, columns : int
        Shape of the grid of axes.
    figsize : tuple of float
        Size of the figure, inches.
    **options
        For ``matplotlib.figure.Figure.subplots``, such as ``sharex``.

    Returns
    -------
    figure, axes
        The axes, or an array of several.
    """
    figure = new_figure(figsize=figsize)
    return figure, figure.subplots(rows, columns, **options)


def make_panels(
    n: int,
    *,
    where: str,
    ax: Any = None,
    columns: int | None = None,
    height_mm: float = 45.0,
    lettered: bool = True,
    **options: Any,
) -> list[Any]:
    """Make one axes for each panel, or take the one that was given.

    Parameters
    ----------
    n : int
        Number of panels.
    where : str
        Name of the figure, for messages.
    ax : matplotlib axes, optional
        Where a single panel is drawn.
    columns : int, optional
        Panels side by side; default 1 for one panel, 2 for up to four, else 3. Up to two of
        them are one column of a page wide, more are two.
    height_mm : float
        Height of a row of panels.
    lettered : bool
        Put a, b, c, ... above several panels.
    **options
        For :func:`new_axes`, such as ``sharex``.

    Returns
    -------
    list of matplotlib axes
        n axes.

    Raises
    ------
    InputError
        If there is no panel, or several for one axes.
    """
    if n == 0:
        raise InputError(f"{where}: the table is empty.")
    if ax is not None:
        if n > 1:
            raise InputError(
                f"{where}: {n} panels for one axes; choose one of them, or leave ax out."
            )
        return [ax]
    wide = columns or (1 if n == 1 else 2 if n <= 4 else 3)
    wide = min(wide, n)
    rows = math.ceil(n / wide)
    size = figure_size(1 if wide <= 2 else 2, rows * height_mm)
    _, grid = new_axes(rows, wide, figsize=size, squeeze=False, **options)
    panels = list(grid.flat)
    for spare in panels[n:]:
        spare.remove()
    if lettered and n > 1:
        for k, panel in enumerate(panels[:n]):
            add_letter(panel, k)
    return panels[:n]


def open_grid(
    rows: int, columns: int, *, where: str, size: tuple[float, float], ax: Any = None, **ratios: Any
) -> tuple[Any, Any]:
    """Make the grid of a figure of unlike panels, or divide the place of the axes given.

    Parameters
    ----------
    rows, columns : int
        Shape of the grid.
    where : str
        Name of the figure, for messages.
    size : tuple of float
        Size of a new figure, inches.
    ax : matplotlib axes, optional
        The panels take its place in its figure; it is removed.
    **ratios
        ``height_ratios``, ``width_ratios``.

    Returns
    -------
    figure, grid
        For ``figure.add_subplot(grid[i, j])``.

    Raises
    ------
    InputError
        If the axes have no place in a grid, as those of ``figure.add_axes``.
    """
    if ax is None:
        figure = new_figure(figsize=size)
        return figure, figure.add_gridspec(rows, columns, **ratios)
    place = ax.get_subplotspec()
    if place is None:
        raise InputError(
            f"{where}: its panels divide the place of the axes given, and these have none; make "
            "them with plt.subplots."
        )
    figure = ax.figure
    ax.remove()
    return figure, place.subgridspec(rows, columns, **ratios)


def add_letter(ax: Axes, k: int) -> None:
    """Put the letter of a panel above its left edge.

    Parameters
    ----------
    ax : matplotlib axes
        The panel.
    k : int
        Its number from 0; a to z, then aa, ab, ...
    """
    letter = _ALPHABET[k % 26] if k < 26 else _ALPHABET[k // 26 - 1] + _ALPHABET[k % 26]
    ax.set_title(letter, loc="left", fontweight="bold")


def use_log_axes(ax: Axes) -> None:
    """Make both axes logarithmic, with plain numbers: powers of ten would be below 6 pt.

    Parameters
    ----------
    ax : matplotlib axes
        The panel.
    """
    ax.set_xscale("log")
    ax.set_yscale("log")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(FuncFormatter(partial(_say_minor, axis)))


def _say_minor(axis: Axis, value: float, _: int | None = None) -> str:
    """Say the minor ticks at 2 and 5 where the axis is not longer than two decades."""
    low, high = axis.get_view_interval()
    said = f"{value:g}" if high <= 100.0 * low else ""
    return said if said.strip("0.")[:1] in ("2", "5") else ""


def draw_points(ax: Axes, x: Any, y: Any, *, mark: AnimalMark, **options: Any) -> Any:
    """Draw points with the mark of an animal.

    Parameters
    ----------
    ax : matplotlib axes
        Where.
    x, y : array_like, shape (n,)
        Places.
    mark : AnimalMark
        From :func:`pawnb.figures.style.mark_animals`.
    **options
        For ``Axes.plot``; ``color`` is that of the outline, and of the inside where filled.

    Returns
    -------
    matplotlib.lines.Line2D
        The points.
    """
    colour = options.pop("color", "black")
    inside = colour if mark.filled else "white"
    options = {"markersize": 3.5, "markeredgewidth": 0.6, **options}
    (drawn,) = ax.plot(
        x, y, linestyle="none", marker=mark.marker, markerfacecolor=inside,
        markeredgecolor=colour, **options,
    )  # fmt: skip
    return drawn


def add_note(ax: Axes, text: str, *, at: tuple[float, float] = (1.0, 1.0), **options: Any) -> None:
    """Write a short note in a panel, in fractions of the axes.

    Parameters
    ----------
    ax : matplotlib axes
        The panel.
    text : str
        What to write.
    at : tuple of float
        Where; the text lies left of and below it.
    **options
        For ``Axes.text``.
    """
    options = {"ha": "right", "va": "top", "fontsize": small_pt(), **options}
    ax.text(*at, text, transform=ax.transAxes, **options)


def add_heading(ax: Axes, title: str, details: str) -> None:
    """Write a title above a panel, and details in small letters between it and the panel.

    Parameters
    ----------
    ax : matplotlib axes
        The panel.
    title : str
        Title.
    details : str
        One or more short lines.
    """
    size = small_pt()
    lines = details.count("\n") + 1
    ax.set_title(title, pad=4.0 + 1.25 * size * lines)
    ax.annotate(details, (0.5, 1.0), xytext=(0.0, 2.0), xycoords="axes fraction",
                textcoords="offset points", ha="center", va="bottom", fontsize=size)  # fmt: skip


def label_outer(panels: Sequence[Axes], *, x: str, y: str) -> None:
    """Name the axes of panels that share their scales: only the left ones and the lowest.

    Parameters
    ----------
    panels : sequence of matplotlib axes
        From :func:`make_panels`.
    x, y : str
        Names of the axes, with their units.
    """
    places = [panel.get_subplotspec() for panel in panels]
    wide = max((p.colspan.stop for p in places if p is not None), default=1)
    for k, (panel, place) in enumerate(zip(panels, places, strict=True)):
        if place is None or place.is_first_col():
            panel.set_ylabel(y)
        if place is None or k + wide >= len(panels):
            panel.set_xlabel(x)
            panel.tick_params(axis="x", labelbottom=True)


def say_lines(counts: str, legs: Sequence[str]) -> str:
    """Add to the counts which leg of a pair is drawn dashed."""
    return f"{counts}\ndashed: {legs[1]}" if len(legs) > 1 else counts


def say_phase(phase: float) -> str:
    """Return a phase with two digits; 0.999 is 0.00, as phases lie in [0, 1)."""
    return f"{round(phase, 2) % 1.0:.2f}"


def add_animal_legend(ax: Any, marks: dict[str, AnimalMark], *, most: int = 12) -> None:
    """Name the animals below a figure, where there are several and not too many.

    A row of names has its place in the figure; it gets taller by those that follow.

    Parameters
    ----------
    ax : matplotlib axes
        Any axes of the figure.
    marks : dict
        From :func:`pawnb.figures.style.mark_animals`.
    most : int
        More animals than this are not named one by one.
    """
    if not 1 < len(marks) <= most:
        return
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], linestyle="none", marker=m.marker, markersize=3.5, markeredgewidth=0.6,
               markeredgecolor="black", markerfacecolor="black" if m.filled else "white")
        for m in marks.values()
    ]  # fmt: skip
    # as many names in a row as fit at about 0.6 of the size of the letters
    figure = ax.figure
    widest = max(len(name) for name in marks) * 0.62 * get_style().font_size_pt + 22.0
    width, height = figure.get_size_inches()
    columns = min(max(1, int(width * 72.0 / widest)), len(marks))
    further = math.ceil(len(marks) / columns) - 1
    figure.set_size_inches(width, height + further * 1.5 * get_style().font_size_pt / 72.0)
    figure.legend(
        handles, list(marks), loc="outside lower center", ncols=columns,
        handletextpad=0.2, columnspacing=1.0, handlelength=1.2,
    )  # fmt: skip


def group_legs(legs: Iterable[str]) -> list[tuple[str, list[str]]]:
    """Group legs into panels: the left and the right leg of a pair share one.

    Parameters
    ----------
    legs : iterable of str
        Names, each counted once.

    Returns
    -------
    list of (str, list of str)
        Title and legs (left, then right) of each panel, from the front; legs whose names say
        no place have a panel each.
    """
    groups: dict[str, list[str]] = {}
    for leg in sort_legs(legs):
        place = find_leg_place(leg)
        if place is None:
            groups[leg] = [leg]
        else:
            words = {"F": "Fore legs", "M": "Middle legs", "H": "Hind legs"}
            letter = leg.replace("L", "", 1).replace("R", "", 1)
            groups.setdefault(words.get(letter, f"Legs {letter}"), []).append(leg)
    return [(title, sorted(own)) for title, own in groups.items()]


def say_counts(n: int, what: str, n_animals: int) -> str:
    """Say how many of something of how many animals, in words.

    Parameters
    ----------
    n : int
        Number of them.
    what : str
        One of them, as ``"stride"``.
    n_animals : int
        Number of animals.

    Returns
    -------
    str
        As ``"12 strides, 1 animal"``.
    """
    return f"{n} {what}{'s' * (n != 1)}, {n_animals} animal{'s' * (n_animals != 1)}"


def with_unit(name: str, unit: str | None) -> str:
    """Return the name of an axis with its unit in brackets.

    Parameters
    ----------
    name : str
        What is shown.
    unit : str or None
        Unit; None or empty where it is not known, which the name then says.

    Returns
    -------
    str
        As ``"Speed (mm/s)"``.
    """
    return f"{name} ({unit or 'unit of the tracks'})"


def speed_unit(unit: str | None) -> str:
    """Return the unit of a speed from that of a length; said in words where it is not known."""
    return f"{unit}/s" if unit else "unit of the tracks/s"
