"""Trial to Tracks in one call, and tracking again from a corrected frame."""

from __future__ import annotations

import contextlib
import dataclasses
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.parameters import parameters_set
from pawnb.core.paws.maghsoudi2019.settings import REFERENCE_WIDTH_PX
from pawnb.core.paws.offline.again import Again, frames_again, weighing_of
from pawnb.core.paws.offline.detection.colour.cache import DetectionCache
from pawnb.core.paws.offline.detection.predictions import Predictions
from pawnb.core.paws.offline.quality.likeness import add_likeness, keep_likeness
from pawnb.core.paws.offline.settings import OfflineSettings
from pawnb.core.paws.offline.tracker import LEARNT
from pawnb.core.paws.retracked_span import TOLERANCE_PX, keep_untouched
from pawnb.core.paws.tracker import DEFAULT, AnyTracker, Correction, KeptEvidence
from pawnb.core.reproject import fill_reprojected
from pawnb.core.rig import Rig
from pawnb.core.video import ViewSet, open_views
from pawnb.errors import InputError, InputWarning
from pawnb.schema import ORIGIN_CODE, Tracks, add_provenance
from pawnb.trial import Trial, load_trial
from pawnb.workflow.calibration.real_units import in_real_units
from pawnb.workflow.interrupt import interruptible
from pawnb.workflow.progress import Progress, tracking_progress
from pawnb.workflow.provenance.manifest import run_alone
from pawnb.workflow.provenance.notes import noted_warnings
from pawnb.workflow.provenance.record import build_step, trial_checksums, trial_fingerprint
from pawnb.workflow.provenance.results import (
    describe_trial,
    make_folder,
    provenance_steps,
    results_folder,
    write_track_results,
)
from pawnb.workflow.reviewing.quality import tell_failed
from pawnb.workflow.tracking.kept_candidates import (
    describe_source,
    keep_store,
    open_store,
    reopen_store,
    session_stacks,
)
from pawnb.workflow.tracking.methods import (
    by_dotted_name,
    method_of_tracks,
    recorded_parameters,
    settings_in_force,
    stage_parameters,
    stage_parameters_of_tracks,
    tracker_settings,
    trial_tracker,
)
from pawnb.workflow.tracking.placed import (
    clicks_by_hand,
    clicks_learnt_from,
    clicks_of_frame,
    start_clicks,
)
from pawnb.workflow.tracking.predicted import read_predictions
from pawnb.workflow.tracking.retrack_pose import retrack_pose
from pawnb.workflow.tracking.track_pose import track_pose_trial
from pawnb.workflow.tracking.trial_views import frame_range, paw_task, points_by_view, trial_rig
from pawnb.workflow.tracking.unfinished import join_earlier, unfinished_tracks

_PUBLISHED_FRAMES = 2
"""Start clicks in two frames give a published method its first velocities."""


def track(
    trial: Trial | str | Path,
    *,
    method: str = DEFAULT,
    settings: Mapping[str, Any] | None = None,
    start: pd.DataFrame | None = None,
    frames: tuple[int, int] | None = None,
    out: str | Path | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    command: Sequence[str] | None = None,
) -> Tracks:
    """Track the points, or the pose, of a trial through its recording.

    Parameters
    ----------
    trial : Trial, str or Path
        The trial, its ``trial.toml``, or the folder that holds it.
    method : {"pawnb", "paper", "slic-3d", "slic-2d"}
        ``"pawnb"`` decides over the whole recording. ``"paper"``: superpixels, a 3D Kalman
        filter and a stride template, after Haji Maghsoudi et al. 2019; ``"slic-3d"`` and
        ``"slic-2d"`` are the lesser variants it is compared with: no template, and a 2D
        filter in each view. ``"slic-2d"`` alone tracks several views without a calibration:
        ``image_position`` has every view, and ``position`` is that in the first view in which
        the point was clicked, px.
    settings : mapping, optional
        Settings of the tracker; they go before those of ``[tracking]`` in the trial.
    start : pandas.DataFrame, optional
        Clicks with columns frame, view, point, u, v (px); default the trial's ``start.csv``.
        Of a jointed animal the columns of ``start_pose.csv``.
    frames : tuple of int, optional
        Half-open range of frames; default the trial's, else all. Method ``"pawnb"`` goes both
        ways from the clicks, as tracking a jointed animal does; the others begin with the first
        clicked frame and warn of what lies before it.
    out : str or Path, optional
        Folder for ``tracks.nc``, its tables, ``suspects.csv``, ``quality.json``,
        ``provenance.json`` and ``candidates.bin``. After an interruption a second run goes on
        from what is there.
    progress : callable, optional
        ``progress(done, total)``; default a bar on a terminal or in a notebook. One that takes
        ``doing``, too, is told in words what is done: "tracking", "deciding", or in a first run
        "compiling (first run only)".
    stop : callable, optional
        Asked before each frame; when it answers True, what is done is kept. By default an
        interrupt (Ctrl-C) does that. Called again with the same ``out``, it goes on from there.
        Method ``"pawnb"`` has tracks to show once it has come to the clicks.
    command : sequence of str, optional
        The command line, for the provenance.

    Returns
    -------
    xarray.Dataset
        Tracks; see :mod:`pawnb.schema`. With a calibration, points are shown also in the views
        that do not track them, re-projected from their place in space.
        :func:`pawnb.assess_quality` says how good they are; ``image_likeness`` is the correlation
        of the picture at a label with that at a click of the point, in a sample of frames.

    Raises
    ------
    InputError
        If anything the trial names is missing or does not fit.

    Warns
    -----
    QualityWarning
        If most labels are expected to be wrong.

    Examples
    --------
    >>> tracks = pawnb.track(trial, out="sample/results")
    >>> sorted(tracks["keypoint"].values.tolist())
    ['FL', 'FR', 'HL', 'HR']
    """
    if not isinstance(trial, Trial):
        trial = load_trial(trial)
    track_trial = _TRACK[trial_tracker(trial, method).kind]
    return track_trial(
        trial, method=method, settings=settings, start=start, frames=frames, out=out,
        progress=progress, stop=stop, command=command,
    )  # fmt: skip


def _track_points(
    trial: Trial,
    *,
    method: str,
    settings: Mapping[str, Any] | None,
    start: pd.DataFrame | None,
    frames: tuple[int, int] | None,
    out: str | Path | None,
    progress: Progress | None,
    stop: Callable[[], bool] | None,
    command: Sequence[str] | None,
) -> Tracks:
    """Track the points of a trial of kind ``paws``; arguments as of :func:`track`."""
    tracker = trial_tracker(trial, method)
    chosen = tracker_settings(trial, method=method, settings=settings)
    with contextlib.ExitStack() as stack:
        notes = stack.enter_context(noted_warnings())
        own = stage_parameters(trial, method=method, settings=settings)
        stack.enter_context(parameters_set(own))
        asked = stack.enter_context(interruptible()) if stop is None else stop
        shown = stack.enter_context(contextlib.ExitStack())
        report = shown.enter_context(_progress(progress, "tracking", tracker))
        views = stack.enter_context(open_views(trial))
        for note in views.notes:
            warnings.warn(note, InputWarning, stacklevel=3)
        clicks = start_clicks(trial, views, start)
        rig = trial_rig(trial, views, method=method)
        first, last = frame_range(trial, views, clicks, method=method, frames=frames)
        if not tracker.is_offline:
            _refuse_more_frames(clicks, method)
            _tell_left_out((frames or trial.frames or (0, last))[0], first)
        if out is not None:
            stack.enter_context(run_alone(make_folder(out)))
        store = _store(trial, tracker, out, stack)
        step = build_step(
            "track",
            command=command,
            # clicks that were handed over stand in the record themselves
            inputs=trial_checksums(trial, start=start is None),
            settings=settings_in_force(trial, method=method, settings=settings),
            method=method,
            **recorded_parameters(tracker),
            frames=[first, last],
            trial=trial_fingerprint(trial),
            start=clicks.to_dict(orient="records"),
        )
        # an offline tracker keeps its evidence instead
        earlier = unfinished_tracks(Path(out), step) if out and not tracker.is_offline else None
        begin = first if earlier is None else int(earlier["frame"][-1])
        span: dict[str, Any] = {"frames": (begin, last), "tracks": earlier}
        if tracker.is_offline:
            span["predictions"] = _predictions(trial, views, clicks, (begin, last))
        task = paw_task(trial, rig, clicks, progress=report, stop=asked, **span)
        kept = KeptEvidence(store, None if store is None else session_stacks(store.source))
        go = tracker.track if earlier is None else tracker.resume
        tracks = go(views, clicks, task, settings=chosen, kept=kept)
        shown.close()
        if stop is None and tracks.sizes["time"] < last - first:
            _tell_interrupted(tracks, first, last, kept=store is not None or out is not None)
        sizes = _sizes(views)
        if not tracker.is_offline:
            tracks = _shown_in_every_view(tracks, rig, sizes)
        # where the rate varies these are the file's own time stamps
        times = views.time_s[tracks["frame"].to_numpy()]
        tracks = in_real_units(tracks, trial, units="px")
        if earlier is not None:
            step["gone_on_from"] = begin
            tracks = join_earlier(earlier, tracks)
        tracks = describe_trial(tracks.assign_coords(time=times), trial, sizes=sizes)
        whole = tracks.sizes["time"] == last - first
        tracks = add_likeness(views, tracks, clicks)
        tracks = add_provenance(tracks, **step, complete=whole, notes=notes)
        if out is not None:
            write_track_results(tracks, out, rig=rig)
    tell_failed(tracks, complete=whole)
    return tracks


def retrack(
    trial: Trial,
    tracks: Tracks,
    frame: int,
    *,
    learn: bool = False,
    out: str | Path | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Tracks:
    """Track on from a corrected frame, with every state of the tracker reset.

    Features, Kalman states, 3D points, template fits and collision flags start anew
    from the positions in ``frame`` (2019 paper, section 3.1). Only the stretch that the
    correction touches is tracked again: each point put in place by hand in ``frame``, to
    the next frame in which that was done, or to where the new track has met the old one
    (within 2 px of the paper's pictures in every view, 10 frames in a row). Other points
    and all other rows stay as they are. Where nothing was put in place in ``frame``, all
    points are tracked again to the end.

    Method ``pawnb`` decides over the whole recording again, with everything that was put
    in place by hand as certain. Other points then take their new rows, too, about where
    they have moved: where one paw was taken for another, both are set right. Of tracks that were
    made by what was learnt in the recording only the frames up to the next click of the corrected
    points are looked at; what paws look like is learnt anew from the correction, too. Pictures and
    flow that this session has kept of the recording are not decoded again.

    Of a jointed animal see :func:`pawnb.workflow.tracking.retrack_pose.retrack_pose`.

    Parameters
    ----------
    trial : Trial
        The trial of these tracks.
    tracks : xarray.Dataset
        Tracks with the corrections already applied.
    frame : int
        The corrected frame.
    learn : bool
        Learn the initial colours of the corrected points anew, from this frame on, as the
        paper's user may ask for. Without, they stay those of the start, and method
        ``pawnb`` decodes nothing that an earlier run has searched; where on a paw its point
        lies stays as clicked at the start, too. With it, method ``pawnb`` learns both from
        every position that was put in place by hand and searches the recording anew; what
        was learnt so stays when it is tracked again later.
    out : str or Path, optional
        Folder with the results of the earlier run; default ``results`` beside the trial.
    progress, stop
        As for :func:`track`.

    Returns
    -------
    xarray.Dataset
        Tracks of the same frames.

    Raises
    ------
    InputError
        If the frame is not among those of the tracks.

    Examples
    --------
    >>> frame = int(tracks["frame"][30])
    >>> again = pawnb.retrack(trial, tracks, frame)
    >>> again.sizes["time"] == tracks.sizes["time"]
    True
    """
    retrack_trial = _RETRACK[trial_tracker(trial).kind]
    return retrack_trial(trial, tracks, frame, learn=learn, out=out, progress=progress, stop=stop)


def _retrack_points(
    trial: Trial,
    tracks: Tracks,
    frame: int,
    *,
    learn: bool,
    out: str | Path | None,
    progress: Progress | None,
    stop: Callable[[], bool] | None,
) -> Tracks:
    """Track the points of a trial of kind ``paws`` again; arguments as of :func:`retrack`."""
    known = tracks["frame"].to_numpy()
    if frame not in known:
        raise InputError(
            f"frame {frame} is not among the tracked frames {known[0]} to {known[-1]}."
        )
    tracker, settings = method_of_tracks(trial, tracks)
    if isinstance(settings, OfflineSettings) and "evidence" in tracks.attrs:
        # what found these tracks finds them again
        settings = dataclasses.replace(settings, evidence=tracks.attrs["evidence"])
    placed = corrected_points(tracks, frame)
    learnt = _frames_learnt_in(tracks) | (dict.fromkeys(placed, frame) if learn else {})
    own = stage_parameters_of_tracks(trial, tracks)
    clicks = clicks_of_frame(trial, tracks, frame)
    begin = int(frame)
    old: Tracks | None = tracks
    given: dict[str, Any] = {}
    with contextlib.ExitStack() as stack:
        stack.enter_context(parameters_set(own))
        report = stack.enter_context(_progress(progress, "tracking again", tracker))
        views = stack.enter_context(open_views(trial))
        rig = trial_rig(trial, views, method=tracker.name)
        looked = clicks_learnt_from(tracks)
        if tracker.is_offline and looked is not None:
            clicks = clicks_by_hand(trial, tracks)
            begin, old = int(known[0]), None
            if tracks.attrs.get("evidence") == LEARNT:
                given = _learnt_again(trial, tracks, frame, placed) | {"annotations": looked}
            elif not learn:
                folder = results_folder(trial, out)
                if folder.is_dir():  # a run there would write the same candidates
                    stack.enter_context(run_alone(folder))
                store = reopen_store(trial, folder)
                stack.callback(keep_store, store)
                given = {"annotations": looked, "kept": KeptEvidence(store)}
        span = (begin, int(known[-1]) + 1)
        predictions = {}
        if tracker.is_offline:
            predictions = _predictions(trial, views, clicks, span)
        task = paw_task(
            trial, rig, clicks, frames=span, tracks=old, predictions=predictions, progress=report,
            stop=stop,
        )  # fmt: skip
        corrected = Correction(learnt, **given)
        new = tracker.retrack(views, clicks, task, settings=settings, corrected=corrected)
        sizes = _sizes(views)
        tolerance = {
            name: TOLERANCE_PX * reader.width / REFERENCE_WIDTH_PX
            for name, reader in views.readers.items()
        }
    new = in_real_units(new, trial, units="px")
    joint = old is None
    if joint and new.sizes["time"] < known[-1] + 1 - known[0]:
        return tracks  # stopped: a part of the recording does not decide over the whole
    new = new.isel(time=np.isin(new["frame"], known))
    new = keep_untouched(tracks, new, frame, tolerance_px=tolerance, joint=joint)
    if not tracker.is_offline:
        new = _shown_in_every_view(new, rig, sizes)
    new = keep_likeness(tracks, new.assign_attrs(tracks.attrs))
    new = describe_trial(new.assign_coords(time=tracks["time"]), trial)
    step = build_step(
        "retrack",
        command=None,
        inputs=trial_checksums(trial, start=False),
        settings=dataclasses.asdict(settings) | by_dotted_name(own),
        frame=int(frame),
        points=placed,
        learn=learn,
        start=clicks.to_dict(orient="records"),
    )
    return add_provenance(new, **step)


def _learnt_again(
    trial: Trial, tracks: Tracks, frame: int, placed: Sequence[str]
) -> dict[str, Any]:
    """Return what is kept for tracks by learnt evidence, and in which frames they are made anew."""
    stacks = session_stacks(describe_source(trial))
    given: dict[str, Any] = {"kept": KeptEvidence(stacks=stacks)}
    if placed:
        frames = frames_again(tracks, int(frame), placed)
        given["again"] = Again(tracks, frames, weighing_of(tracks))
    return given


def _predictions(
    trial: Trial, views: ViewSet, clicks: pd.DataFrame, frames: tuple[int, int]
) -> dict[str, Predictions]:
    """Return what other programs predict, for the method that has a use for it."""
    own = points_by_view(trial, clicks).values()
    points = list(dict.fromkeys(point for names in own for point in names))
    return read_predictions(trial, views, points=points, frames=frames)


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
        warnings.warn(
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
    warnings.warn(
        f"interrupted: frames {frames[0]} to {frames[-1]} of {first} to {last - 1} are "
        f"tracked{again}.",
        InputWarning,
        stacklevel=4,
    )


def corrected_points(tracks: Tracks, frame: int) -> list[str]:
    """Return the points that were put in place by hand in a frame, in any view."""
    here = tracks.isel(time=tracks["frame"].to_numpy() == frame)
    placed = (here["image_origin"] == ORIGIN_CODE["edited"]).any(("time", "view", "individual"))
    return [str(point) for point in here["keypoint"].to_numpy()[placed.to_numpy()]]


def _frames_learnt_in(tracks: Tracks) -> dict[str, int]:
    """Return the frame in which colours of points were last learnt anew."""
    steps = [step for step in provenance_steps(tracks) if step["step"] == "retrack"]
    return {point: step["frame"] for step in steps if step.get("learn") for point in step["points"]}


def _sizes(views: ViewSet) -> dict[str, tuple[int, int]]:
    """Return width and height of each view's picture, px."""
    return {name: (r.width, r.height) for name, r in views.readers.items()}


def _shown_in_every_view(
    tracks: Tracks, rig: Rig | None, sizes: Mapping[str, tuple[int, int]]
) -> Tracks:
    """Show points also in the views that do not track them (2019 paper, Fig. 8)."""
    return tracks if rig is None else fill_reprojected(tracks, rig, sizes=sizes)[0]


def _progress(progress: Progress | None, label: str, tracker: AnyTracker) -> Any:
    """Return a context that gives the caller's progress, or a bar of our own."""
    then = "deciding" if tracker.is_offline else ""
    kind = tracker.kind if tracker.is_offline else None
    return tracking_progress(progress, label, kind=kind, then=then)


_TRACK: dict[str, Callable[..., Tracks]] = {"paws": _track_points, "pose": track_pose_trial}
_RETRACK: dict[str, Callable[..., Tracks]] = {"paws": _retrack_points, "pose": retrack_pose}
