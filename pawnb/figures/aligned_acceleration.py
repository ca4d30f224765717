"""Acceleration in swing or stance, aligned at the greatest speed (2009, Figs. 4.13, 4.14)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import (
    add_heading,
    label_outer,
    make_panels,
    say_counts,
    with_unit,
)
from pawnb.figures.style import colour_legs, style
from pawnb.gait.cycles import ALIGNED_COLUMNS, average_cycles
from pawnb.gait.legs import find_leg_place, sort_legs
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "leg", "phase", "animal", "trial", "stride", "percent", "acceleration", "kind", "n_strides",
    "n_animals", "signal", "unit",
)  # fmt: skip


@checked_arguments
def build_aligned_acceleration_table(
    aligned: pd.DataFrame, *, legs: Sequence[str] | None = None, most: int = 60
) -> pd.DataFrame:
    """Choose the strides to draw and average them where most of them reach.

    Parameters
    ----------
    aligned : pandas.DataFrame
        From :func:`pawnb.gait.cycles.align_acceleration`, of swing or of stance.
    legs : sequence of str, optional
        Legs to show; default the left ones, as the paper, where names tell sides.
    most : int
        Draw at most so many strides a leg, spread evenly over all; means use every stride.

    Returns
    -------
    pandas.DataFrame
        ``acceleration`` at each percent; ``kind`` "stride" or "mean": the mean of the means of
        the animals, at steps that at least half of the strides reach.

    Raises
    ------
    InputError
        If a column is missing, there is no stride, swing and stance are mixed, or a leg is not
        there.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> aligned = pawnb.gait.cycles.align_acceleration(angles, gait.strides, phase="swing")
    >>> table = figures.build_aligned_acceleration_table(aligned, legs=["L2"])
    >>> table["leg"].unique().tolist()
    ['L2']
    """
    check_columns(aligned, ALIGNED_COLUMNS, where="aligned acceleration")
    kinds = list(aligned["phase"].unique())
    if len(kinds) != 1:
        raise InputError(
            f"aligned acceleration: found {' and '.join(kinds) or 'no stride'}; expected strides "
            "of swing or of stance."
        )
    there = sort_legs(aligned["leg"])
    if legs is None:
        places = {leg: find_leg_place(leg) for leg in there}
        legs = [leg for leg, place in places.items() if place and place.side == "L"] or there
    key = ["animal", "trial", "stride"]
    parts = []
    for leg in legs:
        own = aligned[aligned["leg"] == leg]
        if len(own) == 0:
            raise InputError(f"aligned acceleration: no stride of leg {leg!r}; there are "
                             f"{', '.join(there)}.")  # fmt: skip
        strides = own[key].drop_duplicates()
        about = {"n_strides": len(strides), "n_animals": own["animal"].nunique()}
        chosen = np.linspace(0, len(strides) - 1, min(most, len(strides))).round().astype(int)
        shown = own.merge(strides.iloc[np.unique(chosen)], on=key).assign(kind="stride")
        mean = average_cycles(own, value="acceleration")
        mean = mean[2 * mean["n_strides"] >= len(strides)]
        mean = mean[["percent", "mean"]].rename(columns={"mean": "acceleration"})
        mean = mean.assign(leg=leg, animal="", trial="", stride=0, kind="mean")
        parts += [shown.assign(**about), mean.assign(**about)]
    about_all = {name: aligned[name].iloc[0] for name in ("phase", "signal", "unit")}
    return pd.concat(parts, ignore_index=True).assign(**about_all)[list(COLUMNS)]


@checked_arguments
def plot_aligned_acceleration(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw each stride as a thin line and the mean as a thick one, a panel a leg.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_aligned_acceleration_table`.
    ax : matplotlib axes, optional
        Where to draw a table of a single leg; default a new figure.

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
    >>> aligned = pawnb.gait.cycles.align_acceleration(angles, gait.strides, phase="swing")
    >>> table = figures.build_aligned_acceleration_table(aligned, legs=["L2", "R2"], most=20)
    >>> ax = figures.plot_aligned_acceleration(table)
    """
    check_columns(table, COLUMNS, where="aligned acceleration")
    legs = sort_legs(table["leg"])
    colours = colour_legs(legs)
    largest = float(table["acceleration"].abs().max()) if len(table) else 0.0
    power = 3 if largest >= 5e3 else 0
    with style():
        panels = make_panels(
            len(legs), where="aligned acceleration", ax=ax, height_mm=44.0, sharex=True,
            sharey=True,
        )  # fmt: skip
        for panel, leg in zip(panels, legs, strict=True):
            own = table[table["leg"] == leg]
            strides = own[own["kind"] == "stride"]
            for _, stride in strides.groupby(["animal", "trial", "stride"], sort=False):
                panel.plot(stride["percent"], stride["acceleration"] / 10.0**power,
                           color=colours[leg], linewidth=0.3, alpha=0.45)  # fmt: skip
            mean = own[own["kind"] == "mean"]
            panel.plot(mean["percent"], mean["acceleration"] / 10.0**power, color="black",
                       linewidth=1.2)  # fmt: skip
            panel.axvline(0.0, color="0.4", linewidth=0.6, linestyle=(0, (4, 2)))
            panel.axhline(0.0, color="0.4", linewidth=0.4)
            first = own.iloc[0]
            counts = say_counts(int(first["n_strides"]), "stride", int(first["n_animals"]))
            add_heading(panel, leg, counts)
        first = table.iloc[0]
        label_outer(
            panels, x=f"{str(first['phase']).capitalize()} (%), 0: fastest",
            y=with_unit("Acceleration", f"{'10³ ' if power else ''}{first['unit']}/s²"),
        )  # fmt: skip
    return panels[0]
