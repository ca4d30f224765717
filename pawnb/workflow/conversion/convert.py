"""Tracks from one format to another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pawnb.core.reproject import reproject_tracks
from pawnb.core.rig import Rig
from pawnb.errors import CalibrationError, InputError, did_you_mean
from pawnb.io.coefs import write_coefs
from pawnb.io.dltdv_out import beside
from pawnb.io.formats import Format, read_any_tracks, target_format, write_any_tracks
from pawnb.io.outgoing import has_space, take_animal, views_of
from pawnb.io.points import check_names
from pawnb.schema import Tracks, add_provenance, make_tracks
from pawnb.schema.arguments import checked_arguments
from pawnb.trial import Trial, load_trial
from pawnb.workflow.calibration.program_pixels import move_coefs
from pawnb.workflow.conversion.file_pixels import rig_of_tracks, view_heights
from pawnb.workflow.conversion.foreign_tracks import read_foreign_tracks
from pawnb.workflow.provenance.results import read_result_tracks, results_folder


@checked_arguments
def convert_tracks(
    source: str | Path,
    target: str | Path,
    *,
    to: str | None = None,
    fps: float | None = None,
    program: str | None = None,
    unit: str | None = None,
    view: str | None = None,
    animal: str | None = None,
    heights_px: Sequence[int] | None = None,
    legs: Sequence[str] | Mapping[str, str] | None = None,
) -> list[Path]:
    """Read tracks of any program that is known and write them in the format of any other.

    Parameters
    ----------
    source : str or Path
        Tracks of any program of :data:`pawnb.io.formats.TABLE`. Or a trial (its ``trial.toml`` or
        folder): of kind ``tracks`` what its files hold, triangulated with its calibration, of
        another what pawnb tracked; in a format of pictures, points in space are shown in every
        calibrated view, also where they were not tracked.
    target : str or Path
        The file. A format of one view makes a file for each of several views,
        ``<name>_<view><ending>``.
    to : str, optional
        The target's format, one of :data:`pawnb.io.formats.WRITTEN`; default what its name says:
        ``tracks.nc``, ``tracks.csv``, ``points3d.csv`` (any name that ends in ``3d.csv``),
        ``...xypts.csv``, ``...DLC....csv``, ``.slp``, ``.nwb``, ``.c3d`` and the like.
    fps : float, optional
        Frames per second, needed where the file does not say.
    program : str, optional
        Which program's file the source is; default as its content says.
    unit : str, optional
        Unit of length of 3D points whose file does not say.
    view, animal : str, optional
        Only this view, or this animal.
    heights_px : sequence of int, optional
        Heights of the pictures (one of all, or one a view), for formats that count upwards from
        the lower edge: Argus, and DLTdv 7 and older.

    legs : mapping, optional
        Leg to point: these points are called as the legs from here on, so that what was corrected
        once need not be said again.

    Returns
    -------
    list of Path
        What was written; where DLTdv or Argus is written from a calibrated trial, also its
        coefficients, moved to the same pixels.

    Raises
    ------
    InputError
        If the source cannot be read, the target's format does not hold what it has, or the
        target's name says another format than ``to``.

    Examples
    --------
    >>> done = pawnb.convert_tracks("sample/results/tracks.nc", "sample/paws_xypts.csv")
    >>> [path.name for path in done]
    ['paws_xypts.csv']
    """
    target = Path(target)
    entry = target_format(target, to)
    path = _trial_file(Path(source))
    rig = None
    if path is None:
        tracks = read_any_tracks(source, fps=fps, program=program, unit=unit, heights_px=heights_px)
    else:
        trial = _trial(path, fps, program, unit)
        tracks = _tracks_of(trial, path)
        # points in space need no views
        pictures = entry.holds in ("view", "views") or (view and entry.holds == "view or space")
        rig = rig_of_tracks(trial, tracks) if pictures else None
        heights_px = heights_px or _own_heights(trial, tracks, entry)
    if animal is not None:
        tracks = take_animal(tracks, animal)
    if isinstance(legs, Mapping):
        tracks = _with_legs(tracks, legs, Path(source).name)
    tracks = _in_views(tracks, rig)
    _check_holds(tracks, entry, Path(source).name)
    written = write_any_tracks(tracks, target, program=to, view=view, heights_px=heights_px)
    if rig is not None and entry.name in ("dltdv", "argus"):
        coefs = _moved_coefs(rig, tracks, entry, heights_px)
        written.append(write_coefs(coefs, beside(target, "DLTcoefs").with_suffix(".csv")))
    return written


def _trial_file(source: Path) -> Path | None:
    """Return the ``trial.toml`` that a source is or holds, or None."""
    path = source / "trial.toml" if source.is_dir() else source
    return path if path.suffix == ".toml" and path.exists() else None


def _trial(path: Path, fps: float | None, program: str | None, unit: str | None) -> Trial:
    """Return a trial, which says itself what else would be given."""
    trial = load_trial(path)
    if (fps, program, unit) != (None, None, None):
        raise InputError(
            f"{path}: a trial says its frame rate and unit itself, and what its file is the file "
            "says; leave fps, program and unit away."
        )
    return trial


def _tracks_of(trial: Trial, path: Path) -> Tracks:
    """Return the tracks of a trial: those made elsewhere, or those that pawnb made of it."""
    if trial.is_tracked_elsewhere:
        return read_foreign_tracks(trial)
    results = results_folder(trial) / "tracks.nc"
    if not results.exists():
        raise InputError(f"{results}: trial {trial.name!r} is not tracked yet; run pawnb track "
                         f"{path.parent} first, or name the tracks.nc of its results.")  # fmt: skip
    return read_result_tracks(results)


def _own_heights(trial: Trial, tracks: Tracks, entry: Format) -> list[int] | None:
    """Return the heights of the pictures where the target needs them and the trial knows them."""
    up = trial.calibration is not None and trial.calibration.v == "up"
    if entry.name != "argus" and not (entry.name == "dltdv" and up):
        return None
    return view_heights(trial, tracks)


def _with_legs(tracks: Tracks, legs: Mapping[str, str], source: str) -> Tracks:
    """Return tracks whose points are called as the legs they are."""
    names = [str(point) for point in tracks["keypoint"].to_numpy()]
    for leg, point in legs.items():
        if point not in names:
            raise InputError(
                f"{source}: no point {point!r}{did_you_mean(point, names)} for leg {leg!r}; it has "
                f"{', '.join(names)}."
            )
    called = {point: leg for leg, point in legs.items()}
    if len(called) < len(legs):
        twice = next(p for leg, p in legs.items() if called[p] != leg)
        raise InputError(f"{source}: two legs are the one point {twice!r}; name another.")
    new = [called.get(name, name) for name in names]
    check_names(new, what="point", where=source)
    renamed = tracks.assign_coords(keypoint=np.array(new, dtype=str))
    return add_provenance(renamed, step="name legs", legs=dict(legs))


def _in_views(tracks: Tracks, rig: Rig | None) -> Tracks:
    """Show points in space in every calibrated view, where pictures are asked for."""
    if rig is None or not has_space(tracks):
        return tracks
    if "image_position" not in tracks:
        empty = make_tracks(
            tracks["frame"].to_numpy(),
            [str(point) for point in tracks["keypoint"].to_numpy()],
            fps=float(tracks.attrs["fps"]),
            views=rig.names,
        )
        empty = empty.isel(individual=np.zeros(tracks.sizes["individual"], dtype=int))
        empty = empty.copy(deep=True).assign_coords(individual=tracks["individual"])
        names = ["image_position", "image_origin", "image_confidence"]
        tracks = tracks.merge(empty[names], combine_attrs="override", compat="no_conflicts")
    return reproject_tracks(tracks, rig)


def _check_holds(tracks: Tracks, entry: Format, source: str) -> None:
    """Refuse a format that holds other points than there are."""
    if entry.holds == "space" and not has_space(tracks):
        instead = "write tracks.csv instead" if entry.name == "csv-3d" else "choose another format"
        raise InputError(f"{source} holds no points in space; {instead}.")
    if entry.holds in ("view", "views") and not views_of(tracks) and entry.name != "deeplabcut":
        instead = "write points3d.csv instead" if entry.name == "csv" else "choose another format"
        raise InputError(f"{source} holds no points in pictures; {instead}.")


def _moved_coefs(
    rig: Rig, tracks: Tracks, entry: Format, heights_px: Sequence[int] | None
) -> np.ndarray:
    """Return coefficients in the pixels that the points are written in."""
    names = [name for name in views_of(tracks) if name in rig.names]
    if names != views_of(tracks):
        raise CalibrationError("not every view is calibrated; choose calibrated ones with --view.")
    own = rig.subset(names)
    up = entry.name == "dltdv" and heights_px is not None
    return move_coefs(own.coefs, "dltdv7" if up else entry.name, heights_px)
