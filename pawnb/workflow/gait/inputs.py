"""The inputs of a gait analysis: read as the request or its study says, and analysed one by one."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pawnb import gait
from pawnb.errors import InputError, did_you_mean
from pawnb.gait import GaitTables
from pawnb.gait.analysis.leg_names import choose_legs
from pawnb.gait.cycles import POSITION
from pawnb.gait.events.event_settings import EventSettings
from pawnb.schema import build_settings, each_of, shown
from pawnb.workflow.gait.drawing.source_drawings import SourceTracks
from pawnb.workflow.gait.event_sources import choose_event_legs
from pawnb.workflow.gait.request import GaitRequest, Legs
from pawnb.workflow.gait.sources import GaitSource, read_source
from pawnb.workflow.gait.study import (
    Study,
    StudyTrial,
    is_study,
    read_study,
    tell_if_meant_as_study,
)

_MOUSE = {"FR", "HR", "FL", "HL"}


def read_sources(request: GaitRequest) -> tuple[list[GaitSource], Study | None]:
    """Read every input, under the animals' ids and groups that were given.

    Parameters
    ----------
    request : GaitRequest
        What is asked for; its one input may be a study.

    Returns
    -------
    sources : list of GaitSource
        The inputs.
    study : Study or None
        The study that named them.

    Raises
    ------
    InputError
        If an input cannot be read, or what is said of them does not fit.
    """
    animals, groups, fps = request.animals, request.groups, request.fps
    inputs = each_of(request.inputs, what="inputs")
    studies = [path for path in inputs if is_study(path)]
    if studies:
        if len(inputs) > 1 or animals or groups:
            raise InputError(
                f"{studies[0]}: a study says itself which trials, animals and groups there are; "
                "name nothing beside it."
            )
        study = read_study(studies[0])
        check_settings(study.settings, where=f"{study.path}: [gait]")
        read = [(str(trial.path), partial(_of_study, trial, study, fps)) for trial in study.trials]
        return _each_once(_read_all(read)), study
    for name, given in (("animals", animals), ("groups", groups)):
        if given is not None and len(each_of(given, what=name, one=False)) != len(inputs):
            raise InputError(
                f"{name}: {len(given)} for {len(inputs)} inputs; give the "
                f"{'id' if name == 'animals' else 'group'} of each input's animal."
            )
    sources = _read_all([(str(path), partial(_of_input, path, fps)) for path in inputs])
    if animals is not None:
        sources = [s.of_animal(animal) for s, animal in zip(sources, animals, strict=True)]
    if groups is not None:
        sources = [
            dataclasses.replace(source, group=group)
            for source, group in zip(sources, groups, strict=True)
        ]
    return _each_once(sources), None


def _read_all(inputs: Sequence[tuple[str, Callable[[], GaitSource]]]) -> list[GaitSource]:
    """Read inputs, by name; where several cannot be, name them all at once."""
    sources, faults = [], {}
    for name, read in inputs:
        try:
            sources.append(read())
        except InputError as fault:
            faults[name] = fault
    first = next(iter(faults.values()), None)
    if first is None:
        return sources
    if len(faults) == 1:
        raise first
    raise InputError(
        f"{len(faults)} of {len(inputs)} inputs cannot be used: {', '.join(faults)}. Mend them, or "
        f"leave them out. Of the first: {first}"
    ) from first


def _each_once(sources: list[GaitSource]) -> list[GaitSource]:
    """Return sources; refuse two files of the same trial of an animal."""
    seen: dict[tuple[str, str], GaitSource] = {}
    for source in sources:
        for animal in source.animals:
            first = seen.setdefault((animal, source.trial_name), source)
            if first is not source and first.given == source.given:
                raise InputError(f"{source.given} is named twice; name it once.")
            if first is not source:
                raise InputError(
                    f"{first.given} and {source.given} are both trial {source.trial_name!r} of "
                    f"animal {animal!r}. Of one recording (as .csv and .h5, or filtered as well) "
                    "name one file only; of two, call them by different names."
                )
    return sources


def _of_input(path: Any, fps: float | None) -> GaitSource:
    """Read one input, and check the settings that it has of its own."""
    try:
        own = read_source(path, fps=fps)
    except InputError:
        tell_if_meant_as_study(Path(path))
        raise
    check_settings(own.settings, where=f"{own.given}: [gait]")
    return own


def _of_study(trial: StudyTrial, study: Study, fps: float | None) -> GaitSource:
    """Read a trial of a study, under what the study calls it."""
    check_settings(trial.settings, where=f"{study.path}: gait of {trial.path.name}")
    own = _of_input(trial.path, trial.fps or fps).of_animal(trial.animal)
    if trial.name is not None:
        own = own.of_name(trial.name)
    compared, aside = trial.group or own.group, trial.condition
    if study.compare == "condition":
        compared, aside = aside, compared
    return dataclasses.replace(
        own,
        group=compared,
        compared=study.compare,
        aside=aside,
        settings={**study.settings, **own.settings, **trial.settings},
        fields={**own.fields, **trial.fields},
        legs=dict(study.legs) or None,
    )


def check_settings(values: Mapping[str, Any], *, where: str) -> None:
    """Refuse settings of the gait analysis that are unknown or wrong, under the file they are in.

    Parameters
    ----------
    values : mapping
        Settings that a file holds: fields of :class:`pawnb.gait.EventSettings`, and ``pairs``.
    where : str
        The file and the part of it, for the message.

    Raises
    ------
    InputError
        For an unknown name (a near one is suggested) or a value that cannot be.
    """
    known = sorted(["pairs", *(field.name for field in dataclasses.fields(EventSettings))])
    for name in values:
        if name not in known:
            raise InputError(
                f"{where}: unknown setting {name!r}{did_you_mean(name, known)}; known are "
                f"{', '.join(known)}."
            )
    own = dict(values)
    try:
        read_pairs(own.pop("pairs", None))
        build_settings(EventSettings, own, where="setting")
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def read_pairs(value: Any) -> list[tuple[str, str]] | None:
    """Return pairs of legs from a setting; None for the usual ones.

    Parameters
    ----------
    value : object
        Pairs of names, or their text as in TOML: names in double or single quotes.

    Returns
    -------
    list of (leg, reference) or None
        The pairs.

    Raises
    ------
    InputError
        If it is no list of pairs of names.
    """
    if value is None:
        return None
    try:
        pairs = tomllib.loads(f"pairs = {value}")["pairs"] if isinstance(value, str) else value
        found = [(leg, reference) for leg, reference in pairs]
        found = found if all(isinstance(pair, list | tuple) for pair in pairs) else []
    except (ValueError, TypeError):
        found = []
    if not found or not all(isinstance(name, str) for pair in found for name in pair):
        raise InputError(
            f"setting pairs is {shown(value)}; expected pairs of legs, as [['FL', 'FR']]."
        )
    return found


def _check_one_space(units: Mapping[str, tuple[str, tuple[str, ...]]], trial: str) -> None:
    """Refuse a trial some of whose legs have a place in space, and others in a picture only."""
    own = {unit: legs for unit, (of, legs) in units.items() if of == trial}
    if len(own) > 1 and "px" in own:
        (unit,) = list(own.keys() - {"px"})[:1]
        kept, lost = " ".join(own[unit]), ", ".join(own["px"])
        raise InputError(
            f"trial {trial!r}: in space there is no place of {lost}, or in too few frames, and "
            f"those of a picture cannot be analysed beside the others, which are in {unit}: leave "
            f"{lost} out (--legs {kept}), or look why the views do not agree about it."
        )


def check_alike(parts: Sequence[GaitTables]) -> None:
    """Refuse to pool trials in several units, or with legs under several kinds of names.

    Parameters
    ----------
    parts : sequence of GaitTables
        An analysis of each input.

    Raises
    ------
    InputError
        If lengths, or legs, of one trial cannot be compared with those of another.
    """
    units: dict[str, tuple[str, tuple[str, ...]]] = {}
    kinds: dict[frozenset[str], tuple[str, str]] = {}
    for part in parts:
        names = part.events["trial"].astype(str)
        for one in part.signals:
            if one.signal == POSITION:
                units.setdefault(one.unit, (one.trial, one.legs))
                _check_one_space(units, one.trial)
        for trial, legs in part.events["leg"].astype(str).groupby(names):
            # a trial may call some legs by names of its own: the next one has to do so, too
            own = frozenset(map(_kind_of, legs))
            kinds.setdefault(own, (str(trial), ", ".join(dict.fromkeys(legs))))
    if len(units) > 1:
        said = " and ".join(f"{unit} ({trial})" for unit, (trial, _) in units.items())
        raise InputError(f"trials are in {said}; give all one unit, or analyse them apart.")
    if len(kinds) > 1:
        said = " and ".join(f"{legs} in {trial}" for trial, legs in kinds.values())
        raise InputError(
            f"legs are called {said}; call them alike with --legs, or [legs] of the study."
        )


def _kind_of(leg: str) -> str:
    """Return by which system a leg is named."""
    if leg in _MOUSE:
        return "mouse"
    return "spider" if re.fullmatch(r"[LR]\d+", leg) else "own"


def tracks_of(sources: Sequence[GaitSource], legs: Legs | None) -> list[SourceTracks]:
    """Return the tracks among the inputs, with what the tables call animal, trial and legs.

    Parameters
    ----------
    sources : sequence of GaitSource
        The inputs.
    legs : sequence of str or mapping, optional
        As for :func:`analyse_source`.

    Returns
    -------
    list of SourceTracks
        Those that have tracks.
    """
    found = []
    for source in sources:
        tracks, trial = source.tracks, source.trial
        if tracks is None:
            continue
        alone = trial is not None and tracks.sizes["individual"] == 1
        found.append(
            SourceTracks(
                tracks=tracks,
                animal=trial.animal.id if trial is not None and alone else None,
                trial=trial.name if trial is not None else "trial",
                legs=choose_legs(tracks, trial=trial, legs=source.legs if legs is None else legs),
            )
        )
    return found


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
        Settings of the event detection, and ``pairs``: what phases are measured between, as
        (leg, reference). They go before the input's own.

    Returns
    -------
    GaitTables
        The tables.

    Raises
    ------
    InputError
        If it cannot be analysed.
    """
    chosen = {**source.settings, **(settings or {})}
    pairs = read_pairs(chosen.pop("pairs", None))
    legs = source.legs if legs is None else legs
    if source.events is not None:
        events = source.events
        if legs is not None:
            events = choose_event_legs(events, legs, where=str(source.path))
        return gait.analyse_events(events, event_names=event_names, pairs=pairs, settings=chosen)
    tracks, trial, belt = source.tracks, source.trial, None
    if tracks is None:
        raise InputError(f"{source.path}: neither tracks nor events.")
    if "belt_speed" in tracks:
        belt = tracks["belt_speed"].to_dataframe()[["frame", "belt_speed"]]
        belt = belt.rename(columns={"belt_speed": "speed"})
        trial = None if trial is None else dataclasses.replace(trial, belt_speed=None)
    return gait.analyse(
        tracks, trial=trial, legs=legs, pairs=pairs, belt_speed=belt, settings=chosen
    )
