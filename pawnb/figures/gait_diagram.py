"""Gait diagram: when each foot is in stance (paper 2019, Fig. 4)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.transforms import blended_transform_factory

from pawnb.arrays import BoolArray, FloatArray
from pawnb.errors import InputError
from pawnb.figures.panels import new_axes
from pawnb.figures.style import colour_legs, figure_size, small_pt, style
from pawnb.gait.legs import sort_legs
from pawnb.gait.strides import PARTNER, choose_stride_event
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = ("leg", "start_s", "end_s", "phase", "cut")
_NOT_KNOWN = ("track", "pause", "frames")
"""What of the table of what was dropped hides stance and swing."""


@checked_arguments
def build_gait_diagram_table(
    events: pd.DataFrame,
    *,
    stance_from: str = "auto",
    dropped: pd.DataFrame | None = None,
    span_s: tuple[float, float] | None = None,
) -> pd.DataFrame:
    """Build the bars of a gait diagram from the events of one trial.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one animal and trial: leg, event, time_s.
    stance_from : {"auto", "AEP", "TD"}
        Stance is AEP to PEP or TD to LO; ``auto``: AEP where there is any.
    dropped : pandas.DataFrame, optional
        The table of what was dropped. A stance or a swing in which the foot was not tracked, or
        the animal stood, is shown as unknown. Rows of other animals and trials do not count.
    span_s : tuple of float, optional
        Start and end of the recording; default first and last event of any leg.

    Returns
    -------
    pandas.DataFrame
        ``leg, start_s, end_s, phase, cut``: legs in anatomical order. ``phase`` is
        ``stance`` or ``unknown`` (an event is missing, the foot was not tracked, or the animal
        stood); what has no bar is swing. ``cut`` is ``start`` or ``end`` where a stance goes on
        beyond the span, else empty.

    Raises
    ------
    InputError
        If a column is missing, there is no event, or there are several trials.

    Examples
    --------
    >>> one = gait.events[gait.events["trial"] == "spider-01-run-1"]
    >>> table = figures.build_gait_diagram_table(one)
    >>> sorted(table["leg"].unique())
    ['L1', 'L2', 'L3', 'L4', 'R1', 'R2', 'R3', 'R4']
    """
    check_columns(events, ("leg", "event", "time_s"), where="events")
    if len(events) == 0:
        raise InputError("gait diagram: no events; expected those of one trial.")
    for name in ("animal", "trial"):
        several = events[name].unique() if name in events else ()
        if len(several) > 1:
            raise InputError(
                f"gait diagram: events of {len(several)} {name}s; choose one, for "
                f"instance events[events[{name!r}] == {events[name].iloc[0]!r}]."
            )
    begin = choose_stride_event(events, stance_from)
    used = events[events["event"].isin([begin, PARTNER[begin]])]
    first, last = span_s if span_s is not None else (events["time_s"].min(), events["time_s"].max())
    rows: list[dict[str, Any]] = []
    for leg in sort_legs(events["leg"]):
        own = used[used["leg"] == leg].sort_values("time_s", kind="stable")
        bars = _bars(own["time_s"].to_numpy(), (own["event"] == begin).to_numpy(), first, last)
        unseen = _unseen(dropped, events, leg)
        for start, end, phase, cut in bars:
            if ((unseen[:, 1] > start) & (unseen[:, 0] < end)).any():
                rows.append(dict(zip(COLUMNS, (leg, start, end, "unknown", ""), strict=True)))
            elif phase != "swing":
                rows.append(dict(zip(COLUMNS, (leg, start, end, phase, cut), strict=True)))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _bars(
    times: FloatArray, begins: BoolArray, first: float, last: float
) -> list[tuple[float, float, str, str]]:
    """Pair the events of one leg; what has no partner is cut by the edge or unknown."""
    if len(times) == 0:
        return [(first, last, "unknown", "")]
    # what is under way before the first event, and after the last, is cut by the edge
    at = [first, *(float(time) for time in times), last]
    goes_on = [not begins[0], *(bool(begin) for begin in begins)]
    bars: list[tuple[float, float, str, str]] = []
    for i, (a, b) in enumerate(pairwise(at)):
        edge = "start" if i == 0 else "end" if i == len(times) else ""
        if edge and a >= b:
            continue
        if not edge and goes_on[i] == goes_on[i + 1]:
            bars.append((a, b, "unknown", ""))
        else:
            bars.append((a, b, "stance" if goes_on[i] else "swing", edge))
    return bars


def _unseen(dropped: pd.DataFrame | None, events: pd.DataFrame, leg: str) -> FloatArray:
    """Return start and end of each stretch in which nobody knows what a leg of a trial did."""
    if dropped is None:
        return np.empty((0, 2))
    own = dropped[dropped["leg"].isin([leg, ""]) & dropped["what"].isin(_NOT_KNOWN)]
    for name in ("animal", "trial"):
        if name in own and name in events:
            own = own[own[name] == events[name].iloc[0]]
    return own[["start_s", "end_s"]].to_numpy(dtype=float)


@checked_arguments
def plot_gait_diagram(table: pd.DataFrame, *, ax: Axes | None = None) -> Axes:
    """Draw a gait diagram: one row a leg, a bar for each stance.

    Bars of stances that begin or end outside the recording are pale and open on that
    side; unknown stretches are hatched.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_gait_diagram_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default a new figure, one column wide.

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
    >>> one = gait.events[gait.events["trial"] == "spider-01-run-1"]
    >>> table = figures.build_gait_diagram_table(one)
    >>> ax = figures.plot_gait_diagram(table)
    >>> ax.get_xlabel()
    'Time (s)'
    """
    check_columns(table, COLUMNS, where="gait diagram")
    if len(table) == 0:
        raise InputError("gait diagram: the table has no bars.")
    legs = list(dict.fromkeys(table["leg"]))
    with style():
        if ax is None:
            # one leg has the room of two: the name of the axis would be cut off
            _, ax = new_axes(figsize=figure_size(1, 20.0 + 5.0 * max(2, len(legs))))
        colours = colour_legs(legs)
        for bar in table.itertuples():
            draw_stance_bar(ax, bar, legs.index(str(bar.leg)), colour=colours[str(bar.leg)])
        ax.set_yticks(range(len(legs)), legs)
        ax.set_ylim(len(legs) - 0.4, -0.6)
        if table["start_s"].min() < table["end_s"].max():
            ax.set_xlim(table["start_s"].min(), table["end_s"].max())
        ax.tick_params(axis="y", length=0)
        ax.spines["left"].set_visible(False)
        ax.set_xlabel("Time (s)")
        ax.set_ylabel("Foot in stance")
        said = []
        if (table["cut"] != "").any():
            said.append("pale: stance goes on beyond what is shown")
        if (table["phase"] == "unknown").any():
            said.append("hatched: not known")
        if said:
            place = blended_transform_factory(ax.transAxes, ax.transAxes)
            ax.text(1.0, 1.02, "; ".join(said), transform=place, ha="right", va="bottom",
                    fontsize=small_pt())  # fmt: skip
    return ax


def draw_stance_bar(ax: Axes, bar: Any, row: int, *, colour: str) -> None:
    """Draw one bar; what is not known for certain looks different.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where.
    bar : row of the table
        With start_s, end_s, phase and cut.
    row : int
        Place of its leg, from the top.
    colour : str
        Colour of the leg.
    """
    width = bar.end_s - bar.start_s
    if bar.phase == "unknown":
        ax.barh(row, width, left=bar.start_s, height=0.7, facecolor="white",
                edgecolor="0.55", hatch="////", linewidth=0.4)  # fmt: skip
    else:
        ax.barh(row, width, left=bar.start_s, height=0.7, facecolor=colour, linewidth=0.0,
                alpha=0.4 if bar.cut else 1.0)  # fmt: skip
