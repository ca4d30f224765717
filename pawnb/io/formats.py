"""Tracks of any program, in and out: one table of formats, told apart by what is in the file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pawnb.errors import InputError, did_you_mean
from pawnb.io import argus, native
from pawnb.io.anipose import read_anipose, write_anipose
from pawnb.io.authors2019 import read_authors_trial, trial_stamp
from pawnb.io.c3d_file import read_c3d, write_c3d
from pawnb.io.deeplabcut import read_collected, read_deeplabcut
from pawnb.io.deeplabcut_out import write_collected, write_deeplabcut, write_lightning_pose
from pawnb.io.dltdv import read_dltdv_points, read_dltdv_points3d
from pawnb.io.dltdv_out import write_dltdv_points, write_dltdv_points3d
from pawnb.io.locomouse import read_locomouse
from pawnb.io.movement import write_movement
from pawnb.io.nwb import read_nwb, write_nwb
from pawnb.io.outgoing import has_space, views_of
from pawnb.io.recognise import find_format
from pawnb.io.sleap import read_sleap
from pawnb.io.sleap_out import write_sleap
from pawnb.io.tables import write_table
from pawnb.io.track_tables import read_points3d_table, read_tracks_table
from pawnb.io.wide import read_wide_table, write_wide_table
from pawnb.schema import Tracks, check_fps


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
        ``write(tracks, path)`` gives the file; None where the format is only read.
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
        says_fps=True, read=native.read_tracks, write=write_movement, writes_with=_VIEW,
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
        says_fps=True, extra="nwb", read=read_nwb, write=write_nwb, writes_with=_VIEW,
    ),
    Format(
        name="c3d", title="C3D", endings=(".c3d",), holds="space", says_fps=True, extra="c3d",
        read=read_c3d, reads_with=_UNIT, write=write_c3d,
    ),
    Format(
        name="locomouse", title="LocoMouse .mat", endings=(".mat",), holds="views",
        read=read_locomouse,
    ),
    Format(
        name="authors2019", title="csv of the 2019 authors", endings=(".csv",), holds="views",
        read=_read_authors,
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


def recognise_format(path: str | Path) -> str:
    """Say which program's tracks a file holds.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    str
        One of :data:`FORMATS`: ``"csv"`` and ``"csv-3d"`` are pawnb's tables ``tracks.csv``
        and ``points3d.csv``, ``"table"`` a csv with ``<point>_x, <point>_y`` of every point.

    Raises
    ------
    InputError
        If there is no such file or it is none of them.

    Examples
    --------
    >>> pawnb.io.recognise_format("sample/m01DLC.csv")
    'deeplabcut'
    """
    path = Path(path)
    found = find_format(path)
    if found is None:
        raise InputError(
            f"{path.name}: not tracks that are read here; expected tracks.nc, tracks.csv, "
            "points3d.csv, or a file of DeepLabCut, Lightning Pose (.csv, .h5), SLEAP (.slp, .h5, "
            ".csv), Anipose (.csv), DLTdv, Argus (xypts.csv, xyzpts.csv), movement (.nc), NWB, "
            "C3D or LocoMouse (.mat), or a csv with frame and <point>_x, <point>_y (and _z) of "
            "every point."
        )
    return found


def read_any_tracks(
    path: str | Path,
    *,
    fps: float | None = None,
    program: str | None = None,
    unit: str | None = None,
    heights_px: Sequence[int] | None = None,
) -> Tracks:
    """Read tracks of pawnb or of another program.

    Parameters
    ----------
    path : str or Path
        The file.
    fps : float, optional
        Frames per second, needed where the file does not say.
    program : str, optional
        One of :data:`FORMATS`; default as :func:`recognise_format` says.
    unit : str, optional
        Unit of length of 3D points whose file does not say; default mm.
    heights_px : sequence of int, optional
        Heights of the pictures in px (one of all, or one a view), for points that are counted
        upwards from the lower edge: those of Argus, and of DLTdv 7 and older.

    Returns
    -------
    xarray.Dataset
        Tracks.

    Raises
    ------
    InputError
        If the file cannot be read, or the frame rate is needed and not given.

    Examples
    --------
    >>> tracks = pawnb.io.read_any_tracks("sample/m01DLC.csv", fps=200.0)
    >>> "hindpaw_R" in tracks["keypoint"]
    True
    """
    path = Path(path)
    check_rate(fps)
    entry = find_entry(recognise_format(path) if program is None else program)
    if fps is None and not entry.says_fps:
        raise InputError(
            f"{path.name}: this file does not say its frame rate; give fps, the frames per second "
            "of the recording (--fps on the command line)."
        )
    told = {"unit": unit, "heights_px": heights_px}
    return entry.read(path, fps=fps, **_taken(told, entry.reads_with))


def _taken(told: dict[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Return what a format takes of what was told."""
    return {name: told[name] for name in names if told[name] is not None}


def load_tracks(path: str | Path, *, fps: float | None = None, **more: Any) -> Tracks:
    """Read tracks of any program that is known; the same as :func:`read_any_tracks`.

    Parameters
    ----------
    path : str or Path
        The file, recognised by what is in it.
    fps : float, optional
        Frames per second, needed where the file does not say.
    **more
        ``program``, ``unit``, ``heights_px``: see :func:`read_any_tracks`.

    Returns
    -------
    xarray.Dataset
        Tracks.

    Raises
    ------
    InputError
        If the file cannot be read, or the frame rate is needed and not given.

    Examples
    --------
    >>> pawnb.load_tracks("sample/results/tracks.nc").sizes["time"]
    60
    """
    return read_any_tracks(path, fps=fps, **more)


def target_format(path: str | Path, program: str | None = None) -> Format:
    """Return the format that a file to be written gets, so that its name never lies.

    Parameters
    ----------
    path : str or Path
        The file to write.
    program : str, optional
        The format asked for; default that which the name says.

    Returns
    -------
    Format
        A format that is written.

    Raises
    ------
    InputError
        If the name says no format, or another one than that asked for.
    """
    path = Path(path)
    said = _named(path)
    if program is None:
        if said is None:
            several = [one.name for one in TABLE if path.suffix in one.endings and one.write]
            hint = f"{path.suffix} may be of {', '.join(several)}: say which with --to" if several \
                else f"expected --to and one of {', '.join(WRITTEN)}"  # fmt: skip
            raise InputError(f"{path.name}: not a format that is written by that name; {hint}.")
        return said
    entry = find_entry(program)
    if entry.write is None:
        raise InputError(
            f"{entry.title} is read but not written; expected --to and one of {', '.join(WRITTEN)}."
        )
    if path.suffix not in entry.endings:
        raise InputError(
            f"{path.name}: {entry.title} is written into {' or '.join(entry.endings)}; name the "
            "file so, or choose another format with --to."
        )
    own = any(word in path.name for word in entry.names)
    other = next((one for one in TABLE if any(word in path.name for word in one.names)), None)
    if other is not None and not own and other is not entry:
        raise InputError(
            f"{path.name} is what a file of {other.title} is called, and {entry.title} is asked "
            "for; choose another name, or another format with --to."
        )
    return entry


def _named(path: Path) -> Format | None:
    """Return the format that a name says, or None where it says none."""
    fits = [one for one in TABLE if path.suffix in one.endings and one.write is not None]
    words = [(word, one) for one in fits for word in one.names if word in path.name]
    if words:
        return max(words, key=lambda pair: len(pair[0]))[1]
    if path.suffix == ".csv":
        return find_entry("csv")
    if path.suffix == ".nc":
        return find_entry("pawnb")
    return fits[0] if len(fits) == 1 or path.suffix == ".slp" else None


def write_any_tracks(
    tracks: Tracks,
    path: str | Path,
    *,
    program: str | None = None,
    view: str | None = None,
    heights_px: Sequence[int] | None = None,
) -> list[Path]:
    """Write tracks in the format of any program that is known.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks.
    path : str or Path
        The file. Where the format holds one view and the tracks have several, each view gets a
        file of its own, ``<name>_<view><ending>``.
    program : str, optional
        The format; default that which the name says.
    view : str, optional
        Write this view only.
    heights_px : sequence of int, optional
        As for :func:`read_any_tracks`.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    InputError
        If the format cannot hold these tracks, or the name says another one.

    Examples
    --------
    >>> [path.name for path in pawnb.io.write_any_tracks(tracks, "sample/m01.analysis.h5")]
    ['m01.analysis.h5']
    """
    path, entry = Path(path), target_format(path, program)
    views = views_of(tracks)
    if view is not None and view not in views:
        raise InputError(
            f"no view {view!r} in these tracks; there are {', '.join(views) or 'none'}."
        )
    if view is not None and "image_position" in tracks and entry.holds == "views":
        tracks = tracks.sel(view=[view])
    if entry.holds == "view or space" and view is None and has_space(tracks):
        tracks = tracks.drop_dims(["view", "image_space"], errors="ignore")
        views = []
    apart = entry.holds in ("view", "view or space") and len(views) > 1 and view is None
    targets = (
        {one: path.with_name(f"{path.stem}_{one}{path.suffix}") for one in views}
        if apart
        else {view: path}
    )
    for one, own in targets.items():
        told = {"view": one, "heights_px": heights_px}
        if entry.write is not None:
            entry.write(tracks, own, **_taken(told, entry.writes_with))
    return list(targets.values())


def check_rate(fps: float | None) -> None:
    """Refuse a frame rate that cannot be, given or not needed.

    Parameters
    ----------
    fps : float, optional
        Frames per second.

    Raises
    ------
    InputError
        If it is not a number above 0.
    """
    if fps is not None:
        check_fps(fps)
