"""All measures of all animals at once: a heat map of standard deviations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.long_names import letters_in, width_of, wrap_name
from pawnb.figures.panels import new_axes, speed_unit, with_unit
from pawnb.figures.style import figure_size, style
from pawnb.gait.overview import measures_by_animal, standardise
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("animal", "group", "measure", "mean", "z")
_LIMIT_SD = 2.5
"""Colours end here: one of a few animals can hardly be further from the mean."""
_USUAL_LETTERS = 8
"""Longer names of animals make the figure higher."""
_AXES_SHARE = 0.6
"""Of the width of the figure: without the measures and the bar of colours."""
_UNITS = {
    "_deg_s2": " (deg/s²)", "_deg_s": " (deg/s)", "_deg": " (deg)", "_hz": " (Hz)", "_s": " (s)",
    "_bl": " (body lengths)",
}  # fmt: skip


_LENGTHS = (
    "stride_length", "step_displacement", "excursion", "swing_distance", "aep_lateral",
    "pep_lateral", "step_length", "step_width", "swing_height", "toe_clearance",
)  # fmt: skip


def say_measure(name: str, *, unit: str | None = None) -> str:
    """Return the name of a column as words, with its unit: ``swing_s`` is ``swing (s)``.

    Parameters
    ----------
    name : str
        Column of the strides.
    unit : str, optional
        Unit of lengths; without it lengths and speeds are named without any.

    Returns
    -------
    str
        Words.
    """
    for ending, told in _UNITS.items():
        if name.endswith(ending):
            return name.removesuffix(ending).replace("_", " ") + told
    words = name.replace("_", " ")
    if unit and name in _LENGTHS:
        return with_unit(words, unit)
    return with_unit(words, speed_unit(unit)) if unit and name == "speed" else words


@checked_arguments
def build_measure_heat_map_table(
    strides: pd.DataFrame,
    measures: Sequence[str],
    *,
    groups: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Put measures of animals side by side, each in standard deviations from its mean.

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
        ``COLUMNS``, a row an animal and measure: ``mean`` in the measure's unit, ``z`` in
        standard deviations over animals. Animals stand by group, then by name.

    Raises
    ------
    InputError
        If there are fewer than three animals or two measures.

    Examples
    --------
    >>> measures = ["frequency_hz", "duty_factor", "stride_length"]
    >>> table = figures.build_measure_heat_map_table(gait.strides, measures)
    """
    means = measures_by_animal(strides, measures)
    z = standardise(means).z
    of = {animal: str((groups or {}).get(str(animal), "")) for animal in z.index}
    order = sorted(z.index, key=lambda animal: (of[animal], str(animal)))
    rows = [
        (str(animal), of[animal], measure, means.loc[animal, measure], z.loc[animal, measure])
        for measure in z.columns for animal in order
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=list(COLUMNS))


@checked_arguments
def plot_measure_heat_map(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw a row a measure and a column an animal: purple below the mean, orange above it.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_measure_heat_map_table`.
    ax : matplotlib axes, optional
        Where to draw; default a new figure, as high as it has measures.

    Returns
    -------
    matplotlib axes
        The axes; a line parts the groups, whose names stand above.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> measures = ["frequency_hz", "duty_factor", "stride_length", "swing_s", "speed"]
    >>> table = figures.build_measure_heat_map_table(gait.strides, measures)
    >>> ax = figures.plot_measure_heat_map(table)
    """
    check_columns(table, COLUMNS, where="heat map of measures")
    if len(table) == 0:
        raise InputError("heat map of measures: the table is empty.")
    animals = list(dict.fromkeys(table["animal"].astype(str)))
    measures = list(dict.fromkeys(table["measure"].astype(str)))
    grid = table.assign(animal=table["animal"].astype(str)).pivot_table(
        index="measure", columns="animal", values="z"
    )
    with style():
        if ax is None:
            wide = 1 if len(animals) <= 8 else 2
            longer = width_of(max(map(len, animals))) - width_of(_USUAL_LETTERS)
            high = max(62.0, 30.0 + 4.0 * len(measures)) + max(0.0, longer)
            _, ax = new_axes(figsize=figure_size(wide, high))
        drawn = ax.imshow(
            grid.loc[measures, animals].to_numpy(), cmap=mpl.colormaps["PuOr_r"], aspect="auto",
            vmin=-_LIMIT_SD, vmax=_LIMIT_SD, interpolation="nearest",
        )  # fmt: skip
        ax.set_yticks(range(len(measures)), [say_measure(name) for name in measures])
        ax.set_xticks(range(len(animals)), animals, rotation=90)
        ax.tick_params(length=0)
        _part_groups(ax, table, animals)
        figure: Any = ax.figure
        bar = figure.colorbar(drawn, ax=ax, extend="both", aspect=30)
        bar.set_label("From the mean (SD)")
        bar.outline.set_visible(False)
    return ax


def _part_groups(ax: Any, table: pd.DataFrame, animals: list[str]) -> None:
    """Draw lines between groups and their names above them."""
    of = dict(zip(table["animal"].astype(str), table["group"].astype(str), strict=True))
    names = [of[animal] for animal in animals]
    whole_mm = _AXES_SHARE * 25.4 * ax.figure.get_size_inches()[0]
    for name in dict.fromkeys(names):
        inside = [k for k, other in enumerate(names) if other == name]
        if name:
            middle = (inside[0] + inside[-1]) / 2.0
            words = wrap_name(name, letters_in(whole_mm * len(inside) / len(animals)))
            ax.annotate(words, (middle, 1.0), xycoords=("data", "axes fraction"), ha="center",
                        va="bottom", xytext=(0, 2), textcoords="offset points")  # fmt: skip
        if inside[0]:
            ax.axvline(inside[0] - 0.5, color="black", linewidth=1.2)
