"""Curves over the stride of two groups and more, and the stretches in which they differ."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from pawnb.figures.long_names import letters_in, width_of, wrap_name
from pawnb.figures.panels import add_heading, label_outer, make_panels, with_unit
from pawnb.figures.style import OKABE_ITO, small_pt, style
from pawnb.gait.cycles import AVERAGE_COLUMNS, average_cycles
from pawnb.gait.cycles.tests import CLUSTER_COLUMNS, compare_cycles
from pawnb.gait.legs import sort_legs
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "row",
    "group",
    *AVERAGE_COLUMNS,
    *(c for c in CLUSTER_COLUMNS if c not in AVERAGE_COLUMNS),
)
_COLOURS = ("blue", "vermillion", "bluish green", "reddish purple", "orange", "black")
_LINES = ("-", (0, (3, 1.2)), (0, (1, 1)), (0, (5, 1, 1, 1)))
_SHOWN_P = 0.05
_SMALL = 0.75
"""Width of the letters of details, as a share of the others."""
_LINE_LETTERS = 8
"""Room that the line beside a name in the legend takes, letters."""


@checked_arguments
def build_cycle_comparison_table(
    cycles: pd.DataFrame, *, group: str = "group", paired: bool = False
) -> pd.DataFrame:
    """Average curves of each group over animals, and test where they differ.

    Parameters
    ----------
    cycles : pandas.DataFrame
        From :func:`pawnb.gait.cycles.cut_cycles`, with a column of groups.
    group : str
        Column of groups, or of conditions.
    paired : bool
        Whether the groups are conditions of the same animals.

    Returns
    -------
    pandas.DataFrame
        ``COLUMNS``: ``row`` is ``curve`` (the columns of
        :func:`pawnb.gait.cycles.average_cycles`, for each ``group``) or ``cluster`` (those of
        :func:`pawnb.gait.cycles.tests.compare_cycles`).

    Raises
    ------
    InputError
        As :func:`pawnb.gait.cycles.tests.compare_cycles`.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> cycles = pawnb.gait.cycles.cut_cycles(angles, gait.strides)
    >>> cycles["group"] = np.where(cycles["animal"] < "spider-03", "young", "old")
    >>> table = figures.build_cycle_comparison_table(cycles)
    """
    clusters = compare_cycles(cycles, group=group, paired=paired)
    names = list(dict.fromkeys(cycles[group].dropna().astype(str)))
    curves = [
        average_cycles(cycles[cycles[group].astype(str) == name]).assign(group=name, row="curve")
        for name in names
    ]
    table = pd.concat([*curves, clusters.assign(row="cluster")], ignore_index=True)
    return table.reindex(columns=list(COLUMNS))


@checked_arguments
def plot_cycle_comparison(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the mean curves with their bands; bars below are clusters with p of 0.05 or less.

    Of three groups and more that p is adjusted for the number of comparisons.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_cycle_comparison_table`.
    ax : matplotlib axes, optional
        Where to draw a table of a single leg; default a new figure with a panel a leg.

    Returns
    -------
    matplotlib axes
        The first panel.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or there are several legs for one axes.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> cycles = pawnb.gait.cycles.cut_cycles(angles, gait.strides)
    >>> cycles = cycles[cycles["leg"].isin(["L2", "R2"])]
    >>> cycles["group"] = np.where(cycles["animal"] < "spider-03", "young", "old")
    >>> ax = figures.plot_cycle_comparison(figures.build_cycle_comparison_table(cycles))
    """
    check_columns(table, COLUMNS, where="comparison of curves")
    curves, clusters = (table[table["row"] == name] for name in ("curve", "cluster"))
    legs = sort_legs(curves["leg"].astype(str))
    groups = list(dict.fromkeys(curves["group"].astype(str)))
    with style():
        panels = make_panels(
            len(legs), where="comparison of curves", ax=ax, sharex=True, sharey=True,
            height_mm=_height_mm(len(legs)), columns=None if len(legs) <= 6 else 4,
        )  # fmt: skip
        drawn: list[Any] = []
        room = letters_in(_panel_mm(panels), size=_SMALL)
        for panel, leg in zip(panels, legs, strict=True):
            own = curves[curves["leg"] == leg]
            drawn = [_draw_curve(panel, own[own["group"] == g], k) for k, g in enumerate(groups)]
            panel.set_xlim(0.0, 100.0)
            found = clusters[(clusters["leg"] == leg) & (clusters["p_adjusted"] <= _SHOWN_P)]
            counts = own.groupby("group", sort=False)["n_animals"].max()
            add_heading(panel, leg, _say_animals(counts, room) + _say_p(found))
        _draw_clusters(panels, legs, clusters, curves)
        first = curves.iloc[0]
        name = str(first["signal"])
        label_outer(panels, x="Stride (%)",
                    y=with_unit(name[:1].upper() + name[1:], str(first["unit"])))  # fmt: skip
        if ax is None:
            figure: Any = panels[0].figure
            notes = dict.fromkeys(clusters["note"].fillna("").astype(str))
            said = "\n".join([f"Bands: {first['band']}", *filter(None, notes)])
            wide = letters_in(25.4 * figure.get_size_inches()[0] - 10.0)
            beside = sum(len(name) + _LINE_LETTERS for name in groups) <= wide
            names = [wrap_name(name, wide - _LINE_LETTERS) for name in groups]
            figure.legend(drawn, names, loc="outside lower center", title=said,
                          ncols=len(groups) if beside else 1)  # fmt: skip
            if not beside:
                lines = sum(name.count("\n") + 1 for name in names) - 1
                width, height = figure.get_size_inches()
                figure.set_size_inches(width, height + lines * width_of(2) / 25.4)
    return panels[0]


def _panel_mm(panels: list[Any]) -> float:
    """Return about how wide a panel is, mm."""
    place = panels[0].get_subplotspec()
    beside = 1 if place is None else place.get_gridspec().ncols
    return float(25.4 * panels[0].figure.get_size_inches()[0] / beside)


def _say_animals(counts: pd.Series[float], room: int) -> str:
    """Say how many animals each group has; without the names where they are long."""
    said = "animals " + ", ".join(f"{name}: {n:.0f}" for name, n in counts.items())
    if len(said) <= room:
        return said
    return "animals " + ", ".join(f"{n:.0f}" for n in counts)  # in the order of the legend


def _height_mm(n_legs: int) -> float:
    """Return the height of a row of panels; of one row, with the legend below it."""
    return 62.0 if n_legs <= 2 else 46.0


def _draw_curve(ax: Any, own: pd.DataFrame, k: int) -> Any:
    """Draw the curve of a group with its band; return the line."""
    colour = OKABE_ITO[_COLOURS[k % len(_COLOURS)]]
    ax.fill_between(own["percent"], own["low"], own["high"], color=colour, alpha=0.2, linewidth=0)
    (line,) = ax.plot(own["percent"], own["mean"], color=colour, linestyle=_LINES[k % len(_LINES)])
    return line


def _say_p(found: pd.DataFrame) -> str:
    """Return p of the clusters that are drawn, in words."""
    if found.empty:
        return ""
    p = found["p_adjusted"]
    name = "p" if (p == found["p"]).all() else "adj. p"  # of three groups and more
    said = ", ".join("< 0.001" if one < 0.001 else f"{one:.3f}" for one in p)
    return f"\n{name} {said}"


def _draw_clusters(
    panels: list[Any], legs: list[str], clusters: pd.DataFrame, curves: pd.DataFrame
) -> None:
    """Draw bars below the curves, one row for each two groups."""
    low = float(curves[["mean", "low"]].min().min())
    high = float(curves[["mean", "high"]].max().max())
    pairs = list(dict.fromkeys(zip(clusters["group_a"], clusters["group_b"], strict=True)))
    room = letters_in(_panel_mm(panels), size=_SMALL)
    step = 0.06 * (high - low) or 0.1
    for panel, leg in zip(panels, legs, strict=True):
        own = clusters[(clusters["leg"] == leg) & (clusters["p_adjusted"] <= _SHOWN_P)]
        for row in own.to_dict("records"):
            between = (row["group_a"], row["group_b"])
            y = low - (1.0 + pairs.index(between)) * step
            first, last = float(row["start_percent"]), float(row["stop_percent"])
            ends = [(first, last)]
            if last < first:  # it goes on over the end of the stride
                ends = [(first, 100.0), (0.0, last)]
            for start, stop in ends:
                panel.plot([start, stop], [y, y], color="black", linewidth=2.2,
                           solid_capstyle="butt")  # fmt: skip
            if len(pairs) > 1:
                panel.annotate(wrap_name("-".join(between), room), (first, y), ha="left", va="top",
                               fontsize=small_pt())  # fmt: skip
    panels[0].set_ylim(low - (len(pairs) + 1.2) * step, high + step)
