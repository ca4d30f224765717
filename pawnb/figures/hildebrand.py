"""Hildebrand's diagram: lag of the fore leg against the hind leg's time on the ground."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import add_animal_legend, draw_points, new_axes
from pawnb.figures.style import figure_size, mark_animals, small_pt, style
from pawnb.gait.circular import mean_vector
from pawnb.gait.phases.patterns import hildebrand_table
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "animal", "trial", "side", "stride", "duty_percent", "lag_percent", "n", "level", "told_by",
)  # fmt: skip

REGIONS = (
    (0.0, "pace"),
    (25.0, "lateral sequence, single foot"),
    (50.0, "trot"),
    (75.0, "diagonal sequence, single foot"),
    (100.0, "pace"),
)
"""Lag in percent at which each symmetrical gait lies (Hildebrand 1965, Science 150: 701)."""


@checked_arguments
def build_hildebrand_diagram_table(strides: pd.DataFrame, phases: pd.DataFrame) -> pd.DataFrame:
    """Collect Hildebrand's two numbers of all strides, and their means by animal.

    Parameters
    ----------
    strides, phases : pandas.DataFrame
        As for :func:`pawnb.gait.phases.patterns.hildebrand_table`, which says what the numbers are.

    Returns
    -------
    pandas.DataFrame
        The rows of that table with ``level`` "stride" and ``n`` 1; below them one row an
        animal, both sides together, with ``level`` "animal": mean duty factor and circular
        mean of the lags (NaN where they cancel out), ``n`` strides, trial and side empty.

    Raises
    ------
    InputError
        If no fore leg is measured relative to the hind leg of its side.

    Examples
    --------
    >>> key = {"animal": "m1", "trial": "run-1", "stride": [1, 2]}
    >>> strides = pd.DataFrame({**key, "leg": "HL", "duty_factor": [0.6, 0.7]})
    >>> phases = pd.DataFrame({**key, "leg": "FL", "reference": "HL", "phase": [0.4, 0.5]})
    >>> table = figures.build_hildebrand_diagram_table(strides, phases)
    >>> animal = table[table["level"] == "animal"].iloc[0]
    >>> round(float(animal["duty_percent"])), round(float(animal["lag_percent"]))
    (65, 45)
    """
    table = hildebrand_table(strides, phases)
    rows = []
    for animal, own in table.groupby("animal", sort=True):
        told_by = "AEP to PEP" if (own["told_by"] == "AEP to PEP").any() else "contact"
        mean, _, n = mean_vector(own["lag_percent"].to_numpy(dtype=float) / 100.0 % 1.0)
        rows.append({"animal": animal, "trial": "", "side": "", "stride": 0, "n": n,
                     "duty_percent": float(own["duty_percent"].mean()),
                     "lag_percent": 100.0 * mean, "level": "animal",
                     "told_by": told_by})  # fmt: skip
    both = [table.assign(n=1, level="stride"), pd.DataFrame(rows)]
    return pd.concat(both, ignore_index=True)[list(COLUMNS)]


@checked_arguments
def plot_hildebrand_diagram(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw the diagram: pale points are strides, dark ones the means of animals.

    The time on the ground falls to the right, as Hildebrand drew it: walks on the left, runs
    (below 50 percent) on the right. Where contact is not known the axis is the stance from AEP to
    PEP, which is longer, and walk and run are not told apart. The names stand where the ideal gaits
    lie; gaits go over into each other without a line between them.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_hildebrand_diagram_table`.
    ax : matplotlib axes, optional
        Where to draw; default a new figure, one column wide.

    Returns
    -------
    matplotlib axes
        The axes.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> key = {"animal": "m1", "trial": "run-1", "stride": [1, 2]}
    >>> strides = pd.DataFrame({**key, "leg": "HL", "duty_factor": [0.6, 0.7]})
    >>> phases = pd.DataFrame({**key, "leg": "FL", "reference": "HL", "phase": [0.4, 0.5]})
    >>> table = figures.build_hildebrand_diagram_table(strides, phases)
    >>> ax = figures.plot_hildebrand_diagram(table)
    """
    check_columns(table, COLUMNS, where="Hildebrand diagram")
    if len(table) == 0:
        raise InputError("Hildebrand diagram: the table is empty.")
    marks = mark_animals(table["animal"])
    duty = table["duty_percent"].dropna()
    low = min(40.0, float(np.floor(duty.min() / 10.0) * 10.0)) if len(duty) else 20.0
    high = max(80.0, float(np.ceil(duty.max() / 10.0) * 10.0)) if len(duty) else 80.0
    with style():
        new = ax is None
        if ax is None:
            _, ax = new_axes(figsize=figure_size(1, 80.0))
        for lag, name in REGIONS:
            ax.axhline(lag, color="0.88", linewidth=0.6, zorder=0)
            ax.text(low + 0.01 * (high - low), lag + (-1.0 if lag == 100.0 else 1.0), name,
                    color="0.5", fontsize=small_pt(), ha="right", zorder=0.5,
                    va="top" if lag == 100.0 else "bottom",
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4})  # fmt: skip
        by_contact = bool((table["told_by"] == "contact").all())
        if by_contact:
            ax.axvline(50.0, color="0.7", linewidth=0.7, linestyle=(0, (4, 2)), zorder=0)
            for word, side, where in (("walk", "right", 50.8), ("run", "left", 49.2)):
                ax.text(where, 95.0, word, color="0.5", fontsize=small_pt(), ha=side, va="top")
        for animal, own in table.groupby("animal", sort=True):
            mark = marks[str(animal)]
            strides, mean = own[own["level"] == "stride"], own[own["level"] == "animal"]
            draw_points(ax, strides["duty_percent"], strides["lag_percent"], mark=mark,
                        color="0.65", markersize=2.0, alpha=0.5, zorder=2)  # fmt: skip
            draw_points(ax, mean["duty_percent"], mean["lag_percent"], mark=mark,
                        markersize=5.0, zorder=3)  # fmt: skip
        ax.set_xlim(high, low)
        ax.set_ylim(0.0, 100.0)
        ax.set_yticks([0, 25, 50, 75, 100])
        stance = "Hind foot on the ground" if by_contact else "Hind stance, AEP to PEP"
        ax.set_xlabel(f"{stance} (% of stride)")
        ax.set_ylabel("Fore foot after hind foot (% of stride)")
        if new:
            add_animal_legend(ax, marks)
    return ax
