"""Tracks made elsewhere whose pixels are not pawnb's: points and coefficients are moved alike."""

from __future__ import annotations

import contextlib
import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from pawnb.core.reconstruct import triangulate_tracks
from pawnb.core.rig import Rig, require_rig
from pawnb.core.video import open_view
from pawnb.errors import CalibrationError, InputWarning, VideoError
from pawnb.io.dltdv import read_dltdv_points
from pawnb.schema import ORIGIN_CODE, Tracks, add_provenance
from pawnb.trial import Trial, View

MAX_RESIDUAL_PX = 20.0
"""Points found by programs are left out in space where their views disagree by more."""


def read_dltdv_trial(path: Path, trial: Trial) -> Tracks:
    """Read and triangulate points that were digitised in the views with DLTdv.

    Parameters
    ----------
    path : Path
        ``...xypts.csv``.
    trial : Trial
        Its ``[calibration] dlt`` belongs to DLTdv's own pixels, counted from 1; ``v = "up"``
        says that both count upwards (DLTdv 7 and older).

    Returns
    -------
    xarray.Dataset
        Tracks with positions in space where there is a DLT. Image positions are in pixels of
        pawnb. Where both count upwards and nobody says how high a picture is, they cannot be
        told and are left out, with a warning; positions in space do not depend on it.

    Raises
    ------
    CalibrationError
        If the height of a picture is needed (nothing is triangulated) and not known, or the DLT
        cannot be used.
    """
    tracks = read_dltdv_points(path, fps=trial.fps)
    trial = with_views(trial, tracks)
    sizes = picture_sizes(trial)
    calibration = trial.calibration
    up = calibration is not None and calibration.v == "up"
    unknown = _without_height(trial, sizes) if up else []
    if unknown and not needs_space(tracks, trial):
        raise CalibrationError(
            f'{path.name} counts v upwards ([calibration] v = "up") and the height of the '
            f"picture of view {unknown[0]!r} is not known; name its video under [[views]], or "
            "give crop = [0, 0, width, height] there."
        )
    if up:
        # any height does for triangulation, as long as points and coefficients share it
        sizes |= dict.fromkeys(unknown, (0, 0))
        heights = [_height(trial.view(str(name)), sizes) for name in tracks["view"].to_numpy()]
        tracks = read_dltdv_points(path, fps=trial.fps, heights_px=heights)
    if not needs_space(tracks, trial):
        return tracks
    rig = require_rig(trial, sizes=sizes, first_pixel=1)
    # a person put every point: none is left out
    tracks = triangulate_tracks(tracks, rig)
    _warn_of_doubtful(tracks, path.name)
    if not unknown:
        return tracks
    warnings.warn(
        f"{path.name} counts v upwards and the height of the picture of view {unknown[0]!r} is not "
        "known: positions in space are all there, positions in the pictures are left out. Give "
        "crop = [0, 0, width, height] under [[views]] to have them.",
        InputWarning,
        stacklevel=3,
    )
    tracks = tracks.drop_dims(["view", "image_space"])
    return add_provenance(tracks, step="leave out image positions", why="v up, heights unknown")


def triangulate_foreign(tracks: Tracks, rig: Rig, *, where: str) -> Tracks:
    """Triangulate points that another program found, without those whose views disagree.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions.
    rig : Rig
        The calibrated views, in the same pixels.
    where : str
        How a warning names the file.

    Returns
    -------
    xarray.Dataset
        Tracks in space. Points whose residual is above ``MAX_RESIDUAL_PX`` are missing there,
        and a warning says how many.
    """
    tracks = triangulate_tracks(tracks, rig, max_residual_px=MAX_RESIDUAL_PX)
    refused = json.loads(tracks.attrs["provenance"])["steps"][-1]["refused"]
    if refused:
        all_of_them = refused + int((tracks["origin"] != ORIGIN_CODE["missing"]).sum())
        warnings.warn(
            f"{where}: {refused} of {all_of_them} points are left out in space, as the views "
            f"disagree about them by more than {MAX_RESIDUAL_PX:g} px.",
            InputWarning,
            stacklevel=3,
        )
    return tracks


def _warn_of_doubtful(tracks: Tracks, where: str) -> None:
    """Say which digitised points the views disagree about most."""
    residual = tracks["residual"].to_numpy()
    doubtful = residual > MAX_RESIDUAL_PX
    if doubtful.any():
        time, point, _ = np.unravel_index(np.nanargmax(residual), residual.shape)
        warnings.warn(
            f"{where}: the views disagree about {doubtful.sum()} of {np.isfinite(residual).sum()} "
            f"points by more than {MAX_RESIDUAL_PX:g} px, most about "
            f"{tracks['keypoint'].to_numpy()[point]} in frame {tracks['frame'].to_numpy()[time]} "
            f"({np.nanmax(residual):.0f} px); they are kept: look at them in DLTdv.",
            InputWarning,
            stacklevel=3,
        )


def needs_space(tracks: Tracks, trial: Trial) -> bool:
    """Say whether points of several calibrated views are not known in space yet."""
    return not (
        trial.calibration is None
        or trial.calibration.dlt is None
        or tracks.sizes.get("view", 0) < 2
        or tracks.sizes["space"] != 3
        or np.isfinite(tracks["position"]).any()
    )


def with_views(trial: Trial, tracks: Tracks) -> Trial:
    """Return a trial with views: without its own, those of the file, in that order."""
    if trial.views:
        return trial
    names = tracks["view"].to_numpy() if "view" in tracks.dims else ()
    return replace(trial, views=tuple(View(name=str(name), video="") for name in names))


def picture_sizes(trial: Trial) -> dict[str, tuple[int, int]]:
    """Return width and height in px of the whole picture of each view whose video is there."""
    sizes = {}
    for view in trial.views:
        if not view.video:
            continue
        with contextlib.suppress(VideoError):
            reader = open_view(view, trial.folder)
            sizes[view.name] = (reader.source.width, reader.source.height)
            reader.close()
    return sizes


def _without_height(trial: Trial, sizes: dict[str, tuple[int, int]]) -> list[str]:
    """Return the views whose picture may be of any height."""
    return [view.name for view in trial.views if view.crop is None and view.name not in sizes]


def _height(view: View, sizes: dict[str, tuple[int, int]]) -> int:
    """Return the height of what a view shows."""
    return sizes[view.name][1] if view.crop is None else view.crop[3] - view.crop[1]
