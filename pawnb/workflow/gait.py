"""Tracks or events to gait tables and figures; several inputs are pooled by animal."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb import gait
from pawnb.errors import InputError, did_you_mean
from pawnb.gait import GaitTables
from pawnb.gait.contacts import events_from_contacts, is_contact_table
from pawnb.gait.coordination import coordination_tables
from pawnb.io import native
from pawnb.io.formats import OWN_FORMATS, read_any_tracks, recognise_format
from pawnb.io.tables import read_cells, read_numbers, write_table
from pawnb.schema import Tracks, check_columns
from pawnb.trial import Animal, Trial, load_trial
from pawnb.workflow.foreign_tracks import read_foreign_tracks
from pawnb.workflow.gait_statistics import joint_angles_of, statistics_tables
from pawnb.workflow.provenance import build_step, file_checksum, write_provenance
from pawnb.workflow.results import (
    RESULTS_FOLDER,
    describe_trial,
    described_trial,
    make_folder,
    provenance_steps,
    results_folder,
)
from pawnb.workflow.save_figures import Which, save_gait_figures

Legs = Sequence[str] | Mapping[str, str]
"""Legs to use, or names of legs to names of points."""

TABLES = ("events", "strides", "phases", "phase_summary", "dropped")


@dataclass(frozen=True)
class GaitSource:
    """One input of the gait analysis, ready to analyse.

    Parameters
    ----------
    path : Path
        The file that was read.
    folder : Path
        Where results go by default.
    tracks : xarray.Dataset, optional
        Tracks, or
    events : pandas.DataFrame, optional
        events scored elsewhere.
    trial : Trial, optional
        What is known of the recording.
    """

    path: Path
    folder: Path
    tracks: Tracks | None = None
    events: pd.DataFrame | None = None
    trial: Trial | None = None


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
        animals = strides["animal"].nunique()
        legs = strides["leg"].nunique()
        lines = [
            f"{len(strides)} strides of {legs} legs of {animals} "
            f"{'animal' if animals == 1 else 'animals'}; {len(dropped)} dropped (dropped.csv "
            "says why)"
        ]
        if len(strides):
            middle = strides[["frequency_hz", "duty_factor"]].median()
            lines.append(
                f"median stride frequency {middle['frequency_hz']:.2f} Hz, duty factor "
                f"{middle['duty_factor']:.2f}"
            )
        lines += [f"note: {note}" for note in self.tables.notes]
        lines.append(f"wrote {len(self.files)} files to {self.out}")
        return "\n".join(lines)


def run_gait(
    inputs: Sequence[str | Path],
    *,
    out: str | Path | None = None,
    fps: float | None = None,
    legs: Legs | None = None,
    event_names: Mapping[str, str] | None = None,
    settings: Mapping[str, Any] | None = None,
    figures: Which = "all",
    command: Sequence[str] | None = None,
) -> GaitRun:
    """Analyse the gait of one or more inputs; write tables, statistics and figures.

    Parameters
    ----------
    inputs : sequence of str or Path
        Trials (``trial.toml`` or its folder), results folders, files of tracks (also those of
        DeepLabCut, SLEAP, Anipose, DLTdv; without a trial the file's name is the animal's id),
        ``events.csv`` scored by hand, or ground contact by hand (a csv with frame and 0 or 1 for
        each leg). They are pooled by the animal's id.
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
    settings : mapping, optional
        Settings of the event detection.
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
    """
    sources = [read_source(path, fps=fps) for path in inputs]
    parts = [
        analyse_source(source, legs=legs, event_names=event_names, settings=settings)
        for source in sources
    ]
    tables = gait.pool(parts) if len(parts) > 1 else parts[0]
    if out is None:
        out = sources[0].folder if len(sources) == 1 else Path(RESULTS_FOLDER)
    folder = make_folder(out)
    step = build_step(
        "gait",
        command=command,
        inputs={_label(source): file_checksum(source.path) for source in sources},
        settings=dataclasses.asdict(tables.settings),
        legs=dict(legs) if isinstance(legs, Mapping) else list(legs) if legs else None,
        event_names=dict(event_names) if event_names else None,
        sources={
            _label(source): provenance_steps(source.tracks)
            for source in sources
            if source.tracks is not None
        },
    )
    files = []
    for name in TABLES:
        path = folder / f"{name}.csv"
        write_table(getattr(tables, name), path)
        files.append(path)
    statistics, remarks = _statistics(sources, parts, tables)
    tables = dataclasses.replace(tables, notes=(*tables.notes, *remarks))
    for name, table in (coordination_tables(tables) | statistics).items():
        files.append(write_table(table, folder / f"{name}.csv"))
    files += save_gait_figures(tables, folder / "figures", record=step, which=figures)
    write_provenance([step], folder / "provenance.json")
    files.append(folder / "provenance.json")
    return GaitRun(tables, folder, tuple(files))


def _statistics(
    sources: Sequence[GaitSource], parts: Sequence[GaitTables], tables: GaitTables
) -> tuple[dict[str, pd.DataFrame], list[str]]:
    """Return the tables of statistics, with the groups and joint angles of the inputs."""
    groups: dict[tuple[str, str], str] = {}
    posed = []
    for source, part in zip(sources, parts, strict=True):
        trial = source.trial
        if trial is not None and trial.animal.group is not None:
            pairs = part.strides[["animal", "trial"]].drop_duplicates().astype(str)
            groups |= dict.fromkeys(map(tuple, pairs.to_numpy()), trial.animal.group)
        if source.tracks is not None:
            alone = trial is not None and source.tracks.sizes["individual"] == 1
            animal = trial.animal.id if trial is not None and alone else None
            posed.append((source.tracks, animal, trial.name if trial is not None else "trial"))
    return statistics_tables(tables, groups=groups, angles=joint_angles_of(posed))


def read_source(path: str | Path, *, fps: float | None = None) -> GaitSource:
    """Read one input of the gait analysis, whatever kind it is.

    Parameters
    ----------
    path : str or Path
        A trial, a results folder, a file of tracks, or an ``events.csv``.
    fps : float, optional
        Frames per second, for files that do not say.

    Returns
    -------
    GaitSource
        What was read.

    Raises
    ------
    InputError
        If there is nothing at ``path``, or it is none of these.
    """
    path = Path(path)
    if path.is_dir():
        for name in ("trial.toml", "tracks.nc", "events.csv"):
            if (path / name).exists():
                return read_source(path / name, fps=fps)
        raise InputError(
            f"{path}: neither a trial nor results; expected a trial.toml, a tracks.nc or an "
            "events.csv in it."
        )
    if not path.exists():
        raise InputError(
            f"{path}: no such file; expected a trial, a results folder, tracks or an events.csv."
        )
    if path.suffix == ".toml":
        return _read_trial(load_trial(path))
    if path.suffix == ".csv":
        cells = read_cells(path, ())
        if "event" in cells:
            return _read_events(path, fps)
        if is_contact_table(cells):
            return _read_contacts(path, cells, fps)
    program = recognise_format(path)
    tracks = read_any_tracks(path, fps=fps, program=program)
    trial = described_trial(tracks, where=str(path), folder=path.parent)
    if trial is None and program not in OWN_FORMATS:
        trial = _foreign_trial(tracks, path)
    return GaitSource(path, path.parent, tracks=tracks, trial=trial)


def _read_trial(trial: Trial) -> GaitSource:
    """Read the tracks of a trial: those made elsewhere, or those that pawnb made."""
    out = results_folder(trial)
    if trial.kind == "tracks" and trial.tracks_file is not None:
        tracks = describe_trial(read_foreign_tracks(trial), trial)
        return GaitSource(trial.path(trial.tracks_file), out, tracks=tracks, trial=trial)
    path = out / "tracks.nc"
    if not path.exists():
        raise InputError(f"{path}: trial {trial.name!r} is not tracked yet; run pawnb track first.")
    return GaitSource(path, out, tracks=native.read_tracks(path), trial=trial)


def _read_events(path: Path, fps: float | None) -> GaitSource:
    """Read a csv of events scored by hand."""
    cells = read_cells(path, ("leg", "event"))
    events = cells.copy()
    for name in ("frame", "time_s"):
        if name in events:
            events[name] = read_numbers(cells, name, where=str(path), empty=True)
    if "time_s" not in events:
        check_columns(cells, ("frame",), where=f"{path} (without time_s)")
        events["time_s"] = events["frame"] / _needed_fps(fps, path)
    return GaitSource(path, path.parent / RESULTS_FOLDER, events=events)


def _read_contacts(path: Path, cells: pd.DataFrame, fps: float | None) -> GaitSource:
    """Read a csv of ground contact scored by hand: frame, and 0 or 1 for each leg."""
    numbers = {
        name: read_numbers(
            cells, name, where=str(path), whole=name == "frame", empty=name != "frame"
        )
        for name in map(str, cells)
    }
    events = events_from_contacts(
        pd.DataFrame(numbers), fps=_needed_fps(fps, path), animal=path.stem, trial=path.stem
    )
    return GaitSource(path, path.parent / RESULTS_FOLDER, events=events)


def _foreign_trial(tracks: Tracks, path: Path) -> Trial | None:
    """Return what is known of tracks of another program: the file's name is trial and animal."""
    if tracks.sizes["individual"] != 1:
        return None  # the file names its animals
    return Trial(
        kind="tracks",
        name=path.stem,
        fps=float(tracks.attrs["fps"]),
        animal=Animal(id=path.stem),
        folder=path.parent,
        tracks_file=path.name,
    )


def _needed_fps(fps: float | None, path: Path) -> float:
    """Return the frame rate, or say that it is needed."""
    if fps is None:
        raise InputError(
            f"{path}: this file does not say its frame rate; give it with --fps, for instance "
            "--fps 250."
        )
    return fps


def analyse_source(
    source: GaitSource,
    *,
    legs: Legs | None = None,
    event_names: Mapping[str, str] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> GaitTables:
    """Analyse one input.

    Parameters
    ----------
    source : GaitSource
        What :func:`read_source` returned.
    legs : sequence of str or mapping, optional
        Legs to use, or names of legs to names of points (or of legs in a table of events);
        default all.
    event_names : mapping, optional
        What a table of events calls its events.
    settings : mapping, optional
        Settings of the event detection.

    Returns
    -------
    GaitTables
        The tables.

    Raises
    ------
    InputError
        If it cannot be analysed.
    """
    if source.events is not None:
        events = source.events
        if legs is not None:
            events = _choose_event_legs(events, legs, source.path)
        if "trial" not in events:
            events = events.assign(trial=source.path.stem)
        return gait.analyse_events(events, event_names=event_names, settings=settings)
    tracks, trial, belt = source.tracks, source.trial, None
    if tracks is None:
        raise InputError(f"{source.path}: neither tracks nor events.")
    if "belt_speed" in tracks:
        belt = tracks["belt_speed"].to_dataframe()[["frame", "belt_speed"]]
        belt = belt.rename(columns={"belt_speed": "speed"})
        trial = None if trial is None else dataclasses.replace(trial, belt_speed=None)
    return gait.analyse(tracks, trial=trial, legs=legs, belt_speed=belt, settings=settings)


def _choose_event_legs(events: pd.DataFrame, legs: Legs, path: Path) -> pd.DataFrame:
    """Return the events of some legs, under the names that were asked for."""
    named = dict(legs) if isinstance(legs, Mapping) else {leg: leg for leg in legs}
    there = events["leg"].astype(str)
    for name in named.values():
        if name not in set(there):
            raise InputError(
                f"{path}: no leg {name!r}{did_you_mean(name, set(there))}; there are "
                f"{', '.join(sorted(set(there)))}."
            )
    chosen = events[there.isin(named.values())]
    return chosen.assign(leg=chosen["leg"].astype(str).map({v: k for k, v in named.items()}))


def _label(source: GaitSource) -> str:
    """Name an input in the provenance without its absolute path."""
    return f"{source.path.parent.name}/{source.path.name}"
