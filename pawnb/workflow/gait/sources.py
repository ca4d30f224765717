"""The inputs of the gait analysis: trials, results, tracks of any program, events by hand."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.edits.log import say_unsaved
from pawnb.errors import InputError, InputWarning, PawnbError
from pawnb.files import check_file
from pawnb.gait import GaitTables
from pawnb.input_warnings import warn_of_input
from pawnb.io.authors2019 import trial_stamp
from pawnb.io.formats import check_rate, read_any_tracks, recognise_format
from pawnb.io.osp_tracker import tables_in_folder
from pawnb.io.points import tell_rate
from pawnb.io.unread import tell_folder
from pawnb.schema import Tracks
from pawnb.trial import Animal, Trial, load_trial
from pawnb.workflow.conversion.foreign_tracks import files_of_tracks, read_foreign_tracks
from pawnb.workflow.gait.event_sources import groups_of_events, read_scored_file, read_trial_events
from pawnb.workflow.provenance.mended_trial import as_described_now
from pawnb.workflow.provenance.results import (
    RESULTS_FOLDER,
    describe_trial,
    described_trial,
    need_sources,
    read_result_tracks,
    results_folder,
    tell_fault,
    tell_fault_of_events,
)
from pawnb.workflow.reviewing.foreign import CORRECTED


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
    guessed : bool
        Whether the animal's id is only the name of the file.
    further : tuple of Path
        Further files that tracks made elsewhere were read from, such as their calibration.
    group : str, optional
        Group of its animals, as told beside it.
    compared : {"group", "condition"}
        What ``group`` is: a study may compare conditions.
    aside : str, optional
        The condition where groups are compared, the group where conditions are.
    of_trial : Path, optional
        The ``trial.toml`` that named it.
    settings : mapping
        Settings of the analysis of its own.
    fields : mapping
        Covariates: what is known of its animal beside its group.
    legs : mapping, optional
        Names of legs to names of points, as its study says.
    called : tuple of str, optional
        Animal and trial as tracks of one animal say them, where other names were given.
    """

    path: Path
    folder: Path
    tracks: Tracks | None = None
    events: pd.DataFrame | None = None
    trial: Trial | None = None
    guessed: bool = False
    further: tuple[Path, ...] = ()
    group: str | None = None
    compared: str = "group"
    aside: str | None = None
    of_trial: Path | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    fields: Mapping[str, Any] = field(default_factory=dict)
    legs: Mapping[str, str] | None = None
    called: tuple[str, str] | None = None

    @property
    def given(self) -> Path:
        """The file that was named: the trial's, or what was read."""
        return self.of_trial or self.path

    def groups(self, tables: GaitTables) -> dict[tuple[str, str], str]:
        """Return the group of each animal and trial in the tables made of this input.

        That which was told goes before a column ``group`` of the events, and that before the
        trial's.
        """
        own = None if self.trial is None else self.trial.animal.group
        named = {} if self.events is None else groups_of_events(self.events, where=str(self.path))
        found = {}
        for animal, trial in tables.trials:
            group = self.group or named.get((animal, trial)) or own
            if group is not None:
                found[animal, trial] = group
        return found

    def set_aside(self, tables: GaitTables) -> dict[tuple[str, str], str]:
        """Return ``aside`` of each animal and trial in the tables made of this input."""
        return {} if self.aside is None else dict.fromkeys(tables.trials, self.aside)

    def of_animal(self, animal: str) -> GaitSource:
        """Return the same input as that of one animal."""
        if self.events is not None:
            named_events = self._events_of(animal, self.events)
            return replace(self, events=named_events, guessed=False)
        if self.tracks is not None and self.tracks.sizes["individual"] > 1:
            named = self._of_several(animal.split("+"), self.tracks)
            return replace(self, tracks=named, guessed=False)
        trial = self.trial
        if trial is not None:
            trial = replace(trial, animal=replace(trial.animal, id=animal))
        return replace(self, trial=trial, guessed=False, called=self._own_names())

    def _events_of(self, animal: str, events: pd.DataFrame) -> pd.DataFrame:
        """Return events under other ids of their animals."""
        own = list(dict.fromkeys(events["animal"].astype(str)))
        ids = [animal] if len(own) < 2 else animal.split("+")
        self._check_ids(ids, own, what="events")
        return events.assign(
            animal=events["animal"].astype(str).map(dict(zip(own, ids, strict=True)))
        )

    def _of_several(self, ids: list[str], tracks: Tracks) -> Tracks:
        """Return tracks of several animals under other ids."""
        self._check_ids(ids, self.animals, what="tracks")
        return tracks.assign_coords(individual=ids)

    def _check_ids(self, ids: Sequence[str], own: Sequence[str], *, what: str) -> None:
        """Refuse ids that are not one for each animal."""
        if own and (len(ids) != len(own) or not all(ids) or len(set(ids)) < len(ids)):
            raise InputError(
                f"{self.path}: these {what} have {len(own)} animals, {', '.join(own)}; name each "
                "once, joined by + in this order, such as m1+m2, or leave animals (--animals) away."
            )

    @property
    def animals(self) -> tuple[str, ...]:
        """Ids of the animals of tracks; none of events."""
        if self.tracks is None or self.trial is None:
            return ()
        if self.tracks.sizes["individual"] == 1:
            return (self.trial.animal.id,)
        return tuple(str(one) for one in self.tracks["individual"].to_numpy())

    @property
    def trial_name(self) -> str:
        """What the tables call the trial of tracks."""
        return "trial" if self.trial is None else self.trial.name

    def of_name(self, name: str) -> GaitSource:
        """Return the same input under another name of its trial."""
        if self.events is not None:
            trials = self.events[["animal", "trial"]].astype(str).drop_duplicates()
            twice = trials[trials.duplicated("animal")]
            if len(twice):
                own = trials.loc[trials["animal"] == twice["animal"].iloc[0], "trial"]
                raise InputError(
                    f"{self.path}: these events are of several trials of one animal, "
                    f"{', '.join(own)}; leave name = {name!r} away, which would make one of them."
                )
            return replace(self, events=self.events.assign(trial=name))
        trial = self.trial
        named = None if trial is None else replace(trial, name=name)
        return replace(self, trial=named, called=self._own_names())

    def _own_names(self) -> tuple[str, str] | None:
        """Return animal and trial as the input itself says them, where it is of one animal."""
        if self.called is not None or len(self.animals) != 1:
            return self.called
        return self.animals[0], self.trial_name


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
    check_rate(fps)
    if path.is_dir():
        tell_folder(path)
        need_sources(path)
        for name in ("trial.toml", "tracks.nc", "events.csv"):
            if (path / name).exists():
                return read_source(path / name, fps=fps)
        if tables_in_folder(path):
            return _read_tracks(path, fps)
        raise InputError(
            f"{path}: neither a trial nor results; expected a trial.toml, a tracks.nc or an "
            "events.csv in it, or tables of Tracker's points only."
        )
    check_file(path, expected="a trial, a results folder, tracks or an events.csv")
    if path.suffix == ".toml":
        return _at_own_rate(_read_trial(load_trial(path), path), fps)
    if trial_stamp(path.name) is not None:
        raise InputError(
            f"{path}: one of the four files of a trial of the 2019 authors, which need their DLT; "
            "name it under [tracks] file of a trial.toml of kind 'tracks'."
        )
    events = read_scored_file(path, fps=fps)
    if events is not None:
        tell_fault_of_events(path)
        guessed = bool((events["animal"] == path.stem).all())
        return GaitSource(path, path.parent / RESULTS_FOLDER, events=events, guessed=guessed)
    if (own := _trial_of_results(path)) is not None:
        return _at_own_rate(_read_trial(own, own.folder / "trial.toml"), fps)
    return _read_tracks(path, fps)


def _at_own_rate(source: GaitSource, fps: float | None) -> GaitSource:
    """Return an input that says its frame rate itself; say so where another one is given."""
    if source.trial is not None:
        tell_rate(str(source.of_trial), source.trial.fps, fps, kept=True, stacklevel=3)
    return source


def _read_tracks(path: Path, fps: float | None) -> GaitSource:
    """Read tracks of any program."""
    program = recognise_format(path)
    tracks = read_any_tracks(path, fps=fps, program=program)
    tell_fault(tracks, path)
    if path.name == "tracks.nc":
        _tell_unsaved(tracks, path)
    trial = described_trial(tracks, where=str(path), folder=path.parent)
    if trial is not None:
        return GaitSource(
            path, path.parent, tracks=tracks, trial=trial, settings=trial.gait,
            fields=trial.animal.extra,
        )  # fmt: skip
    trial, guessed = _file_as_trial(tracks, path, program)
    return GaitSource(path, path.parent, tracks=tracks, trial=trial, guessed=guessed)


def _read_trial(trial: Trial, file: Path) -> GaitSource:
    """Read the tracks of a trial: those made elsewhere, or those that pawnb made."""
    out = results_folder(trial)
    own: dict[str, Any] = {
        "trial": trial, "of_trial": file, "settings": trial.gait, "fields": trial.animal.extra,
    }  # fmt: skip
    if trial.is_tracked_elsewhere and trial.track_files:
        events = read_trial_events(trial)
        if events is not None:
            return GaitSource(trial.path(trial.track_files[0]), out, events=events, **own)
        tracks = describe_trial(read_foreign_tracks(trial), trial)
        path, *further = files_of_tracks(trial)
        return GaitSource(path, out, tracks=tracks, **own, further=tuple(further))
    path = out / "tracks.nc"
    if not path.exists():
        raise InputError(f"{path}: trial {trial.name!r} is not tracked yet; run pawnb track first.")
    tracks = read_result_tracks(path)
    _tell_unsaved(tracks, path)
    return GaitSource(path, out, tracks=as_described_now(tracks, trial), **own)


def _trial_of_results(path: Path) -> Trial | None:
    """Return the trial, as described now, in whose own folder of results tracks lie."""
    if path.name != "tracks.nc" or not (path.parent.parent / "trial.toml").exists():
        return None
    try:
        trial = load_trial(path.parent.parent)
    except PawnbError:
        return None  # the tracks know how it was described when they were made
    here = results_folder(trial).resolve() == path.parent.resolve()
    return trial if here and not trial.is_tracked_elsewhere else None


def _tell_unsaved(tracks: Tracks, path: Path) -> None:
    """Warn of corrections that were made in a review and are not in the tracks."""
    file = path.with_name("edits.jsonl")
    if not file.exists():
        return
    try:
        said = say_unsaved(tracks, file)
    except PawnbError as error:
        warn_of_input(f"{file}: {str(error).rstrip('.')}.", InputWarning, stacklevel=3)
        return
    if said:
        warn_of_input(f"{file}: {said}", InputWarning, stacklevel=3)


def _file_as_trial(tracks: Tracks, path: Path, program: str) -> tuple[Trial, bool]:
    """Return what is known of tracks without a trial, and whether the animal's id is a guess.

    The file's name is the trial's (that of its folder, where it is only ``tracks`` or
    ``points3d``), and the animal's too where the file gives it none.
    """
    name = recording_name(path, program)
    own = str(tracks["individual"].to_numpy()[0])
    alone = tracks.sizes["individual"] == 1  # else the file names its animals
    guessed = alone and re.fullmatch(r"animal|(individual|id|track)_?\d+", own) is not None
    trial = Trial(
        kind="tracks",
        name=name,
        fps=float(tracks.attrs["fps"]),
        animal=Animal(id=name if guessed else own),
        folder=path.parent,
        tracks_file=path.name,
    )
    return trial, guessed


def recording_name(path: Path, program: str) -> str:
    """Return what the recording is called whose tracks a program wrote into a file."""
    name = path.stem.removeprefix(CORRECTED)
    if program == "deeplabcut":  # which puts the name of its network behind that of the video
        name = re.sub(r"(?<=.)DLC(_.*)?$", "", name)
    if program == "sleap":  # which puts what the file is behind it
        name = re.sub(r"(?<=.)\.(analysis|predictions)$", "", name)
    return path.resolve().parent.name if name in ("tracks", "points3d") else name
