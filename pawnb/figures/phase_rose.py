"""Phase rose: how the phases of pairs of legs lie around the cycle (paper 2009, Fig. 4.15)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.projections.polar import PolarAxes

from pawnb.errors import InputError
from pawnb.figures.panels import new_axes, say_counts, say_phase
from pawnb.figures.phases_shown import choose_pairs, interval_length, mean_of_pair, say_interval
from pawnb.figures.style import OKABE_ITO, figure_size, get_style, small_pt, style
from pawnb.gait.circular import mean_vector
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "leg", "reference", "bin_start", "bin_end", "count", "n", "n_animals", "mean", "r",
    "basis", "basis_mean", "basis_r", "ci_low", "ci_high",
)  # fmt: skip


@checked_arguments
def build_phase_rose_table(
    phases: pd.DataFrame,
    *,
    summary: pd.DataFrame | None = None,
    pairs: Sequence[tuple[str, str]] | None = None,
    bins: int = 20,
) -> pd.DataFrame:
    """Count the phases of every pair of legs in equal sectors of the cycle.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    summary : pandas.DataFrame, optional
        Their ``phase_summary``; default made from the phases.
    pairs : sequence of (leg, reference), optional
        Pairs to show, in this order; default all of them.
    bins : int
        Number of sectors.

    Returns
    -------
    pandas.DataFrame
        One row a pair and sector: ``leg, reference, bin_start, bin_end`` (cycles, half
        open), ``count``; and, the same in each row of a pair, ``n`` strides,
        ``n_animals``, ``mean`` (cycles) and ``r`` over strides. ``basis_mean`` and ``basis_r``
        count what ``basis`` says: ``animals`` where there are two or more, each by its mean
        phase, else ``strides``; ``ci_low`` and ``ci_high`` are the interval of the mean over
        animals, which may wrap (NaN for one animal).

    Raises
    ------
    InputError
        If a column is missing, there is no phase, a phase is outside [0, 1), or bins
        is below 4.

    Examples
    --------
    >>> rose = figures.build_phase_rose_table(
    ...     gait.phases, summary=gait.phase_summary, pairs=[("L2", "R2")]
    ... )
    >>> len(rose), int(rose["count"].sum()) == int(rose["n"].iloc[0])
    (20, True)
    """
    groups = choose_pairs(phases, pairs, where="phase rose")
    if bins < 4:
        raise InputError(f"bins is {bins}; expected 4 or more.")
    rows: list[dict[str, Any]] = []
    for (leg, reference), own in groups:
        values = own["phase"].to_numpy(dtype=float)
        mean, r, n = mean_vector(values)
        about = mean_of_pair(own, summary)
        basis = [about[name] for name in ("basis", "mean", "r", "ci_low", "ci_high")]
        count = np.bincount(np.minimum((values * bins).astype(int), bins - 1), minlength=bins)
        for k in range(bins):
            row = (leg, reference, k / bins, (k + 1) / bins, int(count[k]), n,
                   own["animal"].nunique(), mean, r, *basis)  # fmt: skip
            rows.append(dict(zip(COLUMNS, row, strict=True)))
    return pd.DataFrame(rows, columns=list(COLUMNS))


@checked_arguments
def plot_phase_rose(table: pd.DataFrame, *, ax: PolarAxes | None = None) -> PolarAxes:
    """Draw phase roses: sectors whose area is the number of strides, and the mean vector.

    The phase runs clockwise from the top. The radius of a sector is the square root of
    its count, relative to the fullest sector; the arrow is the mean vector over animals (over
    strides where there is one animal), and reaches the outer circle at r = 1. The arc outside
    it is the interval of the mean over animals.

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

    Examples
    --------
    >>> rose = figures.build_phase_rose_table(
    ...     gait.phases, summary=gait.phase_summary, pairs=[("L2", "R2"), ("L2", "L3")]
    ... )
    >>> ax = figures.plot_phase_rose(rose)
    >>> len(ax.figure.axes)
    2
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
        page = 1 if columns <= 2 else 2
        width = get_style().column_mm if page == 1 else get_style().page_mm
        height = 0.62 * width / columns + 22.0
        _, grid = new_axes(
            lines, columns, figsize=figure_size(page, height * lines), squeeze=False,
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
    if math.isfinite(first["basis_mean"]):
        ax.annotate(
            "", xy=(2.0 * math.pi * first["basis_mean"], first["basis_r"]), xytext=(0.0, 0.0),
            arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.2,
                        "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": 7.0},
        )  # fmt: skip
    low, high = first["ci_low"], first["ci_high"]
    if math.isfinite(low) and math.isfinite(high):
        arc = 2.0 * math.pi * (low + np.linspace(0.0, interval_length(low, high), 91))
        ax.plot(arc, np.full(len(arc), 1.05), color="black", linewidth=2.0, clip_on=False,
                solid_capstyle="butt")  # fmt: skip
    ax.set_ylim(0.0, 1.0)
    ax.set_yticks([0.5], [""])
    ax.set_xticks(np.arange(4) * math.pi / 2.0, ["0", "0.25", "0.5", "0.75"])
    ax.tick_params(axis="x", pad=0.0)
    ax.grid(linewidth=0.3, color="0.8")
    ax.set_axisbelow(True)
    strides, animals = int(first["n"]), int(first["n_animals"])
    length = f"r {first['basis_r']:.2f}"
    found = "no mean, "
    if strides == 1:  # r of one phase is 1 whatever the animal does
        found, length = f"{say_phase(first['basis_mean'])} cycle", ""
    elif math.isfinite(first["basis_mean"]):
        found = f"mean {say_phase(first['basis_mean'])} "
        found += f"{say_interval(low, high)} " if math.isfinite(low) else ""
        found += "cycle, "
    ax.set_title(f"{first['leg']} relative to {first['reference']}", pad=8.0)
    ax.set_xlabel(
        f"{found}{length}\n"
        f"{say_counts(strides, 'stride', animals)}\nfullest sector: {int(count.max())}",
        fontsize=small_pt(),
    )
