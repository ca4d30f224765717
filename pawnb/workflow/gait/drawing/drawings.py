"""Which figures the gait tables give: each with its name, its table and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import pandas as pd

from pawnb import figures
from pawnb.errors import InputError
from pawnb.figures.panels import speed_unit, with_unit
from pawnb.files import safe_name
from pawnb.gait import GaitTables
from pawnb.gait.analysis.notes import Note, trial_of
from pawnb.gait.coordination import coordination_tables
from pawnb.gait.cycles import (
    HEIGHT,
    LEG_ANGLE,
    POSITION,
    LegSignals,
    align_acceleration,
    average_cycles,
    centre_signals,
    cut_cycles,
)
from pawnb.workflow.gait.statistics import Groups, is_paired, length_unit, with_group

Drawn = tuple[pd.DataFrame, Any]


@dataclass(frozen=True)
class Drawing:
    """One figure that can be drawn.

    Parameters
    ----------
    name : str
        Name of its files.
    kind : str
        Name of the figure: ``plot_<kind>`` draws it.
    draw : callable
        Makes the table and draws it; raises InputError where it cannot.
    """

    name: str
    kind: str
    draw: Callable[[], Drawn]


def gait_drawings(
    tables: GaitTables,
    *,
    groups: Groups | None = None,
    notes: Sequence[str] | None = None,
    references: Mapping[str, tuple[float, str]] | None = None,
) -> Iterator[Drawing]:
    """List the figures of an analysis.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis.
    groups : mapping, optional
        (animal, trial) to its group: measures of the groups are drawn side by side.
    notes : sequence of str, optional
        What the pages of animals tell of the run; default the notes of the tables.
    references : mapping, optional
        Lines beside measures against speed; see :func:`pawnb.figures.plot_regression`.

    Yields
    ------
    Drawing
        Trial by trial, then of all animals together, then animal by animal.
    """
    unit = length_unit(tables)
    yield from _of_trials(tables)
    yield from _of_phases(tables, unit)
    yield from _of_coordination(tables)
    yield from _of_signals(tables)
    yield from _of_strides(
        tables, unit, tables.notes if notes is None else notes, references=references
    )
    if groups:
        yield from _of_groups(tables, groups, unit)


def make_drawing(
    name: str, kind: str, build: Callable[[], pd.DataFrame], **options: Any
) -> Drawing:
    """Return a drawing whose table is built when it is drawn.

    Parameters
    ----------
    name : str
        Name of its files.
    kind : str
        ``plot_<kind>`` of :mod:`pawnb.figures` draws it.
    build : callable
        Makes the table.
    **options
        Of ``plot_<kind>``.

    Returns
    -------
    Drawing
        The drawing.
    """

    def draw() -> Drawn:
        table = build()
        return table, getattr(figures, f"plot_{kind}")(table, **options)

    return Drawing(name, kind, draw)


def _of_trials(tables: GaitTables) -> Iterator[Drawing]:
    """Gait diagram of every trial."""
    for (animal, trial), own in tables.events.groupby(["animal", "trial"], sort=False):
        gone = tables.dropped
        gone = gone[(gone["animal"] == animal) & (gone["trial"] == trial)]
        events = own.reset_index(drop=True)
        yield make_drawing(
            f"gait_diagram_{safe_name(f'{animal}_{trial}')}",
            "gait_diagram",
            partial(figures.build_gait_diagram_table, events, dropped=gone),
        )


def _of_phases(tables: GaitTables, unit: str | None) -> Iterator[Drawing]:
    """Phases: roses, histograms, against speed; Hildebrand's diagram of four legs."""
    phases, strides, summary = tables.phases, tables.strides, tables.phase_summary
    steps = partial(
        figures.build_stepping_pattern_table, tables.events, strides, dropped=tables.dropped
    )
    yield make_drawing("stepping_pattern", "stepping_pattern", steps, unit=unit)
    rose = partial(figures.build_phase_rose_table, phases, summary=summary)
    yield make_drawing("phase_rose", "phase_rose", rose)
    histogram = partial(figures.build_phase_histogram_table, phases, summary=summary)
    yield make_drawing("phase_histogram", "phase_histogram", histogram)
    speed = partial(figures.build_phase_speed_table, phases, strides)
    yield make_drawing("phase_speed", "phase_speed", speed, unit=unit)
    if {"FR", "HR"} <= set(strides["leg"]) or {"FL", "HL"} <= set(strides["leg"]):
        both = partial(figures.build_hildebrand_diagram_table, strides, phases)
        yield make_drawing("hildebrand_diagram", "hildebrand_diagram", both)


def _of_coordination(tables: GaitTables) -> Iterator[Drawing]:
    """Feet on the ground, and distances to ideal gaits."""
    found = coordination_tables(tables)

    def build(name: str) -> pd.DataFrame:
        if name not in found:
            raise InputError(f"{name}: these events and phases give no such table.")
        return found[name]

    yield make_drawing("support_shares", "support_shares", partial(build, "support_shares"))
    yield make_drawing("pattern_distances", "pattern_distances", partial(build, "patterns"))


def _of_signals(tables: GaitTables) -> Iterator[Drawing]:
    """Averages over the stride of every signal; phase plane and acceleration of the first."""
    strides = tables.strides
    by_kind: dict[str, list[LegSignals]] = {}
    for one in centre_signals([one for one in tables.signals if one.signal == POSITION]):
        by_kind.setdefault(POSITION, []).append(one)
    for one in tables.signals:
        if one.signal == POSITION:
            continue
        by_kind.setdefault(one.signal, []).append(one)
    kinds = [kind for kind in (LEG_ANGLE, POSITION, HEIGHT) if kind in by_kind]
    for kind in kinds:
        name = "stride_average_" + kind.replace(" ", "_").replace("-", "_")
        yield make_drawing(name, "stride_average", partial(_average, by_kind[kind], strides))
    if not kinds:
        return
    first = by_kind[kinds[0]]
    yield make_drawing("phase_plane", "phase_plane", partial(_plane, first, strides))
    for phase in ("swing", "stance"):
        name = f"aligned_acceleration_{phase}"
        yield make_drawing(
            name, "aligned_acceleration", partial(_aligned, first, strides, phase=phase)
        )


def _one_unit(signals: list[LegSignals]) -> None:
    """Refuse signals in several units: they cannot share a figure."""
    units = sorted({one.unit for one in signals})
    if len(units) > 1:
        raise InputError(
            f"{signals[0].signal}: trials in {' and in '.join(units)}; analyse them apart."
        )


def _average(signals: list[LegSignals], strides: pd.DataFrame) -> pd.DataFrame:
    """Return the average over the stride."""
    _one_unit(signals)
    return average_cycles(cut_cycles(signals, strides))


def _plane(signals: list[LegSignals], strides: pd.DataFrame) -> pd.DataFrame:
    """Return the cycles in the phase plane."""
    _one_unit(signals)
    return figures.build_phase_plane_table(cut_cycles(signals, strides))


def _aligned(signals: list[LegSignals], strides: pd.DataFrame, *, phase: str) -> pd.DataFrame:
    """Return the aligned acceleration."""
    _one_unit(signals)
    aligned = align_acceleration(signals, strides, phase=phase)
    return figures.build_aligned_acceleration_table(aligned)


def _of_strides(
    tables: GaitTables,
    unit: str | None,
    notes: Sequence[str],
    *,
    references: Mapping[str, tuple[float, str]] | None,
) -> Iterator[Drawing]:
    """Stride measures against speed, and a page for every animal."""
    strides = tables.strides
    names = _axis_names(unit)
    pairs = [(name, "speed") for name in names if name != "speed"]
    lines = partial(figures.build_regression_table, strides, pairs, points="trial")
    yield make_drawing(
        "against_speed", "regression", lines, names=names, references=dict(references or {})
    )
    for animal in sorted(strides["animal"].astype(str).unique()):
        yield make_drawing(
            f"summary_{safe_name(animal)}",
            "summary_page",
            partial(figures.build_summary_page_table, strides, animal=animal),
            events=tables.events,
            strides=strides,
            phases=tables.phases,
            dropped=tables.dropped,
            unit=unit,
            notes=_about(animal, strides, notes),
        )


def _about(animal: str, strides: pd.DataFrame, notes: Sequence[str]) -> list[str]:
    """Return the notes that are about an animal: all but those about trials of others."""
    trials = strides[["animal", "trial"]].drop_duplicates().astype(str)
    own = trials["animal"] == animal
    others = set(trials.loc[~own, "trial"]) - set(trials.loc[own, "trial"])
    others |= {trial_of(*one) for one in trials[~own].itertuples(index=False, name=None)}
    return [note for note in notes if not (isinstance(note, Note) and note.where in others)]


def _axis_names(unit: str | None) -> dict[str, str]:
    """Return what the main measures are called on an axis."""
    return {
        "speed": with_unit("Speed", speed_unit(unit)),
        "frequency_hz": "Stride frequency (Hz)",
        "stride_length": with_unit("Stride length", unit),
        "duty_factor": "Duty factor (fraction)",
    }


def _of_groups(tables: GaitTables, groups: Groups, unit: str | None) -> Iterator[Drawing]:
    """Each animal, means of groups, and their differences with intervals."""
    strides = with_group(tables.strides, groups)
    if strides["group"].nunique() < 2:
        return
    paired = is_paired(strides)
    for measure, label in _axis_names(unit).items():
        if strides[measure].notna().any():
            build = partial(
                figures.build_estimation_table, strides, measure, paired=paired, average_over="leg"
            )
            yield make_drawing(f"estimation_{measure}", "estimation", build, label=label)
