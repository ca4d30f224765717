"""Points of a trial of kind ``paws`` tracked through its recording."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import pandas as pd

from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.quality.likeness import add_likeness
from pawnb.core.paws.offline.reuse.kept_evidence import GONE_ON_FROM, KeptStacks
from pawnb.core.paws.offline.self_training.doubted_clicks import (
    LOOK_AT_CLICKS,
    doubted_clicks_in_words,
    doubted_clicks_of,
)
from pawnb.core.paws.tracker import DEFAULT, AnyTracker, KeptEvidence
from pawnb.core.rig import Rig
from pawnb.core.video import ViewSet
from pawnb.core.video.doubts.cuts import WatchedViews, tell_cuts, with_cuts
from pawnb.core.video.doubts.exchanged_films import film_codes, tell_other_films
from pawnb.core.video.doubts.frozen_labels import Freezes, without_frozen
from pawnb.core.video.doubts.repeated import freezes_of_views, tell_freezes
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.io.start import clicked_films
from pawnb.schema import Tracks, add_provenance
from pawnb.trial import Trial
from pawnb.workflow.calibration.moved_cameras import tell_moved_clicks, tell_moved_views
from pawnb.workflow.calibration.real_units import in_real_units
from pawnb.workflow.provenance.manifest import known_files, run_alone
from pawnb.workflow.provenance.mended_trial import tell_exchanged_views
from pawnb.workflow.provenance.results import (
    describe_trial,
    make_folder,
    results_folder,
    write_track_results,
)
from pawnb.workflow.reviewing.quality import tell_failed
from pawnb.workflow.start.exchanged_clicks import (
    solve_clicks,
    tell_disagreeing_clicks,
    tell_exchanged_clicks,
    tell_one_place,
)
from pawnb.workflow.start.turned_axes import tell_turned_axes
from pawnb.workflow.tracking.kept_candidates import keep_store, open_store, session_stacks
from pawnb.workflow.tracking.methods import tracker_settings, trial_tracker
from pawnb.workflow.tracking.opened_run import OpenedRun, first_run, record_of_run
from pawnb.workflow.tracking.options import TrackOptions
from pawnb.workflow.tracking.placed import start_clicks
from pawnb.workflow.tracking.point_tracker import point_trackers, tell_unused
from pawnb.workflow.tracking.predicted import predictions_for
from pawnb.workflow.tracking.trial_views import (
    frame_range,
    paw_task,
    shown_in_every_view,
    trial_rig,
)
from pawnb.workflow.tracking.unfinished import (
    join_earlier,
    unfinished_tracks,
    whole_tracks_stay,
)
from pawnb.workflow.tracking.unsynchronised import doubt_synchronisation, may_be_unsynchronised

_PUBLISHED_FRAMES = 2
"""Start clicks in two frames give a published method its first velocities."""


def track_points(trial: Trial, asked: TrackOptions) -> Tracks:
    """Track the points of a trial of kind ``paws``.

    Parameters
    ----------
    trial : Trial
        The trial.
    asked : TrackOptions
        What :func:`pawnb.track` was asked for.

    Returns
    -------
    xarray.Dataset
        Tracks.

    Raises
    ------
    InputError
        If anything the trial names is missing or does not fit.
    """
    tracker, out = trial_tracker(trial, asked.method), asked.out
    chosen = tracker_settings(trial, method=asked.method, settings=asked.settings)
    then = "deciding" if tracker.is_offline else ""
    with contextlib.ExitStack() as stack:
        run, stop, notes = stack.enter_context(first_run(trial, tracker, asked, then=then))
        run.tell_notes()
        views, watched = run.views, WatchedViews(run.views)
        clicks = start_clicks(trial, views, asked.start)
        rig = trial_rig(trial, views, method=asked.method)
        first, last = frame_range(trial, views, clicks, method=asked.method, frames=asked.frames)
        doubts = _doubt_films(trial, views, clicks) if asked.start is None else []
        doubts += _doubt_clicks(rig, clicks)
        freezes = _tell_doubts(trial, views, doubts, (first, last), quick=asked.quick)
        more = point_trackers(trial, stop, tell=True) if tracker.is_offline else []
        if not tracker.is_offline:
            _refuse_more_frames(clicks, asked.method)
            _tell_left_out((asked.frames or trial.frames or (0, last))[0], first)
        if out is not None:
            stack.enter_context(run_alone(make_folder(out)))
        store = _store(trial, tracker, out, stack)
        rows = clicks.to_dict(orient="records")
        step = record_of_run(trial, tracker, asked, frames=(first, last), start=rows)
        # an offline tracker keeps its evidence instead
        earlier = unfinished_tracks(Path(out), step) if out and not tracker.is_offline else None
        begin = first if earlier is None else int(earlier["frame"][-1])
        span: dict[str, Any] = {"frames": (begin, last), "tracks": earlier}
        if tracker.is_offline:
            span["predictions"] = predictions_for(trial, views, clicks, frames=(begin, last))
        task = paw_task(trial, rig, clicks, evidence=more, progress=run.report, stop=stop, **span)
        kept = KeptEvidence(store, _stacks(store, quick=asked.quick))
        go = tracker.track if earlier is None else tracker.resume
        tracks = go(watched, clicks, task, settings=chosen, kept=kept)
        if gone_on_from := json.loads(tracks.attrs.pop(GONE_ON_FROM, "[]")):
            step[GONE_ON_FROM] = gone_on_from
        run.end_progress()
        if asked.stop is None and tracks.sizes["time"] < last - first:
            _tell_interrupted(tracks, first, last, kept=store is not None or out is not None)
        if not tracker.is_offline:
            tracks = shown_in_every_view(tracks, rig, run.sizes)
        if earlier is not None:
            step["gone_on_from"] = begin
        tracks = _described(tracks, trial, run, earlier=earlier)
        whole = tracks.sizes["time"] == last - first
        tell_unused(trial, tracks, clicks)
        tracks = _tell_cuts(trial, watched, _judged(tracks, views, clicks, rig, freezes))
        tracks = add_provenance(tracks, **step, complete=whole, notes=notes)
        if out is not None and (whole or not whole_tracks_stay(Path(out))):
            write_track_results(tracks, out, rig=rig, warn=True)
    tell_failed(tracks, complete=whole)
    return tracks


def _doubt_clicks(rig: Rig | None, clicks: pd.DataFrame) -> list[str]:
    """Say what looks wrong in the clicks, and in how they lie in space."""
    doubts = tell_one_place(clicks)
    if rig is None:
        return doubts
    doubts += tell_disagreeing_clicks(solve_clicks(rig, clicks))
    doubts += tell_moved_clicks(clicks, rig)
    return [*doubts, *tell_exchanged_clicks(rig, clicks), *tell_turned_axes(rig, clicks)]


def _doubt_films(trial: Trial, views: ViewSet, clicks: pd.DataFrame) -> list[str]:
    """Say which views show films in which others were clicked, or tracked from these clicks."""
    file = trial.start_file()
    films = {} if file is None else clicked_films(trial.path(file))
    if films and (said := tell_other_films(film_codes(views.readers), films)):
        return said
    tracked = [one for one in known_files(results_folder(trial)).steps if one["step"] == "track"]
    if not tracked or tracked[-1].get("start") != clicks.to_dict(orient="records"):
        return []
    return tell_exchanged_views(tracked[-1], trial)


def _tell_doubts(
    trial: Trial, views: ViewSet, doubts: list[str], frames: tuple[int, int], *, quick: bool
) -> Freezes:
    """Warn of what looks wrong in clicks and films, and return where films stand still."""
    freezes = freezes_of_views(trial, views, start=frames[0], stop=frames[1])
    doubts = [*doubts, *tell_freezes(views, freezes)]
    if not quick and may_be_unsynchronised(trial, views):
        doubts = [*doubts, *doubt_synchronisation(trial, views, start=frames[0], stop=frames[1])]
    for doubt in doubts:
        warn_of_input(f"{doubt}.", InputWarning, stacklevel=3)
    return freezes


def _judged(
    tracks: Tracks, views: ViewSet, clicks: pd.DataFrame, rig: Rig | None, freezes: Freezes
) -> Tracks:
    """Return tracks with how alike labels look, and what pictures and cameras say against them."""
    tracks = without_frozen(add_likeness(views, tracks, clicks), freezes)
    for words in doubted_clicks_in_words(doubted_clicks_of(tracks)):
        warn_of_input(f"start clicks: {words}; {LOOK_AT_CLICKS}.", InputWarning, stacklevel=3)
    return tell_moved_views(tracks, rig, clicks=clicks)


def _tell_cuts(trial: Trial, watched: WatchedViews, tracks: Tracks) -> Tracks:
    """Warn of films that leap, where they were read, and return tracks that say so."""
    cuts = watched.find_cuts(trial)
    for words in tell_cuts(watched, cuts):
        warn_of_input(f"{words}.", InputWarning, stacklevel=3)
    return with_cuts(tracks, cuts)


def _described(tracks: Tracks, trial: Trial, run: OpenedRun, *, earlier: Tracks | None) -> Tracks:
    """Return tracks in real units, with what an earlier run has found, times and the trial."""
    # where the rate varies these are the file's own time stamps
    times = run.views.time_s[tracks["frame"].to_numpy()]
    tracks = in_real_units(tracks, trial, units="px")
    if earlier is not None:
        tracks = join_earlier(earlier, tracks)
    return describe_trial(tracks.assign_coords(time=times), trial, sizes=run.sizes)


def _stacks(store: DetectionCache | None, *, quick: bool) -> KeptStacks | None:
    """Return pictures and flow that this session keeps: of earlier runs only where quick."""
    stacks = None if store is None else session_stacks(store.source)
    if stacks is not None and not quick:
        stacks.forget()
    return stacks


def _store(
    trial: Trial, tracker: AnyTracker, out: str | Path | None, stack: contextlib.ExitStack
) -> DetectionCache | None:
    """Return where candidates are kept, for the tracker that keeps them."""
    if not tracker.is_offline:
        return None
    store = open_store(trial, None if out is None else Path(out))
    stack.callback(keep_store, store)
    return store


def _refuse_more_frames(clicks: pd.DataFrame, method: str) -> None:
    """Refuse start clicks that a published method has no use for."""
    frames = sorted(clicks["frame"].unique().tolist())
    if len(frames) > _PUBLISHED_FRAMES:
        raise InputError(
            f"the start has clicks in {len(frames)} frames ({frames[0]} to {frames[-1]}); method "
            f"{method!r} takes one frame, or two that give the first velocities: leave others out, "
            f"or use method {DEFAULT!r}, which takes any number."
        )


def _tell_left_out(asked: int, first: int) -> None:
    """Warn that frames before the first click are not tracked."""
    if asked < first:
        warn_of_input(
            f"frames {asked} to {first - 1} lie before the first click, in frame {first}, and are "
            f"not tracked; click the points in frame {asked} too to have them.",
            InputWarning,
            stacklevel=4,
        )


def _tell_interrupted(tracks: Tracks, first: int, last: int, *, kept: bool) -> None:
    """Warn that a person stopped the run, or stop where nothing was done."""
    frames = tracks["frame"].to_numpy()
    again = "; run it again to go on from there" if kept else ""
    if not len(frames):
        raise KeyboardInterrupt(f"interrupted before every point was placed{again}")
    warn_of_input(
        f"interrupted: frames {frames[0]} to {frames[-1]} of {first} to {last - 1} are "
        f"tracked{again}.",
        InputWarning,
        stacklevel=4,
    )
