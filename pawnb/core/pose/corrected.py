"""A pose that a person corrected, in Tracks."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from pawnb.arrays import IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import animal_of, poses_of, tracks_from_poses
from pawnb.core.pose.pose_table import pose_names, pose_table, poses_from_table
from pawnb.core.pose.poses import Poses
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.io.pose import check_pose
from pawnb.schema import ORIGIN_CODE, Tracks

_CORRECTED_DECIMALS = 4
"""As many as a pose file holds: 0.0001 px, 0.0001 degree."""


def pose_values(animal: StickAnimal, pose: Poses) -> dict[str, float]:
    """Return the pose of one frame as numbers by name, the columns of ``pose.csv``.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    pose : Poses
        One frame.

    Returns
    -------
    dict
        x, y, heading, the joints, scale and projected lengths.
    """
    table = pose_table(animal, plain_track(animal, pose)).drop(columns="frame")
    return {
        str(name): round(float(value), _CORRECTED_DECIMALS) for name, value in table.iloc[0].items()
    }


def put_pose(tracks: Tracks, frame: int, values: Mapping[str, float]) -> Tracks:
    """Return Tracks with the pose of one frame replaced by a person's.

    Every point of the frame is then of origin ``edited`` with confidence 1 and without a standard
    deviation. In space, the frame is missing until it is tracked again.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one jointed animal; not modified.
    frame : int
        Frame number.
    values : mapping
        As :func:`pose_values` gives them.

    Returns
    -------
    xarray.Dataset
        New Tracks.

    Raises
    ------
    InputError
        If these are not Tracks of a jointed animal, the frame is not among theirs, or a number
        has a wrong name or is none.
    """
    animal = animal_of(tracks)
    rows = np.flatnonzero(tracks["frame"].to_numpy() == frame)
    if not len(rows):
        known = tracks["frame"].to_numpy()
        raise InputError(f"frame {frame} is not in the tracks ({known[0]} to {known[-1]}).")
    table, names = pd.DataFrame([{"frame": frame, **values}]), pose_names(animal)
    known_columns = {"frame", "x", "y", "heading", "scale", *names.joints, *names.lengths}
    for name in table.columns:
        if name not in known_columns:
            raise InputError(f"pose of frame {frame}: the animal has no {name!r}.")
    check_pose(table, names=names, where=f"pose of frame {frame}")
    _, pose = poses_from_table(table, animal)
    flat = tracks_from_poses(
        animal,
        plain_track(animal, pose, origin="edited"),
        fps=float(tracks.attrs["fps"]),
        view=str(tracks["view"].to_numpy()[0]),
        individual=str(tracks["individual"].to_numpy()[0]),
        px_per_unit=tracks.attrs.get("px_per_unit"),
        unit=str(tracks.attrs["units"]),
    )
    return _with_row(tracks, int(rows[0]), flat)


def _with_row(tracks: Tracks, row: int, flat: Tracks) -> Tracks:
    """Return Tracks with one row of those in the first view; what that view cannot tell is NaN."""
    tracks = tracks.copy(deep=True)
    in_space = tracks.sizes["space"] == 3
    for name, variable in tracks.data_vars.items():
        if "time" not in variable.dims or name == "belt_speed":
            continue
        values, blank = variable.to_numpy(), _blank(str(name))
        if "view" in variable.dims:
            values[row] = blank
            values[row, 0] = flat[name].to_numpy()[0, 0]
        elif name in flat and not (in_space and "keypoint" in variable.dims):
            values[row] = flat[name].to_numpy()[0]
        else:
            values[row] = blank
    return tracks


def _blank(name: str) -> float | int:
    """Return what a variable holds where there is nothing."""
    if name.endswith("origin"):
        return ORIGIN_CODE["missing"]
    return 0.0 if name.endswith("confidence") else np.nan


def posed_frames(tracks: Tracks) -> IntArray:
    """Return the frames whose pose a person corrected."""
    edited = poses_of(tracks).origin == ORIGIN_CODE["edited"]
    return tracks["frame"].to_numpy()[edited.all(axis=1)]
