"""Roll, pitch and yaw of the body, from landmarks in space (2019 paper, section 5, Fig. 9)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError, did_you_mean
from pawnb.schema import Tracks, check_tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.signals import butterworth_lowpass
from pawnb.trial import Trial

BODY_ANGLE_COLUMNS = ("frame", "time_s", "roll_deg", "pitch_deg", "yaw_deg")


@checked_arguments
def body_angles(
    tracks: Tracks,
    *,
    along: Sequence[str] | None = None,
    across: tuple[str, str] | None = None,
    trial: Trial | None = None,
    forward: Sequence[float] | None = None,
    up: Sequence[float] | None = None,
    cutoff_hz: float | None = None,
) -> pd.DataFrame:
    """Return roll, pitch and yaw of the body in every frame.

    The body axis runs from the first to the last point of ``along``. **Yaw** is its
    heading in the horizontal plane, from forward, positive to the animal's left (counter-
    clockwise from above). **Pitch** is its elevation above that plane, positive nose up.
    **Roll** turns the body about its axis, positive with the animal's left side up; it is
    that of the line from the right to the left point of ``across``. A body that is turned by
    yaw, then pitch, then roll, each about its own new axis, has these three angles.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with positions x, y, z of one animal.
    along : sequence of str, optional
        Two or more points along the body, rear to front; default the trial's
        ``[animal] body``.
    across : tuple of str, optional
        A point at the animal's left and its fellow at the right, such as the ears; default
        the trial's ``[animal] across``. Without it there is no roll.
    trial : Trial, optional
        For ``along``, ``across`` and the directions.
    forward, up : sequence of float, optional
        Directions in calibrated space; default the trial's, else +X and +Z.
    cutoff_hz : float, optional
        Low-pass the points first (zero lag); default not.

    Returns
    -------
    pandas.DataFrame
        ``frame``, ``time_s``, ``roll_deg``, ``pitch_deg``, ``yaw_deg``, in degrees from -180
        to 180 (pitch -90 to 90). An angle is NaN where a point that it needs is missing, and
        roll also where the body points straight up or down.

    Raises
    ------
    InputError
        If the tracks are not in space, a point is unknown or not named, or forward and up
        are parallel.

    Examples
    --------
    A body whose front is 45 degrees to the left.

    >>> body = pawnb.schema.make_tracks([0], ["tail_base", "nose"], fps=250.0, unit="mm")
    >>> body["position"].loc[{"keypoint": "tail_base"}] = 0.0
    >>> body["position"].loc[{"keypoint": "nose", "space": ["x", "y"]}] = 50.0
    >>> body["position"].loc[{"keypoint": "nose", "space": "z"}] = 0.0
    >>> pawnb.gait.body_angles(body, along=["tail_base", "nose"])["yaw_deg"].round(1).tolist()
    [45.0]
    """
    check_tracks(tracks)
    if tracks.sizes["space"] != 3 or tracks.sizes["individual"] != 1:
        raise InputError(
            "body angles need the positions x, y, z of one individual; calibrate the views, and "
            "choose an individual with tracks.isel(individual=[0])."
        )
    names = tuple(along or (trial.animal.body if trial is not None else ()))
    if len(names) < 2:
        raise InputError(
            "body angles need two or more points along the body, rear to front, for instance "
            "along=['tail_base', 'nose'], or body = [...] under [animal] of the trial."
        )
    if across is None and trial is not None and trial.animal.across:
        left, right = trial.animal.across
        across = left, right
    axes = _laboratory(trial, forward, up)
    path = partial(_path, tracks, axes=axes, cutoff_hz=cutoff_hz)
    x, y, z = (path(names[-1]) - path(names[0])).T
    level = np.hypot(x, y)
    roll = np.full(len(x), np.nan)
    if across is not None:
        left, right = across
        roll = _roll(np.stack([x, y, z], axis=-1), path(left) - path(right))
    return pd.DataFrame(
        {
            "frame": tracks["frame"].to_numpy(),
            "time_s": tracks["time"].to_numpy(),
            "roll_deg": np.degrees(roll),
            "pitch_deg": np.degrees(np.arctan2(z, level)),
            "yaw_deg": np.degrees(np.arctan2(y, x)),
        },
        columns=list(BODY_ANGLE_COLUMNS),
    )


def _path(tracks: Tracks, name: str, *, axes: FloatArray, cutoff_hz: float | None) -> FloatArray:
    """Return where a point is in the laboratory's axes, (n, 3): forward, left, up."""
    known = [str(n) for n in tracks["keypoint"].to_numpy()]
    if name not in known:
        raise InputError(
            f"the tracks have no point {name!r}{did_you_mean(name, known)}; they have "
            f"{', '.join(known)}."
        )
    xyz = tracks["position"].sel(keypoint=name).isel(individual=0).to_numpy()
    if cutoff_hz is not None:
        fs_hz = float(tracks.attrs["fps"])
        xyz = butterworth_lowpass(xyz, cutoff_hz=cutoff_hz, fs_hz=fs_hz)
    return np.asarray(xyz @ axes.T)


def _laboratory(
    trial: Trial | None, forward: Sequence[float] | None, up: Sequence[float] | None
) -> FloatArray:
    """Return the laboratory's forward, left and up, level, as the rows of a matrix."""
    calibration = trial.calibration if trial is not None else None
    if forward is None:
        forward = calibration.forward if calibration is not None else (1.0, 0.0, 0.0)
    if up is None:
        up = calibration.up if calibration is not None else (0.0, 0.0, 1.0)
    f, u = np.asarray(forward, dtype=float), np.asarray(up, dtype=float)
    left = np.cross(u, f)
    if not np.linalg.norm(left) > 1e-6 * np.linalg.norm(u) * np.linalg.norm(f):
        raise InputError(
            f"forward is {f.tolist()} and up is {u.tolist()}; expected two directions that are "
            "not parallel."
        )
    u, left = u / np.linalg.norm(u), left / np.linalg.norm(left)
    return np.stack([np.cross(left, u), left, u])


def _roll(axis: FloatArray, across: FloatArray) -> FloatArray:
    """Return the roll, rad, of lines from right to left about body axes, both (n, 3)."""
    level_left = np.stack([-axis[:, 1], axis[:, 0], np.zeros(len(axis))], axis=-1)
    length = np.linalg.norm(level_left, axis=-1, keepdims=True)
    level_left = level_left / np.where(length > 0, length, np.nan)
    above = np.cross(axis, level_left)
    above = above / np.linalg.norm(above, axis=-1, keepdims=True)
    return np.arctan2((across * above).sum(axis=-1), (across * level_left).sum(axis=-1))
