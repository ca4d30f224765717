"""A trial of a jointed animal to Tracks: its species, its start pose, and the tracker's run."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.background import Background
from pawnb.core.pose.pose_table import pose_names, poses_from_table
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.presence import find_animal_frames
from pawnb.core.pose.space.as_tracks import tracks_in_space
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.start_proposal.silhouette import find_silhouette
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.pose.tracker import PoseRequest
from pawnb.core.rig import Rig
from pawnb.core.video import ViewReader, ViewSet
from pawnb.core.video.doubts.exchanged_films import film_code
from pawnb.core.video.doubts.frozen_labels import Freezes, without_frozen
from pawnb.core.video.doubts.repeated import freezes_of_views, tell_freezes
from pawnb.errors import InputError, InputWarning
from pawnb.input_warnings import warn_of_input
from pawnb.io.pose import check_pose, read_pose
from pawnb.schema import Tracks, add_provenance
from pawnb.trial import Trial, View
from pawnb.workflow.provenance.manifest import run_alone
from pawnb.workflow.provenance.results import describe_trial, make_folder, write_track_results
from pawnb.workflow.reviewing.quality import tell_failed
from pawnb.workflow.start.propose_pose import trial_animal, trial_background
from pawnb.workflow.start.start_doubts import (
    legs_outside,
    say_outside,
    start_doubts,
    tell_backwards,
    tell_other_film,
    tell_size,
)
from pawnb.workflow.tracking.methods import (
    space_settings,
    tracker_settings,
    trial_tracker,
)
from pawnb.workflow.tracking.opened_run import OpenedRun, first_run, record_of_run
from pawnb.workflow.tracking.options import TrackOptions
from pawnb.workflow.tracking.pose.left_over import with_left_over
from pawnb.workflow.tracking.pose.pose_in_space import find_in_space, load_second
from pawnb.workflow.tracking.unfinished import open_kept_frames, whole_tracks_stay


def track_pose_trial(trial: Trial, asked: TrackOptions) -> Tracks:
    """Track the pose of a jointed animal through its recording, both ways from the start.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``pose`` with one view, or with two and a DLT calibration: the pose is
        tracked in the first, and the second tells where the joints are in space.
    asked : TrackOptions
        What :func:`pawnb.track` was asked for. Interrupted, a run leaves ``unfinished.bin`` in
        ``out``, with which the same run goes on; its results are those of one run.

    Returns
    -------
    xarray.Dataset
        Tracks from the first to the last frame in which the animal was found.

    Raises
    ------
    InputError
        If anything the trial names is missing or does not fit.
    KeyboardInterrupt
        If a person stopped it before any pose was found.
    """
    tracker, out = trial_tracker(trial, asked.method), asked.out
    chosen = tracker_settings(trial, method=asked.method, settings=asked.settings)
    in_space = space_settings(trial, settings=asked.settings)
    view, _ = pose_views(trial)
    animal, poses, table = start_pose(trial, asked.start)
    with contextlib.ExitStack() as stack:
        run, stop, notes = stack.enter_context(first_run(trial, tracker, asked))
        run.tell_notes()
        views = run.views
        reader, rig = views.readers[view.name], load_second(trial, views)
        span = _frame_range(trial, views, poses, asked.frames)
        check_in_picture(poses, reader)
        background = trial_background(trial, views)
        _tell_doubts(trial, animal, poses, views, background, asked)
        freezes = _tell_freezes(trial, views, span)
        if background.n_frames > 1 and not (tracker.is_offline or asked.frames or trial.frames):
            span = _with_animal(reader, view, span, poses)
        rows, empty = _without_blanks(table), background.source
        step = record_of_run(trial, tracker, asked, frames=span, start=rows, background=empty)
        if out is not None:
            stack.enter_context(run_alone(make_folder(out)))
        kept = stack.enter_context(open_kept_frames(None if out is None else Path(out), step))
        request = PoseRequest(str(view.name), span, animal, background, run.report, stop)
        go = tracker.resume if kept.frames else tracker.track
        track = go(views, poses, request, settings=chosen, kept=kept)
        run.end_progress()
        complete = not stop()
        track = _known_part(track, trial, complete=complete)
        if asked.stop is None and not complete:
            _tell_interrupted(track, span)
        space = None
        if rig is not None:
            space, track = find_in_space(
                trial, views, track, animal=animal, rig=rig, settings=in_space,
                progress=asked.progress, stop=stop, kept=kept,
            )  # fmt: skip
            complete = complete and not stop()
        tracks = pose_tracks(trial, animal, track, space=space, rig=rig)
        tracks = with_left_over(tracks, reader=reader, background=background)
        tracks = _described(without_frozen(tracks, freezes, needs_all=True), trial, run)
        made = {"complete": complete, "estimated": dict(track.estimated), "notes": notes}
        second = {} if space is None else {"second_view": str(trial.views[1].name)}
        tracks = add_provenance(tracks, **step, **made, **second)
        if out is not None and (complete or not whole_tracks_stay(Path(out))):
            write_track_results(tracks, out, warn=True)
        if complete:
            kept.remove()
    tell_failed(tracks, complete=complete)
    return tracks


def _described(tracks: Tracks, trial: Trial, run: OpenedRun) -> Tracks:
    """Return tracks with their times and what a reader needs to know of the trial."""
    # where the rate varies these are the file's own time stamps
    tracks = tracks.assign_coords(time=run.views.time_s[tracks["frame"].to_numpy()])
    return describe_trial(tracks, trial, sizes=run.sizes)


def _without_blanks(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a table, each with the cells that are filled."""
    return [
        {str(name): cell for name, cell in row.items() if not pd.isna(cell)}
        for row in table.to_dict("records")
    ]


def start_pose(
    trial: Trial, start: pd.DataFrame | None = None
) -> tuple[StickAnimal, Poses, pd.DataFrame]:
    """Return the animal with its own proportions, its poses to start from, and their table.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``pose``.
    start : pandas.DataFrame, optional
        Columns of ``start_pose.csv``; default the trial's file.

    Returns
    -------
    animal : StickAnimal
        The animal.
    poses : Poses
        One frame or more.
    table : pandas.DataFrame
        What they were read from.

    Raises
    ------
    InputError
        If there is no start pose, or it cannot be one.
    """
    species = trial_animal(trial)
    names = pose_names(species)
    if start is not None:
        table = check_pose(start, names=names, where="start pose")
    else:
        file = trial.start_pose_file()
        if file is None or not trial.path(file).exists():
            there = "" if file is None else f" ({file}: no such file)"
            raise InputError(
                f"trial {trial.name!r} has no start pose{there}; pose the animal with "
                "pawnb.widgets.StickPoser, or name a csv under [start] pose."
            )
        table = read_pose(trial.path(file), names=names)
    animal, poses = poses_from_table(table, species)
    return animal, poses, table


def pose_views(trial: Trial) -> tuple[View, View | None]:
    """Return the view of a trial of kind ``pose`` in which it is tracked, and the second.

    Parameters
    ----------
    trial : Trial
        The trial.

    Returns
    -------
    first : View
        The view that poses are in.
    second : View or None
        The view that tells where joints are in space, where there is one.

    Raises
    ------
    InputError
        If it has more than two, a second one without calibration, or frames of the first that
        are not counted from the file's first.
    """
    n = len(trial.views)
    if n > 2:
        raise InputError(
            f"trial {trial.name!r} has {n} views; a pose is tracked in one view, and a second one "
            "gives the joints in space: keep one or two."
        )
    if n == 2 and (trial.calibration is None or trial.calibration.of_views is None):
        raise InputError(
            f"trial {trial.name!r} has a second view, {trial.views[1].name!r}, but no calibration "
            'that says how it lies to the first; add [calibration] dlt = "DLTcoefs.csv" '
            "(`pawnb.core.calibration.rig_from_points.fit_rig` makes its columns from known "
            "points), or keep one view."
        )
    view = trial.views[0]
    if view.offset:
        raise InputError(
            f"view {view.name!r}: offset is {view.offset}; a pose is tracked in the first view, "
            "whose frames are counted from the first of its file: leave offset out there."
        )
    return view, trial.views[1] if n == 2 else None


def check_in_picture(poses: Poses, reader: ViewReader) -> None:
    """Refuse a start pose whose body is off the picture.

    Parameters
    ----------
    poses : Poses
        Poses to start from.
    reader : ViewReader
        The view.

    Raises
    ------
    InputError
        For the first pose that is.
    """
    size = np.array([reader.width, reader.height])
    for frame, (x, y) in zip(poses.frames, poses.xy, strict=True):
        if not (-0.5 <= x < size[0] - 0.5 and -0.5 <= y < size[1] - 0.5):
            raise InputError(
                f"start pose: the body of frame {frame} is at x = {x:g}, y = {y:g}, outside the "
                f"picture of {size[0]} x {size[1]} px; put it on the animal."
            )


def _other_film(trial: Trial, reader: ViewReader, asked: TrackOptions) -> list[str]:
    """Say that poses in the trial's file were made in another film, where these are taken."""
    if asked.start is not None or (file := trial.start_pose_file()) is None:
        return []
    film = film_code(reader.source)
    return tell_other_film(trial.path(file), view=trial.views[0].name, film=film)


def _tell_doubts(
    trial: Trial,
    animal: StickAnimal,
    poses: Poses,
    views: ViewSet,
    background: Background,
    asked: TrackOptions,
) -> None:
    """Warn of poses made in another film, and of what looks wrong in each start frame."""
    reader = views.readers[trial.views[0].name]
    doubts = _other_film(trial, reader, asked)
    for i, frame in enumerate(poses.frames.tolist()):
        pose = poses.take([i])
        outline = find_silhouette(reader.frame(frame).image(), background)
        doubts = [*doubts, *tell_size(animal, pose, trial=trial)]
        if outline is not None:
            doubts += start_doubts(outline, frame)
            doubts += tell_backwards(animal, pose, reader=reader, background=background)
        outside = legs_outside(animal, pose, size=(reader.width, reader.height))
        if outside and not (outline is not None and outline.at_edge):  # that is said already
            doubts.append(say_outside(outside, frame))
    for doubt in doubts:
        warn_of_input(f"{doubt}.", InputWarning, stacklevel=4)


def _tell_freezes(trial: Trial, views: ViewSet, span: tuple[int, int]) -> Freezes:
    """Warn of films that stand still, and return where they do."""
    freezes = freezes_of_views(trial, views, start=span[0], stop=span[1])
    for doubt in tell_freezes(views, freezes):
        warn_of_input(f"{doubt}.", InputWarning, stacklevel=4)
    return freezes


def pose_tracks(
    trial: Trial,
    animal: StickAnimal,
    track: PoseTrack,
    *,
    space: SpaceTrack | None = None,
    rig: Rig | None = None,
) -> Tracks:
    """Return what was found as Tracks: in space where there is a second view.

    Parameters
    ----------
    trial : Trial
        The trial.
    animal : StickAnimal
        Its animal.
    track : PoseTrack
        Poses in the first view.
    space : SpaceTrack, optional
        Joints in space, row for row.
    rig : Rig, optional
        The calibrated views, where there are two.

    Returns
    -------
    xarray.Dataset
        Tracks.
    """
    who, calibration = trial.animal.id, trial.calibration
    if space is not None and rig is not None:
        names = (trial.views[0].name, trial.views[1].name)
        return tracks_in_space(
            animal, track, space, rig=rig, fps=trial.fps, views=names, individual=who
        )
    return tracks_from_poses(
        animal,
        track,
        fps=trial.fps,
        view=trial.views[0].name,
        individual=who,
        px_per_unit=None if calibration is None else calibration.px_per_unit,
        unit="px" if calibration is None else calibration.unit,
    )


def _frame_range(
    trial: Trial, views: ViewSet, poses: Poses, frames: tuple[int, int] | None
) -> tuple[int, int]:
    """Return the half-open range of frames to track, checked against recording and start."""
    first, last = frames or trial.frames or (0, views.n_frames)
    if not 0 <= first < last <= views.n_frames:
        raise InputError(
            f"frames {first} to {last - 1} were asked for; the recording has frames 0 to "
            f"{views.n_frames - 1}: choose a range within."
        )
    if not ((poses.frames >= first) & (poses.frames < last)).any():
        posed = ", ".join(map(str, poses.frames))
        raise InputError(
            f"the start pose is of frame {posed}, outside frames {first} to {last - 1}; pose the "
            "animal in a frame within, or change the range."
        )
    return first, last


def _with_animal(
    reader: ViewReader, view: View, span: tuple[int, int], poses: Poses
) -> tuple[int, int]:
    """Return the frames that show the animal (Pullar 2009, §3.1), if the start is among them.

    The method of the thesis follows what it is given; it does not know an animal that is gone.
    """
    shown = find_animal_frames(reader, frames=span, known=view.background_frames)
    if shown.first is None or shown.last is None:
        return span
    inside = (poses.frames >= shown.first) & (poses.frames <= shown.last)
    return (shown.first, shown.last + 1) if inside.any() else span


def _known_part(track: PoseTrack, trial: Trial, *, complete: bool) -> PoseTrack:
    """Return the track from the first to the last frame in which there is a pose."""
    if not complete and not np.isfinite(track.poses.xy).any():
        raise KeyboardInterrupt
    known = np.flatnonzero(np.isfinite(track.poses.xy).all(axis=1))
    if not len(known):
        raise InputError(
            f"trial {trial.name!r}: the animal was found in no frame; look at the start pose and "
            "the background."
        )
    return track.take(slice(int(known[0]), int(known[-1]) + 1))


def _tell_interrupted(track: PoseTrack, span: tuple[int, int]) -> None:
    """Warn that a person stopped the run."""
    frames = track.poses.frames
    warn_of_input(
        f"interrupted: frames {frames[0]} to {frames[-1]} of {span[0]} to {span[1] - 1} are "
        "tracked.",
        InputWarning,
        stacklevel=3,
    )
