"""Histograms of phase lags with their mean and interval (paper 2009, Figs. 4.15 to 4.17)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pawnb.errors import InputError
from pawnb.figures.panels import add_heading, label_outer, make_panels, say_counts, say_phase
from pawnb.figures.phases_shown import ANTI_PHASE_ZONE, choose_pairs, mean_of_pair, say_interval
from pawnb.figures.style import OKABE_ITO, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "leg", "reference", "bin_start", "bin_end", "count", "n", "n_animals", "basis", "mean",
    "ci_low", "ci_high", "pattern",
)  # fmt: skip


@checked_arguments
def build_phase_histogram_table(
    phases: pd.DataFrame,
    *,
    summary: pd.DataFrame | None = None,
    pairs: Sequence[tuple[str, str]] | None = None,
    bins: int = 20,
) -> pd.DataFrame:
    """Count the phases of pairs of legs in equal bins of the cycle.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    summary : pandas.DataFrame, optional
        Their ``phase_summary``; default made from the phases.
    pairs : sequence of (leg, reference), optional
        Pairs to show, in this order; default all of them.
    bins : int
        Number of bins.

    Returns
    -------
    pandas.DataFrame
        One row a pair and bin: ``leg, reference, bin_start, bin_end`` (cycles, half open),
        ``count`` of strides; and, the same in each row of a pair, ``n`` strides,
        ``n_animals``, and ``mean``, ``ci_low``, ``ci_high`` (cycles; an interval may wrap) and
        ``pattern``. ``basis`` says what these count: ``animals`` where there are two or more,
        else ``strides`` (no interval then, and no pattern: one animal says nothing of others).

    Raises
    ------
    InputError
        If a column is missing, there is no phase, a pair is not there, a phase is outside
        [0, 1), or bins is below 4.

    Examples
    --------
    >>> table = figures.build_phase_histogram_table(gait.phases, pairs=[("L2", "R2")], bins=10)
    >>> len(table)
    10
    """
    if bins < 4:
        raise InputError(f"bins is {bins}; expected 4 or more.")
    groups = choose_pairs(phases, pairs, where="phase histogram")
    rows: list[dict[str, Any]] = []
    for (leg, reference), own in groups:
        values = own["phase"].to_numpy(dtype=float)
        count = np.bincount(np.minimum((values * bins).astype(int), bins - 1), minlength=bins)
        about = mean_of_pair(own, summary)
        for k in range(bins):
            rows.append({"leg": leg, "reference": reference, "bin_start": k / bins,
                         "bin_end": (k + 1) / bins, "count": int(count[k]), "n": len(values),
                         **about})  # fmt: skip
    return pd.DataFrame(rows)[list(COLUMNS)]


@checked_arguments
def plot_phase_histogram(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw a histogram for each pair, the zone of anti-phase, the mean and its interval.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_phase_histogram_table`.
    ax : matplotlib axes, optional
        Where to draw a table of a single pair. Default: a new figure with one panel a pair,
        one column wide for up to four pairs, else two columns.

    Returns
    -------
    matplotlib axes
        The first panel; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or it holds several pairs where ``ax`` is
        given.

    Examples
    --------
    >>> table = figures.build_phase_histogram_table(
    ...     gait.phases, summary=gait.phase_summary, pairs=[("L2", "R2"), ("L2", "L3")]
    ... )
    >>> ax = figures.plot_phase_histogram(table)
    """
    check_columns(table, COLUMNS, where="phase histogram")
    pairs = [own for _, own in table.groupby(["leg", "reference"], sort=False)]
    with style():
        columns = None if len(pairs) <= 9 else 4
        panels = make_panels(
            len(pairs), where="phase histogram", ax=ax, columns=columns, height_mm=41.0
        )
        for panel, own in zip(panels, pairs, strict=True):
            _draw(panel, own)
        label_outer(panels, x="Phase (cycles)", y="Strides")
        if ax is None:
            _add_legend(panels[0], table)
    return panels[0]


def _draw(ax: Axes, own: pd.DataFrame) -> None:
    """Draw one pair of legs."""
    first = own.iloc[0]
    top = max(float(own["count"].max()), 1.0)
    ax.axvspan(*ANTI_PHASE_ZONE, color="0.92", linewidth=0)
    ax.bar(own["bin_start"], own["count"], width=own["bin_end"] - own["bin_start"],
           align="edge", color=OKABE_ITO["sky blue"], edgecolor="white", linewidth=0.3)  # fmt: skip
    if math.isfinite(first["mean"]):
        ax.axvline(first["mean"], color="black", linestyle=(0, (4, 2)), linewidth=0.9)
    for low, high in _segments(first["ci_low"], first["ci_high"]):
        ax.plot([low, high], [1.06 * top, 1.06 * top], color="black", linewidth=2.0,
                solid_capstyle="butt")  # fmt: skip
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(0.0, 1.15 * top)
    ax.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "", "0.5", "", "1"])
    ax.locator_params(axis="y", nbins=4, integer=True)
    said = say_phase(first["mean"]) if math.isfinite(first["mean"]) else "no mean"
    words = [said, say_interval(first["ci_low"], first["ci_high"]), first["pattern"]]
    said = " ".join(word for word in words if isinstance(word, str) and word)
    counts = say_counts(int(first["n"]), "stride", int(first["n_animals"]))
    add_heading(ax, f"{first['leg']} to {first['reference']}", f"{said}\n{counts}")


def _segments(low: float, high: float) -> list[tuple[float, float]]:
    """Return an interval of the cycle as stretches of the axis; two where it wraps."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return []
    return [(low, high)] if low <= high else [(low, 1.0), (0.0, high)]


def _add_legend(ax: Axes, table: pd.DataFrame) -> None:
    """Say what zone, line and bar are."""
    of = "animals" if (table["basis"] == "animals").all() else "strides"
    handles: list[Any] = [Patch(color="0.92"), Line2D([], [], color="black", linewidth=0.9,
                                                      linestyle=(0, (4, 2)))]  # fmt: skip
    words = ["anti-phase", f"mean over {of}"]
    if table["ci_low"].notna().any():
        handles.append(Line2D([], [], color="black", linewidth=2.0))
        words.append("95 % interval over animals")
    figure: Any = ax.figure
    wide = figure.get_size_inches()[0] > 4.5
    figure.legend(handles, words, loc="outside lower center", ncols=3 if wide else 2,
                     columnspacing=1.0, handlelength=1.6)  # fmt: skip
