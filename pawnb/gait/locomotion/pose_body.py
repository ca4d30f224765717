"""Body and legs of a jointed animal whose pose was tracked: its own heading, its leg angles."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pandas as pd

from pawnb.arrays import FloatArray
from pawnb.errors import InputError
from pawnb.gait.legs import sort_legs
from pawnb.gait.locomotion.body import BodyPoints
from pawnb.gait.locomotion.foot_trajectories import FootPaths, get_foot_paths
from pawnb.schema import Tracks, check_tracks
from pawnb.schema.arguments import checked_arguments

BODY_POINTS = "body"
"""Name of the point at the body's origin."""


def leg_roots(points: Sequence[str]) -> dict[str, str]:
    """Return the joint at the body of each leg of a jointed animal, such as ``L1.BC`` of ``L1``.

    It is the first of the leg's joints: they stand from the body outwards, and a species file may
    name them otherwise.
    """
    roots: dict[str, str] = {}
    for point in points:
        leg, dot, _ = point.partition(".")
        if dot and leg in points:
            roots.setdefault(leg, point)
    return roots


@checked_arguments
def leg_angles(tracks: Tracks, *, individual: str | None = None) -> pd.DataFrame:
    """Return the total angle of every leg in every frame (Pullar 2009, §3.6).

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of a jointed animal.
    individual : str, optional
        Which animal; default the first.

    Returns
    -------
    pandas.DataFrame
        ``frame, time_s, leg, leg_angle`` (degrees: of tarsus, body-coxa joint and contralateral
        body-coxa joint, 0 where perpendicular to the body, positive forwards), leg by leg; NaN
        where a leg was not tracked.

    Raises
    ------
    InputError
        If the Tracks hold no pose.

    Examples
    --------
    >>> angles = pawnb.gait.leg_angles(tracks)
    >>> sorted(angles["leg"].unique())
    ['L1', 'L2', 'L3', 'L4', 'R1', 'R2', 'R3', 'R4']
    """
    check_tracks(tracks)
    who = individual or str(tracks["individual"].to_numpy()[0])
    points = [str(point) for point in tracks["keypoint"].to_numpy()]
    legs = sort_legs(leg_roots(points))
    feet = get_foot_paths(tracks, {leg: leg for leg in legs}, individual=who)
    posed = pose_body(tracks, feet[0], individual=who) if feet else None
    if posed is None or posed[1].angle_deg is None:
        raise InputError(
            f"these tracks hold no pose: leg angles need a heading, the point {BODY_POINTS!r} and "
            "body-coxa joints such as L1.BC."
        )
    frame, time = tracks["frame"].to_numpy(), tracks["time"].to_numpy()
    return pd.concat(
        [
            pd.DataFrame({"frame": frame, "time_s": time, "leg": leg, "leg_angle": angle})
            for leg, angle in zip(posed[1].legs, posed[1].angle_deg.T, strict=True)
        ],
        ignore_index=True,
    )


def pose_body(
    dense: Tracks, feet: FootPaths, *, individual: str
) -> tuple[BodyPoints, FootPaths] | None:
    """Take body and leg angles from the pose.

    Parameters
    ----------
    dense : xarray.Dataset
        Tracks on the grid, with ``heading``, a point ``body`` and the joints of the legs
        (``<leg>.BC``; the first of a leg is where it meets the body).
    feet : FootPaths
        The feet in one space of these Tracks.
    individual : str
        Which animal.

    Returns
    -------
    body : BodyPoints
        The origin of the body's frame, and a point one unit in front of it.
    feet : FootPaths
        The same feet with ``angle_deg``: the total leg angle of Pullar 2009, §3.6 (tarsus,
        body-coxa joint, contralateral body-coxa joint; 0 where perpendicular to the body,
        positive forwards).

    Notes
    -----
    None is returned where the Tracks hold no pose, or not in the space of the feet.
    """
    points = [str(point) for point in dense["keypoint"].to_numpy()]
    known = leg_roots(points)
    if "heading" not in dense or BODY_POINTS not in points or not set(feet.legs) <= set(known):
        return None
    roots = {leg: known[leg] for leg in feet.legs}
    body = _in_space(dense, {BODY_POINTS: BODY_POINTS}, feet.source, individual)
    root = _in_space(dense, roots, feet.source, individual)
    if body is None or root is None:
        return None
    heading = np.radians(dense["heading"].sel(individual=individual).to_numpy().astype(float))
    front = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    origin = body[:, :, 0]
    tips = feet.positions
    ahead_of = front
    if body.shape[1] == 3:
        # angles are those seen in the view of the pose, as with one view
        seen = _in_picture(dense, {BODY_POINTS: BODY_POINTS, **roots}, individual)
        ahead_of = _forward_in_space(seen, np.concatenate([body, root], axis=-1), front)
        body, root = seen[:, :, :1], seen[:, :, 1:]
        tips = _in_picture(dense, {leg: leg for leg in feet.legs}, individual)
    ahead = BodyPoints(
        points=np.stack([origin, origin + ahead_of], axis=-1),
        names=(BODY_POINTS, "heading"),
        guessed=False,
    )
    # y is down: to the right of the heading the cross product is positive
    out = root - body
    side = np.sign(np.nanmedian(front[:, :1] * out[:, 1] - front[:, 1:] * out[:, 0], axis=0))
    reach = tips - root
    forwards = np.einsum("ndk,nd->nk", reach, front)
    outwards = side * (front[:, :1] * reach[:, 1] - front[:, 1:] * reach[:, 0])
    angle = np.degrees(np.arctan2(forwards, outwards))
    return ahead, dataclasses.replace(feet, angle_deg=angle)


def _in_picture(dense: Tracks, points: dict[str, str], individual: str) -> np.ndarray:
    """Return points (n, 2, k) in the first view, in the order given."""
    one = dense["image_position"].sel(individual=individual).isel(view=0)
    one = one.sel(keypoint=list(points.values()))
    return np.asarray(one.transpose("time", "image_space", "keypoint").to_numpy(), dtype=float)


def _forward_in_space(seen: np.ndarray, places: np.ndarray, front: np.ndarray) -> np.ndarray:
    """Return the body's direction in space, (n, 3), unit length.

    The points of the body, ``seen`` (n, 2, k) in the picture and at ``places`` (n, 3, k), say how
    a step in the picture goes on in space; NaN where they are not known.
    """
    flat = seen - seen.mean(axis=2, keepdims=True)
    solid = places - places.mean(axis=2, keepdims=True)
    known = np.isfinite(flat).all(axis=(1, 2)) & np.isfinite(solid).all(axis=(1, 2))
    out = np.full((len(seen), 3), np.nan)
    square = np.einsum("nik,njk->nij", flat[known], flat[known])
    cross = np.einsum("nik,njk->nij", flat[known], solid[known])
    step = np.linalg.solve(square, cross)
    ahead = np.einsum("ni,nij->nj", front[known], step)
    out[known] = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    return out


def _in_space(
    dense: Tracks, points: dict[str, str], source: str, individual: str
) -> FloatArray | None:
    """Return points (n, d, k) in one space, in the order given, or None."""
    for space in get_foot_paths(dense, points, individual=individual):
        if space.source == source and set(space.legs) == set(points):
            return space.positions[:, :, [space.legs.index(name) for name in points]]
    return None
