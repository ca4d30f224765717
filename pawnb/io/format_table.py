"""The table of formats: how each is read, how it is written, and what a file of it holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pawnb.errors import InputError, did_you_mean
from pawnb.io import argus, native
from pawnb.io.anipose import read_anipose, write_anipose
from pawnb.io.authors2019 import read_authors_trial, trial_stamp
from pawnb.io.authors2019_out import write_authors_trial
from pawnb.io.c3d_file import read_c3d, write_c3d
from pawnb.io.deeplabcut import read_collected, read_deeplabcut
from pawnb.io.deeplabcut_out import write_collected, write_deeplabcut, write_lightning_pose
from pawnb.io.dltdv import read_dltdv_points, read_dltdv_points3d
from pawnb.io.dltdv_out import write_dltdv_points, write_dltdv_points3d
from pawnb.io.imagej import read_manual_tracking, read_mtrackj
from pawnb.io.kinovea import read_kinovea
from pawnb.io.locomouse import read_locomouse
from pawnb.io.locomouse_out import write_locomouse
from pawnb.io.motion_capture import read_qtm, read_trc, read_vicon
from pawnb.io.movement import write_movement
from pawnb.io.nwb import read_nwb, write_nwb
from pawnb.io.osp_tracker import read_osp_tracker
from pawnb.io.sleap import read_sleap
from pawnb.io.sleap_out import write_sleap
from pawnb.io.tables import write_table
from pawnb.io.track_tables import read_points3d_table, read_tracks_table
from pawnb.io.trackmate import read_trackmate
from pawnb.io.wide import read_wide_table, write_wide_table
from pawnb.io.xmalab_out import write_xmalab_points, write_xmalab_points3d
from pawnb.schema import Tracks


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format of tracks.

    Parameters
    ----------
    name : str
        What ``--from`` and ``--to`` call it.
    title : str
        What people call it.
    endings : tuple of str
        How names of its files end.
    read : callable
        ``read(path, fps=)`` gives Tracks.
    reads_with : tuple of str
        What else reading may be told: ``unit``, ``heights_px``.
    write : callable, optional
        ``write(tracks, path)`` gives the file, or a list of all that it wrote; None where the
        format is only read.
    writes_with : tuple of str
        What else writing may be told: ``view``, ``heights_px``.
    holds : {"view", "views", "space", "view or space", "all"}
        What a file holds: points of one view (several views make several files), of all views,
        in space, either, or everything.
    says_fps : bool
        Whether a file says its frame rate.
    names : tuple of str
        Words in a name by which people know the format: such a name gets no other one.
    extra : str
        Extra of the package that a part of it needs.
    """

    name: str
    title: str
    endings: tuple[str, ...]
    read: Callable[..., Tracks]
    reads_with: tuple[str, ...] = ()
    write: Callable[..., Any] | None = None
    writes_with: tuple[str, ...] = ()
    holds: str = "view"
    says_fps: bool = False
    names: tuple[str, ...] = ()
    extra: str = ""


def _read_authors(path: Path, *, fps: float) -> Tracks:
    """Read the trial of the 2019 authors that a file belongs to."""
    stamp = trial_stamp(path.name)
    if stamp is None:
        raise InputError(
            f"{path.name}: not named as the 2019 authors do (cam1.f.<animal>.<condition>.<stamp>"
            ".csv); without its name the other three files of the trial cannot be found."
        )
    return read_authors_trial(path.parent, stamp, fps=fps)


def _write_views(tracks: Tracks, path: Path) -> Path:
    """Write ``tracks.csv``."""
    return write_table(native.tracks_table(tracks), path)


def _write_space(tracks: Tracks, path: Path) -> Path:
    """Write ``points3d.csv``."""
    return write_table(native.points3d_table(tracks), path)


_UNIT, _HEIGHTS, _VIEW = ("unit",), ("heights_px",), ("view",)

TABLE: tuple[Format, ...] = (
    Format(
        name="pawnb", title="pawnb tracks.nc", endings=(".nc",), holds="all", says_fps=True,
        read=native.read_tracks, write=native.write_tracks,
    ),
    Format(
        name="movement", title="movement netCDF", endings=(".nc",), holds="view or space",
        says_fps=True, read=native.read_tracks, reads_with=_UNIT, write=write_movement,
        writes_with=_VIEW,
    ),
    Format(
        name="deeplabcut", title="DeepLabCut", endings=(".csv", ".h5"), names=("DLC",),
        read=read_deeplabcut, reads_with=_UNIT, write=write_deeplabcut, writes_with=_VIEW,
    ),
    Format(
        name="collected", title="DeepLabCut CollectedData", endings=(".csv", ".h5"),
        names=("CollectedData",), read=read_collected, write=write_collected, writes_with=_VIEW,
    ),
    Format(
        name="lightning-pose", title="Lightning Pose", endings=(".csv",),
        read=read_deeplabcut, write=write_lightning_pose, writes_with=_VIEW,
    ),
    Format(
        name="sleap", title="SLEAP", endings=(".slp", ".h5", ".csv"), extra="sleap",
        names=(".analysis.h5", ".analysis.csv"), read=read_sleap, write=write_sleap,
        writes_with=_VIEW,
    ),
    Format(
        name="anipose", title="Anipose 3D csv", endings=(".csv",), holds="space",
        read=read_anipose, reads_with=_UNIT, write=write_anipose,
    ),
    Format(
        name="dltdv-3d", title="DLTdv xyzpts", endings=(".csv", ".tsv"), holds="space",
        names=("xyzpts",), read=read_dltdv_points3d, reads_with=_UNIT, write=write_dltdv_points3d,
    ),
    Format(
        name="dltdv", title="DLTdv xypts", endings=(".csv", ".tsv"), holds="views",
        names=("xypts",), read=read_dltdv_points, reads_with=_HEIGHTS, write=write_dltdv_points,
        writes_with=_HEIGHTS,
    ),
    Format(
        name="xmalab-3d", title="XMALab 3D points", endings=(".csv",), holds="space",
        read=read_dltdv_points3d, reads_with=_UNIT, write=write_xmalab_points3d,
    ),
    Format(
        name="xmalab", title="XMALab 2D points", endings=(".csv",), holds="views",
        read=read_dltdv_points, reads_with=_HEIGHTS, write=write_xmalab_points,
        writes_with=_HEIGHTS,
    ),
    Format(
        name="argus-3d", title="Argus xyzpts", endings=(".csv",), holds="space",
        names=("-xyzpts",), read=argus.read_argus_points3d, reads_with=_UNIT,
        write=argus.write_argus_points3d,
    ),
    Format(
        name="argus", title="Argus xypts", endings=(".csv",), holds="views", names=("-xypts",),
        read=argus.read_argus_points, reads_with=_HEIGHTS, write=argus.write_argus_points,
        writes_with=_HEIGHTS,
    ),
    Format(
        name="csv", title="pawnb tracks.csv", endings=(".csv",), holds="views",
        read=read_tracks_table, write=_write_views,
    ),
    Format(
        name="csv-3d", title="pawnb points3d.csv", endings=(".csv",), holds="space",
        names=("3d.csv",), read=read_points3d_table, reads_with=_UNIT, write=_write_space,
    ),
    Format(
        name="table", title="table of points side by side", endings=(".csv",),
        holds="view or space", read=read_wide_table, reads_with=_UNIT, write=write_wide_table,
        writes_with=_VIEW,
    ),
    Format(
        name="nwb", title="NWB with ndx-pose", endings=(".nwb",), holds="view or space",
        says_fps=True, extra="nwb", read=read_nwb, reads_with=_UNIT, write=write_nwb,
        writes_with=_VIEW,
    ),
    Format(
        name="c3d", title="C3D", endings=(".c3d",), holds="space", says_fps=True, extra="c3d",
        read=read_c3d, reads_with=_UNIT, write=write_c3d,
    ),
    Format(
        name="trc", title="OpenSim .trc", endings=(".trc",), holds="space", says_fps=True,
        read=read_trc, reads_with=_UNIT,
    ),
    Format(
        name="qtm", title="Qualisys .tsv", endings=(".tsv",), holds="space", says_fps=True,
        read=read_qtm, reads_with=_UNIT,
    ),
    Format(
        name="vicon", title="Vicon Nexus .csv", endings=(".csv",), holds="space", says_fps=True,
        read=read_vicon, reads_with=_UNIT,
    ),
    Format(
        name="locomouse", title="LocoMouse .mat", endings=(".mat",), holds="views",
        read=read_locomouse, write=write_locomouse,
    ),
    Format(
        name="kinovea", title="Kinovea .kva, .txt, .csv", endings=(".kva", ".txt", ".csv"),
        read=read_kinovea, reads_with=_UNIT,
    ),
    Format(
        name="tracker", title="Tracker .trk, table as text", endings=(".trk", ".txt", ".csv"),
        read=read_osp_tracker, reads_with=_UNIT,
    ),
    Format(
        name="manual-tracking", title="ImageJ's Manual Tracking", endings=(".xls", ".txt", ".csv"),
        read=read_manual_tracking,
    ),
    Format(
        name="trackmate", title="TrackMate .xml, .csv", endings=(".xml", ".csv"),
        read=read_trackmate, reads_with=_UNIT,
    ),
    Format(name="mtrackj", title="MTrackJ .mdf", endings=(".mdf",), read=read_mtrackj),
    Format(
        name="authors2019", title="csv of the 2019 authors", endings=(".csv",), holds="views",
        read=_read_authors, write=write_authors_trial,
    ),
)  # fmt: skip
"""Every format: how it is read, how it is written, what a file of it holds."""

FORMATS = tuple(one.name for one in TABLE)
"""Names of the formats that are read."""

WRITTEN = tuple(one.name for one in TABLE if one.write is not None)
"""Names of the formats that are written."""


def find_entry(name: str) -> Format:
    """Return a format by its name.

    Parameters
    ----------
    name : str
        One of :data:`FORMATS`.

    Returns
    -------
    Format
        What is known of it.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    for one in TABLE:
        if one.name == name:
            return one
    raise InputError(
        f"unknown format {name!r}{did_you_mean(name, FORMATS)}; expected {', '.join(FORMATS)}."
    )
