"""What ``pawnb check`` says of a jointed animal: species, start pose, background, edges."""

from __future__ import annotations

import numpy as np

from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.background import Background, find_background
from pawnb.core.pose.pose_suspects import joints_beyond_range
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.start_proposal.silhouette import find_silhouette
from pawnb.core.video import ViewReader, ViewSet
from pawnb.core.video.doubts.exchanged_films import film_code
from pawnb.errors import InputWarning, PawnbError
from pawnb.input_warnings import hearing_input_warnings
from pawnb.trial import Trial, View
from pawnb.workflow.checking.check_report import CheckReport
from pawnb.workflow.start.propose_pose import trial_animal, trial_background
from pawnb.workflow.start.start_doubts import (
    SECOND_ANIMAL,
    legs_outside,
    say_outside,
    start_doubts,
    tell_backwards,
    tell_other_film,
    tell_size,
)
from pawnb.workflow.tracking.pose.pose_in_space import load_second
from pawnb.workflow.tracking.pose.track_pose import check_in_picture, pose_views, start_pose

_ON_ANIMAL = 0.5
"""Least share of the body's middle line that must lie on the animal."""
_SEVERAL = 3
_MOVES_GREY = 12.0
_MOVES_SHARE = 3e-4
"""Background frames in which this share of the picture varies that much are not empty."""


def check_pose_trial(trial: Trial, views: ViewSet, report: CheckReport) -> None:
    """Add to a report what concerns the pose of a jointed animal.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``pose``.
    views : ViewSet
        Its open views.
    report : CheckReport
        The report.
    """
    try:
        view, second = pose_views(trial)
        species = trial_animal(trial)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    report.found.append(
        f"species {species.name}: {len(species.legs)} legs, {species.n_dof} degrees of freedom"
    )
    if second is not None:
        _check_second(trial, views, second, report)
    elif trial.calibration is None or trial.calibration.px_per_unit is None:
        report.doubts.append("no px_per_unit in [calibration]: positions will be in px")
    reader = views.readers[view.name]
    background = _find_background(trial, views, report)
    try:
        animal, poses, _ = start_pose(trial)
        check_in_picture(poses, reader)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    outside = [int(frame) for frame in poses.frames if not 0 <= frame < views.n_frames]
    if outside:
        report.faults.append(
            f"start pose of frame {outside[0]}; the recording has frames 0 to {views.n_frames - 1}."
        )
        return
    frames = ", ".join(map(str, poses.frames))
    report.found.append(f"start pose: {', '.join(animal.leg_names)} in frame {frames}")
    if (file := trial.start_pose_file()) is not None:
        film = film_code(reader.source)
        report.doubts += tell_other_film(trial.path(file), view=view.name, film=film)
    for row in range(len(poses)):
        _check_joints(trial, animal, poses.take([row]), reader, report)
        if background is not None:
            _check_on_animal(animal, poses.take([row]), reader, background, report)


def _check_second(trial: Trial, views: ViewSet, second: View, report: CheckReport) -> None:
    """Say what the second view gives, and what keeps it from doing so."""
    told: list[InputWarning] = []
    try:
        with hearing_input_warnings(told.append, shown=False):
            load_second(trial, views)
            empty = find_background(views.readers[second.name], second, folder=trial.folder)
    except PawnbError as error:
        report.faults.append(str(error))
        return
    report.doubts += [str(warning) for warning in told]
    report.found.append(f"second view {second.name}: joints in space; background: {empty.source}")


def _find_background(trial: Trial, views: ViewSet, report: CheckReport) -> Background | None:
    """Return the empty scene, and say where it comes from and what is doubtful about it."""
    told: list[InputWarning] = []
    try:
        with hearing_input_warnings(told.append, shown=False):
            background = trial_background(trial, views)
    except PawnbError as error:
        report.faults.append(str(error))
        return None
    report.doubts += [str(warning) for warning in told]
    report.found.append(f"background: {background.source}")
    _check_empty(background, report)
    return background


def _check_empty(background: Background, report: CheckReport) -> None:
    """Doubt background frames in which something moves."""
    moving = float((background.sd > _MOVES_GREY).mean())
    if background.source.startswith("frame") and moving > _MOVES_SHARE:
        report.doubts.append(
            f"something moves in the background, {background.source}: {100 * moving:.1f} % of the "
            "picture varies there; name frames without the animal"
        )


def _check_joints(
    trial: Trial, animal: StickAnimal, pose: Poses, reader: ViewReader, report: CheckReport
) -> None:
    """Doubt an unlikely size, joints beyond their range, and legs off the picture."""
    frame = pose.frames[0]
    report.doubts += tell_size(animal, pose, trial=trial)
    beyond = joints_beyond_range(animal, pose.angles_deg[0])
    if beyond:
        worst = sorted(beyond, key=lambda name: -beyond[name])[:_SEVERAL]
        said = ", ".join(f"{name} by {beyond[name]:.0f} degrees" for name in worst)
        more = f" and {len(beyond) - _SEVERAL} more" if len(beyond) > _SEVERAL else ""
        report.doubts.append(
            f"start pose of frame {frame}: joints beyond their range: {said}{more}"
        )
    names = legs_outside(animal, pose, size=(reader.width, reader.height))
    if names:
        report.doubts.append(say_outside(names, int(frame)))


def _check_on_animal(
    animal: StickAnimal,
    pose: Poses,
    reader: ViewReader,
    background: Background,
    report: CheckReport,
) -> None:
    """Compare the start pose with what differs from the background in its frame."""
    frame = int(pose.frames[0])
    outline = find_silhouette(reader.frame(frame).image(), background)
    if outline is None:
        report.doubts.append(
            f"nothing in frame {frame} of the start pose differs from the background"
        )
        return
    report.doubts += start_doubts(outline, frame)
    report.doubts += tell_backwards(animal, pose, reader=reader, background=background)
    ends = [part.centre[0] + side * part.length / 2 for part in animal.body for side in (-1, 1)]
    along = np.linspace(min(ends), max(ends), 21)[1:-1] * float(pose.scale[0])
    turn = np.radians(float(pose.heading_deg[0]))
    line = pose.xy[0] + along[:, None] * [np.cos(turn), np.sin(turn)]
    at = np.rint(outline.to_grid(line)).astype(int)
    height, width = outline.mask.shape
    inside = (at >= 0).all(axis=1) & (at < [width, height]).all(axis=1)
    on = outline.mask[at[inside, 1], at[inside, 0]].sum() / len(at)
    # of two animals the outline is the larger one's: the pose may well be on the other
    if on < _ON_ANIMAL and outline.others <= SECOND_ANIMAL:
        report.faults.append(
            f"start pose of frame {frame} is off the animal: {100 * on:.0f} % of its body lies on "
            "what differs from the background; put it on the animal."
        )
