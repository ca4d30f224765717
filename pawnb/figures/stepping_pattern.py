"""Stepping patterns at several speeds, one above another (paper 2009, Fig. 4.5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.gait_diagram import build_gait_diagram_table, draw_stance_bar
from pawnb.figures.long_names import letters_in, wrap_name
from pawnb.figures.numbers_shown import say_number
from pawnb.figures.panels import add_letter, new_axes
from pawnb.figures.style import figure_size, small_pt, style
from pawnb.gait.legs import sort_legs
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "panel", "animal", "trial", "leg", "start_s", "end_s", "phase", "cut", "span_s", "speed",
    "frequency_hz", "stride_length", "n_strides",
)  # fmt: skip
_STRIDES = 4.0
"""Length of the stretch shown, in strides of the slowest trial."""


@checked_arguments
def build_stepping_pattern_table(
    events: pd.DataFrame,
    strides: pd.DataFrame,
    *,
    trials: Sequence[tuple[str, str]] | None = None,
    most: int = 3,
    span_s: float | None = None,
    dropped: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Build stepping patterns of one animal from its slowest to its fastest trial.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of any animals and trials.
    strides : pandas.DataFrame
        Their strides: they tell speed, frequency and length.
    trials : sequence of (animal, trial), optional
        What to show, from the top. Default: of the animal with the most trials (the same
        animal, so that size plays no part), ``most`` of them from the slowest to the fastest,
        by stride frequency where no speed is known.
    most : int
        Number of trials, where none are named.
    span_s : float, optional
        Duration shown, the same for all; default four strides of the slowest, or as much as
        the shortest trial has.
    dropped : pandas.DataFrame, optional
        As for :func:`~pawnb.figures.build_gait_diagram_table`.

    Returns
    -------
    pandas.DataFrame
        The bars of a gait diagram with ``panel`` (from 0), animal and trial, times counted
        from the start of what is shown, its duration ``span_s``, and means over the trial's
        strides of all legs: ``speed``, ``frequency_hz``, ``stride_length`` (NaN where not
        known), with their number.

    Raises
    ------
    InputError
        If there is no stride, a trial is not there, or the span is not above 0.

    Examples
    --------
    >>> table = figures.build_stepping_pattern_table(gait.events, gait.strides, most=2)
    >>> table["trial"].nunique()
    2
    """
    check_columns(strides, ("animal", "trial", "period_s", "speed"), where="strides")
    if span_s is not None and not span_s > 0:
        raise InputError(f"span_s is {span_s}; expected more than 0.")
    numbers = ["speed", "frequency_hz", "stride_length"]
    groups = strides.groupby(["animal", "trial"], sort=False)
    means = groups[numbers].mean()
    means["n_strides"] = groups.size()
    about: dict[Any, dict[Any, Any]] = means.to_dict("index")
    chosen: list[Any] = _choose(means, most) if trials is None else [(a, t) for a, t in trials]
    for pair in chosen:
        if pair not in about:
            raise InputError(f"stepping pattern: no strides of animal {pair[0]!r}, trial "
                             f"{pair[1]!r}; there are {len(means)} trials.")  # fmt: skip
    if not chosen:
        raise InputError("stepping pattern: no strides; expected those of at least one trial.")
    own_events = [_of(events, pair) for pair in chosen]
    if span_s is None:
        longest = max(float(_of(strides, pair)["period_s"].median()) for pair in chosen)
        shortest = min(float(np.ptp(own["time_s"])) for own in own_events)
        span_s = min(_STRIDES * longest, shortest)
    parts = []
    for panel, (pair, own) in enumerate(zip(chosen, own_events, strict=True)):
        bars = build_gait_diagram_table(
            own, dropped=None if dropped is None else _of(dropped, pair)
        )
        reach = (float(own["time_s"].min()), float(own["time_s"].max()))
        first = choose_window(_of(strides, pair), reach, span_s)
        bars = _window(bars, first, first + span_s)
        parts.append(
            bars.assign(
                panel=panel, animal=pair[0], trial=pair[1], span_s=span_s,
                **{str(name): value for name, value in about[pair].items()},
            )
        )  # fmt: skip
    return pd.concat(parts, ignore_index=True)[list(COLUMNS)]


def choose_window(strides: pd.DataFrame, reach: tuple[float, float], span_s: float) -> float:
    """Choose which stretch of a trial to show.

    Parameters
    ----------
    strides : pandas.DataFrame
        Strides of the trial, of all legs.
    reach : tuple of float
        First and last second that can be shown.
    span_s : float
        Duration of the stretch.

    Returns
    -------
    float
        Its begin, s: the middle, unless another one shows more than twice as many whole strides,
        as where the animal stands or is not seen in the middle.
    """
    low, high = reach
    middle = max(low, (low + high - span_s) / 2.0)
    if "start_s" not in strides:
        return middle
    start = strides["start_s"].to_numpy(dtype=float)
    end = start + strides["period_s"].to_numpy(dtype=float)
    begins = np.append(middle, start[start + span_s <= high])
    inside = (start >= begins[:, None]) & (end <= begins[:, None] + span_s)
    n = inside.sum(axis=1)
    return float(begins[n.argmax()]) if n.max() > 2 * n[0] else middle


def _choose(means: pd.DataFrame, most: int) -> list[tuple[Any, ...]]:
    """Choose trials of the animal with the most of them, spread evenly over their speeds."""
    if len(means) == 0:
        return []
    animals = means.index.get_level_values("animal")
    own = means[animals == animals.value_counts().index[0]]
    name = "speed" if own["speed"].notna().all() else "frequency_hz"
    own = own.sort_values(name, kind="stable")
    places = np.unique(np.linspace(0, len(own) - 1, min(most, len(own))).round().astype(int))
    return [own.index[i] for i in places]


def _of(table: pd.DataFrame, pair: tuple[Any, ...]) -> pd.DataFrame:
    """Return the rows of one animal and trial."""
    own = table[(table["animal"] == pair[0]) & (table["trial"] == pair[1])]
    return own.reset_index(drop=True)


def _window(bars: pd.DataFrame, first: float, last: float) -> pd.DataFrame:
    """Cut bars to a window and count time from its start; every leg keeps a row."""
    inside = bars[(bars["end_s"] > first) & (bars["start_s"] < last)]
    return inside.assign(
        start_s=inside["start_s"].clip(lower=first) - first,
        end_s=inside["end_s"].clip(upper=last) - first,
        cut="",
    )


@checked_arguments
def plot_stepping_pattern(
    table: pd.DataFrame, *, ax: Axes | None = None, unit: str | None = None
) -> Axes:
    """Draw stepping patterns: a bar is stance, a gap swing; all panels last equally long.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_stepping_pattern_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw a table of a single trial; default a new figure, one column wide, with a
        panel a trial.
    unit : str, optional
        Unit of length of speed and stride length.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or there are several trials for one axes.

    Examples
    --------
    >>> table = figures.build_stepping_pattern_table(
    ...     gait.events, gait.strides, dropped=gait.dropped, most=2
    ... )
    >>> ax = figures.plot_stepping_pattern(table, unit="mm")
    """
    check_columns(table, COLUMNS, where="stepping pattern")
    if len(table) == 0:
        raise InputError("stepping pattern: the table is empty.")
    shown = list(table["panel"].unique())
    legs = sort_legs(table["leg"])
    if ax is not None and len(shown) > 1:
        raise InputError(f"stepping pattern: {len(shown)} trials for one axes; leave ax out.")
    with style():
        if ax is None:
            height = len(shown) * (9.0 + 3.4 * len(legs)) + 8.0
            _, grid = new_axes(
                len(shown), 1, figsize=figure_size(1, height), squeeze=False, sharex=True
            )
            panels = list(grid.flat)
        else:
            panels = [ax]
        for k, (number, panel) in enumerate(zip(shown, panels, strict=True)):
            own = table[table["panel"] == number]
            for bar in own.itertuples():
                draw_stance_bar(panel, bar, legs.index(str(bar.leg)), colour="black")
            _finish(panel, own, legs, unit)
            if len(shown) > 1:
                add_letter(panel, k)
        _draw_scale(panels[-1], float(table["span_s"].iloc[0]))
    return panels[0]


def _finish(ax: Axes, own: pd.DataFrame, legs: list[str], unit: str | None) -> None:
    """Name the legs and say what trial this is."""
    first = own.iloc[0]
    ax.set_yticks(range(len(legs)), legs)
    ax.set_ylim(len(legs) - 0.4, -0.6)
    ax.set_xlim(0.0, first["span_s"])
    ax.set_xticks([])
    ax.tick_params(axis="y", length=0)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    words = []
    if np.isfinite(first["speed"]):
        words.append(f"speed {say_number(first['speed'])} {unit or 'units'}/s")
    words.append(f"{first['frequency_hz']:.2f} strides/s")
    if np.isfinite(first["stride_length"]):
        words.append(f"stride length {say_number(first['stride_length'])} {unit or 'units'}")
    names = dict.fromkeys((str(first["animal"]), str(first["trial"])))
    figure: Any = ax.figure
    letters = letters_in(figure.get_size_inches()[0] * 25.4 * ax.get_position().width)
    lines = [wrap_name(", ".join(names), letters), ", ".join(words)]
    ax.set_title("\n".join(lines), fontsize=small_pt())


def _draw_scale(ax: Axes, span_s: float) -> None:
    """Draw a scale of time under the last panel: a tenth to a third of what is shown."""
    power = 10.0 ** np.floor(np.log10(span_s / 4.0))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= span_s / 2.5)
    place = ax.get_xaxis_transform()
    ax.plot([0.0, length], [-0.05, -0.05], color="black", linewidth=1.5, transform=place,
            clip_on=False, solid_capstyle="butt")  # fmt: skip
    ax.set_xlabel(f"{length:g} s", loc="left", labelpad=8.0)
