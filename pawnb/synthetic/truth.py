"""What is exactly known of a rendered recording, as tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.schema import EVENTS_COLUMNS, POINTS3D_COLUMNS, START_COLUMNS, TRACKS_COLUMNS
from pawnb.synthetic.camera import PinholeCamera
from pawnb.synthetic.gait_model import Gait
from pawnb.synthetic.mouse import LANDMARKS, Mouse
from pawnb.synthetic.scene import LEGS, SceneSettings

VISIBLE_FROM = 0.3
"""A paw counts as visible where more than this share of it is seen."""


def paw_positions(gait: Gait, settings: SceneSettings, time_s: FloatArray) -> FloatArray:
    """Return the tracked points (t, legs, 3) in calibrated X, Y, Z (mm), in the order of LEGS.

    Parameters
    ----------
    gait : Gait
        How the mouse runs.
    settings : SceneSettings
        The scene.
    time_s : ndarray, shape (t,)
        Times, s.

    Returns
    -------
    ndarray, shape (t, legs, 3)
        Positions, mm.
    """
    facing = np.array([settings.direction, settings.direction, 1.0])
    return np.stack([gait.legs[leg].position(time_s) for leg in LEGS], axis=1) * facing


def points3d_truth(positions: np.ndarray) -> pd.DataFrame:
    """Return the columns of points3d.csv for positions (frames, legs, 3)."""
    n = len(positions)
    x, y, z = positions.reshape(-1, 3).T
    return pd.DataFrame(
        {
            "frame": np.repeat(np.arange(n), len(LEGS)),
            "point": np.tile(LEGS, n),
            "x": x,
            "y": y,
            "z": z,
            "residual_px": 0.0,
            "origin": "measured",
        },
        columns=list(POINTS3D_COLUMNS),
    )


def landmarks_truth(mouse: Mouse, time_s: np.ndarray) -> pd.DataFrame:
    """Return frame, point, x, y, z (mm) of nose, ears and tail at times (t,)."""
    xyz = np.stack([mouse.landmarks(float(t)) for t in time_s])
    frames = np.repeat(np.arange(len(time_s)), len(LANDMARKS))
    table = pd.DataFrame(xyz.reshape(-1, 3), columns=["x", "y", "z"])
    table.insert(0, "frame", frames)
    table.insert(1, "point", np.tile(LANDMARKS, len(time_s)))
    return table


def tracks_truth(
    positions: np.ndarray, fractions: np.ndarray, cameras: Sequence[PinholeCamera]
) -> pd.DataFrame:
    """Return the columns of tracks.csv, then visible (0/1) and visible_fraction.

    Parameters
    ----------
    positions : ndarray (frames, legs, 3)
        Tracked points, mm.
    fractions : ndarray (frames, views, legs)
        Share of each paw that is seen.
    cameras : sequence of PinholeCamera
        The views; every paw has a row in every view, also in those that do not track it.

    Returns
    -------
    DataFrame
        ``origin`` is "measured" where the paw is visible, else "reprojected": its place is
        known from space, not from this picture.
    """
    n = len(positions)
    parts = []
    for number, camera in enumerate(cameras):
        uv, _ = camera.project(positions)
        share = fractions[:, number].ravel()
        visible = share > VISIBLE_FROM
        part = pd.DataFrame(
            {
                "frame": np.repeat(np.arange(n), len(LEGS)),
                "view": camera.name,
                "point": np.tile(LEGS, n),
                "u": uv[..., 0].ravel(),
                "v": uv[..., 1].ravel(),
                "confidence": 1.0,
                "origin": np.where(visible, "measured", "reprojected"),
                "visible": visible.astype(int),
                "visible_fraction": share,
            },
            columns=[*TRACKS_COLUMNS, "visible", "visible_fraction"],
        )
        parts.append(part)
    table = pd.concat(parts, ignore_index=True)
    return table.sort_values("frame", kind="stable", ignore_index=True)


def events_truth(
    gait: Gait, settings: SceneSettings, *, begin_s: float, frames: int, animal: str, trial: str
) -> pd.DataFrame:
    """Return the columns of events.csv, then x, y, z of the paw at the event.

    TD and LO are the instants at which the paw begins and ends to move with the belt. AEP
    and PEP are the turning points of the paw along forward in the laboratory, which is
    what a treadmill study sees: AEP just before TD, PEP just after LO. Frames are
    fractional; only events from the first frame to the last are listed.

    Parameters
    ----------
    gait : Gait
        How the mouse runs.
    settings : SceneSettings
        The scene.
    begin_s : float
        Time of the first frame, s.
    frames : int
        How many frames there are.
    animal, trial : str
        Names for the table.

    Returns
    -------
    pandas.DataFrame
        One row an event; positions in mm.
    """
    facing = np.array([settings.direction, settings.direction, 1.0])
    rows = []
    for leg in LEGS:
        motion = gait.legs[leg]
        pep, aep = motion.extremes()
        for event, times in (
            ("AEP", aep), ("TD", motion.touch_down_s), ("LO", motion.lift_off_s), ("PEP", pep),
        ):  # fmt: skip
            frame = (times - begin_s) * settings.fps
            for at, when in zip(frame, times, strict=True):
                if 0.0 <= at <= frames - 1:
                    place = motion.position(np.array([when]))[0] * facing
                    rows.append((animal, trial, leg, event, at, at / settings.fps, "truth", *place))
    table = pd.DataFrame(rows, columns=[*EVENTS_COLUMNS, "x", "y", "z"])
    order = table["leg"].map(LEGS.index)
    table = table.assign(_leg=order).sort_values(["_leg", "frame"], kind="stable")
    return table.drop(columns="_leg").reset_index(drop=True)


def start_clicks(tracks: pd.DataFrame, points_by_view: dict[str, tuple[str, ...]]) -> pd.DataFrame:
    """Return start.csv: the visible paws of frame 0 where they are tracked, in whole px.

    A person clicks whole pixels, so the truth is rounded.
    """
    first = tracks[(tracks["frame"] == 0) & (tracks["visible"] == 1)]
    tracked = [
        point in points_by_view[view]
        for view, point in zip(first["view"], first["point"], strict=True)
    ]
    clicks = first.loc[tracked, list(START_COLUMNS)].reset_index(drop=True)
    return clicks.assign(u=clicks["u"].round(), v=clicks["v"].round())
