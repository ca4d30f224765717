"""Tracks of any program, in and out: one table of formats, told apart by what is in the file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pawnb.errors import InputError
from pawnb.io.format_table import FORMATS, TABLE, WRITTEN, Format, find_entry
from pawnb.io.outgoing import has_space, views_of
from pawnb.io.recognise import find_format
from pawnb.io.unread import say_found, say_unread
from pawnb.schema import Tracks, check_fps
from pawnb.schema.arguments import checked_arguments

__all__ = [
    "FORMATS",
    "TABLE",
    "WRITTEN",
    "Format",
    "check_rate",
    "find_entry",
    "load_tracks",
    "read_any_tracks",
    "recognise_format",
    "target_format",
    "write_any_tracks",
]


@checked_arguments
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
        if (told := say_unread(path)) is not None:
            raise InputError(f"{path.name}: {told}.")
        said = say_found(path)
        raise InputError(
            f"{path.name}: not tracks that are read here{said and f' ({said})'}; expected "
            "tracks.nc, tracks.csv, points3d.csv, or a file of DeepLabCut, Lightning Pose (.csv, "
            ".h5), SLEAP (.slp, .h5, .csv), Anipose (.csv), DLTdv, Argus (xypts.csv, xyzpts.csv), "
            "movement (.nc), NWB, C3D, OpenSim (.trc), Qualisys (.tsv), Vicon (.csv), LocoMouse "
            "(.mat), Kinovea (.kva, .txt, .csv), Tracker (.trk, .txt), ImageJ's Manual Tracking, "
            "MTrackJ (.mdf) or TrackMate (.xml, .csv), or a csv with frame and <point>_x, "
            "<point>_y (and _z) of every point."
        )
    return found


@checked_arguments
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


@checked_arguments
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


@checked_arguments
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
    done: list[Path] = []
    for one, own in targets.items():
        told = {"view": one, "heights_px": heights_px}
        if entry.write is not None:
            written = entry.write(tracks, own, **_taken(told, entry.writes_with))
            done += written if isinstance(written, list) else [own]
    return done


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
