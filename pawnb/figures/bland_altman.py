"""Agreement of two people or two runs: Bland-Altman plots."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import add_animal_legend, draw_points, make_panels, say_counts
from pawnb.figures.style import OKABE_ITO, mark_animals, small_pt, style
from pawnb.gait.repeatability import match_strides, repeatability_table
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

_CONSTANT = (
    "n", "n_animals", "bias", "bias_low", "bias_high", "limit_low", "limit_low_low",
    "limit_low_high", "limit_high", "limit_high_low", "limit_high_high", "icc", "icc_low",
    "icc_high",
)  # fmt: skip
COLUMNS = ("measure", "animal", "mean", "difference", *_CONSTANT)


@checked_arguments
def build_bland_altman_table(
    first: pd.DataFrame,
    second: pd.DataFrame,
    *,
    measures: Sequence[str] | None = None,
    tolerance: float = 0.25,
    level: float = 0.95,
) -> pd.DataFrame:
    """Pair the strides of two people, or of two runs, and compute bias and limits.

    Parameters
    ----------
    first, second : pandas.DataFrame
        Their strides, of the same trials.
    measures : sequence of str, optional
        Columns; default all that both have.
    tolerance : float
        How far apart two starts may be; see :func:`pawnb.gait.repeatability.match_strides`.
    level : float
        Level of the intervals.

    Returns
    -------
    pandas.DataFrame
        ``measure, animal, mean, difference`` (second minus first), a row a stride; and, the
        same in each row of a measure, the columns of
        :func:`pawnb.gait.repeatability.repeatability_table`.

    Raises
    ------
    InputError
        If a measure is missing, no stride is shared, or no measure has three shared strides.

    Examples
    --------
    >>> again = gait.strides.assign(duty_factor=gait.strides["duty_factor"] + 0.01)
    >>> table = figures.build_bland_altman_table(gait.strides, again, measures=["duty_factor"])
    >>> round(float(table["bias"].iloc[0]), 3)
    0.01
    """
    pairs = match_strides(first, second, tolerance=tolerance)
    found = repeatability_table(first, second, measures=measures, tolerance=tolerance, level=level)
    parts = []
    for row in found.to_dict("records"):
        a, b = (pairs[f"{row['measure']}_{k}"].to_numpy(dtype=float) for k in (1, 2))
        known = np.isfinite(a) & np.isfinite(b)
        if not math.isfinite(row["bias"]):
            continue
        parts.append(
            pd.DataFrame(
                {
                    "measure": row["measure"], "animal": pairs["animal"].to_numpy()[known],
                    "mean": (a + b)[known] / 2.0, "difference": (b - a)[known],
                    **{name: row[name] for name in _CONSTANT},
                }
            )
        )  # fmt: skip
    if not parts:
        raise InputError("Bland-Altman: no measure has three shared strides.")
    return pd.concat(parts, ignore_index=True)[list(COLUMNS)]


@checked_arguments
def plot_bland_altman(
    table: pd.DataFrame, *, ax: Axes | None = None, names: Mapping[str, str] | None = None
) -> Axes:
    """Draw difference against mean, with bias, limits of agreement and their intervals.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_bland_altman_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw a single measure; default a new figure with a panel a measure.
    names : mapping, optional
        What measures are called, with units.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or ``ax`` is given for several measures.

    Examples
    --------
    >>> runs = [run.tracks(noise_px=0.5, seed=1) for run in study.runs[:2]]
    >>> again = pawnb.gait.pool(
    ...     [pawnb.gait.analyse(t, trial=run.trial) for t, run in zip(runs, study.runs)]
    ... )
    >>> table = figures.build_bland_altman_table(
    ...     gait.strides, again.strides, measures=["period_s", "duty_factor"]
    ... )
    >>> ax = figures.plot_bland_altman(table)
    """
    check_columns(table, COLUMNS, where="Bland-Altman")
    measures = [own for _, own in table.groupby("measure", sort=False)]
    called = dict(names or {})
    with style():
        panels = make_panels(len(measures), where="Bland-Altman", ax=ax, height_mm=56.0)
        marks = mark_animals(table["animal"])
        for panel, own in zip(panels, measures, strict=True):
            measure = str(own["measure"].iloc[0])
            _draw(panel, own.iloc[0])
            for animal, points in own.groupby("animal", sort=True):
                draw_points(panel, points["mean"], points["difference"], mark=marks[str(animal)],
                            markersize=2.8, zorder=3)  # fmt: skip
            panel.set_xlabel(f"Mean: {called.get(measure, measure)}")
            panel.set_ylabel("Difference")
            panel.set_title(_words(own.iloc[0]), fontsize=small_pt(), loc="right",
                            linespacing=1.15)  # fmt: skip
        add_animal_legend(panels[0], marks)
    return panels[0]


def _draw(ax: Any, first: pd.Series) -> None:
    """Draw bias and limits of one measure."""
    ax.axhline(0.0, color="0.7", linewidth=0.6)
    for name, colour, dashes in (
        ("bias", OKABE_ITO["blue"], "-"),
        ("limit_low", OKABE_ITO["vermillion"], "--"),
        ("limit_high", OKABE_ITO["vermillion"], "--"),
    ):
        ax.axhspan(first[f"{name}_low"], first[f"{name}_high"], color=colour, alpha=0.15,
                   linewidth=0.0)  # fmt: skip
        ax.axhline(first[name], color=colour, linestyle=dashes)


def _words(first: pd.Series) -> str:
    """Say agreement in short lines, the shortest last: the panel's letter stands beside it."""
    lines = [say_counts(int(first["n"]), "stride", int(first["n_animals"]))]
    if math.isfinite(first["icc"]):
        lines.append(f"ICC {first['icc']:.2f} ({first['icc_low']:.2f} to {first['icc_high']:.2f})")
    lines.append(f"limits {first['limit_low']:.2g} to {first['limit_high']:.2g}")
    lines.append(f"bias {first['bias']:.2g}")
    return "\n".join(lines).replace("-", "−")
