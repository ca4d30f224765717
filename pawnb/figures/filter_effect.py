"""What filtering does to velocity and acceleration (paper 2009, Fig. 3.10)."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.figures.panels import make_panels
from pawnb.figures.style import OKABE_ITO, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import differentiate, smooth_motion

COLUMNS = ("quantity", "time_s", "raw", "filtered", "cutoff_hz", "method")
_MOST_SQUARES = 60
_EXPONENTS = {"position": "", "velocity": "/s", "acceleration": "/s²"}


@checked_arguments
def build_filter_effect_table(
    x: FloatArray,
    *,
    fs_hz: float,
    cutoff_hz: float | None,
    method: Literal["butterworth", "spline"] = "butterworth",
    order: int = 4,
    span_s: tuple[float, float] | None = None,
) -> pd.DataFrame:
    """Differentiate a signal as it is and after smoothing.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Positions or unwrapped angles; NaN where missing.
    fs_hz : float
        Sampling rate, in Hz.
    cutoff_hz : float or None
        Cut-off, in Hz; None, for the spline only, chooses it by cross-validation.
    method : {"butterworth", "spline"}
        How to smooth; see :func:`pawnb.signals.smooth_motion`.
    order : int
        Order of the Butterworth filter.
    span_s : tuple of float, optional
        Part of the recording to show; all of it is filtered.

    Returns
    -------
    pandas.DataFrame
        ``quantity`` (position, velocity, acceleration), ``time_s, raw, filtered``, and
        ``cutoff_hz`` (NaN where it was chosen) and ``method``.

    Raises
    ------
    InputError
        If x is not one signal, or nothing of it is in the span.

    Examples
    --------
    >>> time_s = np.arange(200) / 100.0
    >>> x = 10.0 * np.sin(2 * np.pi * 2.0 * time_s) + np.random.default_rng(0).normal(size=200)
    >>> table = figures.build_filter_effect_table(x, fs_hz=100.0, cutoff_hz=8.0)
    >>> len(table) >= 200
    True
    """
    x = np.asarray(x, dtype=float)
    if x.ndim != 1:
        raise InputError(f"filter effect: x has {x.ndim} dimensions; expected one signal.")
    dt = 1.0 / fs_hz
    raw = (x, differentiate(x, dt=dt), differentiate(x, dt=dt, order=2))
    smooth = smooth_motion(x, fs_hz=fs_hz, cutoff_hz=cutoff_hz, method=method, order=order)
    time = np.arange(len(x)) * dt
    low, high = span_s if span_s is not None else (0.0, np.inf)
    shown = (time >= low) & (time <= high)
    if not (shown & np.isfinite(x)).any():
        raise InputError("filter effect: no sample in the span; expected at least one.")
    parts = [
        pd.DataFrame(
            {
                "quantity": quantity, "time_s": time[shown], "raw": before[shown],
                "filtered": after[shown],
                "cutoff_hz": np.nan if cutoff_hz is None else cutoff_hz, "method": method,
            }
        )
        for quantity, before, after in zip(_EXPONENTS, raw, smooth, strict=True)
    ]  # fmt: skip
    return pd.concat(parts, ignore_index=True)[list(COLUMNS)]


@checked_arguments
def plot_filter_effect(
    table: pd.DataFrame,
    *,
    ax: Axes | None = None,
    unit: str | None = None,
    name: str = "Position",
) -> Axes:
    """Draw raw and filtered position, velocity and acceleration below one another.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_filter_effect_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw a table of one quantity; default a new figure.
    unit : str, optional
        Unit of the signal.
    name : str
        What the signal is called.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or ``ax`` is given for several quantities.

    Examples
    --------
    >>> time_s = np.arange(200) / 100.0
    >>> x = 10.0 * np.sin(2 * np.pi * 2.0 * time_s) + np.random.default_rng(0).normal(size=200)
    >>> table = figures.build_filter_effect_table(x, fs_hz=100.0, cutoff_hz=8.0)
    >>> ax = figures.plot_filter_effect(table, unit="mm")
    """
    check_columns(table, COLUMNS, where="filter effect")
    quantities = [own for _, own in table.groupby("quantity", sort=False)]
    names = {"position": name, "velocity": "Velocity", "acceleration": "Acceleration"}
    with style():
        panels = make_panels(
            len(quantities), where="filter effect", ax=ax, columns=1, height_mm=38.0, sharex=True
        )
        for panel, own in zip(panels, quantities, strict=True):
            quantity = str(own["quantity"].iloc[0])
            panel.plot(own["time_s"], own["raw"], linestyle="none", marker="o", markersize=2.2,
                       color="black", markeredgewidth=0.0, label="raw")  # fmt: skip
            # squares as in the paper, unless they would hide the raw points
            few = len(own) <= _MOST_SQUARES
            panel.plot(own["time_s"], own["filtered"], marker="s" if few else "", markersize=2.6,
                       markerfacecolor="white", markeredgewidth=0.5, linewidth=0.9,
                       color=OKABE_ITO["vermillion"], label=_label(own))  # fmt: skip
            measure = "" if unit is None else f" ({unit}{_EXPONENTS[quantity]})"
            panel.set_ylabel(f"{names[quantity]}{measure}")
        panels[-1].set_xlabel("Time (s)")
        panels[0].figure.align_ylabels(panels)
        panels[0].legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2,
            handletextpad=0.4, columnspacing=1.0,
        )  # fmt: skip
    return panels[0]


def _label(own: pd.DataFrame) -> str:
    """Name the smoothing."""
    cutoff = float(own["cutoff_hz"].iloc[0])
    kind = {"butterworth": "Butterworth", "spline": "spline"}[str(own["method"].iloc[0])]
    return f"{kind}, {cutoff:.3g} Hz" if np.isfinite(cutoff) else f"{kind}, cross-validated"
