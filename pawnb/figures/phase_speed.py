"""Phase lag against speed, with each animal's line (paper 2009, Figs. 4.18, 4.19)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.panels import (
    add_animal_legend,
    add_heading,
    draw_points,
    label_outer,
    make_panels,
    speed_unit,
    with_unit,
)
from pawnb.figures.phases_shown import choose_pairs
from pawnb.figures.style import mark_animals, style
from pawnb.gait.analysis.phase_patterns import NEAR
from pawnb.gait.circular import mean_vector
from pawnb.gait.regression.phase_slopes import phases_at_speeds, slope_of_pair
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "leg", "reference", "animal", "trial", "stride", "speed", "phase", "n_strides", "slope",
    "ci_low", "ci_high", "p", "n_animals", "animal_slope", "animal_speed", "animal_phase", "note",
)  # fmt: skip

_LEAST_WIDTH = 0.05
"""Least width of the axis of speeds, as a share of the speed: on one belt they are rounding."""


@checked_arguments
def build_phase_speed_table(
    phases: pd.DataFrame,
    strides: pd.DataFrame,
    *,
    pairs: Sequence[tuple[str, str]] | None = None,
    per: str = "trial",
    speed: str = "speed",
) -> pd.DataFrame:
    """Put phase lags beside the speed at which they were measured, with slopes within animals.

    Parameters
    ----------
    phases : pandas.DataFrame
        ``PHASES_COLUMNS``.
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``: the stride of the reference leg gives the speed.
    pairs : sequence of (leg, reference), optional
        Pairs to show; default all.
    per : {"trial", "stride"}
        One point a trial (circular mean of its phases, mean of its speeds), as the paper, or
        one a stride. Slopes are those of strides in both.
    speed : str
        Column of the strides on the x axis.

    Returns
    -------
    pandas.DataFrame
        ``COLUMNS``, one row a point (``stride`` 0 for whole trials). The same in all rows of a
        pair: mean ``slope`` of phase on speed within ``n_animals`` animals, its interval and p
        (:func:`pawnb.gait.regression.phase_slopes.phase_speed_table`), and its ``note``. The same
        in all rows of an animal: its own slope, and the mean speed and phase through which its line
        runs.

    Raises
    ------
    InputError
        If a column is missing, no stride has a speed, a pair is not there, or ``per`` is
        unknown.

    Examples
    --------
    >>> table = figures.build_phase_speed_table(gait.phases, gait.strides, pairs=[("L2", "R2")])
    >>> int(table["n_animals"].iloc[0])
    4
    """
    if per not in ("trial", "stride"):
        raise InputError(f"per is {per!r}; expected 'trial' or 'stride'.")
    chosen = choose_pairs(phases, pairs, where="phase against speed")
    known = phases_at_speeds(pd.concat([own for _, own in chosen]), strides, speed=speed)
    parts = []
    for (leg, reference), own in known.groupby(["leg", "reference"], sort=False):
        points = _by_trial(own) if per == "trial" else own.assign(n_strides=1)
        about = slope_of_pair(own)
        parts.append(
            points.merge(_lines(own), on="animal").assign(
                leg=str(leg), reference=str(reference), **about
            )
        )
    return pd.concat(parts, ignore_index=True)[list(COLUMNS)]


def _by_trial(points: pd.DataFrame) -> pd.DataFrame:
    """Return one point a trial."""
    rows = [
        {"animal": animal, "trial": trial, "stride": 0, "n_strides": len(own),
         "phase": mean_vector(own["phase"].to_numpy(dtype=float)).mean,
         "speed": float(own["speed"].mean())}
        for (animal, trial), own in points.groupby(["animal", "trial"], sort=False)
    ]  # fmt: skip
    table = pd.DataFrame(rows, columns=["animal", "trial", "stride", "n_strides", "phase", "speed"])
    return table[table["phase"].notna()]


def _lines(own: pd.DataFrame) -> pd.DataFrame:
    """Return each animal's slope, and a point of its line."""
    rows = [
        {"animal": animal, "animal_slope": slope_of_pair(part)["slope"],
         "animal_speed": float(part["speed"].mean()),
         "animal_phase": mean_vector(part["phase"].to_numpy(dtype=float)).mean}
        for animal, part in own.groupby("animal", sort=False)
    ]  # fmt: skip
    return pd.DataFrame(rows)


@checked_arguments
def plot_phase_speed(
    table: pd.DataFrame, *, ax: Axes | None = None, unit: str | None = None,
    x_label: str | None = None, near: float = NEAR,
) -> Axes:  # fmt: skip
    """Draw phase against speed: a shape and a line an individual, anti-phase between dashes.

    Of a pair whose phases lie about 0 the axis goes from half a cycle before to half a cycle after,
    so that neighbours such as 0.98 and 0.02 stand beside each other; in-phase is between the dashes
    there.

    Above each panel stands the mean slope of the animals in cycles for each unit of speed, with
    its interval of 95 %.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_phase_speed_table`.
    ax : matplotlib axes, optional
        Where to draw a table of a single pair; default a new figure with a panel a pair.
    unit : str, optional
        Unit of length of the speeds.
    x_label : str, optional
        Name and unit of the x axis, where it is no speed in that unit.
    near : float
        How far from 0.5, or from 0, the dashes are, cycles. Default 0.1, within which a mean is
        named anti-phase or in-phase; in the paper 0.25.

    Returns
    -------
    matplotlib axes
        The first panel.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, there are several pairs for one axes, or
        ``near`` is not above 0 and below 0.5.

    Examples
    --------
    >>> table = figures.build_phase_speed_table(
    ...     gait.phases, gait.strides, pairs=[("L2", "R2"), ("L2", "L3")]
    ... )
    >>> ax = figures.plot_phase_speed(table, unit="mm")
    """
    check_columns(table, COLUMNS, where="phase against speed")
    if not 0.0 < near < 0.5:
        raise InputError(f"near is {near}; expected above 0 and below 0.5 cycle.")
    pairs = [own for _, own in table.groupby(["leg", "reference"], sort=False)]
    marks = mark_animals(table["animal"])
    with style():
        columns = None if len(pairs) <= 9 else 4
        panels = make_panels(
            len(pairs), where="phase against speed", ax=ax, columns=columns, height_mm=40.0
        )
        for panel, own in zip(panels, pairs, strict=True):
            low = _lowest_phase(own)
            for animal, part in own.groupby("animal", sort=True):
                draw_points(panel, part["speed"], (part["phase"] - low) % 1.0 + low,
                            mark=marks[str(animal)], alpha=0.8, clip_on=False)  # fmt: skip
                _draw_line(panel, part, low)
            for limit in (0.5 - near, 0.5 + near):
                panel.axhline(limit + low, color="0.4", linewidth=0.7, linestyle=(0, (4, 2)))
            panel.set_ylim(low - 0.03, low + 1.03)
            ends = ("0", "0.5", "1") if low == 0.0 else ("0.5", "0", "0.5")
            panel.set_yticks(low + np.arange(5) / 4.0, [ends[0], "", ends[1], "", ends[2]])
            _set_speeds(panel, own["speed"])
            first = own.iloc[0]
            add_heading(panel, f"{first['leg']} to {first['reference']}", _say(own))
        label_outer(panels, x=x_label or with_unit("Speed", speed_unit(unit)), y="Phase (cycles)")
        if ax is None:
            add_animal_legend(panels[0], marks)
    return panels[0]


def _lowest_phase(own: pd.DataFrame) -> float:
    """Return where the axis begins: 0, or -0.5 where the phases lie about 0."""
    mean = mean_vector(own["phase"].to_numpy(dtype=float)).mean
    return -0.5 if abs((mean + 0.5) % 1.0 - 0.5) < 0.25 else 0.0


def _set_speeds(ax: Axes, speed: pd.Series) -> None:
    """Show speeds as they are, and those that hardly differ as neighbours."""
    ax.ticklabel_format(axis="x", useOffset=False)
    middle, least = float(speed.min() + speed.max()) / 2.0, float(speed.abs().max()) * _LEAST_WIDTH
    if float(np.ptp(speed)) < least > 0.0:
        ax.set_xlim(middle - least / 2.0, middle + least / 2.0)


def _draw_line(ax: Axes, part: pd.DataFrame, low: float) -> None:
    """Draw an animal's line over the speeds of its points; it may leave the cycle and return."""
    first = part.iloc[0]
    if not math.isfinite(first["animal_slope"]):
        return
    x = np.array([part["speed"].min(), part["speed"].max()])
    y = first["animal_phase"] - low + first["animal_slope"] * (x - first["animal_speed"])
    for turn in range(math.floor(y.min()), math.floor(y.max()) + 1):
        ax.plot(x, y - turn + low, color="0.35", linewidth=0.6)


def _say(own: pd.DataFrame) -> str:
    """Return the slope with its interval, p, and how many animals they count."""
    first = own.iloc[0]
    animals = int(first["n_animals"])
    if not animals:
        return "no animal at several speeds"
    who = f"{animals} animal{'s' * (animals != 1)}"
    if not math.isfinite(first["ci_low"]):
        return f"slope {first['slope']:.2g}, {who}"
    p = "p < 0.001" if first["p"] < 0.001 else f"p {first['p']:.3f}"
    return f"slope {first['slope']:.2g} [{first['ci_low']:.2g}, {first['ci_high']:.2g}]\n{p}, {who}"
