"""Figures of a whole study: curves compared, phases at every instant, all measures at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import partial

import pandas as pd

from pawnb import figures
from pawnb.errors import InputError
from pawnb.gait import GaitTables
from pawnb.gait.cycles import HEIGHT, LEG_ANGLE, POSITION, LegSignals, centre_signals, cut_cycles
from pawnb.gait.cycles.tests import compare_cycles
from pawnb.gait.phases.density import phase_density
from pawnb.workflow.gait.drawing.drawings import Drawing, make_drawing
from pawnb.workflow.gait.statistics import Groups, is_paired, known_measures, with_group


def overview_drawings(
    tables: GaitTables, *, groups: Groups | None = None, joints: Sequence[LegSignals] = ()
) -> Iterator[Drawing]:
    """List the figures that show all animals of a study together.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis.
    groups : mapping, optional
        (animal, trial) to its group.
    joints : sequence of LegSignals
        Joint angles of jointed animals.

    Yields
    ------
    Drawing
        Densities of phases at every instant; all measures as a heat map and as principal
        components; with groups, curves over the stride with the stretches that differ.
    """
    signals = signals_by_kind(tables)
    first = next(iter(signals.values()), [])
    yield make_drawing("phase_density", "phase_density", partial(_density, first, tables.strides))
    measures = known_measures(tables.strides)
    of = group_of_animals(groups)
    for kind in ("measure_heat_map", "measure_components"):
        build = getattr(figures, f"build_{kind}_table")
        yield make_drawing(kind, kind, partial(build, tables.strides, measures, groups=of))
    if not groups or len(set(groups.values())) < 2:
        return
    for signal, own in with_joints(signals, joints).items():
        name = "curves_" + signal.replace(" ", "_").replace("-", "_")
        yield make_drawing(name, "cycle_comparison", partial(_curves, own, tables.strides, groups))


def curve_clusters(
    tables: GaitTables, *, groups: Groups | None, joints: Sequence[LegSignals] = ()
) -> pd.DataFrame:
    """Compare curves over the stride between groups, signal by signal.

    Parameters
    ----------
    tables, groups, joints
        As for :func:`overview_drawings`.

    Returns
    -------
    pandas.DataFrame
        :data:`pawnb.gait.cycles.tests.CLUSTER_COLUMNS`; empty where nothing can be compared.
    """
    parts = []
    for own in with_joints(signals_by_kind(tables), joints).values() if groups else ():
        cycles = with_group(cut_cycles(own, tables.strides), groups or {})
        with suppress(InputError):  # fewer than two animals in a group, or no whole stride
            parts.append(compare_cycles(cycles, paired=is_paired(cycles)))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def with_joints(
    signals: dict[str, list[LegSignals]], joints: Sequence[LegSignals]
) -> dict[str, list[LegSignals]]:
    """Return signals by kind, with those of joints behind them.

    Parameters
    ----------
    signals : dict
        From :func:`signals_by_kind`.
    joints : sequence of LegSignals
        Joint angles.

    Returns
    -------
    dict
        Kind to signals.
    """
    every = {kind: list(own) for kind, own in signals.items()}
    for one in joints:
        every.setdefault(one.signal, []).append(one)
    return every


def signals_by_kind(tables: GaitTables) -> dict[str, list[LegSignals]]:
    """Return the signals of an analysis by kind, those that are drawn first in front.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis.

    Returns
    -------
    dict
        Leg angles, positions about the middle of the animal, heights; those that are there.
    """
    kinds = {
        kind: [one for one in tables.signals if one.signal == kind]
        for kind in (LEG_ANGLE, POSITION, HEIGHT)
    }
    kinds[POSITION] = centre_signals(kinds[POSITION])
    return {kind: own for kind, own in kinds.items() if own}


def group_of_animals(groups: Groups | None) -> dict[str, str]:
    """Return the group of each animal that is in one only.

    Parameters
    ----------
    groups : mapping or None
        (animal, trial) to its group.

    Returns
    -------
    dict
        Animal to group; animals that were filmed in several conditions are not there.
    """
    found: dict[str, set[str]] = {}
    for (animal, _), group in (groups or {}).items():
        found.setdefault(animal, set()).add(group)
    return {animal: own.pop() for animal, own in found.items() if len(own) == 1}


def _density(signals: Sequence[LegSignals], strides: pd.DataFrame) -> pd.DataFrame:
    """Return densities of phases."""
    if not signals:
        raise InputError(
            "phase density: no signal of the legs; events alone tell no phase between."
        )
    return phase_density(signals, strides)


def _curves(signals: Sequence[LegSignals], strides: pd.DataFrame, groups: Groups) -> pd.DataFrame:
    """Return curves of groups, and where they differ."""
    cycles = with_group(cut_cycles(signals, strides), groups)
    return figures.build_cycle_comparison_table(cycles, paired=is_paired(cycles))
