"""The gait analysis: from Tracks, or from events scored by hand, to the gait tables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError, InputWarning
from pawnb.gait.analysis.feet_apart import say_on_one_place
from pawnb.gait.analysis.leg_names import choose_legs, guess_body, notes_on_legs
from pawnb.gait.analysis.notes import Note
from pawnb.gait.analysis.stated_belt import belt_on_grid
from pawnb.gait.analysis.tables import GaitTables, Pairs, build_tables, pool, say_whose_notes
from pawnb.gait.cycles.leg_signals import LegSignals
from pawnb.gait.events.contacts import unscored_gaps
from pawnb.gait.events.debounce import drop_short_states
from pawnb.gait.events.event_pipeline import EVENT_TABLE_COLUMNS, analyse_space, dropped_table
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.events.manual_events import check_scored_events
from pawnb.gait.legs import sort_legs
from pawnb.gait.locomotion.body import BodyPoints
from pawnb.gait.locomotion.foot_trajectories import (
    FootPaths,
    get_foot_paths,
    least_confidence,
    notes_on_confidence,
    notes_on_doubtful_places,
    notes_on_placeholders,
    notes_on_views,
)
from pawnb.gait.locomotion.grid import Grid, put_on_grid
from pawnb.gait.locomotion.pose_body import pose_body
from pawnb.gait.locomotion.seen_part import seen_part
from pawnb.gait.strides.stride_table import Motion
from pawnb.input_warnings import warn_of_input
from pawnb.schema import Tracks, absent_frames, build_settings, check_tracks, shown
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial

_GAP_COLUMNS = ("leg", "start_s", "end_s", "what")


@checked_arguments
def analyse(
    tracks: Tracks,
    *,
    trial: Trial | None = None,
    legs: Sequence[str] | Mapping[str, str] | None = None,
    pairs: Pairs | None = None,
    belt_speed: float | pd.DataFrame | None = None,
    forward: Sequence[float] | None = None,
    settings: EventSettings | Mapping[str, Any] | None = None,
) -> GaitTables:
    """Analyse the gait of tracked feet.

    AEP and PEP are the extremes of each foot's position along forward in the body frame;
    TD and LO are told from its speed relative to the ground or belt, and its height in
    3D. Strides, phase lags and their statistics follow.

    TD and LO are those of the tracked point: one on the wrist or ankle leaves the ground
    before the toes do, and its contact is shorter than theirs. A foot that creeps into
    contact without any jolt lands, by this measure, a little early.

    A foot that stops dead is the other extreme. Its speed jumps at touch-down, and frames and
    low-pass round the jump off by about a frame or 0.36 / cut-off, whichever is longer: AEP is
    found up to half of that early and TD late, PEP and LO the other way round. Duty factors of
    such feet (a half-cosine swing, 250 frames and 3 to 8 strides a second) come out 0.013 to
    0.042 too long from AEP to PEP and 0.016 to 0.037 too short from TD to LO, more at higher
    speeds as stances get shorter. It goes away with more frames and a higher ``cutoff_hz``.
    Of feet that move back before they land, as those of running mice do, AEP and PEP are
    right to 0.005.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one or more individuals.
    trial : Trial, optional
        Gives animal, name, belt speed, body points, direction and names of legs.
    legs : sequence of str or mapping, optional
        Points that are feet, or names of legs to names of points. Default: the trial's
        ``[tracks] legs``, else guessed (:func:`~pawnb.gait.analysis.leg_names.guess_legs`), which a
        note says.
    pairs : sequence of (leg, reference), optional
        Pairs whose phase is measured; default
        :func:`~pawnb.gait.legs.default_pairs`.
    belt_speed : float or DataFrame, optional
        Speed of a treadmill in unit/s, or a table frame, speed; default the trial's.
    forward : sequence of float, optional
        Direction towards the front, 2 or 3 numbers; default as the trial says, or
        derived: from the travel on the ground, from the swing of the feet in pictures.
    settings : EventSettings or mapping, optional
        Settings; unknown names are refused.

    Returns
    -------
    GaitTables
        The tables.

    Raises
    ------
    InputError
        If the tracks do not follow the schema, a leg or setting is unknown, no leg is
        ever seen, or the belt speed cannot be used.

    Warns
    -----
    InputWarning
        If the trial has another frame rate than the tracks, as after ``trial.toml`` was mended.

    Examples
    --------
    >>> gait = pawnb.gait.analyse(tracks, trial=run.trial)
    >>> true = run.strides["duty_factor"].mean()
    >>> bool(abs(gait.strides["duty_factor"].mean() - true) < 0.05)
    True
    >>> gait.events[["leg", "event", "frame", "time_s"]].shape[1]
    4
    """
    if trial is not None and not isinstance(trial, Trial):
        raise InputError(f"trial is {shown(trial)}; expected what pawnb.load_trial returns.")
    where = f"trial {trial.name!r}" if trial is not None else "these tracks"
    settings = _settings(settings)
    check_tracks(tracks, where=where)
    if trial is not None and not math.isclose(tracks.attrs["fps"], trial.fps, rel_tol=1e-6):
        warn_of_input(
            f"{where} has {trial.fps:g} frames/s and these tracks {tracks.attrs['fps']:g}: times "
            "are those of the tracks. If the trial was mended since, pawnb.run_gait(trial) brings "
            "tracks to it.",
            InputWarning,
            stacklevel=2,
        )
    named = choose_legs(tracks, trial=trial, legs=legs, where=where)
    individuals = [str(i) for i in tracks["individual"].to_numpy()]
    parts = []
    for individual in individuals:
        # each is in the picture for a time of its own
        feet = list(named.values())
        least = least_confidence(tracks, settings.min_confidence)
        part, unseen = seen_part(tracks.sel(individual=[individual]), feet=feet, least=least)
        grid, dense = put_on_grid(part, where=where)
        belt = belt_on_grid(belt_speed, trial, grid)
        lost = [*unseen, *_lost_frames(part, grid)]
        animal = trial.animal.id if trial is not None and len(individuals) == 1 else individual
        parts.append(
            _analyse_one(
                dense, grid, named, trial=trial, individual=individual, pairs=pairs, belt=belt,
                forward=None if forward is None else np.asarray(forward, dtype=float),
                settings=settings, lost=lost,
                who={"animal": animal, "trial": trial.name if trial is not None else "trial"},
            )
        )  # fmt: skip
    if not any(basis.motion for part in parts for basis in part.bases):
        raise InputError(
            f"animal {parts[0].bases[0].who['animal']!r}: none of the legs {', '.join(named)} has "
            "a position in any frame"
            + (f" (those with a confidence below {least:g} do not count)" if least > 0.0 else "")
            + "; track it first, or lower min_confidence (--set min_confidence=...)."
        )
    tables = pool(say_whose_notes(parts))
    told = legs is not None or (trial is not None and trial.tracks_legs)
    if told:
        return tables
    of_trial = trial.name if trial is not None else "trial"
    said = [
        Note(note, where=of_trial)
        for note in notes_on_legs(map(str, tracks["keypoint"].to_numpy()), named)
    ]
    return replace(tables, notes=(*said, *tables.notes))


@checked_arguments
def analyse_events(
    events: pd.DataFrame,
    *,
    event_names: Mapping[str, str] | None = None,
    pairs: Pairs | None = None,
    settings: EventSettings | Mapping[str, Any] | None = None,
) -> GaitTables:
    """Analyse events that were scored by hand or come from another program.

    Parameters
    ----------
    events : pandas.DataFrame
        Columns leg, event (AEP, PEP, TD, LO) and time_s; animal, trial, frame and
        method are filled in where they are missing.
    event_names : mapping, optional
        What the table calls its events, where it has other names for them:
        ``{"down": "TD", "up": "LO"}``.
    pairs : sequence of (leg, reference), optional
        Pairs whose phase is measured; default
        :func:`~pawnb.gait.legs.default_pairs`.
    settings : EventSettings or mapping, optional
        ``stride_events``, ``max_stride_s``, ``min_stance_s`` and ``min_swing_s`` are used.
        Where the last two are None, events of tables of ground contact are cleared of stances
        and swings much shorter than the leg's usual ones
        (:func:`~pawnb.gait.events.debounce.drop_short_states`), which ``dropped`` says.

    Returns
    -------
    GaitTables
        The tables; stride length and speed are NaN.

    Raises
    ------
    InputError
        If a column is missing, an event is unknown, or a time is not a number.

    Examples
    --------
    Two feet whose touch-downs and lift-offs (s) were scored by hand.

    >>> rows = [("FR", "TD", t) for t in (0.0, 0.2, 0.4)] + [("FR", "LO", t) for t in (0.12, 0.32)]
    >>> rows += [("FL", "TD", t) for t in (0.1, 0.3, 0.5)] + [("FL", "LO", t) for t in (0.22, 0.42)]
    >>> events = pd.DataFrame(rows, columns=["leg", "event", "time_s"])
    >>> events = events.assign(animal="m01", trial="run-1", frame=events["time_s"] * 250.0)
    >>> gait = pawnb.gait.analyse_events(events)
    >>> gait.strides["duty_factor"].round(2).unique().tolist()
    [0.6]
    """
    settings = _settings(settings)
    events = check_scored_events(events, names=event_names)
    parts = []
    for (animal, trial), own in events.groupby(["animal", "trial"], sort=False):
        who = {"animal": str(animal), "trial": str(trial)}
        legs = sort_legs(own["leg"])
        gaps = unscored_gaps(own)
        own, short = drop_short_states(own, who, settings=settings)
        unscored = [
            {
                "leg": gap.leg,
                "start_s": gap.start_s,
                "end_s": gap.end_s,
                "what": "contact",
                "why": "frames are not in the table, or not scored",
            }
            for gap in gaps.itertuples()
        ]
        parts.append(
            build_tables(
                _in_order(own, legs), who, pairs=pairs, settings=settings, legs=legs,
                gaps=gaps, dropped=dropped_table([*unscored, *short], who),
            )
        )  # fmt: skip
    return pool(parts)


def _in_order(events: pd.DataFrame, legs: list[str]) -> pd.DataFrame:
    """Sort events by leg, in the order given, and time."""
    rank = events["leg"].map({leg: i for i, leg in enumerate(legs)}).to_numpy()
    order = np.lexsort((events["time_s"].to_numpy(), rank))
    return events.iloc[order].reset_index(drop=True)


def _settings(settings: EventSettings | Mapping[str, Any] | None) -> EventSettings:
    """Return settings as a checked dataclass."""
    if isinstance(settings, EventSettings):
        return settings
    return build_settings(EventSettings, {} if settings is None else settings, where="gait")


def _analyse_one(
    dense: Tracks,
    grid: Grid,
    legs: Mapping[str, str],
    *,
    trial: Trial | None,
    individual: str,
    pairs: Pairs | None,
    belt: FloatArray | None,
    forward: FloatArray | None,
    settings: EventSettings,
    lost: Sequence[Mapping[str, Any]],
    who: Mapping[str, str],
) -> GaitTables:
    """Analyse one individual on the grid."""
    least = least_confidence(dense, settings.min_confidence)
    spaces = get_foot_paths(dense, legs, individual=individual, min_confidence=least)
    seen = [leg for space in spaces for leg in space.legs]
    events: list[dict[str, Any]] = []
    gaps: list[dict[str, Any]] = []
    dropped = [*(dict(row) for row in lost), *_never_seen(legs, seen, grid)]
    motion: dict[str, Motion] = {}
    signals: list[LegSignals] = []
    notes = [
        *notes_on_placeholders(spaces), *notes_on_confidence(dense, least),
        *notes_on_doubtful_places(dense, legs, individual=individual, least=least),
        *notes_on_views(dense, spaces),
    ]  # fmt: skip
    for space in spaces:
        posed = pose_body(dense, space, individual=individual)
        body, space = posed or (
            _body_points(dense, trial, individual, space.source, least=least),
            space,
        )
        others = _other_points(dense, legs, individual, space.source, least=least)
        found = analyse_space(
            space, grid, trial=trial, belt=belt, body=body, others=others, forward=forward,
            settings=settings, who=who,
        )  # fmt: skip
        events += found.events
        gaps += found.gaps
        dropped += found.dropped
        notes += [*found.notes, *say_on_one_place(space, fs_hz=grid.fs_hz)]
        signals += found.signals
        motion |= dict.fromkeys(space.legs, found.motion)
    table = pd.DataFrame([{**who, **e} for e in events], columns=list(EVENT_TABLE_COLUMNS))
    table = table.astype({"frame": float, "time_s": float, "position": float})
    return build_tables(
        _in_order(table, list(legs)), who, pairs=pairs, settings=settings, motion=motion,
        gaps=pd.DataFrame(gaps, columns=list(_GAP_COLUMNS)), legs=list(legs),
        dropped=dropped_table(dropped, who), notes=notes, signals=signals,
        body_length=_body_length(dense, trial, spaces[0].unit) if spaces else None,
    )  # fmt: skip


def _never_seen(legs: Mapping[str, str], seen: Sequence[str], grid: Grid) -> list[dict[str, Any]]:
    """Return a row of what is dropped for each leg that has no position in any frame."""
    span = {"start_s": grid.time_s[0], "end_s": grid.time_s[-1]}
    return [
        {"leg": leg, **span, "what": "leg", "why": "never seen"} for leg in legs if leg not in seen
    ]


def _lost_frames(tracks: Tracks, grid: Grid) -> list[dict[str, Any]]:
    """Return what is said of frames without a row: they are no frames without movement."""
    rows = []
    for first, last, file in absent_frames(tracks):
        start, end = np.interp((first, last), grid.frame, grid.time_s)
        span = f"frame {first} is" if first == last else f"frames {first} to {last} are"
        rows.append(
            {
                "leg": "", "start_s": float(start), "end_s": float(end), "what": "frames",
                "why": f"{span} not in {file}",
            }
        )  # fmt: skip
    return rows


def _body_length(tracks: Tracks, trial: Trial | None, unit: str) -> float | None:
    """Return the length of the body in the unit of the positions, where anybody says it."""
    if "body_length" in tracks.attrs:
        return float(tracks.attrs["body_length"])
    said = trial.animal.extra.get("body_length") if trial is not None else None
    known = trial.calibration.unit if trial is not None and trial.calibration else "px"
    return float(said) if isinstance(said, int | float) and unit == known else None


def _other_points(
    dense: Tracks, legs: Mapping[str, str], individual: str, source: str, *, least: float
) -> FootPaths | None:
    """Return the tracked points that are no feet, in one space."""
    feet = set(legs.values())
    points = [p for p in map(str, dense["keypoint"].to_numpy()) if p not in feet]
    if not points:
        return None
    found = get_foot_paths(
        dense, {p: p for p in points}, individual=individual, min_confidence=least
    )
    return next((one for one in found if one.source == source), None)


def _body_points(
    dense: Tracks, trial: Trial | None, individual: str, source: str, *, least: float
) -> BodyPoints | None:
    """Return the points of the body in one space: those the trial names, or guessed ones."""
    named = trial.animal.body if trial is not None else ()
    names = named or guess_body([str(p) for p in dense["keypoint"].to_numpy()]) or ()
    if not names:
        return None
    points = {p: p for p in names}
    spaces = get_foot_paths(dense, points, individual=individual, min_confidence=least)
    for space in spaces:
        if space.source == source and len(space.legs) == len(names):
            order = [space.legs.index(p) for p in names]
            along = space.positions[:, :, order]
            return BodyPoints(points=along, names=tuple(names), guessed=not named)
    return None
