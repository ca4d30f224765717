"""Own animals among others: speed against size over species (paper 2009, Fig. 4.3, 4.4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import draw_points, new_axes, use_log_axes
from pawnb.figures.style import OKABE_ITO, figure_size, mark_animals, small_pt, style
from pawnb.gait.regression import fit_power
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "row", "name", "group", "own", "x", "y", "low", "high", "line", "n", "a", "b", "ci_low",
    "ci_high", "r2", "p",
)  # fmt: skip
_STEPS = 60
_LINE_STYLES = ("-", "--", ":", "-.")


@checked_arguments
def build_scaling_table(
    reference: pd.DataFrame,
    own: pd.DataFrame | None = None,
    *,
    size: str,
    value: str,
    group: str = "group",
    without: Sequence[str] = (),
    level: float = 0.95,
) -> pd.DataFrame:
    """Fit power laws to a table of species, without and with one's own.

    Parameters
    ----------
    reference : pandas.DataFrame
        One row a species (or animal): ``name``, a column of groups, size and value, all in
        the units of ``own``. No such table comes with pawnb: it is the user's.
    own : pandas.DataFrame, optional
        The same columns for one's own species, a row each.
    size, value : str
        Columns: for instance mass_kg and speed.
    group : str
        Column of groups, such as families.
    without : sequence of str
        Groups, each of which is also left out once, to see whether a law rests on it.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``row`` is ``point`` (``name, group, own, x, y``) or ``line`` (``x, y, low, high`` of
        the law called ``line``, with ``n, a, b, ci_low, ci_high, r2, p``). The laws:
        ``reference``, ``with own``, and ``without ...`` of the reference.

    Raises
    ------
    InputError
        If a column is missing, a value is not above 0, a group to leave out is not there, or
        fewer than three points are left.

    Examples
    --------
    >>> others = pd.DataFrame(
    ...     {"name": list("abcdef"), "group": ["wolf"] * 3 + ["crab"] * 3,
    ...      "length_mm": [4.0, 6.0, 9.0, 12.0, 15.0, 20.0],
    ...      "speed_mm_s": [90.0, 130.0, 180.0, 260.0, 300.0, 420.0]}
    ... )
    >>> table = figures.build_scaling_table(others, size="length_mm", value="speed_mm_s")
    >>> len(table) >= 6
    True
    """
    needed = ["name", group, size, value]
    check_columns(reference, needed, where="reference table")
    tables = [reference[needed].assign(own=False)]
    if own is not None:
        check_columns(own, needed, where="own animals")
        tables.append(own[needed].assign(own=True))
    points = pd.concat(tables, ignore_index=True).dropna(subset=[size, value])
    points = points.rename(columns={group: "group", size: "x", value: "y"}).assign(row="point")
    others = points[~points["own"]]
    absent = [name for name in without if name not in set(others["group"])]
    if absent:
        raise InputError(f"reference table: no group {absent[0]!r} to leave out.")
    laws = {"reference": others}
    if own is not None:
        laws["with own"] = points
    laws |= {f"without {name}": others[others["group"] != name] for name in without}
    parts = [points]
    for name, used in laws.items():
        line = fit_power(used["x"].to_numpy(float), used["y"].to_numpy(float), level=level)
        grid = line.predict(np.geomspace(line.x_low, line.x_high, _STEPS))
        parts.append(
            grid.rename(columns={"fit": "y"}).assign(
                row="line", line=name, own=False, n=line.n, a=line.a, b=line.b,
                ci_low=line.b_low, ci_high=line.b_high, r2=line.r2, p=line.p,
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True).reindex(columns=list(COLUMNS))


@checked_arguments
def plot_scaling(
    table: pd.DataFrame,
    *,
    ax: Axes | None = None,
    size_name: str = "Size",
    value_name: str = "Value",
) -> Axes:
    """Draw species by group on logarithmic axes, one's own filled, with the power laws.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_scaling_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default a new figure, one column wide.
    size_name, value_name : str
        What the axes are called, with units.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    InputError
        If a column is missing or the table has no point.

    Examples
    --------
    >>> others = pd.DataFrame(
    ...     {"name": list("abcdef"), "group": ["wolf"] * 3 + ["crab"] * 3,
    ...      "length_mm": [4.0, 6.0, 9.0, 12.0, 15.0, 20.0],
    ...      "speed_mm_s": [90.0, 130.0, 180.0, 260.0, 300.0, 420.0]}
    ... )
    >>> table = figures.build_scaling_table(others, size="length_mm", value="speed_mm_s")
    >>> ax = figures.plot_scaling(table, size_name="Length (mm)", value_name="Speed (mm/s)")
    """
    check_columns(table, COLUMNS, where="scaling figure")
    points = table[table["row"] == "point"]
    if len(points) == 0:
        raise InputError("scaling figure: the table has no point.")

    with style():
        if ax is None:
            _, ax = new_axes(figsize=figure_size(1, 90.0))
        marks = mark_animals(points["group"])
        shown = []
        for group, species in points.groupby("group", sort=True):
            mark = marks[str(group)]
            for own in (False, True):
                some = species[species["own"].astype(bool) == own]
                if len(some) == 0:
                    continue
                look = {"color": OKABE_ITO["vermillion"], "markersize": 5.0, "zorder": 4}
                look = look if own else {"color": "0.35", "label": str(group)}
                words = "\n".join(dict.fromkeys(some["name"].astype(str)))
                look |= {"label": words} if own else {}
                shown.append(
                    draw_points(ax, some["x"], some["y"], mark=mark._replace(filled=own), **look)
                )
        drawn = _draw_laws(ax, table[table["row"] == "line"])
        use_log_axes(ax)
        ax.set_xlabel(size_name)
        ax.set_ylabel(value_name)
        ax.legend(handles=drawn, loc="upper left", fontsize=small_pt(), handlelength=1.8)
        ax.figure.legend(
            handles=shown, loc="outside lower center", ncols=3, handletextpad=0.2,
            columnspacing=1.0,
        )  # fmt: skip
    return ax


def _draw_laws(ax: Any, lines: pd.DataFrame) -> list[Any]:
    """Draw the power laws, the first with its band; return the lines."""
    drawn = []
    for k, (name, line) in enumerate(lines.groupby("line", sort=False)):
        first = line.iloc[0]
        colour = OKABE_ITO["blue"] if k == 0 else "black"
        if k == 0:
            ax.fill_between(line["x"], line["low"], line["high"], color=colour, alpha=0.15,
                            linewidth=0.0)  # fmt: skip
        words = f"{name}: x^{first['b']:.3g}, r² = {first['r2']:.2f}, n = {first['n']:.0f}"
        drawn += ax.plot(
            line["x"], line["y"], color=colour, linestyle=_LINE_STYLES[k % 4], label=words
        )
    return drawn
