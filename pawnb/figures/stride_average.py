"""Averages of a signal over the stride, with bands, leg by leg."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from pawnb.figures.panels import (
    SECOND_LEG,
    add_heading,
    group_legs,
    label_outer,
    make_panels,
    say_counts,
    say_lines,
    with_unit,
)
from pawnb.figures.style import colour_legs, style
from pawnb.gait.cycles import AVERAGE_COLUMNS
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def plot_stride_average(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the mean course of a signal over the stride and its band.

    All panels span the same range, wherever its middle lies, so that courses compare.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`pawnb.gait.cycles.average_cycles`, which says what the band is.
    ax : matplotlib axes, optional
        Where to draw a table of a single leg or pair; default a new figure with a panel for
        each pair of legs.

    Returns
    -------
    matplotlib axes
        The first panel.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or there are several pairs for one axes.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> cycles = pawnb.gait.cycles.cut_cycles(angles, gait.strides)
    >>> ax = figures.plot_stride_average(pawnb.gait.cycles.average_cycles(cycles))
    """
    check_columns(table, AVERAGE_COLUMNS, where="stride average")
    groups = group_legs(table["leg"])
    colours = colour_legs([leg for _, legs in groups for leg in legs])
    ends = {}
    for title, legs in groups:
        own = table[table["leg"].isin(legs)]
        ends[title] = own[["mean", "low"]].min().min(), own[["mean", "high"]].max().max()
    widest = max((high - low for low, high in ends.values()), default=0.0) or 1.0
    with style():
        panels = make_panels(
            len(groups), where="stride average", ax=ax, height_mm=46.0, sharex=True
        )
        for panel, (title, legs) in zip(panels, groups, strict=True):
            for k, leg in enumerate(legs):
                own = table[table["leg"] == leg]
                line = "-" if k == 0 else SECOND_LEG
                panel.fill_between(own["percent"], own["low"], own["high"], color=colours[leg],
                                   alpha=0.25, linewidth=0)  # fmt: skip
                panel.plot(own["percent"], own["mean"], color=colours[leg], linestyle=line,
                           label=leg)  # fmt: skip
            own = table[table["leg"].isin(legs)]
            counts = say_counts(int(own.groupby("leg")["n_strides"].max().sum()), "stride",
                                int(own["n_animals"].max()))  # fmt: skip
            add_heading(panel, title, say_lines(counts, legs))
            panel.set_xlim(0.0, 100.0)
            middle = (ends[title][0] + ends[title][1]) / 2.0
            panel.set_ylim(middle - 0.55 * widest, middle + 0.55 * widest)
        first = table.iloc[0]
        name = str(first["signal"])
        label_outer(panels, x="Stride (%)",
                    y=with_unit(name[:1].upper() + name[1:], str(first["unit"])))  # fmt: skip
        if ax is None:
            band = Patch(color="0.8")
            figure: Any = panels[0].figure
            figure.legend([band], [str(first["band"])], loc="outside lower center")
    return panels[0]
