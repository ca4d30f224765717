"""Tracks made elsewhere whose pixels are not pawnb's: points and coefficients are moved alike."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from pawnb.core.dlt import transform_image
from pawnb.core.lens import lenses_of_views
from pawnb.core.reconstruct import triangulate_tracks
from pawnb.core.rig import Rig, require_rig
from pawnb.core.video import open_view
from pawnb.errors import CalibrationError, InputWarning, VideoError
from pawnb.input_warnings import warn_of_input
from pawnb.io.argus import read_argus_points
from pawnb.io.authors2019 import VIEWS as AUTHORS_VIEWS
from pawnb.io.authors2019 import read_authors_dlt
from pawnb.io.cameras import read_cameras
from pawnb.io.dltdv import read_dltdv_points
from pawnb.schema import ORIGIN_CODE, Tracks, add_provenance
from pawnb.trial import Trial, View
from pawnb.workflow.calibration.moved_cameras import tell_moved_views

MAX_RESIDUAL_PX = 20.0
"""Points found by programs are left out in space where their views disagree by more."""
_MOST_REFUSED = 1.0 / 3.0
"""Of the points; where more are left out it is the calibration, and not single points. Set by hand:
a good one of four cameras leaves out 5 % of them, with one wrong camera 87 %; cameras in the wrong
order leave out all, and 46 % in small pictures (256 px)."""


def read_digitised_trial(path: Path, trial: Trial, program: str = "dltdv") -> Tracks:
    """Read and triangulate points that were digitised in the views with DLTdv or Argus.

    Parameters
    ----------
    path : Path
        ``...xypts.csv``.
    trial : Trial
        Its ``[calibration] dlt`` belongs to the program's own pixels: DLTdv's are counted from 1,
        and ``v = "up"`` says that they count upwards (DLTdv 7 and older); Argus' count upwards
        always, from 0.
    program : {"dltdv", "argus"}
        Whose file it is.

    Returns
    -------
    xarray.Dataset
        Tracks with positions in space where there is a calibration. Image positions are in pixels
        of pawnb. Where both count upwards and nobody says how high a picture is, they cannot be
        told and are left out, with a warning; positions in space do not depend on it.

    Raises
    ------
    CalibrationError
        If the height of a picture is needed (nothing is triangulated) and not known, or the DLT
        cannot be used.
    """
    tracks = _read_points(path, trial.fps, program)
    trial = with_views(trial, tracks)
    sizes = picture_sizes(trial)
    calibration = trial.calibration
    of_cameras = calibration is not None and calibration.cameras is not None
    up = program == "argus" or (calibration is not None and calibration.v == "up")
    unknown = _without_height(trial, sizes) if up else []
    if unknown and (of_cameras or not needs_space(tracks, trial)):
        raise CalibrationError(
            f'{path.name} counts v upwards ([calibration] v = "up", or Argus) and the height of '
            f"the picture of view {unknown[0]!r} is not known; name its video under [[views]], or "
            "give crop = [0, 0, width, height] there, with which it need not be at hand."
        )
    if up:
        # any height does for triangulation, as long as points and coefficients share it
        sizes |= dict.fromkeys(unknown, (0, 0))
        heights = [_height(trial.view(str(name)), sizes) for name in tracks["view"].to_numpy()]
        tracks = _read_points(path, trial.fps, program, heights)
    if not needs_space(tracks, trial):
        return tracks
    tracks = straighten_tracks(tracks, trial, sizes)
    # a person put every point: none is left out
    rig = _rig_of_program(trial, sizes, program)
    tracks = triangulate_tracks(tracks, rig, even=of_cameras)
    _warn_of_doubtful(tracks, path.name)
    tracks = tell_moved_views(tracks, rig, where=path.name)
    if not unknown:
        return tracks
    warn_of_input(
        f"{path.name} counts v upwards and the height of the picture of view {unknown[0]!r} is not "
        "known: positions in space are all there, positions in the pictures are left out. Give "
        "crop = [0, 0, width, height] under [[views]] to have them.",
        InputWarning,
        stacklevel=3,
    )
    tracks = tracks.drop_dims(["view", "image_space"])
    return add_provenance(tracks, step="leave out image positions", why="v up, heights unknown")


def _read_points(
    path: Path, fps: float, program: str, heights_px: list[int] | None = None
) -> Tracks:
    """Read points of DLTdv or Argus; without heights only the names of the views are right."""
    if program == "argus":
        return read_argus_points(path, fps=fps, heights_px=heights_px or (0,))
    return read_dltdv_points(path, fps=fps, heights_px=heights_px)


def _rig_of_program(trial: Trial, sizes: dict[str, tuple[int, int]], program: str) -> Rig:
    """Return the rig in pawnb's pixels of coefficients in those of a program."""
    said = trial.calibration
    if program != "argus" or said is None or said.dlt is None:
        return require_rig(trial, sizes=sizes, first_pixel=1 if program == "dltdv" else 0)
    rig = require_rig(replace(trial, calibration=replace(said, v="up")), sizes=sizes)
    # upwards was taken as DLTdv counts, from 1; Argus counts u from 0
    back = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    coefs = np.stack([transform_image(column, back) for column in rig.coefs.T], axis=1)
    return replace(rig, coefs=coefs)


def rig_of_tracks(trial: Trial, tracks: Tracks) -> Rig | None:
    """Return the calibrated views of a trial of kind ``tracks``, in the pixels of its tracks.

    Parameters
    ----------
    trial : Trial
        The trial.
    tracks : xarray.Dataset
        Its tracks, read with :func:`pawnb.workflow.conversion.foreign_tracks.read_foreign_tracks`.

    Returns
    -------
    Rig or None
        None where the trial has no calibration of its views.

    Raises
    ------
    CalibrationError
        If the calibration cannot be read, or a height is needed and not known.
    """
    if trial.calibration is None or trial.calibration.of_views is None:
        return None
    program = str(tracks.attrs.get("source_software"))
    if trial.calibration.dlt is not None and program.startswith("Kinematic-Software"):
        coefs = read_authors_dlt(trial.path(trial.calibration.dlt))
        return Rig(AUTHORS_VIEWS, coefs, unit=trial.calibration.unit)
    trial = _with_cameras(trial, tracks)
    if not trial.views:
        raise CalibrationError(
            f"trial {trial.name!r}: its tracks are in space only; name the views of its "
            "calibration under [[views]] to have them in pictures."
        )
    sizes = picture_sizes(trial)
    return _rig_of_program(trial, sizes, {"Argus": "argus", "DLTdv": "dltdv"}.get(program, ""))


def _with_cameras(trial: Trial, tracks: Tracks) -> Trial:
    """Return a trial with views: its own, those of the tracks, or else its cameras."""
    said = trial.calibration
    if trial.views or "view" in tracks.dims or said is None or said.cameras is None:
        return with_views(trial, tracks)
    names = [camera.name for camera in read_cameras(trial.path(said.cameras))]
    return replace(trial, views=tuple(View(name=name, video="") for name in names))


def view_heights(trial: Trial, tracks: Tracks) -> list[int] | None:
    """Return the heights of what the views of tracks show, px; None where one is not known.

    Parameters
    ----------
    trial : Trial
        The trial, which names videos, crops or cameras with the size of their pictures.
    tracks : xarray.Dataset
        Its tracks.

    Returns
    -------
    list of int or None
        A height a view.
    """
    trial = _with_cameras(trial, tracks)
    sizes = picture_sizes(trial)
    if trial.calibration is not None and trial.calibration.cameras is not None:
        for camera in read_cameras(trial.path(trial.calibration.cameras)):
            if camera.size is not None:
                sizes.setdefault(camera.name, camera.size)
    if _without_height(trial, sizes):
        return None
    return [_height(view, sizes) for view in trial.views]


def straighten_tracks(tracks: Tracks, trial: Trial, sizes: dict[str, tuple[int, int]]) -> Tracks:
    """Move points as they were filmed to where they lie without the distortion of the lens.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks made elsewhere, in the pixels of the views (cropped and mirrored as these are).
    trial : Trial
        Its calibration names the lenses; without any the tracks come back as they are.
    sizes : dict
        Width and height of the whole picture of each view, where it is known.

    Returns
    -------
    xarray.Dataset
        New tracks.

    Raises
    ------
    CalibrationError
        If a mirrored view is as wide as nobody says.
    """
    if "image_position" not in tracks:
        return tracks
    names = [str(name) for name in tracks["view"].to_numpy()]
    lenses = lenses_of_views(trial, names)
    if not lenses:
        return tracks
    new = tracks.copy(deep=True)
    for i, name in enumerate(names):
        if name not in lenses:
            continue
        view = trial.view(name)
        u0, v0 = (0, 0) if view.crop is None else view.crop[:2]
        width = 0 if view.crop is None else view.crop[2] - view.crop[0]
        if view.mirror and not width:
            if name not in sizes:
                raise CalibrationError(
                    f"view {name!r}: the width of its picture is needed to straighten a mirrored "
                    "view; name its video under [[views]], or give crop."
                )
            width = sizes[name][0]
        place = new["image_position"][:, i].transpose("time", "keypoint", "individual", ...)
        uv = place.to_numpy()
        mirror = np.array([-1.0, 1.0]) if view.mirror else np.ones(2)
        at = np.array([width - 1.0 if view.mirror else 0.0, 0.0])
        straight = lenses[name].straighten(at + mirror * uv + (u0, v0)) - (u0, v0)
        new["image_position"][:, i] = place.copy(data=at + mirror * straight).transpose(
            "time", "image_space", "keypoint", "individual"
        )
    return add_provenance(new, step="straighten", views=[n for n in names if n in lenses])


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

    Raises
    ------
    CalibrationError
        If the views disagree about more than a third of the points.
    """
    tracks = triangulate_tracks(tracks, rig, max_residual_px=MAX_RESIDUAL_PX, even=True)
    refused = json.loads(tracks.attrs["provenance"])["steps"][-1]["refused"]
    if refused:
        all_of_them = refused + int((tracks["origin"] != ORIGIN_CODE["missing"]).sum())
        said = f"as the views disagree about them by more than {MAX_RESIDUAL_PX:g} px"
        if refused > _MOST_REFUSED * all_of_them:  # else one view in px would stand in for space
            raise CalibrationError(
                f"{where}: {refused} of {all_of_them} points have no place in space, {said}. Is "
                "each file that of its view, and is the calibration that of these cameras, at this "
                "size of the picture? (pawnb calibrate --judge tells which camera does not belong.)"
            )
        text = f"{where}: {refused} of {all_of_them} points are left out in space, {said}."
        warn_of_input(text, InputWarning, stacklevel=3)
    return tell_moved_views(tracks, rig, where=where)


def _warn_of_doubtful(tracks: Tracks, where: str) -> None:
    """Say which digitised points the views disagree about most."""
    residual = tracks["residual"].to_numpy()
    doubtful = residual > MAX_RESIDUAL_PX
    if doubtful.any():
        time, point, _ = np.unravel_index(np.nanargmax(residual), residual.shape)
        warn_of_input(
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
        or trial.calibration.of_views is None
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
