"""Tracking poses again about a frame in which a person corrected the pose."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import animal_of, poses_of
from pawnb.core.pose.corrected import posed_frames
from pawnb.core.pose.poses import Poses, joint_positions
from pawnb.core.pose.track_result import PoseTrack, join_tracks
from pawnb.core.pose.tracker import PoseRequest
from pawnb.core.video import ViewSet
from pawnb.core.video.doubts.frozen_labels import without_frozen
from pawnb.core.video.doubts.repeated import freezes_of_views
from pawnb.errors import InputError
from pawnb.schema import Tracks, add_provenance
from pawnb.trial import Trial
from pawnb.workflow.progress import Progress
from pawnb.workflow.provenance.record import build_step, trial_checksums
from pawnb.workflow.provenance.results import describe_trial, provenance_steps
from pawnb.workflow.start.propose_pose import trial_background
from pawnb.workflow.tracking.methods import (
    by_dotted_name,
    method_of_tracks,
    space_settings_of_tracks,
    stage_parameters_of_tracks,
)
from pawnb.workflow.tracking.opened_run import opened_run
from pawnb.workflow.tracking.options import RetrackOptions
from pawnb.workflow.tracking.pose.left_over import with_left_over
from pawnb.workflow.tracking.pose.pose_in_space import find_in_space, load_second
from pawnb.workflow.tracking.pose.track_pose import pose_tracks, pose_views

_MET_FRAMES = 10
"""The new track has met the old one after so many frames in a row on it, as for paws."""
_MET_SHARE = 0.02
"""Joints and body within this share of the leg span are the same: twice what a tip may be off."""
_FRAMES_BESIDE = 10
"""Joints in space are found in so many frames more on either side of what is new, so that heights
join those beside: a frame's heights are fitted with those of two frames on either side."""
_FIRST_REACH = 100
"""Frames on either side that are tracked again at first; twice as many while they do not meet."""


def retrack_pose(trial: Trial, tracks: Tracks, frame: int, *, asked: RetrackOptions) -> Tracks:
    """Track poses again both ways from a frame, with its pose as certain.

    The stretch that is tracked again reaches, on either side, to where the new track has met the
    old one (every joint within 2 % of the leg span, 10 frames in a row), but no further than the
    next frame that a person posed: at the start or in a correction. Poses outside the stretch
    stay as they are, and so does the pose of ``frame``. The animal's look is learnt where the
    first run learnt it.

    Parameters
    ----------
    trial : Trial
        The trial of these tracks.
    tracks : xarray.Dataset
        Tracks with the corrections already applied.
    frame : int
        The corrected frame.
    asked : RetrackOptions
        What :func:`pawnb.retrack` was asked for. The look is learnt anew, and nothing is kept, in
        any case. Stopped, the tracks are returned as they were.

    Returns
    -------
    xarray.Dataset
        Tracks of the same frames.

    Raises
    ------
    InputError
        If the frame is not among those of the tracks, or the animal has no pose there.
    """
    animal, old = animal_of(tracks), poses_of(tracks)
    frames, here = old.poses.frames, _row_of(frame, old.poses)
    tracker, settings = method_of_tracks(trial, tracks)
    own = stage_parameters_of_tracks(trial, tracks)
    limits, certain = _certain(tracks, old, here)
    stop = asked.stop
    with opened_run(
        trial, tracker, parameters=own, progress=asked.progress, label="tracking again"
    ) as run:
        view, _ = pose_views(trial)
        background = trial_background(trial, run.views)

        def track_part(part: range) -> PoseTrack:
            rows = [row for row in certain if row in part]
            span = int(frames[part[0]]), int(frames[part[-1]]) + 1
            request = PoseRequest(str(view.name), span, animal, background, run.report, stop)
            found: PoseTrack = tracker.retrack(
                run.views, old.poses.take(sorted(rows)), request, settings=settings,
                corrected=old.poses.take([certain[0]]),
            )  # fmt: skip
            return found

        again = _Again(animal, old, here, limits, certain)
        touched, new = again.run(track_part)
        if stop is not None and stop():
            return tracks
        joined = join_tracks(
            [old.take(slice(0, touched.start)), new, old.take(slice(touched.stop, None))]
        )
        made = _whole(
            trial, tracks, run.views, animal=animal, track=joined, rows=touched,
            progress=asked.progress, stop=stop,
        )  # fmt: skip
        if stop is not None and stop():
            return tracks
        reader = run.views.readers[view.name]
        part = range(int(frames[touched[0]]), int(frames[touched[-1]]) + 1)
        made = with_left_over(made, reader=reader, background=background, again=part)
        made = _without_frozen(made, trial, run.views)
    step = build_step(
        "retrack",
        command=None,
        inputs=trial_checksums(trial, start=False),
        settings=dataclasses.asdict(settings) | by_dotted_name(own),
        method=tracker.name,
        frame=int(frame),
        frames=[part.start, part.stop],
        background=background.source,
    )
    return add_provenance(made, **step)


def _without_frozen(tracks: Tracks, trial: Trial, views: ViewSet) -> Tracks:
    """Return tracks of which nothing is measured where the film stands still."""
    first, last = (int(tracks["frame"].to_numpy()[end]) for end in (0, -1))
    freezes = freezes_of_views(trial, views, start=first, stop=last + 1)
    return without_frozen(tracks, freezes, needs_all=True)


def _row_of(frame: int, poses: Poses) -> int:
    """Return the row of a corrected frame, which must have a pose."""
    frames = poses.frames
    here = int(np.searchsorted(frames, frame))
    if here == len(frames) or frames[here] != frame:
        raise InputError(
            f"frame {frame} is not among the tracked frames {frames[0]} to {frames[-1]}."
        )
    if not np.isfinite(poses.xy[here]).all():
        raise InputError(f"the animal has no pose in frame {frame}; pose it there first.")
    return here


def _certain(tracks: Tracks, old: PoseTrack, here: int) -> tuple[range, list[int]]:
    """Return how far tracking may reach, and the rows with poses by hand, the first start first.

    The reach is a range of rows that begins and ends at the nearest such rows, where there are.
    """
    frames = old.poses.frames
    made = [step for step in provenance_steps(tracks) if step["step"] == "track"]
    started = [row["frame"] for step in made[-1:] for row in step.get("start", [])]
    posed = np.isin(frames, [*started, *posed_frames(tracks)]) & np.isfinite(old.poses.xy[:, 0])
    first = [row for row in np.flatnonzero(np.isin(frames, started[:1])).tolist() if posed[row]]
    rows = [row for row in np.flatnonzero(posed).tolist() if row not in first]
    before = max((row for row in [*first, *rows] if row < here), default=0)
    after = min((row for row in [*first, *rows] if row > here), default=len(frames) - 1)
    certain = [*first, *rows] if here in [*first, *rows] else [*first, *rows, here]
    return range(before, after + 1), certain


@dataclass(frozen=True)
class _Again:
    """Tracks about a row, further and further, until the new track has met the old one."""

    animal: StickAnimal
    old: PoseTrack
    here: int
    limits: range
    certain: list[int]

    def run(self, track_part: Callable[[range], PoseTrack]) -> tuple[range, PoseTrack]:
        """Return the rows that are new, and their poses."""
        reach = _FIRST_REACH
        while True:
            first, last = self.limits[0], self.limits[-1]
            part = range(max(first, self.here - reach), min(last, self.here + reach) + 1)
            new = self._turned(track_part(part), part)
            same = self._same(new, part)
            up = _until_met(same[self.here - part[0] + 1 :])
            down = _until_met(same[: self.here - part[0]][::-1])
            is_whole = part == self.limits
            if is_whole or (up is not None and down is not None):
                break
            reach *= 2
        begin = part[0] if down is None else self.here - down
        end = part[-1] if up is None else self.here + up
        # the posed rows that bound the stretch stay
        begin += begin in self.certain and begin != self.here
        end -= end in self.certain and end != self.here
        touched = range(begin, end + 1)
        return touched, self._keep(new.take(slice(begin - part[0], end + 1 - part[0])), touched)

    def _turned(self, new: PoseTrack, part: range) -> PoseTrack:
        """Return the new poses with headings counted as the old ones are: no turn more or less."""
        heading = new.poses.heading_deg
        away = heading[self.here - part[0]] - self.old.poses.heading_deg[self.here]
        poses = dataclasses.replace(new.poses, heading_deg=heading - 360.0 * np.round(away / 360.0))
        return dataclasses.replace(new, poses=poses)

    def _same(self, new: PoseTrack, part: range) -> np.ndarray:
        """Return in which rows of a part the new poses are the old ones."""
        old = self.old.take(slice(part[0], part[-1] + 1)).poses
        off = joint_positions(self.animal, new.poses) - joint_positions(self.animal, old)
        far = np.nan_to_num(np.hypot(*np.moveaxis(off, -1, 0)), nan=0.0).max(axis=(1, 2))
        limit = _MET_SHARE * self.animal.span * float(np.nanmedian(self.old.poses.scale))
        lost = [~np.isfinite(p.xy[:, 0]) for p in (old, new.poses)]
        return np.where(lost[0] | lost[1], lost[0] & lost[1], far <= limit)

    def _keep(self, new: PoseTrack, touched: range) -> PoseTrack:
        """Return the new rows with the pose that a person gave put back."""
        at = self.here - touched[0]
        mine = self.old.take(slice(self.here, self.here + 1))
        return join_tracks([new.take(slice(0, at)), mine, new.take(slice(at + 1, None))])


def _until_met(same: np.ndarray) -> int | None:
    """Return after how many rows the new track is on the old one for good, or None."""
    run = 0
    for k, is_same in enumerate(same):
        run = run + 1 if is_same else 0
        if run == _MET_FRAMES:
            return k + 1 - _MET_FRAMES
    return None


def _whole(
    trial: Trial,
    tracks: Tracks,
    views: ViewSet,
    *,
    animal: StickAnimal,
    track: PoseTrack,
    rows: range,
    progress: Progress | None,
    stop: Callable[[], bool] | None,
) -> Tracks:
    """Return Tracks of all rows, of which only ``rows`` are new."""
    rig, space = load_second(trial, views), None
    if rig is not None:
        about = range(
            max(0, rows.start - _FRAMES_BESIDE), min(len(track), rows.stop + _FRAMES_BESIDE)
        )
        space, track = find_in_space(
            trial, views, track, animal=animal, rig=rig,
            settings=space_settings_of_tracks(trial, tracks),
            rows=about, progress=progress, stop=stop,
        )  # fmt: skip
    new = pose_tracks(trial, animal, track, space=space, rig=rig).assign_coords(time=tracks["time"])
    new = describe_trial(new.assign_attrs(tracks.attrs), trial)
    for name, variable in new.data_vars.items():
        if "time" in variable.dims and name in tracks:
            values = tracks[name].transpose(*variable.dims).to_numpy().copy()
            values[rows.start : rows.stop] = variable.to_numpy()[rows.start : rows.stop]
            new[name] = variable.copy(data=values)
    return new
