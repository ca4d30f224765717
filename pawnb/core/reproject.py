"""Points shown in the views that do not track them, from their place in space.

Haji Maghsoudi et al. 2019, section 4.2 and Fig. 8: a paw that the cameras of one side
track is remapped into those of the other side.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks, add_provenance, check_tracks

_FOUND_ORIGINS = [ORIGIN_CODE[name] for name in ("measured", "resolved", "edited")]


def reproject_tracks(
    tracks: Tracks, rig: Rig, *, sizes: Mapping[str, tuple[int, int]] | None = None
) -> Tracks:
    """Fill image positions that are missing with the projection of the position in space.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with image positions, and positions in the space of the rig.
    rig : Rig
        The calibrated views; others stay as they are.
    sizes : mapping, optional
        Width and height of each view's picture, px: what lies outside stays missing.

    Returns
    -------
    xarray.Dataset
        New Tracks. What was filled has ``image_origin`` ``reprojected`` and the confidence of
        the position in space. Only positions that were measured, resolved or put in place by
        hand are shown; what has an image position of its own keeps it. Positions that were
        reprojected before are made anew.

    Raises
    ------
    InputError
        If the tracks have no image positions or no positions in space.
    """
    new, filled = fill_reprojected(tracks, rig, sizes=sizes)
    views = [str(v) for v in tracks["view"].to_numpy() if str(v) in rig.names]
    return add_provenance(new, step="reproject", views=views, filled=filled)


def fill_reprojected(
    tracks: Tracks, rig: Rig, *, sizes: Mapping[str, tuple[int, int]] | None = None
) -> tuple[Tracks, int]:
    """Do as :func:`reproject_tracks`, without a record of it in the provenance.

    Parameters
    ----------
    tracks, rig, sizes
        See there.

    Returns
    -------
    tracks : xarray.Dataset
        New Tracks.
    filled : int
        Number of image positions that were filled.

    Raises
    ------
    InputError
        See there.
    """
    check_tracks(tracks)
    if "image_position" not in tracks or tracks.sizes["space"] != 3:
        raise InputError(
            "reprojection needs Tracks with image positions and with positions x, y, z in the "
            "space of a calibration."
        )
    views = [str(v) for v in tracks["view"].to_numpy() if str(v) in rig.names]
    points = ("time", "keypoint", "individual")
    xyz = tracks["position"].transpose(*points, "space").to_numpy()
    known = np.isin(tracks["origin"].transpose(*points).to_numpy(), _FOUND_ORIGINS)
    projected = rig.subset(views).project(np.where(known[..., None], xyz, np.nan))
    confidence = tracks["confidence"].transpose(*points).to_numpy()
    new = tracks.copy(deep=True)
    names = tracks["view"].to_numpy().tolist()
    filled = 0
    for k, view in enumerate(views):
        here = {"view": names.index(view)}
        uv = projected[..., k, :]
        shown = np.isfinite(uv).all(axis=-1)
        if sizes is not None:
            shown &= ((uv >= -0.5) & (uv < np.array(sizes[view]) - 0.5)).all(axis=-1)
        origin = new["image_origin"][here].transpose(*points).to_numpy()
        old = new["image_position"][here].transpose(*points, "image_space").to_numpy()
        free = ~np.isfinite(old).all(axis=-1) | (origin == ORIGIN_CODE["reprojected"])
        place = np.where((free & shown)[..., None], uv, np.nan)
        code = np.where(shown, ORIGIN_CODE["reprojected"], ORIGIN_CODE["missing"])
        sure = new["image_confidence"][here].transpose(*points).to_numpy()
        spread = np.where(shown, confidence, 0.0)
        for name, dims, values in (
            ("image_position", (*points, "image_space"), np.where(free[..., None], place, old)),
            ("image_origin", points, np.where(free, code, origin)),
            ("image_confidence", points, np.where(free, spread, sure)),
        ):
            new[name][here] = xr.Variable(dims, values)
        filled += int((free & shown).sum())
    return new, filled
