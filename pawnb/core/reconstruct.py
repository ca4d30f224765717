"""Positions in space for whole Tracks, from their image positions and a rig."""

from __future__ import annotations

import numpy as np

from pawnb.core.rig import Rig
from pawnb.errors import CalibrationError, InputError
from pawnb.schema import ORIGIN_CODE, Tracks, add_provenance


def triangulate_tracks(
    tracks: Tracks,
    rig: Rig,
    *,
    max_residual_px: float | None = None,
    refine: bool = False,
    even: bool = False,
) -> Tracks:
    """Fill the positions in space of Tracks from their image positions.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks with ``image_position``; views that the rig lacks are not used.
    rig : Rig
        The calibrated views.
    max_residual_px : float, optional
        Points whose RMS reprojection error is larger become ``missing`` in space; how
        many is written to the provenance.
    refine : bool
        Whether to minimise the reprojection error after the linear solution.
    even : bool
        Whether all views weigh alike: see :func:`pawnb.core.dlt.triangulate`.

    Returns
    -------
    xarray.Dataset
        New Tracks with ``position`` in the unit of the rig, ``residual`` in px, ``origin``
        (``measured`` or ``missing``), and ``confidence`` (mean of the views used).

    Raises
    ------
    InputError
        If there are no image positions in space of three dimensions.
    CalibrationError
        If fewer than two views of the tracks are calibrated.
    """
    if "image_position" not in tracks or tracks.sizes.get("space") != 3:
        raise InputError(
            "triangulation needs Tracks with image positions of several views and space x, y, z."
        )
    views = [str(v) for v in tracks["view"].values if str(v) in rig.names]
    if len(views) < 2:
        raise CalibrationError(
            f"{len(views)} of the views {', '.join(map(str, tracks['view'].values))} are in the "
            f"calibration ({', '.join(rig.names)}); at least 2 are needed."
        )
    part = tracks.sel(view=views)
    order = ("time", "keypoint", "individual", "view", "image_space")
    uv = part["image_position"].transpose(*order).to_numpy()
    found = rig.subset(views).triangulate(uv, refine=refine, even=even)
    limit = np.inf if max_residual_px is None else max_residual_px
    too_far = found.residual_px > limit
    good = np.isfinite(found.residual_px) & ~too_far
    seen = np.isfinite(uv).all(axis=-1)
    confidence = part["image_confidence"].transpose(*order[:-1]).to_numpy()
    total = np.where(seen, confidence, 0.0).sum(axis=-1) / np.maximum(found.n_views, 1)
    dims = ("time", "keypoint", "individual")
    result = tracks.copy()
    result["position"] = (
        ("time", "space", "keypoint", "individual"),
        np.moveaxis(np.where(good[..., None], found.xyz, np.nan), -1, 1),
        {**tracks["position"].attrs, "units": rig.unit},
    )
    result["residual"] = (dims, np.where(good, found.residual_px, np.nan), {"units": "px"})
    result["confidence"] = (dims, np.where(good, total, 0.0), tracks["confidence"].attrs)
    origin = np.where(good, ORIGIN_CODE["measured"], ORIGIN_CODE["missing"]).astype(np.int8)
    result["origin"] = (dims, origin, tracks["origin"].attrs)
    result.attrs["units"] = rig.unit
    return add_provenance(
        result, step="triangulate", views=views, max_residual_px=max_residual_px,
        refused=int(too_far.sum()),
    )  # fmt: skip
