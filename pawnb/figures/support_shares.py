"""Feet on the ground: the share of time with none, one, two, ... of them in stance."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from pawnb.errors import InputError
from pawnb.figures.long_names import letters_in, wrap_name
from pawnb.figures.panels import new_axes
from pawnb.figures.style import figure_size, get_style, small_pt, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("animal", "n_down", "share")
_NUMBER_FROM = 0.07
"""A stretch narrower than this is too narrow for its number."""
_NAMES_SHARE = 0.3
"""Share of a column that names of animals may take."""
_ROWS_MM = 190.0
"""All rows together are at most so high, so that the figure fits on a page."""


@checked_arguments
def plot_support_shares(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw a bar for each animal, parted by the number of feet on the ground.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`pawnb.gait.support.support_shares`.
    ax : matplotlib axes, optional
        Where to draw; default a new figure, one column wide.

    Returns
    -------
    matplotlib axes
        The axes; the number of feet stands in the stretch, and beside the colours below.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> tables = pawnb.gait.coordination.coordination_tables(gait)
    >>> ax = figures.plot_support_shares(tables["support_shares"])
    """
    check_columns(table, COLUMNS, where="feet on the ground")
    if len(table) == 0:
        raise InputError("feet on the ground: the table is empty.")
    animals = [str(a) for a in sorted(table["animal"].astype(str).unique())]
    most = int(table["n_down"].max())
    # cividis is the same to colour-blind eyes, and goes from dark to light
    colours = mpl.colormaps["cividis"](np.linspace(1.0, 0.0, most + 1))
    with style():
        new = ax is None
        names = [wrap_name(a, letters_in(_NAMES_SHARE * get_style().column_mm)) for a in animals]
        if ax is None:
            lines = max(name.count("\n") for name in names) + 1
            row_mm = min(2.5 + 3.0 * lines, _ROWS_MM / len(animals))
            _, ax = new_axes(figsize=figure_size(1, 32.0 + row_mm * len(animals)))
        for row, animal in enumerate(animals):
            own = table[table["animal"].astype(str) == animal].sort_values("n_down")
            left = 0.0
            for n, share in zip(own["n_down"].astype(int), own["share"], strict=True):
                ax.barh(row, 100.0 * share, left=left, height=0.75, color=colours[n],
                        edgecolor="white", linewidth=0.4)  # fmt: skip
                if share >= _NUMBER_FROM:
                    dark = colours[n][:3].mean() < 0.5
                    ax.text(left + 50.0 * share, row, str(n), ha="center", va="center",
                            color="white" if dark else "black", fontsize=small_pt())  # fmt: skip
                left += 100.0 * share
        if new:
            numbers = sorted(table["n_down"].astype(int).unique())
            figure: Any = ax.figure
            figure.legend(
                [Patch(color=colours[n]) for n in numbers], [str(n) for n in numbers],
                loc="outside lower center", ncols=len(numbers), handlelength=1.0,
                columnspacing=1.0, title="Feet on the ground",
            )  # fmt: skip
        ax.set_yticks(range(len(animals)), names)
        ax.set_ylim(len(animals) - 0.5, -0.5)
        ax.set_xlim(0.0, 100.0)
        ax.tick_params(axis="y", length=0)
        ax.set_xlabel("Time (%)")
        ax.set_ylabel("Animal")
    return ax
