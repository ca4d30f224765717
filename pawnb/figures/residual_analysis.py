"""Residual analysis: how a cut-off is chosen (paper 2009, Fig. 3.11)."""

from __future__ import annotations

import math
import textwrap
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import add_note, make_panels, with_unit
from pawnb.figures.style import OKABE_ITO, style
from pawnb.gait.residuals import (
    CURVE_COLUMNS,
    POOLED,
    ResidualAnalysis,
    analyse_residuals,
    named_signals,
)
from pawnb.gait.residuals.cutoffs import Signals, say_unlike
from pawnb.gait.residuals.residual_analysis import analyse_what_is_there
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

_NOTE_LETTERS = 20

COLUMNS = ("signal", *CURVE_COLUMNS, "chosen_hz", "noise_rms", "reason")


@checked_arguments
def build_residual_analysis_table(
    signals: Signals,
    *,
    fs_hz: float,
    order: int = 4,
    band_hz: tuple[float, float] | None = None,
) -> pd.DataFrame:
    """Compute the residual curve of each signal, and of all pooled.

    Parameters
    ----------
    signals : pandas.DataFrame, pandas.Series, ndarray (n,) or (n, k), or list
        One column a signal, all in one unit; NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.
    order : int
        Order of the Butterworth filter, both passes together.
    band_hz : tuple of float, optional
        Straight part of the curve; default: found.

    Returns
    -------
    pandas.DataFrame
        ``signal``, the curve (``cutoff_hz, residual, noise_line, in_band``) and, the same in
        each row of a signal, ``chosen_hz, noise_rms, reason``. ``pooled`` comes last where
        there are several. A signal without a run of 20 samples has no curve (NaN), and
        ``reason`` says so; that of ``pooled`` names the signals that its cut-off does not suit.

    Raises
    ------
    InputError
        If there is no signal, or none of them can be analysed.

    Examples
    --------
    >>> time_s = np.arange(400) / 100.0
    >>> x = 10.0 * np.sin(2 * np.pi * 2.0 * time_s) + np.random.default_rng(0).normal(size=400)
    >>> table = figures.build_residual_analysis_table(pd.DataFrame({"foot": x}), fs_hz=100.0)
    """
    table = named_signals(signals)
    if table.shape[1] == 0:
        raise InputError("residual analysis: no signal; expected at least one column.")
    options: dict[str, Any] = {"fs_hz": fs_hz, "order": order, "band_hz": band_hz}
    pooled = analyse_residuals(table.to_numpy(), **options)
    if table.shape[1] == 1:
        return _with_choice(pooled, str(table.columns[0]))
    found = {str(name): analyse_what_is_there(table[name].to_numpy(), **options) for name in table}
    unlike = say_unlike({name: one.cutoff_hz for name, one in found.items()}, pooled.cutoff_hz)
    found[POOLED] = replace(pooled, reason=f"{pooled.reason}; but {unlike}") if unlike else pooled
    return pd.concat([_with_choice(one, name) for name, one in found.items()], ignore_index=True)


def _with_choice(found: ResidualAnalysis, name: str) -> pd.DataFrame:
    """Return the curve of a signal with its name and what was chosen, in the order of columns."""
    curve = found.curve.assign(
        signal=name, chosen_hz=found.cutoff_hz, noise_rms=found.noise_rms, reason=found.reason
    )
    return curve[list(COLUMNS)]


@checked_arguments
def plot_residual_analysis(
    table: pd.DataFrame, *, ax: Axes | None = None, unit: str | None = None
) -> Axes:
    """Draw residual curves with the noise line and the cut-off, a panel for each signal.

    The height is cut at six times the noise, for the curve rises far beyond it at the left.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_residual_analysis_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw a single signal; default a new figure.
    unit : str, optional
        Unit of the signals.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or ``ax`` is given for several signals.

    Examples
    --------
    >>> time_s = np.arange(400) / 100.0
    >>> x = 10.0 * np.sin(2 * np.pi * 2.0 * time_s) + np.random.default_rng(0).normal(size=400)
    >>> table = figures.build_residual_analysis_table(pd.DataFrame({"foot": x}), fs_hz=100.0)
    >>> ax = figures.plot_residual_analysis(table, unit="mm")
    """
    check_columns(table, COLUMNS, where="residual analysis")
    signals = [own for _, own in table.groupby("signal", sort=False)]
    with style():
        panels = make_panels(len(signals), where="residual analysis", ax=ax, height_mm=52.0)
        for panel, own in zip(panels, signals, strict=True):
            _draw(panel, own)
            if len(signals) > 1:
                panel.set_title(str(own["signal"].iloc[0]))
        name = "Residual (RMS)" if unit is None else with_unit("Residual, RMS", unit)
        for panel in panels:
            panel.set_xlabel("Cut-off (Hz)")
            panel.set_ylabel(name)
    return panels[0]


def _draw(ax: Any, own: pd.DataFrame) -> None:
    """Draw one signal."""
    first = own.iloc[0]
    chosen, noise = float(first["chosen_hz"]), float(first["noise_rms"])
    cutoff = own["cutoff_hz"].to_numpy()
    ax.plot(cutoff, own["residual"], color="black")
    ax.set_xlim(0.0, cutoff[-1])
    highest = float(own["residual"].max())
    if highest > 0.0:  # not of a signal that stands still, or is hardly ever seen
        ax.set_ylim(0.0, 1.05 * highest)
    if not math.isfinite(noise):
        _say_why(ax, str(first["reason"]))
        return
    band = own[own["in_band"]]
    ax.plot(band["cutoff_hz"], band["residual"], color=OKABE_ITO["sky blue"], linewidth=3.0,
            alpha=0.6, zorder=1, label="noise alone")  # fmt: skip
    slope = np.polyfit(cutoff, own["noise_line"], 1)[0]
    ax.plot([0.0, cutoff[-1]], [noise, noise + slope * cutoff[-1]], linestyle="--",
            color=OKABE_ITO["blue"], label="noise line")  # fmt: skip
    if noise > 0.0:
        ax.set_ylim(0.0, min(6.0 * noise, 1.05 * highest))
    if math.isfinite(chosen):
        ax.plot([0.0, chosen, chosen], [noise, noise, 0.0], color=OKABE_ITO["vermillion"],
                linewidth=0.8)  # fmt: skip
        ax.plot([chosen], [noise], marker="o", markersize=3.5, color=OKABE_ITO["vermillion"])
        ax.annotate(f"cut-off {chosen:.2f} Hz", (chosen, noise), xytext=(5.0, 8.0),
                    textcoords="offset points")  # fmt: skip
    else:
        _say_why(ax, str(first["reason"]))
    ax.legend(loc="upper right", handlelength=1.5)


def _say_why(ax: Any, reason: str) -> None:
    """Write in a panel why it has no cut-off: what comes before the reason's first comma."""
    add_note(ax, textwrap.fill(reason.split(", ")[0], _NOTE_LETTERS), at=(0.98, 0.98))
