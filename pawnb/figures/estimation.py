"""Groups of animals side by side, and their differences with intervals (estimation plot)."""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.long_names import letters_in, wrap_name
from pawnb.figures.panels import add_animal_legend, add_letter, draw_points, open_grid
from pawnb.figures.style import figure_size, get_style, mark_animals, small_pt, style
from pawnb.gait.groups import compare_groups, mean_by_animal
from pawnb.gait.groups.shared_names import keep_shared
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "row", "measure", "group", "against", "animal", "value", "ci_low", "ci_high", "effect", "p",
    "p_adjusted", "n", "n_animals", "paired", "counts",
)  # fmt: skip
_FROM_COMPARISON = ("ci_low", "ci_high", "effect", "p", "p_adjusted")
_AXIS_SHARE = 0.7
"""Of the width of the figure, without the numbers beside it."""
_NOT_COMPARED = "0.72"
"""Grey of animals without a partner: seen, but not in mean or difference."""


@checked_arguments
def build_estimation_table(
    table: pd.DataFrame,
    measure: str,
    *,
    group: str = "group",
    paired: bool = False,
    reference: str | None = None,
    average_over: str | None = None,
    level: float = 0.95,
) -> pd.DataFrame:
    """Take animals' means, group means, and differences of groups with their intervals.

    Parameters
    ----------
    table : pandas.DataFrame
        Strides or trials: animal, the group, the measure (no phase: those have no axis).
    measure : str
        Column to compare.
    group : str
        Column of the group or condition.
    paired : bool
        Whether the groups are conditions of the same animals.
    reference : str, optional
        Group the others are drawn against; default the one that comes first. p is adjusted
        over all pairs of groups, also those that are not drawn.
    average_over : str, optional
        Column, for instance leg, whose every name counts alike in an animal's mean; as in
        compare_groups, of those that all animals have.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``row`` is ``animal`` (mean of one animal's ``n`` values), ``mean`` (of a group's
        animals) or ``difference`` (``group`` less ``against``, from
        :func:`pawnb.gait.groups.compare_groups`, with Hedges' g as ``effect``). ``counts`` is
        whether an animal is compared: of conditions, one that lacks its partner is not, and
        is not in the ``mean`` either.

    Raises
    ------
    InputError
        As compare_groups does.

    Examples
    --------
    >>> group = {"spider-01": "a", "spider-02": "a", "spider-03": "b", "spider-04": "b"}
    >>> strides = gait.strides.assign(group=gait.strides["animal"].map(group))
    >>> table = figures.build_estimation_table(strides, "duty_factor", average_over="leg")
    >>> table["row"].value_counts().to_dict()
    {'animal': 4, 'mean': 2, 'difference': 1}
    """
    columns = ["animal", group, measure, *([] if average_over is None else [average_over])]
    check_columns(table, columns, where="estimation plot")
    known = table[columns].dropna()
    if average_over is not None:
        known, _ = keep_shared(known, average_over, group=group, paired=paired)
    names = list(dict.fromkeys(known[group].astype(str)))
    if not names:
        raise InputError(f"estimation plot: no value of {measure!r} with a {group}.")
    found = compare_groups(
        known, [measure], group=group, paired=paired, level=level, average_over=average_over
    )
    drawn = _against(found, names, reference)
    one = names[0] if reference is None else str(reference)
    own = {name: known[known[group].astype(str) == name].astype({"animal": str}) for name in names}
    compared = _compared({name: set(part["animal"]) for name, part in own.items()}, one, paired)
    rows: list[dict[str, Any]] = []
    for name, part in own.items():
        means = mean_by_animal(part, measure, average_over=average_over)
        sizes = part["animal"].value_counts().to_dict()
        rows += [
            {"row": "animal", "group": name, "animal": animal, "value": mean, "n": sizes[animal],
             "counts": animal in compared[name]}
            for animal, mean in means.items()
        ]  # fmt: skip
        means = means[means.index.isin(compared[name])]
        rows.append({"row": "mean", "group": name, "value": float(means.mean()), "counts": True,
                     "n": sum(sizes[a] for a in means.index), "n_animals": len(means)})  # fmt: skip
    for pair in drawn:
        rows.append({"row": "difference", "group": pair["group_b"], "against": pair["group_a"],
                     "value": pair["difference"], "n": pair["n_a"] + pair["n_b"], "counts": True,
                     "n_animals": pair["n_animals_a"] + pair["n_animals_b"] * (not paired),
                     **{name: pair[name] for name in _FROM_COMPARISON}})  # fmt: skip
    whole = pd.DataFrame(rows).assign(measure=measure, paired=paired)
    return whole.reindex(columns=list(COLUMNS))


def _compared(animals: dict[str, set[str]], reference: str, paired: bool) -> dict[str, set[str]]:
    """Return the animals of each group that are compared: of conditions, those with a partner."""
    if not paired:
        return animals
    others = set().union(*(own for name, own in animals.items() if name != reference))
    return {
        name: own & (others if name == reference else animals[reference])
        for name, own in animals.items()
    }


def _against(
    found: pd.DataFrame, names: list[str], reference: str | None
) -> list[dict[Hashable, Any]]:
    """Return the comparisons with one group, that group being taken away."""
    one = names[0] if reference is None else str(reference)
    if one not in names:
        raise InputError(f"reference is {reference!r}; expected one of the groups {names}.")
    turned = {"group_a": "group_b", "group_b": "group_a", "n_a": "n_b", "n_b": "n_a",
              "n_animals_a": "n_animals_b", "n_animals_b": "n_animals_a"}  # fmt: skip
    rows = []
    for pair in found.to_dict("records"):
        if pair["group_b"] == one:  # b less a, seen from the other side
            pair |= {name: pair[other] for name, other in turned.items()}
            low, high = -pair["ci_high"], -pair["ci_low"]
            pair |= {"difference": -pair["difference"], "ci_low": low, "ci_high": high}
            pair |= {"effect": -pair["effect"]}
        if pair["group_a"] == one:
            rows.append(pair)
    return rows


@checked_arguments
def plot_estimation(
    table: pd.DataFrame, *, ax: Axes | None = None, label: str | None = None
) -> Axes:
    """Draw each animal and the means of groups above, the differences with intervals below.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_estimation_table`.
    ax : matplotlib axes, optional
        The panels divide its place in its figure; default a new figure.
    label : str, optional
        What the measure is called, with its unit: ``"Stride length (mm)"``.

    Returns
    -------
    matplotlib axes
        The upper panel; the lower comes after it in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> group = {"spider-01": "a", "spider-02": "a", "spider-03": "b", "spider-04": "b"}
    >>> strides = gait.strides.assign(group=gait.strides["animal"].map(group))
    >>> table = figures.build_estimation_table(strides, "duty_factor", average_over="leg")
    >>> ax = figures.plot_estimation(table, label="Duty factor")
    """
    check_columns(table, COLUMNS, where="estimation plot")
    if len(table) == 0:
        raise InputError("estimation plot: the table is empty.")
    animals = table[table["row"] == "animal"]
    groups = list(dict.fromkeys(animals["group"]))
    marks = mark_animals(animals["animal"])
    paired = bool(table["paired"].iloc[0])
    label = label or str(table["measure"].iloc[0])
    with style():
        figure, grid = open_grid(
            2, 1, where="estimation plot", size=figure_size(1, 105.0), ax=ax,
            height_ratios=[1.3, 1.0],
        )  # fmt: skip
        above = figure.add_subplot(grid[0])
        below = figure.add_subplot(grid[1], sharex=above)
        above.tick_params(labelbottom=False)
        places = {}
        for x, name in enumerate(groups):
            own = animals[animals["group"] == name]
            # animals lie side by side, so that equal means are seen
            across = x + (np.linspace(-0.22, 0.22, len(own)) if len(own) > 1 else np.zeros(1))
            columns = (across, own["animal"], own["value"], own["counts"])
            for at, animal, value, counts in zip(*columns, strict=True):
                spot = float(x) if paired else float(at)
                places[name, animal] = spot, float(value)
                shade = "0.35" if counts else _NOT_COMPARED
                draw_points(above, [spot], [value], mark=marks[animal], color=shade, zorder=3)
            mean = table[(table["row"] == "mean") & (table["group"] == name)]
            above.plot([x - 0.3, x + 0.3], [mean["value"].iloc[0]] * 2, color="black",
                       linewidth=1.6, zorder=2)  # fmt: skip
        if paired:
            for animal in marks:
                line = [places[name, animal] for name in groups if (name, animal) in places]
                above.plot(*zip(*line, strict=True), color="0.75", linewidth=0.6, zorder=1)
        _draw_differences(below, table, groups)
        below.set_xticks(range(len(groups)), _names_with_counts(table, groups))
        below.set_xlim(-0.6, len(groups) - 0.25)
        above.set_ylabel(label)
        below.set_ylabel(f"Difference in\n{label[:1].lower()}{label[1:]}")
        add_letter(above, 0)
        add_letter(below, 1)
        if paired:
            add_animal_legend(above, marks)
        figure.align_ylabels([above, below])
    return above


def _names_with_counts(table: pd.DataFrame, groups: list[str]) -> list[str]:
    """Return the names of groups, each with how many of its animals are compared."""
    counted = table[table["row"] == "mean"].set_index("group")["n_animals"].astype(int)
    there = table[table["row"] == "animal"]["group"].value_counts()
    room = _letters(groups)
    words = []
    for name in groups:
        n, whole = int(counted[name]), int(there[name])
        said = f"{n} of {whole}" if n < whole else f"{n}"
        said += f" animal{'s' * (whole != 1)}"
        # a letter's room lies between the counts of two groups
        said = wrap_name(said, room - 1) if room > len("animals") else f"n {n}"
        words.append(f"{wrap_name(name, room)}\n{said}")
    return words


def _letters(groups: list[str]) -> int:
    """Return how many letters of a group's name fit into a line beside those of the others."""
    return letters_in(_AXIS_SHARE * get_style().column_mm / len(groups))


def _draw_differences(ax: Axes, table: pd.DataFrame, groups: list[str]) -> None:
    """Draw differences with intervals, and write effect size and p beside them."""
    ax.axhline(0.0, color="0.4", linewidth=0.7, linestyle=(0, (4, 2)))
    differences = table[(table["row"] == "difference") & np.isfinite(table["value"].astype(float))]
    for k, pair in enumerate(differences.to_dict("records")):
        x, value = groups.index(pair["group"]), pair["value"]
        if math.isfinite(pair["ci_low"]):
            ax.plot([x, x], [pair["ci_low"], pair["ci_high"]], color="black", linewidth=1.6)
        ax.plot([x], [value], marker="o", markersize=5.0, color="black")
        said = []
        if k == 0:  # all of them are against one group
            said.append(f"less {pair['against']}")
        if pair["paired"]:
            n = int(pair["n_animals"])
            said.append(f"{n} pair{'s' * (n != 1)}")
        if math.isfinite(pair["effect"]):
            said.append(f"g {pair['effect']:.2f}")
        if math.isfinite(pair["p_adjusted"]):
            p = pair["p_adjusted"]
            name = "p" if p == pair["p"] else "adj. p"
            said.append(f"{name} < 0.001" if p < 0.001 else f"{name} {p:.3f}")
        words = "\n".join(wrap_name(line, _letters(groups)) for line in said)
        ax.annotate(words, (x, value), xytext=(6.0, 0.0), textcoords="offset points",
                    va="center", fontsize=small_pt(),
                    bbox={"facecolor": ax.get_facecolor(), "edgecolor": "none", "pad": 0.6},
                    )  # fmt: skip
