"""Legs in their phase plane: velocity against position, stride by stride (2009, Fig. 4.12)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
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
from pawnb.gait.cycles import CYCLE_COLUMNS
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "leg", "animal", "trial", "stride", "percent", "value", "velocity", "kind", "n_strides",
    "n_animals", "signal", "unit",
)  # fmt: skip


@checked_arguments
def build_phase_plane_table(
    cycles: pd.DataFrame, *, legs: Sequence[str] | None = None, most: int = 60
) -> pd.DataFrame:
    """Choose the strides to draw and average the cycles of the animals.

    Parameters
    ----------
    cycles : pandas.DataFrame
        From :func:`pawnb.gait.cycles.cut_cycles`.
    legs : sequence of str, optional
        Legs to show; default all.
    most : int
        Draw at most so many strides a leg, spread evenly over all; means use every stride.

    Returns
    -------
    pandas.DataFrame
        ``value`` and ``velocity`` at each percent of the stride, ``kind`` "stride" or "mean":
        the mean of the means of the animals. ``n_strides`` and ``n_animals`` of the leg.

    Raises
    ------
    InputError
        If a column is missing, no stride is complete, or a leg is not there.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> cycles = pawnb.gait.cycles.cut_cycles(angles, gait.strides)
    >>> table = figures.build_phase_plane_table(cycles, legs=["L2"])
    >>> table["leg"].unique().tolist()
    ['L2']
    """
    check_columns(cycles, CYCLE_COLUMNS, where="cycles")
    key = ["animal", "trial", "stride"]
    whole = cycles[["value", "velocity"]].notna().all(axis=1)
    complete = whole.groupby([cycles[name] for name in ("leg", *key)]).transform("all")
    known = cycles[complete.to_numpy(dtype=bool)] if len(cycles) else cycles
    there = list(dict.fromkeys(known["leg"]))
    parts = []
    for leg in there if legs is None else legs:
        if leg not in there:
            raise InputError(f"phase plane: no complete stride of leg {leg!r}; there are those of "
                             f"{', '.join(map(str, there)) or 'no leg'}.")  # fmt: skip
        own = known[known["leg"] == leg]
        strides = own[key].drop_duplicates()
        about = {"n_strides": len(strides), "n_animals": own["animal"].nunique()}
        places = np.linspace(0, len(strides) - 1, min(most, len(strides))).round().astype(int)
        shown = own.merge(strides.iloc[np.unique(places)], on=key)
        animals = own.groupby(["animal", "percent"])[["value", "velocity"]].mean()
        mean = animals.groupby("percent").mean().reset_index()
        mean = mean.assign(leg=leg, animal="", trial="", stride=0, kind="mean")
        parts += [shown.assign(kind="stride", **about), mean.assign(**about)]
    if not parts:
        raise InputError("phase plane: no stride is complete.")
    kind = {name: cycles[name].iloc[0] for name in ("signal", "unit")}
    return pd.concat(parts, ignore_index=True).assign(**kind)[list(COLUMNS)]


@checked_arguments
def plot_phase_plane(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw each stride as a thin line and the mean cycle as a thick one.

    All panels have the same width and height in their units, wherever their middle lies, so
    that cycles can be compared by eye.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_phase_plane_table`.
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
    >>> table = figures.build_phase_plane_table(cycles, legs=["L2", "R2"], most=20)
    >>> ax = figures.plot_phase_plane(table)
    """
    check_columns(table, COLUMNS, where="phase plane")
    groups = group_legs(table["leg"])
    colours = colour_legs([leg for _, legs in groups for leg in legs])
    with style():
        panels = make_panels(len(groups), where="phase plane", ax=ax, height_mm=46.0, sharey=True)
        widest = max(np.ptp(table.loc[table["leg"].isin(legs), "value"]) for _, legs in groups)
        for panel, (title, legs) in zip(panels, groups, strict=True):
            own = table[table["leg"].isin(legs)]
            for k, leg in enumerate(legs):
                mine = own[own["leg"] == leg]
                strides = mine[mine["kind"] == "stride"]
                for _, stride in strides.groupby(["animal", "trial", "stride"], sort=False):
                    panel.plot(stride["value"], stride["velocity"], color=colours[leg],
                               linewidth=0.3, alpha=0.35)  # fmt: skip
                mean = mine[mine["kind"] == "mean"]
                panel.plot(mean["value"], mean["velocity"], color="black", linewidth=1.2,
                           linestyle="-" if k == 0 else SECOND_LEG, label=leg)  # fmt: skip
            middle = (own["value"].min() + own["value"].max()) / 2.0
            panel.set_xlim(middle - 0.55 * widest, middle + 0.55 * widest)
            n = own.groupby("leg")["n_strides"].first().sum()
            counts = say_counts(int(n), "stride", int(own["n_animals"].max()))
            add_heading(panel, title, say_lines(counts, legs))
        name, unit = str(table["signal"].iloc[0]), str(table["unit"].iloc[0])
        across = with_unit(name[:1].upper() + name[1:], unit)
        label_outer(panels, x=across, y=with_unit("Velocity", f"{unit}/s"))
    return panels[0]
