"""Tracks made elsewhere, with the calibration and belt speed of their trial."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pawnb.core.reconstruct import triangulate_tracks
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.io import authors2019
from pawnb.io.belt import read_belt_speed
from pawnb.io.formats import read_any_tracks, recognise_format
from pawnb.io.track_tables import read_tracks_table
from pawnb.schema import Tracks
from pawnb.trial import Trial

MAX_RESIDUAL_PX = 20.0
"""Points whose views disagree by more are left out in space; the provenance says how many."""


def read_foreign_tracks(trial: Trial) -> Tracks:
    """Read the tracks that a trial of kind ``tracks`` names.

    Parameters
    ----------
    trial : Trial
        ``[tracks] file`` is a ``tracks.nc`` (ours or movement's), a ``tracks.csv``, a file of
        DeepLabCut, SLEAP, Anipose or DLTdv (see :mod:`pawnb.io.formats`), or one of the four
        files of a trial of the 2019 authors (``cam1.f.<trial>.csv``), which are triangulated
        with the DLT of ``[calibration]``, itself in the authors' own pixels.

    Returns
    -------
    xarray.Dataset
        Tracks.

    Raises
    ------
    InputError
        If the file is missing or of another format, or needs a calibration that is absent.
    """
    path = trial.path(trial.tracks_file or "")
    stamp = authors2019.trial_stamp(path.name)
    if stamp is not None:
        tracks = authors2019.read_authors_trial(path.parent, stamp, fps=trial.fps)
        if trial.calibration is None or trial.calibration.dlt is None:
            raise InputError(
                f"trial {trial.name!r} has tracks of four views and no calibration; add "
                "[calibration] dlt with the DLT file that lies beside them."
            )
        coefs = authors2019.read_authors_dlt(trial.path(trial.calibration.dlt))
        rig = Rig(authors2019.VIEWS, coefs, unit=trial.calibration.unit)
        return triangulate_tracks(tracks, rig, max_residual_px=MAX_RESIDUAL_PX)
    unit = trial.calibration.unit if trial.calibration else None
    program = recognise_format(path)
    if program == "csv":
        points3d = path.with_name("points3d.csv")
        return read_tracks_table(
            path,
            fps=trial.fps,
            points3d=points3d if points3d.exists() else None,
            unit=unit or "px",
            individual=trial.animal.id,
        )
    return read_any_tracks(path, fps=trial.fps, program=program, unit=unit)


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
