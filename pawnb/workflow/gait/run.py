"""Tracks or events to gait tables and figures; several inputs are pooled by animal."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb import gait
from pawnb.errors import InputError
from pawnb.gait import EventSettings, GaitTables
from pawnb.gait.analysis.missing_strides import say_no_strides
from pawnb.gait.analysis.notes import alike_in_one
from pawnb.gait.coordination import coordination_tables
from pawnb.gait.cycles import LegSignals
from pawnb.gait.events.event_edits import EVENT_EDITS_FILE
from pawnb.io.tables import write_table, write_text
from pawnb.schema import build_settings
from pawnb.schema.arguments import checked_arguments
from pawnb.workflow.gait.drawing.drawings import Drawing, gait_drawings
from pawnb.workflow.gait.drawing.overview_drawings import overview_drawings
from pawnb.workflow.gait.drawing.save_figures import Which, save_gait_figures
from pawnb.workflow.gait.drawing.source_drawings import SourceTracks, source_drawings
from pawnb.workflow.gait.inputs import (
    analyse_source,
    check_alike,
    read_sources,
    tracks_of,
)
from pawnb.workflow.gait.notes.source_notes import (
    notes_on_sources,
    notes_on_trials,
    say_whose_trial,
)
from pawnb.workflow.gait.notes.tracking_notes import notes_on_tracking
from pawnb.workflow.gait.replaced import other_inputs, tell_replaced
from pawnb.workflow.gait.request import GaitRequest, Legs, TakenOver, record_of
from pawnb.workflow.gait.sources import GaitSource
from pawnb.workflow.gait.species import species_drawings
from pawnb.workflow.gait.statistics import (
    Groups,
    body_angles_of,
    joint_angles_of,
    joint_signals_of,
    length_unit,
    statistics_tables,
)
from pawnb.workflow.gait.study import Study
from pawnb.workflow.gait.study_tables import (
    Fields,
    covariates_of,
    reference_lines,
    size_drawings,
    size_tables,
    tables_of_study,
)
from pawnb.workflow.provenance.manifest import MANIFEST, writing_results
from pawnb.workflow.provenance.notes import noted_warnings, notes_table
from pawnb.workflow.provenance.report.index_page import INDEX_FILE, index_page
from pawnb.workflow.provenance.report.methods_text import methods_paragraphs
from pawnb.workflow.provenance.results import (
    RESULTS_FOLDER,
    make_folder,
    tracking_notes,
)

TABLES = ("events", "strides", "phases", "phase_summary", "dropped")


@dataclass(frozen=True)
class GaitRun:
    """What :func:`run_gait` made.

    Parameters
    ----------
    tables : GaitTables
        The tables.
    out : Path
        The folder they were written to.
    files : tuple of Path
        Every file written.
    """

    tables: GaitTables
    out: Path
    files: tuple[Path, ...] = field(default=())

    def text(self) -> str:
        """Return what was found and written, in a few lines."""
        strides, dropped = self.tables.strides, self.tables.dropped
        what = {
            "stride": len(strides),
            "leg": strides["leg"].nunique(),
            "animal": strides["animal"].nunique(),
        }
        counted = " of ".join(f"{n} {one if n == 1 else f'{one}s'}" for one, n in what.items())
        counted = counted if len(strides) else "no stride was found"
        why = " (dropped.csv says why)" if len(dropped) else ""
        lines = [f"{counted}; {len(dropped)} dropped{why}"]
        if len(strides):
            # each animal counts once, however many strides it took
            own = strides.groupby("animal")[["frequency_hz", "duty_factor"]].median()
            frequency, duty = (_say_middle(own[name]) for name in own)
            lines.append(f"median stride frequency {frequency} Hz, duty factor {duty}")
        notes = alike_in_one((*say_no_strides(self.tables), *self.tables.notes))
        lines += [f"note: {note}" for note in notes]
        lines.append(f"wrote {len(self.files)} files to {self.out}")
        return "\n".join(lines)


def _say_middle(values: pd.Series[float]) -> str:
    """Return the median of animals, and between which they lie."""
    spread = f" (animals: {values.min():.2f} to {values.max():.2f})" if len(values) > 1 else ""
    return f"{values.median():.2f}{spread}"


@checked_arguments
def run_gait(
    inputs: str | Path | Sequence[str | Path],
    *,
    out: str | Path | None = None,
    fps: float | None = None,
    legs: Legs | None = None,
    event_names: Mapping[str, str] | None = None,
    animals: Sequence[str] | None = None,
    groups: Sequence[str] | None = None,
    settings: Mapping[str, Any] | None = None,
    figures: Which = "all",
    command: Sequence[str] | None = None,
) -> GaitRun:
    """Analyse the gait of one or more inputs; write tables, statistics and figures.

    Corrections of events made by hand (``event_edits.jsonl`` in the results of an input or beside
    a study, or in ``out``) are made again.

    Parameters
    ----------
    inputs : str, Path, or sequence of them
        Trials (``trial.toml`` or its folder), results folders, files of tracks (also those of
        DeepLabCut, SLEAP, Anipose, DLTdv; without a trial the file's name is the animal's id),
        ``events.csv`` scored by hand, or ground contact by hand (a csv with frame and 0 or 1 for
        each leg). They are pooled by the animal's id. Or one study (``study.toml`` or csv, see
        :func:`pawnb.workflow.gait.study.read_study`), which names trials, animals, groups,
        conditions, covariates and settings.
    out : str or Path, optional
        Folder to write; default ``results`` beside a single trial, the folder of a
        single results or tracks file, and ``results`` in the current folder for several.
    fps : float, optional
        Frames per second, for inputs that do not say.
    legs : sequence of str or mapping, optional
        Legs to use, or names of legs to names of points; default every point that is named
        like a leg.
    event_names : mapping, optional
        What tables of events call touch-down and lift-off: ``{"down": "TD", "up": "LO"}``.
    animals : sequence of str, optional
        Id of the animal of each input, in their order; default as the input says. A file of
        another program does not say, and counts as an animal of its own.
    groups : sequence of str, optional
        Group of each input's animals, in their order, to compare; default as a column ``group``
        of a table of events says, else as the trial does (``[animal] group``).
    settings : mapping, optional
        Settings of the analysis (:class:`pawnb.gait.EventSettings`, and ``pairs`` of legs). They
        go before those of a trial (``[gait]`` in its ``trial.toml``, or in its study), and these
        before those of a study.
    figures : {"all", "main", "none"}
        Figures to draw: every one that the tables allow (which takes longer than the
        analysis), gait diagrams and phase roses, or none.
    command : sequence of str, optional
        The command line, for the provenance.

    Returns
    -------
    GaitRun
        The tables, and what was written.

    Raises
    ------
    InputError
        If an input is missing, is none of the above, or cannot be analysed.

    Examples
    --------
    >>> files = pawnb.synthetic.write_deeplabcut_sample("others", animals=2)
    >>> run = pawnb.run_gait(files, fps=200.0, out="gait", figures="none")
    >>> sorted(run.tables.strides["leg"].unique())
    ['FL', 'FR', 'HL', 'HR']
    """
    request = GaitRequest(
        inputs=inputs, fps=fps, legs=legs, event_names=event_names, animals=animals,
        groups=groups, settings=settings, figures=figures,
    )  # fmt: skip
    return carry_out(request, out=out, command=command)


def carry_out(
    request: GaitRequest,
    *,
    out: str | Path | None = None,
    command: Sequence[str] | None = None,
    again: TakenOver | None = None,
    corrected: Sequence[Path] = (),
) -> GaitRun:
    """Analyse the gait of what a request names.

    Parameters
    ----------
    request : GaitRequest
        What is asked for.
    out, command
        As for :func:`run_gait`.
    again : TakenOver, optional
        What is taken over from a run that is made again.
    corrected : sequence of Path, optional
        Further folders whose corrections of events count; where it is given, so do those of the
        folder where results of these inputs go by default.

    Returns
    -------
    GaitRun
        As of :func:`run_gait`.
    """
    with noted_warnings() as warned:
        sources, study = read_sources(request)
        parts, tables = _analysed(request, sources, study)
        usual = _default_out(sources, study)
        folder = make_folder(usual if out is None else out)
        usually = [usual] * bool(study is not None or corrected)
        edits = _event_edit_files(sources, [*usually, *corrected, folder])
        edits = edits if again is None else list(again.edits)
        tables = gait.replay_event_edits(tables, edits, renamed=_renamed(sources))
        step = record_of(
            request, sources, edits, tables=tables, study=study, command=command, again=again
        )
        replaced = other_inputs(folder, step) if out is None else []
        found = _findings(request, sources, parts, tables=tables)
        tables = found.tables
        drawings = _drawings(found, study, notes=[*_notes_of(sources, tables), *warned])
        with writing_results(folder, run="gait", steps=[step]) as staging:
            files = [
                write_table(table, staging / f"{name}.csv") for name, table in found.every.items()
            ]
            files += save_gait_figures(
                drawings, staging / "figures", record=step, which=request.figures,
                only=None if again is None else again.only,
            )  # fmt: skip
            notes = [*_notes_of(sources, tables), *warned]  # drawing may have warned, too
            said = methods_paragraphs(
                tables, found.every, step=step, tracked=[one.tracks for one in found.seen],
                verdicts=[one.quality for one in found.seen],
            )  # fmt: skip
            files += _write_words(found.every, files, notes=notes, said=said, folder=staging)
        written = [folder / file.relative_to(staging) for file in files]
    tell_replaced(folder, replaced)
    return GaitRun(tables, folder, (*written, folder / MANIFEST))


@dataclass(frozen=True)
class _Findings:
    """All that is written and drawn: tables by name, and what figures need besides."""

    tables: GaitTables
    every: dict[str, pd.DataFrame]
    groups: Groups
    fields: Fields
    seen: Sequence[SourceTracks]
    angles: pd.DataFrame | None
    joints: Sequence[LegSignals]


def _findings(
    request: GaitRequest,
    sources: Sequence[GaitSource],
    parts: Sequence[GaitTables],
    *,
    tables: GaitTables,
) -> _Findings:
    """Return the tables of all sources with those that are made of them."""
    own = list(zip(sources, parts, strict=True))
    groups = {who: group for s, part in own for who, group in s.groups(part).items()}
    aside = {who: name for s, part in own for who, name in s.set_aside(part).items()}
    seen = tracks_of(sources, request.legs)
    named_tracks = [(one.tracks, one.animal, one.trial) for one in seen]
    angles = joint_angles_of(named_tracks)
    fields = covariates_of(parts, [source.fields for source in sources])
    further, remarks = _further_tables(tables, sources, groups=groups, angles=angles)
    joints = joint_signals_of(named_tracks)
    further |= tables_of_study(tables, groups=groups, joints=joints, fields=fields)
    told = [*notes_on_tracking(seen), *notes_on_sources(sources, request.animals)]
    told += notes_on_trials(sources, tables, groups, aside=aside, fields=fields)
    try:
        further |= size_tables(tables.strides, fields)
    except InputError as error:
        remarks.append(f"gait is not compared with size: {error}")
        fields = {}
    remarks = [*told, *tables.notes, *remarks]
    tables = dataclasses.replace(tables, notes=tuple(remarks))
    every = {name: _grouped(getattr(tables, name), groups) for name in TABLES} | further
    return _Findings(tables, every, groups, fields, seen, angles, joints)


def _drawings(found: _Findings, study: Study | None, *, notes: Sequence[str]) -> Iterator[Drawing]:
    """Yield every figure, in the order in which they are drawn."""
    tables, unit = found.tables, length_unit(found.tables)
    yield from gait_drawings(
        tables, groups=found.groups, notes=notes,
        references=reference_lines(tables.strides, found.fields, unit=unit),
    )  # fmt: skip
    yield from overview_drawings(tables, groups=found.groups, joints=found.joints)
    yield from source_drawings(found.seen, angles=found.angles)
    yield from _drawings_of_study(tables, found.fields, study, unit=unit)


def _write_words(
    every: Mapping[str, pd.DataFrame],
    files: Sequence[Path],
    *,
    notes: Sequence[str],
    said: Sequence[str],
    folder: Path,
) -> list[Path]:
    """Write notes, the methods paragraph, and the index of what there is."""
    told = notes_table(notes, {f"{name}.csv": table for name, table in every.items()})
    own = [
        write_table(told, folder / "notes.csv"),
        write_text("\n\n".join(said) + "\n", folder / "methods.txt"),
    ]
    index = index_page([*files, *own], folder, notes=told, paragraphs=said)
    return [*own, write_text(index, folder / INDEX_FILE)]


def _default_out(sources: Sequence[GaitSource], study: Study | None) -> Path:
    """Return where results go: beside a study, or what a single input says."""
    if study is not None:
        return study.path.parent / RESULTS_FOLDER
    return sources[0].folder if len(sources) == 1 else Path(RESULTS_FOLDER)


def _common(request: GaitRequest, study: Study | None) -> EventSettings:
    """Return the settings that all trials have in common, but for those of their own."""
    asked = {**(study.settings if study is not None else {}), **(request.settings or {})}
    asked.pop("pairs", None)
    return build_settings(EventSettings, asked, where="gait")


def _further_tables(
    tables: GaitTables,
    sources: Sequence[GaitSource],
    *,
    groups: Groups,
    angles: pd.DataFrame | None,
) -> tuple[dict[str, pd.DataFrame], list[str]]:
    """Return the tables of coordination, statistics and bodies, and why some are not there."""
    statistics, remarks = statistics_tables(tables, groups=groups, angles=angles)
    further = coordination_tables(tables) | statistics
    bodies = body_angles_of([(s.tracks, s.trial) for s in sources if s.tracks is not None])
    if len(bodies):
        further["body_angles"] = bodies
    return further, remarks


def _analysed(
    request: GaitRequest, sources: Sequence[GaitSource], study: Study | None
) -> tuple[list[GaitTables], GaitTables]:
    """Return the tables of each source, and those of all."""
    parts = [
        analyse_source(
            source,
            legs=request.legs,
            event_names=request.event_names,
            settings=request.settings,
        )
        for source in sources
    ]
    check_alike(parts)
    if len(parts) == 1:
        return parts, parts[0]
    parts = say_whose_trial(parts)
    return parts, gait.pool(parts, settings=_common(request, study))


def _drawings_of_study(
    tables: GaitTables, fields: Fields, study: Study | None, *, unit: str | None
) -> Iterator[Drawing]:
    """Yield what compares animals with what is known of them, and with species."""
    yield from size_drawings(tables.strides, fields, unit=unit)
    species = () if study is None else study.species
    yield from species_drawings(tables.strides, fields, species, unit=unit)


def _notes_of(sources: Sequence[GaitSource], tables: GaitTables) -> list[str]:
    """Return the notes of the tracking, then those of the analysis."""
    tracked = [n for s in sources if s.tracks is not None for n in tracking_notes(s.tracks)]
    return [*tracked, *say_no_strides(tables), *tables.notes]


def _grouped(table: pd.DataFrame, groups: Groups) -> pd.DataFrame:
    """Return a table with a column ``group`` on the right, where its rows have any."""
    if not groups or not {"animal", "trial"} <= set(table):
        return table
    who = zip(table["animal"].astype(str), table["trial"].astype(str), strict=True)
    return table.assign(group=[groups.get(one, "") for one in who])


def _renamed(sources: Sequence[GaitSource]) -> dict[tuple[str, str], tuple[str, str]]:
    """Return what inputs call their animal and trial to what these are called in this analysis."""
    own = [(s.called, (s.animals[0], s.trial_name)) for s in sources if s.called is not None]
    once = [called for called, _ in own]
    return {called: now for called, now in own if once.count(called) == 1}


def _event_edit_files(sources: Sequence[GaitSource], further: Sequence[Path]) -> list[Path]:
    """Return the corrections of events beside the results of the inputs, and in further folders."""
    own = {folder.resolve(): folder for folder in (*(s.folder for s in sources), *further)}
    return [path for f in own.values() if (path := f / EVENT_EDITS_FILE).exists()]
