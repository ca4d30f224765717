"""What is known of the views of a trial: their rig, their points, where the animal faces."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

import pandas as pd

from pawnb.core.paws.request import TrackingRequest
from pawnb.core.paws.tracker import DEFAULT, find_tracker
from pawnb.core.reproject import fill_reprojected
from pawnb.core.rig import Rig, load_rig
from pawnb.core.video import ViewSet
from pawnb.errors import CalibrationError, InputError
from pawnb.schema import Tracks
from pawnb.trial import Trial


def trial_rig(trial: Trial, views: ViewSet, *, method: str = DEFAULT) -> Rig | None:
    """Return the calibrated views of a trial, or None where nothing is calibrated.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views, for the sizes of their pictures.
    method : str
        The method of the tracker. ``pawnb`` and ``slic-2d`` need no calibration of several
        views: they track each by itself.

    Returns
    -------
    Rig or None
        None where there are no DLT coefficients.

    Raises
    ------
    CalibrationError
        If several views are to be tracked together without a calibration.
    """
    sizes = {name: (r.source.width, r.source.height) for name, r in views.readers.items()}
    rig = load_rig(trial, sizes=sizes)
    if rig is None and len(trial.views) > 1 and find_tracker("paws", method).needs_calibration:
        raise CalibrationError(
            f"trial {trial.name!r} has {len(trial.views)} views and no calibration; "
            'add [calibration] dlt = "DLTcoefs.csv" (11 rows, one column a view), '
            "keep a single view, or track each view by itself with method pawnb or slic-2d."
        )
    return rig


def points_by_view(trial: Trial, clicks: pd.DataFrame) -> dict[str, tuple[str, ...]]:
    """Return the points each view tracks: those it names, else every clicked point."""
    every = tuple(dict.fromkeys(clicks["point"]))
    return {view.name: view.points or every for view in trial.views}


def view_facing(trial: Trial, rig: Rig | None) -> dict[str, int]:
    """Return +1 or -1 for each view in which the animal's direction is known."""
    facing = {view.name: view.facing for view in trial.views if view.facing is not None}
    if rig is not None:
        for name in rig.names:
            # a camera that looks along the animal's path sees it face neither way
            with contextlib.suppress(CalibrationError):
                facing.setdefault(name, rig.facing(name))
    return facing


def frame_range(
    trial: Trial,
    views: ViewSet,
    clicks: pd.DataFrame,
    *,
    method: str = DEFAULT,
    frames: tuple[int, int] | None = None,
) -> tuple[int, int]:
    """Return the half-open range of frames to track.

    Parameters
    ----------
    trial : Trial
        The trial.
    views : ViewSet
        Its open views.
    clicks : pandas.DataFrame
        Its start clicks.
    method : str
        The method of the tracker. ``pawnb`` tracks all frames, the others those from the first
        click on.
    frames : tuple of int, optional
        What was asked for; default the trial's, else the whole recording.

    Returns
    -------
    tuple of int
        The first frame to track, and one past the last.

    Raises
    ------
    InputError
        If the recording has not all of these frames, or a click lies outside.
    """
    clicked = int(clicks["frame"].min())
    first, last = frames or trial.frames or (views.first_frame, views.n_frames)
    if not 0 <= first < last <= views.n_frames:
        raise InputError(
            f"frames {first} to {last - 1} were asked for; the recording has frames 0 to "
            f"{views.n_frames - 1}: choose a range within."
        )
    for frame in (clicked, int(clicks["frame"].max())):
        if not first <= frame < last:
            raise InputError(
                f"the start points were clicked in frame {frame}, outside frames {first} to "
                f"{last - 1}; click a frame within, or change the range."
            )
    # a view may begin later than the trial
    whole = find_tracker("paws", method).is_offline
    return max(first, views.first_frame) if whole else clicked, last


def paw_task(trial: Trial, rig: Rig | None, clicks: pd.DataFrame, **asked: Any) -> TrackingRequest:
    """Return what a tracker is to do, with all that the trial says about it.

    Parameters
    ----------
    trial : Trial
        The trial.
    rig : Rig or None
        Its calibrated views.
    clicks : pandas.DataFrame
        Start clicks.
    **asked
        Further fields of :class:`~pawnb.core.paws.request.TrackingRequest`.

    Returns
    -------
    TrackingRequest
        The task.
    """
    return TrackingRequest(
        rig=rig,
        points_by_view=points_by_view(trial, clicks),
        facing=view_facing(trial, rig),
        fps=trial.fps,
        individual=trial.animal.id,
        unit=rig.unit if rig is not None else "px",
        **asked,
    )


def shown_in_every_view(
    tracks: Tracks, rig: Rig | None, sizes: Mapping[str, tuple[int, int]]
) -> Tracks:
    """Show points also in the views that do not track them (2019 paper, Fig. 8).

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    rig : Rig or None
        The calibrated views; without, the tracks stay as they are.
    sizes : mapping
        View to width and height of its picture, px.

    Returns
    -------
    xarray.Dataset
        Tracks of every view.
    """
    return tracks if rig is None else fill_reprojected(tracks, rig, sizes=sizes)[0]
