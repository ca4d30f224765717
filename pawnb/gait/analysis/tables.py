"""The tables of a gait analysis: made from events, and pooled over trials and animals."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from pawnb.errors import InputError, did_you_mean
from pawnb.files import as_word
from pawnb.gait.analysis.notes import Note
from pawnb.gait.analysis.plausibility import say_implausible
from pawnb.gait.analysis.stride_measures import measure_strides
from pawnb.gait.analysis.stride_support import measure_support
from pawnb.gait.cycles.leg_signals import LegSignals
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.legs import default_pairs, sort_legs
from pawnb.gait.phases.phase_table import build_phases, summarise_phases
from pawnb.gait.strides.stride_table import (
    TRIAL_KEYS,
    Motion,
    build_strides,
    choose_stride_event,
)
from pawnb.schema.arguments import checked_arguments

Pairs = Sequence[tuple[str, str]]
_GAIT_TABLES = ("events", "strides", "phases", "phase_summary", "dropped")


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialBasis:
    """What the tables of one animal and trial are made from beside its events.

    The arguments of :func:`build_tables`, kept so that :func:`rebuild_tables` can make the
    tables again from other events.
    """

    who: Mapping[str, str]
    pairs: Pairs | None
    motion: Mapping[str, Motion] | None
    gaps: pd.DataFrame | None
    legs: Sequence[str] | None
    dropped: pd.DataFrame | None
    signals: Sequence[LegSignals]
    body_length: float | None
    settings: EventSettings


@dataclass(frozen=True, kw_only=True, eq=False)
class GaitTables:
    """The tables of a gait analysis.

    Parameters
    ----------
    events, strides, phases, phase_summary, dropped : pandas.DataFrame
        Tables with the columns of :mod:`pawnb.schema`, some with further columns on the
        right. Rows are ordered by trial, leg and time.
    notes : tuple of str
        What was assumed or estimated, one sentence each;
        :class:`~pawnb.gait.analysis.notes.Note` where it is about one trial.
    settings : EventSettings
        The settings that were asked for.
    signals : tuple of LegSignals
        The smoothed signals the events were found in, of analyses of Tracks; see
        :mod:`pawnb.gait.cycles`.
    bases : tuple of TrialBasis
        What the tables of each trial were made from, for :func:`rebuild_tables`.
    found : GaitTables, optional
        The same analysis before events were corrected by hand; None where none were.

    Examples
    --------
    >>> gait = pawnb.gait.analyse(tracks, trial=run.trial)
    >>> gait.phase_summary[["leg", "reference", "mean", "pattern"]].shape[1]
    4
    """

    events: pd.DataFrame
    strides: pd.DataFrame
    phases: pd.DataFrame
    phase_summary: pd.DataFrame
    dropped: pd.DataFrame
    notes: tuple[str, ...] = ()
    settings: EventSettings = field(default_factory=EventSettings)
    signals: tuple[LegSignals, ...] = ()
    bases: tuple[TrialBasis, ...] = ()
    found: GaitTables | None = None

    @property
    def trials(self) -> tuple[tuple[str, str], ...]:
        """Each animal and trial that was analysed, also those in which no event was found."""
        found = self.events[TRIAL_KEYS].astype(str).itertuples(index=False, name=None)
        known = ((str(basis.who["animal"]), str(basis.who["trial"])) for basis in self.bases)
        return tuple(dict.fromkeys([*found, *known]))

    def __repr__(self) -> str:
        """Return how large each table is; the tables themselves are for their own cells."""
        n_animals, n_trials = len({animal for animal, _ in self.trials}), len(self.trials)
        sizes = [f"{name}: {len(getattr(self, name))} rows" for name in _GAIT_TABLES]
        more = [f"{len(self.notes)} notes", *(["corrected by hand"] if self.found else [])]
        legs = {leg for basis in self.bases for leg in basis.legs or ()} | {*self.events["leg"]}
        without = sort_legs(legs - {*self.strides["leg"]})
        more += [f"no stride of {', '.join(without)}"] * bool(without)
        of = (
            f"{n_trials} trial{'s' * (n_trials != 1)} of {n_animals} animal{'s' * (n_animals != 1)}"
        )
        return f"GaitTables({of}; {', '.join(sizes)}; {', '.join(more)})"


@checked_arguments
def pool(parts: Sequence[GaitTables], *, settings: EventSettings | None = None) -> GaitTables:
    """Put several analyses together; the phase summary is made anew over all of them.

    Parameters
    ----------
    parts : sequence of GaitTables
        Analyses of trials. Trials of one animal must carry the same animal's name.
    settings : EventSettings, optional
        What the settings of all have in common, where trials may have some of their own; default
        all must be made with the same.

    Returns
    -------
    GaitTables
        Tables one below the other, in the order given.

    Raises
    ------
    InputError
        If there is nothing to pool, two parts hold the same animal and trial, or their
        settings differ.

    Examples
    --------
    >>> parts = [pawnb.gait.analyse(one.tracks(), trial=one.trial) for one in study.runs]
    >>> gait = pawnb.gait.pool(parts)
    >>> gait.strides["animal"].unique().tolist()
    ['spider-01', 'spider-02']
    """
    parts = [parts] if isinstance(parts, GaitTables) else list(parts)
    wrong = [part for part in parts if not isinstance(part, GaitTables)]
    if wrong:
        raise InputError(
            f"to pool: found {type(wrong[0]).__name__}; expected analyses, as pawnb.gait.analyse "
            "makes."
        )
    if not parts:
        raise InputError("nothing to pool: expected at least one analysis.")
    seen: set[tuple[str, str]] = set()
    for part in parts:
        both = (part.events[TRIAL_KEYS], part.dropped[TRIAL_KEYS])
        own = {tuple(row) for t in both for row in t.drop_duplicates().to_numpy()}
        double = sorted(seen & own)
        if double:
            raise InputError(
                f"animal {double[0][0]!r}, trial {double[0][1]!r} is there twice; give every "
                "trial its own name."
            )
        seen |= own
        if settings is None and part.settings != parts[0].settings:
            raise InputError(
                "the analyses were made with different settings; make them again with the same."
            )
    tables = {
        name: _stack([getattr(part, name) for part in parts])
        for name in ("events", "strides", "phases", "dropped")
    }
    return GaitTables(
        **tables,
        phase_summary=summarise_phases(tables["phases"]),
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
        settings=settings or parts[0].settings,
        signals=tuple(one for part in parts for one in part.signals),
        bases=tuple(one for part in parts for one in part.bases),
        found=_pool_found(parts, settings),
    )


def _pool_found(parts: Sequence[GaitTables], settings: EventSettings | None) -> GaitTables | None:
    """Return what the parts were before corrections; None where no part has any."""
    if all(part.found is None for part in parts):
        return None
    return pool([part if part.found is None else part.found for part in parts], settings=settings)


def rebuild_tables(
    tables: GaitTables,
    events: pd.DataFrame,
    *,
    excluded: pd.DataFrame | None = None,
    trials: Collection[tuple[str, str]] | None = None,
) -> GaitTables:
    """Make strides, phases and their summary again from other events.

    Parameters
    ----------
    tables : GaitTables
        The result of an analysis; a selection made from it later is not kept in what is made
        again.
    events : pandas.DataFrame
        Events of the same trials, in the order of ``tables.events``.
    excluded : pandas.DataFrame, optional
        Strides that shall not count: ``animal, trial, leg, time_s`` (within the stride), ``why``.
    trials : collection of (animal, trial), optional
        Where events or excluded strides are others; the rest stays as it is, which is far
        quicker than making it again. Default all.

    Returns
    -------
    GaitTables
        The tables, with the notes, settings and signals they had.

    Raises
    ------
    InputError
        If the tables do not come from an analysis.
    """
    if not tables.bases:
        raise InputError(
            "these tables do not say what they were made from; analyse tracks or events again."
        )
    parts = []
    for basis in tables.bases:
        if trials is not None and (basis.who["animal"], basis.who["trial"]) not in trials:
            parts.append(_part_of(tables, basis))
            continue
        own = of_trial(events, basis.who).reset_index(drop=True)
        without = None if excluded is None else of_trial(excluded, basis.who)
        parts.append(build_tables(own, excluded=without, **vars(basis)))
    pooled = pool(parts, settings=tables.settings)
    return replace(pooled, notes=tables.notes, bases=tables.bases)


def _part_of(tables: GaitTables, basis: TrialBasis) -> GaitTables:
    """Return the tables of one animal and trial as they are; :func:`pool` sums up phases."""
    return GaitTables(
        events=of_trial(tables.events, basis.who),
        strides=of_trial(tables.strides, basis.who),
        phases=of_trial(tables.phases, basis.who),
        phase_summary=tables.phase_summary.head(0),
        dropped=of_trial(tables.dropped, basis.who),
        settings=tables.settings,
        signals=tuple(basis.signals),
    )


def of_trial(table: pd.DataFrame, who: Mapping[str, str]) -> pd.DataFrame:
    """Return the rows of one animal and trial.

    Parameters
    ----------
    table : pandas.DataFrame
        A table of gait.
    who : mapping
        ``animal`` and ``trial``.

    Returns
    -------
    pandas.DataFrame
        Its rows.
    """
    return table[(table["animal"] == who["animal"]) & (table["trial"] == who["trial"])]


def build_tables(
    events: pd.DataFrame,
    who: Mapping[str, str],
    *,
    pairs: Pairs | None,
    settings: EventSettings,
    motion: Mapping[str, Motion] | None = None,
    gaps: pd.DataFrame | None = None,
    legs: Sequence[str] | None = None,
    dropped: pd.DataFrame | None = None,
    notes: Sequence[str] = (),
    signals: Sequence[LegSignals] = (),
    body_length: float | None = None,
    excluded: pd.DataFrame | None = None,
) -> GaitTables:
    """Make the tables of one animal and trial from its events; :func:`pool` sums up phases.

    Parameters
    ----------
    events : pandas.DataFrame
        Events of one animal and trial, in order.
    who : mapping
        ``animal`` and ``trial``.
    pairs : sequence of (leg, reference), optional
        Pairs whose phase is measured; None for the usual ones.
    settings : EventSettings
        Settings.
    motion : mapping, optional
        Motion by the name of the leg.
    gaps : pandas.DataFrame, optional
        Stretches that no stride may hold; see :func:`pawnb.gait.strides.build_strides`.
    legs : sequence of str, optional
        Legs in anatomical order; default those of the events.
    dropped : pandas.DataFrame, optional
        What was dropped before.
    notes : sequence of str
        What a reader should know.
    signals : sequence of LegSignals
        Smoothed signals of the legs.
    body_length : float, optional
        Length of the body in the unit of the positions.
    excluded : pandas.DataFrame, optional
        Strides that shall not count; see :func:`pawnb.gait.strides.build_strides`.

    Returns
    -------
    GaitTables
        The tables, the summary of phases still empty.

    Raises
    ------
    InputError
        If a pair names a leg that is not there.
    """
    legs = sort_legs(events["leg"]) if legs is None else legs
    chosen = default_pairs(legs) if pairs is None else _checked_pairs(pairs, legs)
    start = choose_stride_event(events, settings.stride_events)
    strides, no_strides = build_strides(
        events, start_event=start, motion=motion, gaps=gaps, max_stride_s=settings.max_stride_s,
        excluded=excluded,
    )  # fmt: skip
    strides = measure_strides(
        strides, motion=motion, signals=signals, body_length=body_length, settings=settings
    )
    strides = measure_support(strides, events, signals=signals)
    phases, no_phases = build_phases(events, strides, chosen, start_event=start)
    all_dropped = [t for t in (dropped, no_strides, no_phases) if t is not None]
    times = signals[0].time_s if signals else ()
    fps = 1.0 / float(np.median(np.diff(times))) if len(times) > 1 else None
    remarks = [*notes, *say_implausible(strides, fps=fps)]
    if not chosen:
        remarks.append(_how_to_pair(legs))
    return GaitTables(
        events=events,
        strides=strides,
        phases=phases,
        phase_summary=summarise_phases(phases.head(0)),
        dropped=_stack(all_dropped),
        notes=tuple(Note(note, where=who["trial"]) for note in remarks),
        settings=settings,
        signals=tuple(signals),
        bases=(
            TrialBasis(
                who=who, pairs=pairs, motion=motion, gaps=gaps, legs=legs, dropped=dropped,
                signals=signals, body_length=body_length, settings=settings,
            ),
        ),
    )  # fmt: skip


def say_whose_notes(parts: Sequence[GaitTables]) -> list[GaitTables]:
    """Say of each note, of several animals in one recording, whose it is, unless it is of all.

    Parameters
    ----------
    parts : sequence of GaitTables
        The analysis of each animal.

    Returns
    -------
    list of GaitTables
        The same, with the animal before the words of its own notes.
    """
    seen = [part for part in parts if part.bases[0].motion]
    shared = set.intersection(*(set(part.notes) for part in seen)) if seen else set()
    told = []
    for part in parts:
        who = part.bases[0].who
        notes = (
            note
            if note in shared
            else Note(f"{who['animal']}: {Note(note).what}", where=who["trial"])
            for note in part.notes
        )
        told.append(replace(part, notes=tuple(notes)))
    return told


def _stack(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Put tables below each other; empty ones only lend their columns."""
    full = [t for t in tables if len(t)]
    return pd.concat(full, ignore_index=True) if full else tables[0].reset_index(drop=True)


def _how_to_pair(legs: Sequence[str]) -> str:
    """Say that no legs are a pair, and how two become one."""
    said = "no pair of legs by name; name them with pairs for phases"
    if len(legs) < 2:
        return f"{said}."
    one, two = legs[:2]
    # double quotes outside and single ones inside hold in every shell, those of Windows too
    pairs = f"\"pairs=[['{one}','{two}']]\""
    return (
        f"{said} (--set {pairs}), or call them as a left and a right one with legs (--legs "
        f"HL={as_word(one)} HR={as_word(two)})."
    )


def _checked_pairs(pairs: Pairs, legs: Sequence[str]) -> list[tuple[str, str]]:
    """Return the pairs; refuse a leg that is not there or is its own reference."""
    for pair in pairs:
        if len(pair) != 2 or pair[0] == pair[1]:
            raise InputError(f"pairs: {tuple(pair)} is not a leg and another one as reference.")
        for leg in pair:
            if leg not in legs:
                raise InputError(
                    f"pairs: no leg {leg!r}{did_you_mean(leg, legs)}; there are {', '.join(legs)}."
                )
    return [(a, b) for a, b in pairs]
