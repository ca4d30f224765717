"""The stride template fitted to a paw, and what it foretells (paper 2019, Fig. 5)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.arrays import FloatArray, IntArray, Points2D
from pawnb.errors import InputError
from pawnb.figures.panels import add_letter, open_grid
from pawnb.figures.style import OKABE_ITO, figure_size, small_pt, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("frame", "u", "v", "u_fit", "v_fit", "part")
USED, FORETOLD, OTHER = "used for the fit", "foretold", "other"


@checked_arguments
def build_template_fit_table(
    frame: IntArray,
    uv: Points2D,
    uv_fit: FloatArray,
    *,
    used: tuple[int, int],
    foretold: tuple[int, int] | None = None,
) -> pd.DataFrame:
    """Put a tracked paw and the fitted template side by side.

    Parameters
    ----------
    frame : ndarray of int, shape (n,)
        Frame numbers.
    uv : ndarray, shape (n, 2)
        Tracked positions in the picture, px; NaN where not tracked.
    uv_fit : ndarray, shape (n, 2)
        Those of the fitted template, px; NaN where it says nothing.
    used : tuple of int
        Frames the template was fitted to, half open.
    foretold : tuple of int, optional
        Frames of a collision in which it took the place of the tracker, half open.

    Returns
    -------
    pandas.DataFrame
        ``frame, u, v, u_fit, v_fit`` (px) and ``part``: used for the fit, foretold, other.

    Raises
    ------
    InputError
        If the shapes do not belong together, or no frame was used.

    Examples
    --------
    >>> frame = np.arange(20)
    >>> uv = np.column_stack([5.0 * frame, 300.0 + 10.0 * np.sin(frame / 3.0)])
    >>> table = figures.build_template_fit_table(
    ...     frame, uv, uv + 1.0, used=(0, 12), foretold=(12, 16)
    ... )
    >>> table["part"].value_counts().to_dict()
    {'used for the fit': 12, 'foretold': 4, 'other': 4}
    """
    frame = np.asarray(frame, dtype=int)
    uv, uv_fit = np.asarray(uv, dtype=float), np.asarray(uv_fit, dtype=float)
    if uv.shape != (len(frame), 2) or uv_fit.shape != uv.shape:
        raise InputError(
            f"template fit: positions of shape {uv.shape} and {uv_fit.shape} for {len(frame)} "
            f"frames; expected ({len(frame)}, 2) each."
        )
    part = np.full(len(frame), OTHER, dtype=object)
    part[(frame >= used[0]) & (frame < used[1])] = USED
    if not (part == USED).any():
        raise InputError(f"template fit: none of the frames is in {used}, to which it was fitted.")
    if foretold is not None:
        part[(frame >= foretold[0]) & (frame < foretold[1])] = FORETOLD
    columns = (frame, *uv.T, *uv_fit.T, part)
    return pd.DataFrame(dict(zip(COLUMNS, columns, strict=True)))


@checked_arguments
def plot_template_fit(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw u and v of the paw as dots, of the template as a line.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_template_fit_table`.
    ax : matplotlib axes, optional
        The panels divide its place in its figure; default a new figure.

    Returns
    -------
    matplotlib axes
        The upper of the two panels (u, v).

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> frame = np.arange(20)
    >>> uv = np.column_stack([5.0 * frame, 300.0 + 10.0 * np.sin(frame / 3.0)])
    >>> table = figures.build_template_fit_table(
    ...     frame, uv, uv + 1.0, used=(0, 12), foretold=(12, 16)
    ... )
    >>> ax = figures.plot_template_fit(table)
    """
    check_columns(table, COLUMNS, where="template fit")
    if len(table) == 0:
        raise InputError("template fit: the table is empty.")
    with style():
        figure, grid = open_grid(2, 1, where="template fit", size=figure_size(1, 85.0), ax=ax)
        first = figure.add_subplot(grid[0])
        axes = [first, figure.add_subplot(grid[1], sharex=first)]
        first.tick_params(labelbottom=False)
        colours = {USED: "black", FORETOLD: OKABE_ITO["sky blue"], OTHER: "0.65"}
        for k, (panel, name) in enumerate(zip(axes, "uv", strict=True)):
            for part, colour in colours.items():
                own = table[table["part"] == part]
                if own[name].notna().any():
                    panel.plot(own["frame"], own[name], linestyle="none", marker="o",
                            markersize=2.2, markeredgewidth=0.0, color=colour,
                            label=f"tracked, {part}")  # fmt: skip
            panel.plot(table["frame"], table[f"{name}_fit"], color=OKABE_ITO["vermillion"],
                    label="template")  # fmt: skip
            hidden = table.loc[table["part"] == FORETOLD, "frame"]
            if len(hidden):
                panel.axvspan(hidden.min() - 0.5, hidden.max() + 0.5, color="0.93", linewidth=0,
                           label="hidden or in a collision", zorder=0)  # fmt: skip
            panel.set_ylabel(f"{name} (px)")
            add_letter(panel, k)
        if {"leg", "view"} <= set(table):  # as pawnb gait writes them
            about = f"{table['leg'].iloc[0]}, view {table['view'].iloc[0]}"
            first.set_title(about, loc="right", fontsize=small_pt())
        axes[1].invert_yaxis()  # v points down in a picture
        axes[1].set_xlabel("Frame")
        handles, words = axes[0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=2)
    return axes[0]
