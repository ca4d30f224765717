"""Phases of two pairs of legs at every instant, as densities on the torus (DeAngelis 2019)."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes

from pawnb.figures.panels import add_heading, make_panels, say_counts
from pawnb.figures.style import style
from pawnb.gait.phases.density import DENSITY_COLUMNS
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments


@checked_arguments
def plot_phase_density(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw how often two pairs of legs are at each pair of phases; both axes close in a ring.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`pawnb.gait.phases.density.phase_density`.
    ax : matplotlib axes, optional
        Where to draw a table of a single plane; default a new figure with a panel a plane.

    Returns
    -------
    matplotlib axes
        The first panel; the scale of the colours, which all share, is beside the last.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or there are several planes for one axes.

    Examples
    --------
    >>> angles = [one for one in gait.signals if one.signal == "leg angle"]
    >>> table = pawnb.gait.phases.density.phase_density(angles, gait.strides)
    >>> ax = figures.plot_phase_density(table)
    """
    check_columns(table, DENSITY_COLUMNS, where="phase density")
    keys = ["leg_x", "reference_x", "leg_y", "reference_y"]
    planes = list(table.groupby(keys, sort=False))
    most = float(table["density"].max()) if len(table) else 1.0
    with style():
        panels = make_panels(
            len(planes), where="phase density", ax=ax, columns=1 if len(planes) < 3 else 3,
            height_mm=64.0 if len(planes) == 1 else 58.0,
        )  # fmt: skip
        drawn: Any = None
        for panel, ((leg_x, of_x, leg_y, of_y), own) in zip(panels, planes, strict=True):
            grid = own.pivot_table(index="phase_y", columns="phase_x", values="density")
            # viridis is the same to colour-blind eyes and grows evenly lighter
            drawn = panel.imshow(
                grid.to_numpy(), origin="lower", extent=(0.0, 1.0, 0.0, 1.0), vmin=0.0, vmax=most,
                cmap=mpl.colormaps["viridis"], interpolation="nearest", aspect="equal",
            )  # fmt: skip
            for ticks in (panel.set_xticks, panel.set_yticks):
                ticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "", "0.5", "", "1"])
            first = own.iloc[0]
            counts = say_counts(int(first["n_samples"]), "frame", int(first["n_animals"]))
            add_heading(panel, f"{leg_x} and {leg_y}", counts)
            panel.set_xlabel(f"{leg_x} after {of_x} (cycles)")
            panel.set_ylabel(f"{leg_y} after {of_y} (cycles)")
        figure: Any = panels[0].figure
        bar = figure.colorbar(drawn, ax=panels if ax is None else panels[0], shrink=0.8)
        bar.set_label("Density (1: by chance)")
        bar.outline.set_visible(False)
    return panels[0]
