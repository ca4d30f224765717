"""What a reader must know of the inputs of a gait analysis: whose they are, their unit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.gait import GaitTables
from pawnb.gait.analysis.notes import Note, trial_of
from pawnb.io.deeplabcut import PICTURES
from pawnb.io.format_table import find_entry
from pawnb.io.formats import recognise_format
from pawnb.schema import Tracks, rows_with_places
from pawnb.workflow.conversion.film_of_tracks import doubt_film_of_tracks
from pawnb.workflow.gait.event_sources import groups_of_events
from pawnb.workflow.gait.notes.group_notes import name_trials, notes_on_fields, notes_on_groups
from pawnb.workflow.gait.notes.identity_notes import notes_on_identities
from pawnb.workflow.gait.sources import GaitSource
from pawnb.workflow.gait.study_tables import Fields

_MOST = 0.5
"""Share of the trials that have a leg, from which on the others lack it."""
_COMPARED_FRAMES = 200
_SAME_SHARE = 0.1
"""Tracks of two files are of one recording where they differ by less than this share of how far
their points move. Set by hand: a median filter of DeepLabCut's leaves a hundredth."""


def notes_on_sources(sources: Sequence[GaitSource], animals: Sequence[str] | None) -> list[str]:
    """Say what was taken for granted of the inputs, or looks wrong in them.

    Parameters
    ----------
    sources : sequence of GaitSource
        The inputs.
    animals : sequence of str or None
        Ids that were given.

    Returns
    -------
    list of str
        The notes.
    """
    whose = [] if animals is not None else [*_who_is_who(sources), *_same_names(sources)]
    tracked = [
        (source.given.name, source.tracks) for source in sources if source.tracks is not None
    ]
    own = [note for name, tracks in tracked for note in _on_rows(name, tracks)]
    own += [note for source in sources for note in _on_film(source)]
    told = [*_told_otherwise(sources), *_same_recordings(sources), *_units_taken(sources)]
    return [*whose, *own, *told]


def _told_otherwise(sources: Sequence[GaitSource]) -> list[str]:
    """Say which files say another group or animal of themselves than was told beside them."""
    groups, animals = [], []
    for source in sources:
        named = {} if source.events is None else groups_of_events(source.events, where="")
        own = [source.trial.animal.group] if source.trial is not None and not named else []
        said = {group for group in (*named.values(), *own) if group}
        if source.group and source.compared == "group" and said and said != {source.group}:
            groups.append(f"{_named(source)} in {source.group}, not {' or '.join(sorted(said))}")
        now = source.animals[:1]
        if source.of_trial is not None and source.called and source.called[:1] != now:
            animals.append(f"{_named(source)} as {now[0]}, not {source.called[0]}")
    return [
        f"{what} are counted as the study (or command) says, and not as the file itself: "
        f"{'; '.join(told)}. Look which of them is right."
        for what, told in (("groups", groups), ("animals", animals))
        if told
    ]


def say_whose_trial(parts: Sequence[GaitTables]) -> list[GaitTables]:
    """Say of the notes on a trial whose it is, where several animals have one of its name.

    Parameters
    ----------
    parts : sequence of GaitTables
        The analysis of each input.

    Returns
    -------
    list of GaitTables
        The same; notes on the trial ``day1`` of ``m07`` belong to ``m07 day1`` where other inputs
        have a ``day1``, too.
    """
    names = Counter(trial for part in parts for trial in {b.who["trial"] for b in part.bases})
    told = []
    for part in parts:
        whose = {}
        for name in {basis.who["trial"] for basis in part.bases if names[basis.who["trial"]] > 1}:
            animals = [basis.who["animal"] for basis in part.bases if basis.who["trial"] == name]
            whose[name] = trial_of(" and ".join(animals), name)
        notes = [Note(note) for note in part.notes]
        told.append(
            replace(
                part,
                notes=tuple(Note(n.what, where=whose.get(n.where, n.where)) for n in notes),
            )
        )
    return told


def notes_on_trials(
    sources: Sequence[GaitSource],
    tables: GaitTables,
    groups: Mapping[tuple[str, str], str],
    *,
    aside: Mapping[tuple[str, str], str],
    fields: Fields,
) -> list[str]:
    """Say what makes trials that are pooled or compared unlike each other.

    Parameters
    ----------
    sources : sequence of GaitSource
        The inputs.
    tables : GaitTables
        Of all trials.
    groups : mapping
        Group of each animal and trial, where there are any.
    aside : mapping
        Condition of each animal and trial where a study compares groups, group where it compares
        conditions.
    fields : mapping
        (animal, trial) to its covariates.

    Returns
    -------
    list of str
        The notes.
    """
    return [
        *notes_on_groups(tables.trials, groups, aside=aside, compared=sources[0].compared),
        *notes_on_fields(fields),
        *_missing_legs(tables.events),
        *_ways_of_stance(tables.strides, tables.trials),
        *_rates_of_groups(sources, groups),
    ]


def _missing_legs(events: pd.DataFrame) -> list[str]:
    """Say which trials lack a leg that most others have."""
    trials = [events["animal"].astype(str), events["trial"].astype(str)]
    has = pd.crosstab(trials, events["leg"].astype(str)) > 0
    notes = []
    for leg in has.columns[~has.all() & (has.mean() > _MOST)]:
        without = ", ".join(name_trials(has.index[~has[leg]], has.index))
        animals = has[leg].groupby(level=0).any()
        notes.append(
            f"{leg} has no event in {without}: what is said of it counts {int(animals.sum())} of "
            f"{len(animals)} animals."
        )
    return notes


def _ways_of_stance(strides: pd.DataFrame, trials: Sequence[tuple[str, str]]) -> list[str]:
    """Say where stances of some trials are by position and those of others by contact."""
    ways = {
        str(way): own[["animal", "trial"]].drop_duplicates().astype(str)
        for way, own in strides.groupby("method", sort=False)
    }
    if len(ways) < 2:
        return []
    told = " and ".join(
        f"{way.replace('/', ' to ')} in "
        f"{', '.join(name_trials(own.itertuples(index=False, name=None), trials))}"
        for way, own in ways.items()
    )
    return [
        f"stance is from {told}: a leg lands after its AEP and may lift off after its PEP, so that "
        "stance, swing and duty factor of the one are not those of the other. Compare trials with "
        "one kind of events (stride_events, or score the same events in all)."
    ]


def _rates_of_groups(
    sources: Sequence[GaitSource], groups: Mapping[tuple[str, str], str]
) -> list[str]:
    """Say where groups that are compared were filmed at different frame rates."""
    rates: dict[str, set[float]] = {}
    for source in sources:
        for animal in source.animals:
            group = groups.get((animal, source.trial_name))
            if group is not None and source.tracks is not None:
                rates.setdefault(group, set()).add(float(source.tracks.attrs["fps"]))
    if len({frozenset(own) for own in rates.values()}) < 2:
        return []
    said = ", ".join(
        f"{group} at {' and '.join(f'{fps:g}' for fps in sorted(own))}"
        for group, own in rates.items()
    )
    return [
        f"groups were filmed at different rates ({said} frames a second): instants are as exact as "
        "the frames are close, and filters may differ, so that a part of the difference may be "
        "that of the cameras; cutoff_hz gives all the same filter."
    ]


def _who_is_who(sources: Sequence[GaitSource]) -> list[str]:
    """Say where files that name no animal were counted as animals of their own."""
    guessed = [
        source.trial.animal.id if source.trial is not None else source.path.stem
        for source in sources
        if source.guessed
    ]
    if len(sources) < 2 or not guessed:
        return []
    return [
        f"these files do not name their animal, so each counts as one of its own: "
        f"{', '.join(guessed)}. Several of one animal must not: say whose they are with --animals, "
        "one id for each input."
    ]


def _units_taken(sources: Sequence[GaitSource]) -> list[str]:
    """Say of which files lengths are taken to be in mm, though nothing says so."""
    files = [source.path.name for source in sources if _lacks_unit(source)]
    if not files:
        return []
    return [
        f"lengths of {', '.join(files)} are taken to be in mm, as such a file does not say its "
        "unit. Where they are in another: name the file in a trial.toml of kind 'tracks', with "
        'its unit below [calibration] (unit = "m").'
    ]


def _on_rows(name: str, tracks: Tracks) -> Iterator[str]:
    """Say where rows of a file may be no frames of a film, or animals not what they are called."""
    frames = tracks["frame"].to_numpy()[rows_with_places(tracks)]
    fps = float(tracks.attrs["fps"])
    step = int(np.gcd.reduce(np.diff(frames))) if len(frames) > 1 else 1
    if step > 1:
        yield (
            f"{name}: its rows are {step} frames apart, {fps / step:g} a second of {fps:g} frames "
            "a second. Where it has a row for every frame, its frames are counted in another unit: "
            "number them 0, 1, 2, ..."
        )
    if PICTURES in tracks.attrs:
        yield (
            f"{name} holds labels of single pictures, not tracks: the gait is right only where "
            "every frame of one film was labelled and the pictures are numbered as its frames."
        )
    yield from notes_on_identities(name, tracks)


def _on_film(source: GaitSource) -> list[str]:
    """Say where tracks made elsewhere do not fit the film that their trial names."""
    trial, tracks = source.trial, source.tracks
    if source.of_trial is None or trial is None or tracks is None or not trial.is_tracked_elsewhere:
        return []
    return [
        str(Note(note, where=source.trial_name)) for note in doubt_film_of_tracks(trial, tracks)
    ]


def _lacks_unit(source: GaitSource) -> bool:
    """Whether points in space come from a file without a unit, and no trial says one."""
    tracks, trial = source.tracks, source.trial
    if tracks is None or tracks.sizes["space"] != 3 or not np.isfinite(tracks["position"]).any():
        return False
    if trial is not None and trial.calibration is not None:
        return False
    entry = find_entry(recognise_format(source.path))
    # of those that say their frame rate C3D says its unit as well, and movement's reader warns
    return "unit" in entry.reads_with and not entry.says_fps


def _same_names(sources: Sequence[GaitSource]) -> list[str]:
    """Say which animals of files with several are in more than one of them."""
    named = [s.animals for s in sources if s.of_trial is None and len(s.animals) > 1]
    seen = [animal for animals in named for animal in animals]
    shared = [animal for animal in dict.fromkeys(seen) if seen.count(animal) > 1]
    if not shared:
        return []
    return [
        f"{', '.join(shared)}: in several files, and counted as the same animals. Where a program "
        "only numbered the animals of each file, say who they are with --animals, such as m1+m2 "
        "m3+m4 of two files with two animals each."
    ]


def _same_recordings(sources: Sequence[GaitSource]) -> list[str]:
    """Say which files hold the same tracks, which would count as several trials."""
    alike: dict[tuple[int, ...], list[tuple[GaitSource, FloatArray]]] = {}
    for source in sources:
        if source.tracks is not None:
            places = _places(source.tracks)
            alike.setdefault(places.shape, []).append((source, places))
    same: dict[str, list[str]] = {}
    for group in alike.values():
        for one, other in _same_pairs(group):
            # with the first that it is the same as: of many copies there is one sentence
            first = next((name for name, copies in same.items() if _named(one) in copies), None)
            copies = same.setdefault(first or _named(one), [])
            copies += [_named(other)] * (_named(other) not in copies)
    return [
        f"{', '.join((one, *copies[:-1]))} and {copies[-1]} hold the same tracks and count as "
        f"{'two' if len(copies) == 1 else len(copies) + 1} trials; of one recording name one file "
        "only."
        for one, copies in same.items()
    ]


def _named(source: GaitSource) -> str:
    """Return a file and its trial, in words."""
    return f"{source.given.name} ({source.trial_name})"


def _places(tracks: Tracks) -> FloatArray:
    """Return where the points are, in some of the frames."""
    places = tracks["position"].transpose("time", "individual", "keypoint", "space").to_numpy()
    return np.asarray(places[:: max(1, len(places) // _COMPARED_FRAMES)], dtype=float)


def _same_pairs(
    group: Sequence[tuple[GaitSource, FloatArray]],
) -> Iterator[tuple[GaitSource, GaitSource]]:
    """Yield those whose tracks (n, ...) are hardly apart, for how far their points move."""
    flat = np.stack([places.ravel() for _, places in group])
    for i, (one, places) in enumerate(group[:-1]):
        apart = np.abs(flat[i + 1 :] - flat[i])
        known = np.isfinite(apart).sum(axis=1)
        # more than half of them are nearer: so is their median, which takes ten times as long
        near = (apart < _SAME_SHARE * _moved(places)).sum(axis=1)
        for j in np.flatnonzero(2 * near > known):
            yield one, group[i + 1 + int(j)][0]


def _moved(places: FloatArray) -> float:
    """Return how far points are from their mean places, the median; 0 where none is known."""
    known = np.isfinite(places)
    if not known.any():
        return 0.0
    about = np.where(known, places, 0.0).sum(axis=0) / np.maximum(1, known.sum(axis=0))
    return float(np.median(np.abs(places - about)[known]))
