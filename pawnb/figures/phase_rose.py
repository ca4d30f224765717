"""Phase rose: how the phases of pairs of legs lie around the cycle (paper 2009, Fig. 4.15)."""

from __future__ import annotations

import math
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.projections.polar import PolarAxes

from pawnb.errors import InputError
from pawnb.figures.style import COLUMN_MM, OKABE_ITO, PAGE_MM, size_mm, style
from pawnb.gait.circular import mean_vector
from pawnb.schema import PHASES_COLUMNS, check_columns

COLUMNS = (
    "leg", "reference", "bin_start", "bin_end", "count", "n", "n_animals", "mean", "r",
)  # fmt: skip


def build_phase_rose_table(phases: pd.DataFrame, *, bins: int = 20) -> pd.DataFrame:
    """Count the phases of every pair of legs in equal sectors of the cycle.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    bins : int
        Number of sectors.

    Returns
    -------
    pandas.DataFrame
        One row a pair and sector: ``leg, reference, bin_start, bin_end`` (cycles, half
        open), ``count``; and, the same in each row of a pair, ``n`` strides,
        ``n_animals``, ``mean`` (cycles) and ``r`` over strides.

    Raises
    ------
    InputError
        If a column is missing, there is no phase, a phase is outside [0, 1), or bins
        is below 4.
    """
    check_columns(phases, PHASES_COLUMNS, where="phases")
    if len(phases) == 0:
        raise InputError("phase rose: no phases; expected at least one.")
    if bins < 4:
        raise InputError(f"bins is {bins}; expected 4 or more.")
    if not phases["phase"].between(0.0, 1.0, inclusive="left").all():
        raise InputError("phase rose: a phase is not in [0, 1); give phases in cycles.")
    rows: list[dict[str, Any]] = []
    for (leg, reference), own in phases.groupby(["leg", "reference"], sort=False):
        values = own["phase"].to_numpy(dtype=float)
        mean, r, n = mean_vector(values)
        count = np.bincount(np.minimum((values * bins).astype(int), bins - 1), minlength=bins)
        for k in range(bins):
            row = (leg, reference, k / bins, (k + 1) / bins, int(count[k]), n,
                   own["animal"].nunique(), mean, r)  # fmt: skip
            rows.append(dict(zip(COLUMNS, row, strict=True)))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def plot_phase_rose(table: pd.DataFrame, *, ax: PolarAxes | None = None) -> PolarAxes:
    """Draw phase roses: sectors whose area is the number of strides, and the mean vector.

    The phase runs clockwise from the top. The radius of a sector is the square root of
    its count, relative to the fullest sector; the arrow is the mean vector, and reaches
    the outer circle at r = 1.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_phase_rose_table`.
    ax : matplotlib polar axes, optional
        Where to draw a table of a single pair. Default: a new figure with one panel a
        pair, one column wide for one or two pairs, else two columns.

    Returns
    -------
    matplotlib polar axes
        The axes, of the first panel where there are several; all are in
        ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or it holds several pairs where
        ``ax`` is given.
    """
    check_columns(table, COLUMNS, where="phase rose")
    pairs = [own for _, own in table.groupby(["leg", "reference"], sort=False)]
    if not pairs:
        raise InputError("phase rose: the table is empty.")
    if ax is not None and len(pairs) > 1:
        raise InputError(
            f"phase rose: {len(pairs)} pairs of legs for one axes; choose one, or leave ax out."
        )
    with style():
        if ax is not None:
            _draw_rose(ax, pairs[0])
            return ax
        columns = min(len(pairs), 2 if len(pairs) <= 2 else 3 if len(pairs) <= 9 else 4)
        lines = math.ceil(len(pairs) / columns)
        width = COLUMN_MM if columns <= 2 else PAGE_MM
        height = 0.7 * width / columns + 22.0
        _, grid = plt.subplots(
            lines, columns, figsize=size_mm(width, height * lines), squeeze=False,
            subplot_kw={"projection": "polar"},
        )  # fmt: skip
        panels: list[Any] = list(grid.flat)
        for panel, own in zip(panels, pairs, strict=False):
            _draw_rose(panel, own)
        for spare in panels[len(pairs) :]:
            spare.remove()
    return panels[0]


def _draw_rose(ax: PolarAxes, own: pd.DataFrame) -> None:
    """Draw one pair of legs."""
    first = own.iloc[0]
    ax.set_theta_zero_location("N")
    ax.set_theta_direction(-1)
    width = 2.0 * math.pi * (own["bin_end"] - own["bin_start"]).to_numpy()
    centre = math.pi * (own["bin_start"] + own["bin_end"]).to_numpy()
    count = own["count"].to_numpy()
    ax.bar(centre, np.sqrt(count / count.max()), width=width, color=OKABE_ITO["sky blue"],
           edgecolor="white", linewidth=0.4)  # fmt: skip
    if math.isfinite(first["mean"]):
        ax.annotate(
            "", xy=(2.0 * math.pi * first["mean"], first["r"]), xytext=(0.0, 0.0),
            arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.2,
                        "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 7.0},
        )  # fmt: skip
    ax.set_ylim(0.0, 1.0)
    ax.set_yticks([0.5], [""])
    ax.set_xticks(np.arange(4) * math.pi / 2.0, ["0", "0.25", "0.5", "0.75"])
    ax.tick_params(axis="x", pad=-2.0)
    ax.grid(linewidth=0.3, color="0.8")
    ax.set_axisbelow(True)
    strides, animals = int(first["n"]), int(first["n_animals"])
    found = f"mean {first['mean']:.2f} cycle, " if math.isfinite(first["mean"]) else ""
    ax.set_title(f"{first['leg']} relative to {first['reference']}", pad=8.0)
    ax.set_xlabel(
        f"{found}r {first['r']:.2f}\n"
        f"{strides} stride{'s' * (strides != 1)}, {animals} animal{'s' * (animals != 1)}\n"
        f"fullest sector: {int(count.max())}"
    )
