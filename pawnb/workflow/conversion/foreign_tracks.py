"""Tracks made elsewhere, with the calibration and belt speed of their trial."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pawnb.core.rig import Rig, require_rig
from pawnb.errors import InputError
from pawnb.io import authors2019
from pawnb.io.belt import read_belt_speed
from pawnb.io.formats import read_any_tracks, recognise_format
from pawnb.io.track_tables import read_tracks_table
from pawnb.schema import Tracks
from pawnb.trial import Trial
from pawnb.workflow.calibration.real_units import in_real_units
from pawnb.workflow.conversion.file_pixels import (
    needs_space,
    picture_sizes,
    read_digitised_trial,
    straighten_tracks,
    triangulate_foreign,
    with_views,
)
from pawnb.workflow.conversion.files_of_views import OWN, read_files_of_views


def read_foreign_tracks(trial: Trial) -> Tracks:
    """Read the tracks that a trial of kind ``tracks`` names.

    Parameters
    ----------
    trial : Trial
        ``[tracks] file`` is a ``tracks.nc`` (ours or movement's), a ``tracks.csv``, a file of
        DeepLabCut, SLEAP, Anipose, DLTdv or any other of :mod:`pawnb.io.formats`, or one of the
        four files of a trial of the 2019 authors (``cam1.f.<trial>.csv``), which are
        triangulated with the DLT of ``[calibration]``, itself in the authors' own pixels. Or it
        names a file for each view: ``file = { cam1 = "cam1DLC.h5", cam2 = "cam2DLC.h5" }``.

    Returns
    -------
    xarray.Dataset
        Tracks of the trial's ``frames``. Points of several views that the file does not give
        in space are straightened where the calibration names lenses (but for pawnb's own, which
        are straight) and triangulated; positions of a single view are brought to real units by
        ``px_per_unit``.

    Raises
    ------
    InputError
        If the file is missing or of another format, needs a calibration that is absent, or
        has none of the trial's frames.
    """
    if trial.tracks_of_views:
        return _chosen_frames(_in_space(read_files_of_views(trial), trial), trial)
    path = trial.path(trial.tracks_file or "")
    stamp = authors2019.trial_stamp(path.name)
    if stamp is not None:
        return _chosen_frames(_read_authors(path, stamp, trial), trial)
    program = recognise_format(path)
    if program in ("dltdv", "argus"):
        tracks = read_digitised_trial(path, trial, program)
        return _chosen_frames(in_real_units(tracks, trial), trial)
    tracks = _read_file(path, trial, program)
    return _chosen_frames(_in_space(tracks, trial, own=program in OWN), trial)


def _in_space(tracks: Tracks, trial: Trial, *, own: bool = False) -> Tracks:
    """Triangulate tracks of several calibrated views, and bring those of one to real units."""
    if not needs_space(tracks, trial):
        return in_real_units(tracks, trial)
    trial = with_views(trial, tracks)
    sizes = picture_sizes(trial)
    if not own:  # pawnb's own are in the pixels of the straightened view
        tracks = straighten_tracks(tracks, trial, sizes)
    rig = require_rig(trial, sizes=sizes)
    return triangulate_foreign(tracks, rig, where=", ".join(trial.track_files))


def _read_authors(path: Path, stamp: str, trial: Trial) -> Tracks:
    """Read and triangulate a trial of the 2019 authors."""
    tracks = authors2019.read_authors_trial(path.parent, stamp, fps=trial.fps)
    if trial.calibration is None or trial.calibration.dlt is None:
        raise InputError(
            f"trial {trial.name!r} has tracks of four views and no calibration; add "
            "[calibration] dlt with the DLT file that lies beside them."
        )
    coefs = authors2019.read_authors_dlt(trial.path(trial.calibration.dlt))
    rig = Rig(authors2019.VIEWS, coefs, unit=trial.calibration.unit)
    return triangulate_foreign(tracks, rig, where=f"trial {stamp}")


def _read_file(path: Path, trial: Trial, program: str) -> Tracks:
    """Read a file of tracks of any program."""
    unit = None  # of lengths in the file: one that a scale must make real is in px
    if trial.calibration is not None and trial.calibration.px_per_unit is None:
        unit = trial.calibration.unit
    if program == "csv":
        return read_tracks_table(
            path,
            fps=trial.fps,
            points3d=_points3d_beside(path),
            unit=unit or "px",
            individual=trial.animal.id,
        )
    return read_any_tracks(path, fps=trial.fps, program=program, unit=unit)


def _points3d_beside(path: Path) -> Path | None:
    """Return the points in space that lie beside a ``tracks.csv``, or None."""
    points3d = path.with_name("points3d.csv")
    return points3d if points3d.exists() else None


def files_of_tracks(trial: Trial) -> tuple[Path, ...]:
    """Return every file that the tracks and belt speed of such a trial are read from.

    Parameters
    ----------
    trial : Trial
        A trial of kind ``tracks`` whose tracks can be read.

    Returns
    -------
    tuple of Path
        The named file first.
    """
    files = [trial.path(name) for name in trial.track_files]
    path = files[0]
    stamp = authors2019.trial_stamp(path.name)
    if stamp is not None:
        files += sorted(path.parent.glob(f"cam*{stamp}.csv"))
    elif recognise_format(path) == "csv":
        files += [points3d for points3d in (_points3d_beside(path),) if points3d is not None]
    said = trial.calibration
    further = () if said is None else (said.of_views, said.lens)
    files += [trial.path(name) for name in (*further, trial.belt_speed) if isinstance(name, str)]
    return tuple(dict.fromkeys(files))


def _chosen_frames(tracks: Tracks, trial: Trial) -> Tracks:
    """Return the tracks of the trial's frames."""
    if trial.frames is None:
        return tracks
    first, stop = trial.frames
    frames = tracks["frame"].to_numpy()
    inside = (frames >= first) & (frames < stop)
    if not inside.any():
        raise InputError(
            f"trial {trial.name!r}: {', '.join(trial.track_files)} has frames {frames.min()} to "
            f"{frames.max()}, none of [trial] frames = [{first}, {stop}]."
        )
    return tracks.isel(time=inside)


def read_belt(path: str | Path) -> pd.DataFrame:
    """Read a table of belt speed: ours, or that of the 2019 authors.

    Parameters
    ----------
    path : str or Path
        A csv with columns frame, speed (unit/s), or the authors' ``Speed_Time`` file (m/s).

    Returns
    -------
    pandas.DataFrame
        ``frame`` and ``speed``; from the authors' file in mm/s.

    Raises
    ------
    InputError
        If it is neither.
    """
    path = Path(path)
    if path.name.lower().startswith("speed_time"):
        return authors2019.read_authors_speed(path)[["frame", "speed"]]
    return read_belt_speed(path)
