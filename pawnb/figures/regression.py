"""Scatter with regression, its band, and individuals by marker (paper 2009, Fig. 4.1-4.11)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.figures.numbers_shown import say_number
from pawnb.figures.panels import (
    add_animal_legend,
    draw_points,
    make_panels,
    say_counts,
    use_log_axes,
)
from pawnb.figures.style import OKABE_ITO, mark_animals, small_pt, style
from pawnb.gait.regression import AnimalSlopes, Line, fit_line, fit_power, fit_rma
from pawnb.gait.regression.scaling import animal_slopes
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

COLUMNS = (
    "outcome", "predictor", "row", "animal", "x", "y", "x_sd", "y_sd", "low", "high", "points",
    "kind", "method", "n", "n_animals", "a", "b", "ci_low", "ci_high", "r2", "p", "significant",
    "b_animals", "p_animals", "significant_animals",
)  # fmt: skip
_STEPS = 60
_WORDS_LONG, _WORDS_HIGH = 0.6, 0.1
"""Room of the words of a reference line along and across it, of the panel."""
_UNITS = {"animal": "animal", "trial": "trial", "row": "stride"}


@checked_arguments
def build_regression_table(
    measures: pd.DataFrame,
    pairs: Sequence[tuple[str, str]],
    *,
    points: Literal["animal", "trial", "row"] = "animal",
    kind: Literal["linear", "power"] = "linear",
    method: Literal["OLS", "RMA"] = "OLS",
    level: float = 0.95,
) -> pd.DataFrame:
    """Fit a line for each pair of columns, and keep what it was fitted to.

    Parameters
    ----------
    measures : pandas.DataFrame
        Strides or trials: animal, trial (optional), and the columns of the pairs.
    pairs : sequence of (outcome, predictor)
        Columns: y and x of each panel.
    points : {"animal", "trial", "row"}
        What a point is: an animal (mean over its trials, with their standard deviation), a
        trial (mean over its strides), or a row. With several points an animal the p of the
        line takes them as independent; the mean slope of the animals stands beside it.
    kind : {"linear", "power"}
        Straight line or power law.
    method : {"OLS", "RMA"}
        Least squares or reduced major axis.
    level : float
        Level of band and intervals.

    Returns
    -------
    pandas.DataFrame
        ``row`` is ``point`` (``animal, x, y, x_sd, y_sd``), ``line`` (``x, y, low, high``) or
        ``animal`` (``animal, x, y``: the animal's own line); the
        columns from ``points`` on are the same in each row of a pair. ``b_animals`` and
        ``p_animals`` are NaN where there is one point an animal.

    Raises
    ------
    InputError
        If a column is missing, there is no pair, a setting is not known, or a line cannot be
        fitted.

    Examples
    --------
    >>> l2 = gait.strides[gait.strides["leg"] == "L2"]
    >>> table = figures.build_regression_table(l2, [("frequency_hz", "speed")], points="trial")
    >>> sorted(table["outcome"].unique())
    ['frequency_hz']
    """
    if not pairs or points not in _UNITS or kind not in ("linear", "power"):
        raise InputError(
            f"regression figure: {len(pairs)} pairs, points {points!r}, kind {kind!r}; expected "
            "at least one pair, points animal, trial or row, kind linear or power."
        )
    names = list(dict.fromkeys(name for pair in pairs for name in pair))
    check_columns(measures, ["animal", *names], where="measures")
    values = _average(measures, names, points)
    tables = []
    for outcome, predictor in pairs:
        known = values.dropna(subset=[outcome, predictor])
        x, y = known[predictor].to_numpy(float), known[outcome].to_numpy(float)
        animals = known["animal"].astype(str).to_numpy()
        line = _fit(x, y, animals, kind=kind, method=method, level=level)
        shown = pd.DataFrame(
            {
                "row": "point", "animal": animals, "x": x, "y": y,
                "x_sd": known[f"{predictor}_sd"].to_numpy(float),
                "y_sd": known[f"{outcome}_sd"].to_numpy(float),
            }
        )  # fmt: skip
        grid = line.predict(np.linspace(line.x_low, line.x_high, _STEPS))
        drawn = grid.rename(columns={"fit": "y"}).assign(row="line", animal="")
        whole = pd.concat([shown, drawn], ignore_index=True)
        inside = None
        if line.n != line.n_animals:
            points_of = shown.rename(columns={"x": "predictor", "y": "outcome"})
            inside = animal_slopes(points_of, "predictor", "outcome", kind=kind, level=level)
        if inside is not None:
            whole = pd.concat([whole, _own_lines(shown, inside)], ignore_index=True)
        tables.append(
            whole.assign(
                outcome=outcome, predictor=predictor, points=points, kind=kind, method=method,
                n=line.n, n_animals=line.n_animals, a=line.a, b=line.b, ci_low=line.b_low,
                ci_high=line.b_high, r2=line.r2, p=line.p, significant=line.significant,
                b_animals=inside.b if inside else math.nan,
                p_animals=inside.p if inside else math.nan,
                significant_animals=inside.significant if inside else False,
            )
        )  # fmt: skip
    return pd.concat(tables, ignore_index=True).reindex(columns=list(COLUMNS))


def _average(measures: pd.DataFrame, names: list[str], points: str) -> pd.DataFrame:
    """Return one row a point, with the standard deviation over an animal's trials."""
    blank = {f"{name}_sd": math.nan for name in names}
    if points == "row":
        return measures[["animal", *names]].assign(**blank)
    trials = measures[["animal", *names]]
    if "trial" in measures:
        trials = measures.groupby(["animal", "trial"], sort=True)[names].mean().reset_index()
    elif points == "trial":
        raise InputError("regression figure: measures have no column trial; use points='animal'.")
    if points == "trial":
        return trials.assign(**blank)
    groups = trials.groupby("animal", sort=True)[names]
    spread = groups.std(ddof=1).add_suffix("_sd")
    return groups.mean().join(spread).reset_index()


def _fit(
    x: FloatArray, y: FloatArray, animals: np.ndarray, *, kind: str, method: str, level: float
) -> Line:
    """Fit the line that was asked for."""
    if method == "RMA":
        power: Literal["linear", "power"] = "power" if kind == "power" else "linear"
        return fit_rma(x, y, kind=power, animals=animals.tolist(), level=level)
    if method != "OLS":
        raise InputError(f"method is {method!r}; expected 'OLS' or 'RMA'.")
    fit = fit_power if kind == "power" else fit_line
    return fit(x, y, animals=animals.tolist(), level=level)


def _own_lines(points: pd.DataFrame, inside: AnimalSlopes) -> pd.DataFrame:
    """Return the own line of each animal, over its own x."""
    parts = []
    for animal, slope in inside.slopes.items():
        x = points.loc[points["animal"] == animal, "x"].to_numpy(float)
        ends = np.linspace(x.min(), x.max(), 12)
        start = inside.intercepts[animal]
        drawn = math.exp(start) * ends**slope if inside.kind == "power" else start + slope * ends
        parts.append(pd.DataFrame({"row": "animal", "animal": animal, "x": ends, "y": drawn}))
    return pd.concat(parts, ignore_index=True)


@checked_arguments
def plot_regression(
    table: pd.DataFrame,
    *,
    ax: Axes | None = None,
    names: Mapping[str, str] | None = None,
    references: Mapping[str, tuple[float, str]] | None = None,
    log: bool = False,
) -> Axes:
    """Draw scatter plots with regression lines, a panel for each pair.

    One point an animal: the line is solid with its confidence band where its interval excludes
    0, else dashed and without band; bars are one standard deviation over the animal's trials.
    Several points an animal: each animal has its own line, solid where the interval of the
    animals' mean slope excludes 0, else dotted; the line through all points as if they were
    independent is grey and dashed. Each animal has a mark.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_regression_table`.
    ax : matplotlib.axes.Axes, optional
        Where to draw a single pair; default a new figure.
    names : mapping, optional
        What columns are called on the axes, with units: ``{"speed": "Speed (cm/s)"}``.
    references : mapping, optional
        Columns to a value that theory or other animals give, and its words, with the source:
        ``{"duty_factor": (0.75, "unstable below (McGhee & Frank 1968)")}``. Each is a dotted
        line, left out where it lies further from the points than three times their range and a
        quarter of their median.
    log : bool
        Logarithmic axes.

    Returns
    -------
    matplotlib.axes.Axes
        The first panel; all are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing, the table is empty, or ``ax`` is given for several pairs.

    Examples
    --------
    >>> l2 = gait.strides[gait.strides["leg"] == "L2"]
    >>> table = figures.build_regression_table(l2, [("frequency_hz", "speed")], points="trial")
    >>> names = {"frequency_hz": "Stride frequency (Hz)", "speed": "Speed (mm/s)"}
    >>> ax = figures.plot_regression(table, names=names)
    """
    check_columns(table, COLUMNS, where="regression figure")
    pairs = [own for _, own in table.groupby(["outcome", "predictor"], sort=False)]
    called = dict(names or {})
    with style():
        # three and more side by side need two columns of a page for their words
        columns = 3 if len(pairs) == 3 else None
        panels = make_panels(
            len(pairs), where="regression figure", ax=ax, columns=columns, height_mm=56.0
        )
        marks = mark_animals(table.loc[table["row"] == "point", "animal"])
        for panel, own in zip(panels, pairs, strict=True):
            first = own.iloc[0]
            _draw(panel, own, marks)
            panel.set_xlabel(called.get(first["predictor"], first["predictor"]))
            panel.set_ylabel(called.get(first["outcome"], first["outcome"]))
            panel.set_title(_words(first), fontsize=small_pt(), loc="right", linespacing=1.15)
            if log:
                use_log_axes(panel)
            for name, along in ((first["outcome"], "x"), (first["predictor"], "y")):
                if name in (references or {}):
                    _draw_reference(panel, own, (references or {})[name], along=along)
        add_animal_legend(panels[0], marks)
    return panels[0]


def _draw(ax: Any, own: pd.DataFrame, marks: Mapping[str, Any]) -> None:
    """Draw points and lines of one pair."""
    first, line = own.iloc[0], own[own["row"] == "line"]
    inside = own[own["row"] == "animal"]
    certain = bool(first["significant"]) and first["n"] == first["n_animals"]
    colour = OKABE_ITO["vermillion"]
    if certain and line["low"].notna().any():
        ax.fill_between(line["x"], line["low"], line["high"], color=colour, alpha=0.2,
                        linewidth=0.0)  # fmt: skip
    ax.plot(line["x"], line["y"], color=colour if certain else "0.55",
            linestyle="-" if certain else "--")  # fmt: skip
    for _, part in inside.groupby("animal", sort=True):
        ax.plot(part["x"], part["y"], color=colour, linewidth=0.8, zorder=2,
                linestyle="-" if first["significant_animals"] else ":")  # fmt: skip
    for animal, points in own[own["row"] == "point"].groupby("animal", sort=True):
        if points[["x_sd", "y_sd"]].notna().any(axis=None):
            ax.errorbar(points["x"], points["y"], xerr=points["x_sd"], yerr=points["y_sd"],
                        linestyle="none", color="0.6", linewidth=0.5, zorder=1.5)  # fmt: skip
        draw_points(ax, points["x"], points["y"], mark=marks[str(animal)], zorder=3)


def _draw_reference(
    ax: Any, own: pd.DataFrame, reference: tuple[float, str], *, along: str
) -> None:
    """Draw a line along one axis, with its words."""
    value, words = reference
    flat = along == "x"
    points = own.loc[own["row"] == "point", "y" if flat else "x"]
    middle = float(points.median())
    reach = max(3.0 * float(np.ptp(points)), 0.25 * abs(middle))
    if not float(points.min()) - reach <= value <= float(points.max()) + reach:
        return
    (ax.axhline if flat else ax.axvline)(
        value, color="0.35", linewidth=0.8, linestyle=(0, (1, 1.5)), zorder=0.5
    )
    at_end, beyond = _place_words(ax, own, value, flat=flat, low=value <= middle)
    look: dict[str, Any] = {"textcoords": "offset points", "fontsize": small_pt(), "color": "0.35",
                            "zorder": 0.6}  # fmt: skip
    along_axis, off = 0.98 if at_end else 0.02, 1 if beyond else -1
    if flat:
        ax.annotate(words, (along_axis, value), xycoords=("axes fraction", "data"),
                    xytext=(0, off), ha="right" if at_end else "left",
                    va="bottom" if beyond else "top", **look)  # fmt: skip
    else:
        ax.annotate(words, (value, along_axis), xycoords=("data", "axes fraction"),
                    xytext=(off, 0), ha="left" if beyond else "right",
                    va="top" if at_end else "bottom", rotation=90, **look)  # fmt: skip


def _place_words(
    ax: Any, own: pd.DataFrame, value: float, *, flat: bool, low: bool
) -> tuple[bool, bool]:
    """Return at which end of a line and on which side of it words touch the fewest points.

    Of places that are alike the words take that on the side of the points: below a high line and
    above a low one they stay within the panel.
    """
    points = own.loc[own["row"] == "point", ["x", "y"]].to_numpy(float)
    ax.autoscale_view()  # the line may lie beyond the points
    to_panel = ax.transData + ax.transAxes.inverted()
    along, across = to_panel.transform(points).T[:: 1 if flat else -1]
    line = to_panel.transform((points[0, 0], value) if flat else (value, points[0, 1]))[int(flat)]
    touched = {}
    for at_end, beyond in ((low, low), (not low, low), (low, not low), (not low, not low)):
        room = 1.0 - line if beyond else line
        beside = (across - line) * (1.0 if beyond else -1.0)
        near = (beside > -0.5 * _WORDS_HIGH) & (beside < _WORDS_HIGH)
        met = near & ((along > 1.0 - _WORDS_LONG) if at_end else (along < _WORDS_LONG))
        touched[at_end, beyond] = met.sum() if room > _WORDS_HIGH else len(points) + 1
    return min(touched, key=lambda place: touched[place])


def _words(first: pd.Series) -> str:
    """Say the fit of one pair in two or three short lines."""
    if first["kind"] == "power":
        # raised, the exponent would be below 6 pt
        law = f"y = {say_number(first['a'])} x^{say_number(first['b'])}"
    else:
        sign = "+" if first["b"] >= 0 else "−"
        law = f"y = {say_number(first['a'])} {sign} {say_number(abs(first['b']))} x"
    law += f"{' (RMA)' if first['method'] == 'RMA' else ''}, r² = {first['r2']:.2f}"
    counted = say_counts(int(first["n"]), _UNITS[first["points"]], int(first["n_animals"]))
    if first["points"] == "animal" or first["n"] == first["n_animals"]:
        return f"{law}\n{_say_p(first['p'])}, {counted.split(', ')[1]}"
    if not math.isfinite(first["b_animals"]):  # nothing can be said of animals
        what, of_whom = counted.split(", ")
        return f"{law}\n{_say_p(first['p'])} if {what}\nof {of_whom} were independent"
    inside = f"animals: b = {say_number(first['b_animals'])}, {_say_p(first['p_animals'])}"
    return f"all: {law}\n{inside}\n{counted}"


def _say_p(p: float) -> str:
    """Say a p value."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.1 else f"p = {p:.2f}"
