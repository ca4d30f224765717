"""Tracks from one format to another."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pawnb.errors import InputError
from pawnb.io import native
from pawnb.io.formats import read_any_tracks
from pawnb.io.tables import write_table
from pawnb.schema import Tracks
from pawnb.trial import load_trial
from pawnb.workflow.foreign_tracks import read_foreign_tracks

_KINDS = ("tracks.nc", "tracks.csv", "points3d.csv")


def convert_tracks(
    source: str | Path,
    target: str | Path,
    *,
    fps: float | None = None,
    program: str | None = None,
    unit: str | None = None,
) -> Path:
    """Read tracks of any program that is known and write them in a format of pawnb.

    Parameters
    ----------
    source : str or Path
        Tracks of pawnb, DeepLabCut, SLEAP, Anipose, DLTdv or movement; see
        :mod:`pawnb.io.formats`. Or a trial of kind ``tracks`` (its ``trial.toml`` or folder):
        what its file holds, triangulated with its calibration.
    target : str or Path
        ``.nc``: everything, which movement reads too. ``.csv``: a table of the points in the
        views (columns of ``tracks.csv``), or in space where the file's name ends in
        ``3d.csv`` (columns of ``points3d.csv``).
    fps : float, optional
        Frames per second, needed where the file does not say.
    program : str, optional
        Which program's file it is; default as its content says.
    unit : str, optional
        Unit of length of 3D points whose file does not say.

    Returns
    -------
    Path
        What was written.

    Raises
    ------
    InputError
        If the source cannot be read, or the target's format does not hold what it has.
    """
    target = Path(target)
    trial = _trial_file(Path(source))
    if trial is None:
        tracks = read_any_tracks(source, fps=fps, program=program, unit=unit)
    else:
        tracks = _tracks_of_trial(trial, fps, program, unit)
    if target.suffix == ".nc":
        return native.write_tracks(tracks, target)
    if target.suffix != ".csv":
        raise InputError(
            f"{target.name}: not a format that is written; expected a name like "
            f"{', '.join(_KINDS)}."
        )
    if target.stem.endswith("3d"):
        if not _has_space(tracks):
            raise InputError(
                f"{Path(source).name} holds no points in space; write {_KINDS[1]} instead."
            )
        return write_table(native.points3d_table(tracks), target)
    if "image_position" not in tracks and tracks.sizes["space"] != 2:
        raise InputError(
            f"{Path(source).name} holds no points in pictures; write {_KINDS[2]} instead."
        )
    return write_table(native.tracks_table(tracks), target)


def _trial_file(source: Path) -> Path | None:
    """Return the ``trial.toml`` that a source is or holds, or None."""
    path = source / "trial.toml" if source.is_dir() else source
    return path if path.suffix == ".toml" and path.exists() else None


def _tracks_of_trial(
    path: Path, fps: float | None, program: str | None, unit: str | None
) -> Tracks:
    """Return the tracks that a trial names, in space where it is calibrated."""
    trial = load_trial(path)
    if trial.kind != "tracks":
        raise InputError(
            f"{path}: a trial of kind {trial.kind!r}, which pawnb tracks itself; name the "
            "tracks.nc of its results."
        )
    if (fps, program, unit) != (None, None, None):
        raise InputError(
            f"{path}: a trial says its frame rate and unit itself, and what its file is the file "
            "says; leave fps, program and unit away."
        )
    return read_foreign_tracks(trial)


def _has_space(tracks: Tracks) -> bool:
    """Say whether tracks hold points in space."""
    return tracks.sizes["space"] == 3 and bool(np.isfinite(tracks["position"]).any())
