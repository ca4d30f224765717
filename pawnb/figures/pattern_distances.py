"""How far each animal's phases are from ideal gaits: a dot for animal and pattern."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import add_animal_legend, draw_points, new_axes
from pawnb.figures.style import figure_size, mark_animals, small_pt, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("animal", "pattern", "distance")
RANDOM = 1.0 / np.sqrt(12.0)
"""Root mean square of differences that are anywhere from -0.5 to 0.5 cycle."""


@checked_arguments
def plot_pattern_distances(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the distances, patterns from the nearest (by the median of animals) down.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`pawnb.gait.phases.patterns.pattern_distances`.
    ax : matplotlib axes, optional
        Where to draw; default a new figure, one column wide.

    Returns
    -------
    matplotlib axes
        The axes; the dashed line is where phases at random would lie.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> tables = pawnb.gait.coordination.coordination_tables(gait)
    >>> ax = figures.plot_pattern_distances(tables["patterns"])
    """
    check_columns(table, COLUMNS, where="distances to ideal gaits")
    if len(table) == 0:
        raise InputError("distances to ideal gaits: the table is empty.")
    medians = table.groupby("pattern", sort=False)["distance"].median()
    names = [str(name) for name in medians.sort_values(kind="stable").index]
    marks = mark_animals(table["animal"])
    with style():
        new = ax is None
        if ax is None:
            _, ax = new_axes(figsize=figure_size(1, 24.0 + 6.0 * len(names)))
        # animals lie a little above each other, so that equal distances are seen
        shift = np.linspace(-0.25, 0.25, len(marks)) if len(marks) > 1 else np.zeros(1)
        for (animal, mark), up in zip(marks.items(), shift, strict=True):
            own = table[table["animal"].astype(str) == animal]
            rows = [names.index(str(name)) + up for name in own["pattern"]]
            draw_points(ax, own["distance"], rows, mark=mark, clip_on=False, zorder=3)
        for row in range(len(names)):
            ax.axhline(row, color="0.92", linewidth=0.6, zorder=0)
        ax.axvline(RANDOM, color="0.4", linewidth=0.7, linestyle=(0, (4, 2)))
        ax.text(RANDOM, -0.62, " phases at random", fontsize=small_pt(), va="bottom")
        ax.set_yticks(range(len(names)), names)
        ax.set_ylim(len(names) - 0.4, -0.6)
        ax.set_xlim(0.0, 0.5)
        ax.tick_params(axis="y", length=0)
        ax.set_xlabel("Distance to the ideal gait (cycles, RMS)", x=1.0, ha="right")
        if new:
            add_animal_legend(ax, marks)
    return ax
