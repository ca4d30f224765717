"""Comparison of tracking methods: errors, time, reprojection error (paper 2019, Fig. 7)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from pawnb.errors import InputError
from pawnb.figures.panels import open_grid
from pawnb.figures.style import OKABE_ITO, figure_size, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("panel", "method", "view", "kind", "trial", "value", "n", "mean", "sd", "corrections")

PANELS = {
    "major": "Major errors\nper 1000 frames",
    "minor": "Minor errors\nper 1000 frames",
    "time": "Time per 1000\nframes (s)",
    "reprojection": "Reprojection error (px)",
}
_UNCORRECTED = "no corrections made"
_MEASURES = {
    "major": ("major_per_1000", "major_alone_per_1000"),
    "minor": ("minor_per_1000", "minor_alone_per_1000"),
    "time": ("time_s_per_1000", "time_s_per_1000"),
}
_NEEDED = ("trial", "method", *dict.fromkeys(name for pair in _MEASURES.values() for name in pair))
_NEEDED_ERRORS = ("trial", "method", "view", "kind", "n", "mean_px")
_COLOURS = ("blue", "orange", "bluish green", "reddish purple", "sky blue", "vermillion")


@checked_arguments
def build_compare_methods_table(trials: pd.DataFrame, reprojection: pd.DataFrame) -> pd.DataFrame:
    """Gather what the comparison of methods shows: one row a trial in each group.

    Parameters
    ----------
    trials : pandas.DataFrame
        ``comparison.csv``: one row a trial and method. Errors with corrections are shown
        where they were counted, else those without.
    reprojection : pandas.DataFrame
        ``reprojection.csv``: may be empty.

    Returns
    -------
    pandas.DataFrame
        ``panel`` (major, minor, time, reprojection), ``method``, ``view`` and ``kind`` (blank
        but for reprojection), ``trial``, ``value``; and, the same in each row of a group,
        ``n`` trials, ``mean`` and ``sd`` (NaN of one trial). ``corrections`` says whether
        errors were counted with them (made, none; blank but for errors).

    Raises
    ------
    InputError
        If a column is missing or there is no trial.

    Examples
    --------
    >>> rates = {"major_per_1000": [3.0, 8.0], "minor_per_1000": [5.0, 9.0],
    ...          "major_alone_per_1000": [4.0, 9.0], "minor_alone_per_1000": [6.0, 9.0],
    ...          "time_s_per_1000": [60.0, 40.0]}
    >>> trials = pd.DataFrame({"trial": "t1", "method": ["paper", "slic-3d"], **rates})
    >>> errors = pd.DataFrame(
    ...     {"trial": "t1", "method": "paper", "view": "cam1", "point": ["FR", "HR"],
    ...      "kind": ["front", "hind"], "n": 100, "mean_px": [3.0, 2.0]}
    ... )
    >>> table = figures.build_compare_methods_table(trials, errors)
    """
    check_columns(trials, _NEEDED, where="comparison")
    check_columns(reprojection, _NEEDED_ERRORS, where="reprojection")
    if len(trials) == 0:
        raise InputError("comparison of methods: no trials; expected at least one.")
    rows: list[tuple[Any, ...]] = []
    made = {}
    for panel, (corrected, alone) in _MEASURES.items():
        name = alone if trials[corrected].isna().any() else corrected
        if corrected != alone:
            made[panel] = "made" if name == corrected else "none"
        rows += [
            (panel, method, "", "", trial, value)
            for method, trial, value in zip(
                trials["method"], trials["trial"], trials[name], strict=True
            )
        ]
    for group, own in reprojection.groupby(["method", "view", "kind", "trial"], sort=False):
        method, view, kind, trial = group
        value = float(np.average(own["mean_px"], weights=own["n"]))
        rows.append(("reprojection", method, view, kind, trial, value))
    table = pd.DataFrame(rows, columns=list(COLUMNS[:6]))
    groups = table.groupby(["panel", "method", "view", "kind"], sort=False)["value"]
    return table.assign(
        n=groups.transform("size"), mean=groups.transform("mean"), sd=groups.transform("std"),
        corrections=table["panel"].map(made).fillna(""),
    )  # fmt: skip


@checked_arguments
def plot_compare_methods(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the comparison: bars are means over trials, whiskers one SD, dots the trials.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_compare_methods_table`.
    ax : matplotlib axes, optional
        The panels divide its place in its figure; default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        The first of four panels; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> rates = {"major_per_1000": [3.0, 8.0], "minor_per_1000": [5.0, 9.0],
    ...          "major_alone_per_1000": [4.0, 9.0], "minor_alone_per_1000": [6.0, 9.0],
    ...          "time_s_per_1000": [60.0, 40.0]}
    >>> trials = pd.DataFrame({"trial": "t1", "method": ["paper", "slic-3d"], **rates})
    >>> errors = pd.DataFrame(
    ...     {"trial": "t1", "method": "paper", "view": "cam1", "point": ["FR", "HR"],
    ...      "kind": ["front", "hind"], "n": 100, "mean_px": [3.0, 2.0]}
    ... )
    >>> ax = figures.plot_compare_methods(figures.build_compare_methods_table(trials, errors))
    """
    check_columns(table, COLUMNS, where="comparison of methods")
    if len(table) == 0:
        raise InputError("comparison of methods: the table is empty.")
    methods = list(dict.fromkeys(table["method"]))
    colours = {m: OKABE_ITO[_COLOURS[k % len(_COLOURS)]] for k, m in enumerate(methods)}
    with style():
        # the last panel holds a group for each camera and kind of paw
        figure, grid = open_grid(
            1, 4, where="comparison of methods", size=figure_size(2, 75.0), ax=ax,
            width_ratios=[1.0, 1.0, 1.0, 2.6],
        )  # fmt: skip
        axes = [figure.add_subplot(grid[k]) for k in range(4)]
        for letter, place, panel in zip("abcd", axes, PANELS, strict=True):
            own = table[table["panel"] == panel]
            groups = list(dict.fromkeys(zip(own["view"], own["kind"], strict=True)))
            groups.sort(key=lambda group: (group[1], group[0]))
            for i, group in enumerate(groups):
                here = own[(own["view"] == group[0]) & (own["kind"] == group[1])]
                _draw_group(place, here, methods, colours, centre=i)
            alone = (own["corrections"] == "none").any()
            place.set_ylabel(f"{PANELS[panel]},\n{_UNCORRECTED}" if alone else PANELS[panel])
            place.set_title(letter, loc="left", fontweight="bold")
            place.set_ylim(bottom=0.0)
            if panel == "reprojection":
                # eight groups share half a page: upright names would run into each other
                names = [f"{view} {kind}" for view, kind in groups]
                place.set_xticks(range(len(groups)), names, rotation=90)
            else:
                place.set_xticks([])
        handles = [Patch(color=colours[m]) for m in methods]
        n = table[table["panel"] == "time"].groupby("method")["trial"].nunique()
        words = [f"{m} ({n[m]} trial{'s' * int(n[m] != 1)})" for m in methods]
        figure.legend(handles, words, loc="outside lower center", ncols=len(methods),
                      frameon=False)  # fmt: skip
    return axes[0]


def _draw_group(
    ax: Axes, own: pd.DataFrame, methods: list[str], colours: dict[str, str], *, centre: float
) -> None:
    """Draw one bar a method about a place of the axis."""
    width = 0.8 / len(methods)
    for k, method in enumerate(methods):
        here = own[own["method"] == method]
        if len(here) == 0:
            continue
        x = centre + (k - (len(methods) - 1) / 2.0) * width
        mean, sd = float(here["mean"].iloc[0]), float(here["sd"].iloc[0])
        ax.bar(x, mean, width=0.9 * width, color=colours[method])
        if np.isfinite(sd):
            ax.errorbar(x, mean, yerr=[[min(sd, mean)], [sd]], color="black", linewidth=0.8,
                        capsize=1.5)  # fmt: skip
        ax.plot(np.full(len(here), x), here["value"], linestyle="none", marker="o",
                markersize=2.0, markerfacecolor="white", markeredgecolor="black",
                markeredgewidth=0.4)  # fmt: skip
