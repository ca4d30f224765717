"""All measures of all animals at once: their first principal components."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pawnb.errors import InputError
from pawnb.figures.long_names import wrap_name
from pawnb.figures.measure_heat_map import say_measure
from pawnb.figures.panels import add_animal_legend, add_letter, draw_points, open_grid
from pawnb.figures.style import OKABE_ITO, figure_size, mark_animals, small_pt, style
from pawnb.gait.overview import measures_by_animal, principal_components, standardise
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("row", "animal", "group", "measure", "component", "value", "explained", "note")
_MOST_LOADINGS = 12
_LEGEND_LETTERS = 22
_MOST_BESIDE_LEGEND = 12
"""Animals among which there is room for a legend; those of more are not named, either."""
_GROUPS = ("blue", "vermillion", "bluish green", "reddish purple", "orange", "black")


@checked_arguments
def build_measure_components_table(
    strides: pd.DataFrame,
    measures: Sequence[str],
    *,
    groups: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Find the principal components of the standardised measures of animals.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides, with columns animal and leg; the legs of an animal count alike.
    measures : sequence of str
        Columns; those that an animal lacks or that are the same in all are left out.
    groups : mapping, optional
        Animal to its group.

    Returns
    -------
    pandas.DataFrame
        ``COLUMNS``: ``row`` is ``score`` (of an animal) or ``loading`` (of a measure), on
        a ``component``, which explains a share ``explained`` of the variance. ``note`` says what
        so few animals allow.

    Raises
    ------
    InputError
        If there are fewer than three animals or two measures.

    Examples
    --------
    >>> measures = ["frequency_hz", "duty_factor", "stride_length"]
    >>> table = figures.build_measure_components_table(gait.strides, measures)
    """
    found = principal_components(standardise(measures_by_animal(strides, measures)).z)
    rows: list[dict[str, Any]] = []
    for name, share in found.explained.items():
        about = {"component": name, "explained": share, "note": found.note}
        rows += [
            {"row": "score", "animal": str(animal), "value": value,
             "group": str((groups or {}).get(str(animal), "")), **about}
            for animal, value in found.scores[name].items()
        ]  # fmt: skip
        rows += [
            {"row": "loading", "measure": measure, "value": value, **about}
            for measure, value in found.loadings[name].items()
        ]
    return pd.DataFrame(rows).reindex(columns=list(COLUMNS))


@checked_arguments
def plot_measure_components(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw animals on the first two principal components, and what these are made of.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_measure_components_table`.
    ax : matplotlib axes, optional
        Both panels take its place; default a new figure, two columns wide.

    Returns
    -------
    matplotlib axes
        The panel of the animals; the other has the measures that weigh most, at most twelve.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> measures = ["frequency_hz", "duty_factor", "stride_length", "swing_s", "speed"]
    >>> table = figures.build_measure_components_table(gait.strides, measures)
    >>> ax = figures.plot_measure_components(table)
    """
    check_columns(table, COLUMNS, where="components of measures")
    if len(table) == 0:
        raise InputError("components of measures: the table is empty.")
    names = list(dict.fromkeys(table["component"].astype(str)))[:2]
    share = table.drop_duplicates("component").set_index("component")["explained"]
    said = {name: f"{name} ({100 * share[name]:.0f} % of variance)" for name in names}
    with style():
        figure, grid = open_grid(
            1, 2, where="components of measures", size=figure_size(2, 78.0), ax=ax,
            width_ratios=(1.0, 1.0),
        )  # fmt: skip
        left, right = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        for k, panel in enumerate((left, right)):
            add_letter(panel, k)
        _draw_scores(left, table[table["row"] == "score"], names, said)
        _draw_loadings(right, table[table["row"] == "loading"], names)
        note = str(table["note"].iloc[0] or "")
        if note and note != "nan":
            words = "\n".join(textwrap.wrap(note, 52))
            left.annotate(words, (0.0, 1.0), xycoords="axes fraction", xytext=(10.0, 2.0),
                          textcoords="offset points", va="bottom", fontsize=small_pt())  # fmt: skip
    return left


def _draw_scores(ax: Any, scores: pd.DataFrame, names: list[str], said: Mapping[str, str]) -> None:
    """Draw a point an animal, in the colour of its group."""
    groups = sorted(scores["group"].astype(str).unique())
    colours = {g: OKABE_ITO[_GROUPS[k % len(_GROUPS)]] for k, g in enumerate(groups)}
    marks = mark_animals(scores["animal"])
    for line in (ax.axhline, ax.axvline):
        line(0.0, color="0.85", linewidth=0.6, zorder=0)
    for animal, own in scores.groupby("animal", sort=True):
        place = own.set_index("component")["value"]
        y = float(place[names[1]]) if len(names) > 1 else 0.0
        colour = colours[str(own["group"].iloc[0])] if len(groups) > 1 else "black"
        draw_points(ax, [float(place[names[0]])], [y], mark=marks[str(animal)], color=colour,
                    markersize=5.0, clip_on=False, zorder=3)  # fmt: skip
    ax.set_xlabel(said[names[0]])
    ax.set_ylabel(said[names[1]] if len(names) > 1 else "")
    ax.margins(0.12)
    if len(groups) > 1:
        handles = [Line2D([], [], color=colours[g], linewidth=3.0) for g in groups]
        crowded = len(marks) > _MOST_BESIDE_LEGEND
        named = [wrap_name(group, _LEGEND_LETTERS) for group in groups]
        spot: dict[str, Any] = (
            {"loc": "outside lower left", "ncols": len(groups)} if crowded else {}
        )
        (ax.figure if crowded else ax).legend(
            handles, named, **spot, fontsize=small_pt(), handlelength=1.0
        )
    add_animal_legend(ax, marks)


def _draw_loadings(ax: Any, loadings: pd.DataFrame, names: list[str]) -> None:
    """Draw the measures that weigh most on either component."""
    table = loadings.pivot_table(index="measure", columns="component", values="value")[names]
    table = table.loc[list(dict.fromkeys(loadings["measure"]))]
    order = np.argsort(-table.abs().max(axis=1).to_numpy(), kind="stable")[:_MOST_LOADINGS]
    shown = table.iloc[np.sort(order)]
    ax.axvline(0.0, color="0.85", linewidth=0.6, zorder=0)
    rows = np.arange(len(shown))
    for k, (name, marker) in enumerate(zip(names, ("o", "s"), strict=False)):
        colour = ("black", "white")[k]
        ax.plot(shown[name], rows + 0.14 * (2 * k - 1), linestyle="none", marker=marker,
                markersize=3.5, markerfacecolor=colour, markeredgecolor="black",
                markeredgewidth=0.6, label=name, clip_on=False)  # fmt: skip
    for row in rows:
        ax.axhline(row, color="0.92", linewidth=0.6, zorder=0)
    ax.set_yticks(rows, [say_measure(str(name)) for name in shown.index])
    ax.set_ylim(len(shown) - 0.4, -0.6)
    widest = math.ceil(10.0 * float(shown.abs().to_numpy().max())) / 10.0
    ax.set_xlim(-widest, widest)
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel("Loading (−1 to 1)")
    # beside the letter, where no mark of it is taken for a loading
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2,
              fontsize=small_pt(), handletextpad=0.2)  # fmt: skip
