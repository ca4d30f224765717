"""Phase lag against speed, with the limits of anti-phase (paper 2009, Figs. 4.18, 4.19)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

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
from pawnb.gait.circular import mean_vector
from pawnb.gait.circular_correlation import angular_linear
from pawnb.schema import check_columns

COLUMNS = (
    "leg", "reference", "animal", "trial", "stride", "speed", "phase", "n_strides", "r_al", "p",
    "n_animals", "basis",
)  # fmt: skip
_FEWEST = 4


def build_phase_speed_table(
    phases: pd.DataFrame,
    strides: pd.DataFrame,
    *,
    pairs: Sequence[tuple[str, str]] | None = None,
    per: str = "trial",
    speed: str = "speed",
) -> pd.DataFrame:
    """Put phase lags beside the speed at which they were measured, and correlate them.

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
        one a stride.
    speed : str
        Column of the strides on the x axis.

    Returns
    -------
    pandas.DataFrame
        ``COLUMNS``, one row a point (``stride`` 0 for whole trials). The same in all rows of a
        pair: the angular-linear correlation ``r_al`` (Eq. 3.26) and its p by permutation.
        ``basis`` says what they count: ``animals`` with four or more, each by its means; else
        ``trials`` or ``strides`` as if they were independent, and blank below four points.

    Raises
    ------
    InputError
        If a column is missing, no stride has a speed, a pair is not there, or ``per`` is
        unknown.
    """
    check_columns(strides, ("animal", "trial", "leg", "stride", speed), where="strides")
    if per not in ("trial", "stride"):
        raise InputError(f"per is {per!r}; expected 'trial' or 'stride'.")
    keys = ["animal", "trial", "stride"]
    parts = []
    for (leg, reference), own in choose_pairs(phases, pairs, where="phase against speed"):
        base = strides.loc[strides["leg"] == reference, [*keys, speed]]
        points = own.merge(base.rename(columns={speed: "speed"}), on=keys)
        points = points[points["speed"].notna()].assign(n_strides=1)
        if per == "trial":
            points = _by_trial(points)
        if len(points):
            about = _correlate(points, per)
            parts.append(points.assign(leg=leg, reference=reference, **about))
    if not parts:
        raise InputError(
            f"phase against speed: no stride has a {speed}; speeds need tracks, or a belt speed."
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


def _correlate(points: pd.DataFrame, per: str) -> dict[str, Any]:
    """Correlate phase with speed, animals counting once where there are enough of them."""
    n_animals = int(points["animal"].nunique())
    by_animal = n_animals >= _FEWEST
    about: dict[str, Any] = {"r_al": np.nan, "p": np.nan, "n_animals": n_animals}
    about["basis"] = "animals" if by_animal else f"{per}s"
    try:
        found = angular_linear(
            points["phase"].to_numpy(dtype=float),
            points["speed"].to_numpy(dtype=float),
            animals=points["animal"].tolist() if by_animal else None,
        )
    except InputError:  # too few points, or all speeds the same: there is no correlation
        return about
    return about | {"r_al": found.r, "p": found.p_permutation}


def plot_phase_speed(
    table: pd.DataFrame, *, ax: Axes | None = None, unit: str | None = None,
    x_label: str | None = None,
) -> Axes:  # fmt: skip
    """Draw phase against speed: a shape an individual, anti-phase between the dashed lines.

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

    Returns
    -------
    matplotlib axes
        The first panel.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or there are several pairs for one axes.
    """
    check_columns(table, COLUMNS, where="phase against speed")
    pairs = [own for _, own in table.groupby(["leg", "reference"], sort=False)]
    marks = mark_animals(table["animal"])
    with style():
        columns = None if len(pairs) <= 9 else 4
        panels = make_panels(
            len(pairs), where="phase against speed", ax=ax, columns=columns, height_mm=40.0
        )
        for panel, own in zip(panels, pairs, strict=True):
            for animal, part in own.groupby("animal", sort=True):
                draw_points(panel, part["speed"], part["phase"], mark=marks[str(animal)],
                            alpha=0.8, clip_on=False)  # fmt: skip
            for limit in (0.25, 0.75):
                panel.axhline(limit, color="0.4", linewidth=0.7, linestyle=(0, (4, 2)))
            panel.set_ylim(-0.03, 1.03)
            panel.set_yticks([0.0, 0.25, 0.5, 0.75, 1.0], ["0", "", "0.5", "", "1"])
            first = own.iloc[0]
            add_heading(panel, f"{first['leg']} to {first['reference']}", _say(own))
        label_outer(panels, x=x_label or with_unit("Speed", speed_unit(unit)), y="Phase (cycles)")
        if ax is None:
            add_animal_legend(panels[0], marks)
    return panels[0]


def _say(own: pd.DataFrame) -> str:
    """Return correlation, p, and what they count."""
    first = own.iloc[0]
    animals = int(first["n_animals"])
    who = f"{animals} animal{'s' * (animals != 1)}"
    if not math.isfinite(first["r_al"]):
        return f"{len(own)} {first['basis']}, {who}: no r" if first["basis"] != "animals" else who
    p = "p < 0.001" if first["p"] < 0.001 else f"p {first['p']:.3f}"
    if first["basis"] == "animals":
        return f"r {first['r_al']:.2f}, {p}, {who}"
    return f"r {first['r_al']:.2f}, {p} if {len(own)} {first['basis']}\nof {who} were independent"
