"""Angles of legs over time, with the moments of AEP and PEP (paper 2009, §3.6)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import new_axes
from pawnb.figures.style import colour_legs, figure_size, style
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("time_s", "leg", "leg_angle")
_MARKERS = {"AEP": "^", "PEP": "v"}


@checked_arguments
def plot_leg_angles(
    table: pd.DataFrame, *, events: pd.DataFrame | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the angle of one or more legs over time.

    Parameters
    ----------
    table : pandas.DataFrame
        ``time_s, leg, leg_angle`` (degrees), as :func:`pawnb.gait.leg_angles` gives them; take
        the legs to show.
    events : pandas.DataFrame, optional
        Events of the same trial: AEP are marked by triangles that point up, PEP down.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default a new figure, one column wide. The second leg of a pair is
        dashed.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> run = study.runs[0]
    >>> angles = pawnb.gait.leg_angles(run.tracks())
    >>> events = gait.events[gait.events["trial"] == run.trial.name]
    >>> ax = figures.plot_leg_angles(angles[angles["leg"].isin(["L2", "R2"])], events=events)
    """
    check_columns(table, COLUMNS, where="leg angles")
    if len(table) == 0:
        raise InputError("leg angles: the table is empty; choose legs that were tracked.")
    legs = list(dict.fromkeys(table["leg"]))
    with style():
        if ax is None:
            _, ax = new_axes(figsize=figure_size(1, 50.0))
        colours = colour_legs(legs)
        drawn: list[str] = []
        for leg in legs:
            own = table[table["leg"] == leg]
            # from the fifth leg of a side on colours begin again
            dashes = "--" if colours[leg] in drawn else "-"
            drawn.append(colours[leg])
            ax.plot(own["time_s"], own["leg_angle"], dashes, color=colours[leg], label=leg)
            if events is None:
                continue
            for event, marker in _MARKERS.items():
                at = events.loc[(events["leg"] == leg) & (events["event"] == event), "time_s"]
                angle = np.interp(at, own["time_s"], own["leg_angle"])
                ax.plot(at, angle, marker, color=colours[leg], markersize=3.5)
        ax.set_xlabel("Time (s)")
        ax.set_ylabel("Leg angle (°)")
        ax.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return ax
