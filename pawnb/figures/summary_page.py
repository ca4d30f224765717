"""One page about one animal: gait diagram, roses, table of strides, and what speed changes."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from pawnb.errors import InputError
from pawnb.figures.gait_diagram import build_gait_diagram_table, plot_gait_diagram
from pawnb.figures.numbers_shown import say_number
from pawnb.figures.panels import add_note, new_figure, speed_unit, with_unit
from pawnb.figures.phase_rose import build_phase_rose_table, plot_phase_rose
from pawnb.figures.regression import build_regression_table, plot_regression
from pawnb.figures.stepping_pattern import choose_window
from pawnb.figures.style import get_style, size_mm, small_pt, style
from pawnb.gait.legs import sort_legs
from pawnb.schema import check_columns
from pawnb.schema.arguments import checked_arguments

A4_MM = (210.0, 297.0)
_MARGIN_MM = 15.0
MEASURES = {
    "frequency_hz": "Frequency\n(Hz)",
    "stance_s": "Stance\n(s)",
    "swing_s": "Swing\n(s)",
    "duty_factor": "Duty factor\n(fraction)",
    "stride_length": "Stride length\n({unit})",
    "speed": "Speed\n({unit}/s)",
}
"""Columns of the table of strides, and what they are called."""

_SHOWN_STRIDES = 8.0
_MOST_ROSES = 4
_LINES_ON_A4 = 9
"""Lines of notes that find room; for more the page is longer, the rest stays as it is."""
_LINE_SHARE = 0.07
_SIGNS_A_LINE = 150
_LEAST_SPREAD = 1e-4


@checked_arguments
def build_summary_page_table(strides: pd.DataFrame, *, animal: str) -> pd.DataFrame:
    """Describe the strides of one animal leg by leg.

    Parameters
    ----------
    strides : pandas.DataFrame
        ``STRIDES_COLUMNS``.
    animal : str
        The animal.

    Returns
    -------
    pandas.DataFrame
        One row a leg: ``animal, leg, n_strides, n_trials``, and for each of :data:`MEASURES`
        ``..._mean`` and ``..._sd`` over its strides (NaN where not known; SD of one stride).
        The SD describes this animal; it says nothing of others.

    Raises
    ------
    InputError
        If a column is missing or the animal has no stride.

    Examples
    --------
    >>> table = figures.build_summary_page_table(gait.strides, animal="spider-01")
    >>> len(table) > 0
    True
    """
    check_columns(strides, ("animal", "trial", "leg", *MEASURES), where="strides")
    own = strides[strides["animal"].astype(str) == animal]
    if len(own) == 0:
        raise InputError(f"summary page: no strides of animal {animal!r}.")
    rows = []
    for leg in sort_legs(own["leg"]):
        part = own[own["leg"] == leg]
        row: dict[str, Any] = {
            "animal": animal, "leg": leg, "n_strides": len(part),
            "n_trials": part["trial"].nunique(),
        }  # fmt: skip
        for name in MEASURES:
            row[f"{name}_mean"] = float(part[name].mean())
            row[f"{name}_sd"] = float(part[name].std(ddof=1))
        rows.append(row)
    return pd.DataFrame(rows)


@checked_arguments
def plot_summary_page(
    table: pd.DataFrame,
    *,
    events: pd.DataFrame,
    strides: pd.DataFrame,
    phases: pd.DataFrame,
    dropped: pd.DataFrame | None = None,
    unit: str | None = None,
    notes: Sequence[str] = (),
) -> Axes:
    """Draw the page, A4 upright; with many notes it is longer.

    Shown are eight strides of the trial with the most strides, the phases of up to four pairs
    of legs, the table, and stride frequency, stride length and duty factor against speed
    where speeds are known. What cannot be shown leaves its place with a word why.

    Parameters
    ----------
    table : pandas.DataFrame
        From :func:`build_summary_page_table`.
    events, strides, phases : pandas.DataFrame
        The gait tables; rows of other animals are left out.
    dropped : pandas.DataFrame, optional
        As for :func:`~pawnb.figures.build_gait_diagram_table`: what is not known is hatched.
    unit : str, optional
        Unit of length.
    notes : sequence of str
        What a reader must know, written below; the page is longer where they need more than
        nine lines.

    Returns
    -------
    matplotlib.axes.Axes
        The gait diagram; all panels are in ``ax.figure.axes``.

    Raises
    ------
    InputError
        If a column is missing or the table is empty.

    Examples
    --------
    >>> table = figures.build_summary_page_table(gait.strides, animal="spider-01")
    >>> ax = figures.plot_summary_page(
    ...     table, events=gait.events, strides=gait.strides, phases=gait.phases,
    ...     dropped=gait.dropped, unit="mm",
    ... )
    """
    check_columns(table, ("animal", "leg", "n_strides", "n_trials"), where="summary page")
    if len(table) == 0:
        raise InputError("summary page: the table is empty.")
    animal = str(table["animal"].iloc[0])
    events, strides, phases = (
        part[part["animal"].astype(str) == animal] for part in (events, strides, phases)
    )
    with style():
        lines = _wrap_notes(notes)
        ratios = [0.12, 0.45 + 0.08 * len(table), 1.1, 0.4 + 0.1 * len(table), 1.1]
        ratios += [0.15 + _LINE_SHARE * len(lines)] if lines else []
        figure = _new_page(sum(ratios), further=max(0, len(lines) - _LINES_ON_A4))
        rows: Any = figure.subfigures(len(ratios), 1, height_ratios=ratios)
        first = _draw_diagram(rows[1], events, strides, dropped)
        _draw_roses(rows[2], phases)
        _draw_table(rows[3], table, unit)
        _draw_lines(rows[4], strides, unit)
        if lines:
            _write_notes(rows[5], lines)
        n, trials = int(table["n_strides"].sum()), strides["trial"].nunique()
        rows[0].text(
            0.5, 0.5, f"Animal {animal}: {n} strides of {len(table)} legs in {trials} "
            f"trial{'s' * (trials != 1)}",
            fontsize=get_style().font_size_pt + 4.0, ha="center", va="center",
        )  # fmt: skip
    return first


def _new_page(height: float, *, further: int) -> Any:
    """Return a page with margins, A4 but for the lines of notes that find no room there.

    Parameters
    ----------
    height : float
        Of all that is on the page, in the unit of the parts' ratios.
    further : int
        Lines of notes that find no room.

    Returns
    -------
    Figure
        The page.
    """
    inner = A4_MM[1] - 2.0 * _MARGIN_MM
    longer = inner * height / (height - _LINE_SHARE * further)
    width, length = A4_MM[0], longer + 2.0 * _MARGIN_MM
    figure = new_figure(figsize=size_mm(width, length))
    left, low = _MARGIN_MM / width, _MARGIN_MM / length
    layout: Any = figure.get_layout_engine()
    layout.set(rect=(left, low, 1.0 - 2.0 * left, 1.0 - 2.0 * low), h_pad=0.06, hspace=0.03)
    return figure


def _part_of_bars(table: pd.DataFrame, start: float, stop: float) -> pd.DataFrame:
    """Return bars as far as they are within a stretch; those that go on beyond it are cut.

    Bars outside have no width, so that each leg keeps its row.
    """
    begin, end = table["start_s"].clip(start, stop), table["end_s"].clip(start, stop)
    shown, stance = end > begin, table["phase"] == "stance"
    cut = table["cut"].where(shown, "")
    cut = cut.mask(shown & stance & (begin > table["start_s"]), "start")
    cut = cut.mask(shown & stance & (end < table["end_s"]), "end")
    return table.assign(start_s=begin, end_s=end, cut=cut)


def _draw_diagram(
    part: Any, events: pd.DataFrame, strides: pd.DataFrame, dropped: pd.DataFrame | None
) -> Axes:
    """Draw some strides of the trial that has the most."""
    ax: Axes = part.subplots()
    trial = strides["trial"].value_counts(sort=True).index[0]
    own = events[events["trial"] == trial]
    table = build_gait_diagram_table(own, dropped=dropped)
    period = float(strides.loc[strides["trial"] == trial, "period_s"].median())
    low, high = float(table["start_s"].min()), float(table["end_s"].max())
    span_s = _SHOWN_STRIDES * period
    start = choose_window(strides[strides["trial"] == trial], (low, high), span_s)
    stop = min(high, start + span_s)
    plot_gait_diagram(_part_of_bars(table, start, stop), ax=ax)
    ax.set_xlim(start, stop)
    _title(part, f"a  Gait diagram, trial {trial}")
    return ax


def _draw_roses(part: Any, phases: pd.DataFrame) -> None:
    """Draw the phases of the first pairs of legs."""
    pairs = list(dict.fromkeys(zip(phases["leg"], phases["reference"], strict=True)))
    _title(part, "b  Phase lags (cycles)")
    if not pairs:
        _say_nothing(part, "no phases: fewer than two legs with strides at the same time")
        return
    shown = pairs[:_MOST_ROSES]
    table = build_phase_rose_table(phases, pairs=shown)
    axes = part.subplots(1, len(shown), subplot_kw={"projection": "polar"}, squeeze=False)
    for ax, (_, own) in zip(
        axes.flat, table.groupby(["leg", "reference"], sort=False), strict=True
    ):
        plot_phase_rose(own, ax=ax)


def _draw_table(part: Any, table: pd.DataFrame, unit: str | None) -> None:
    """Write the table of strides: mean and SD, and how many strides each leg has."""
    ax = part.subplots()
    ax.set_axis_off()
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(len(table) + 0.5, -1.6)
    _title(part, "c  Strides of each leg: mean (SD over its strides)")
    names = [name for name in MEASURES if table[f"{name}_mean"].notna().any()]
    places = np.linspace(0.2, 0.95, len(names))
    for x, word in ((0.0, "Leg"), (0.09, "n")):
        ax.text(x, -0.5, word, va="center")
    for x, name in zip(places, names, strict=True):
        ax.text(x, -0.5, MEASURES[name].format(unit=unit or "units"), ha="center", va="center")
    for row, leg in enumerate(table.itertuples()):
        ax.text(0.0, row + 0.5, str(leg.leg), va="center")
        ax.text(0.09, row + 0.5, str(leg.n_strides), va="center")
        for x, name in zip(places, names, strict=True):
            mean, sd = (float(table[f"{name}_{what}"].iloc[row]) for what in ("mean", "sd"))
            ax.text(x, row + 0.5, _say_spread(mean, sd), ha="center", va="center")
    for y in (-1.2, 0.1, len(table) + 0.2):
        ax.axhline(y, color="black", linewidth=0.6)


def _say_spread(mean: float, sd: float) -> str:
    """Return mean and SD, with as many decimals as two digits of the SD need."""
    if not np.isfinite(mean):
        return "not known"
    if not np.isfinite(sd) or sd <= 0.0:
        return say_number(mean)
    if sd < _LEAST_SPREAD * abs(mean):  # rounding, not spread
        return f"{mean:.4g} (0)"
    decimals = max(0, 1 - int(np.floor(np.log10(sd))))
    return f"{mean:.{decimals}f} ({sd:.{decimals}f})"


def _title(part: Any, words: str) -> None:
    """Write the title of a part of the page."""
    part.suptitle(words, x=0.0, ha="left", fontsize=get_style().font_size_pt + 1.0,
                  fontweight="bold")  # fmt: skip


def _wrap_notes(notes: Sequence[str]) -> list[str]:
    """Return the lines of the notes."""
    wrapped = (textwrap.wrap(f"- {n}", _SIGNS_A_LINE, subsequent_indent="  ") for n in notes)
    return [line for lines in wrapped for line in lines]


def _write_notes(part: Any, lines: list[str]) -> None:
    """Write the notes."""
    _title(part, "e  Notes")
    ax = part.subplots()
    ax.set_axis_off()
    # names may hold signs that would begin a formula
    ax.text(0.0, 1.0, "\n".join(lines), va="top", fontsize=small_pt())


def _draw_lines(part: Any, strides: pd.DataFrame, unit: str | None) -> None:
    """Draw frequency, length and duty factor against speed."""
    _title(part, "d  Against speed")
    if not strides["speed"].notna().any():
        _say_nothing(part, "no speeds: they need tracks, or a belt speed")
        return
    names = {
        "speed": with_unit("Speed", speed_unit(unit)),
        "frequency_hz": "Stride frequency (Hz)",
        "stride_length": with_unit("Stride length", unit),
        "duty_factor": "Duty factor (fraction)",
    }
    points: Any = "trial" if strides["trial"].nunique() >= 3 else "row"
    outcomes = [name for name in names if name != "speed"]
    for ax, name in zip(part.subplots(1, len(outcomes)), outcomes, strict=True):
        try:
            table = build_regression_table(strides, [(name, "speed")], points=points)
        except InputError:  # too few points, or all at one speed
            ax.plot(strides["speed"], strides[name], linestyle="none", marker="o",
                    markersize=2.5, color="black")  # fmt: skip
            add_note(ax, "no line: too few speeds")
            ax.set_xlabel(names["speed"])
            ax.set_ylabel(names[name])
            continue
        plot_regression(table, ax=ax, names=names)


def _say_nothing(part: Any, why: str) -> None:
    """Say why a part of the page is empty."""
    ax = part.subplots()
    ax.set_axis_off()
    ax.text(0.5, 0.5, why, ha="center", va="center", fontsize=small_pt())
