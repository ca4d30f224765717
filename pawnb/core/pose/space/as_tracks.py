"""Joints in space as Tracks."""

from __future__ import annotations

import numpy as np

from pawnb.arrays import BoolArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.as_tracks import by_point, point_names, tracks_from_poses
from pawnb.core.pose.space.parameters import IN_SPACE
from pawnb.core.pose.space.track import SpaceTrack
from pawnb.core.pose.track_result import PoseTrack
from pawnb.core.rig import Rig
from pawnb.schema import ORIGIN_CODE, Tracks, make_tracks


def tracks_in_space(
    animal: StickAnimal,
    track: PoseTrack,
    space: SpaceTrack,
    *,
    rig: Rig,
    fps: float,
    views: tuple[str, str],
    individual: str = "animal",
) -> Tracks:
    """Return joints in space as Tracks, with the pose in the first view.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    track : PoseTrack
        Its poses in the first view.
    space : SpaceTrack
        Its joints in space, row for row.
    rig : Rig
        The calibrated views.
    fps : float
        Frames per second.
    views : tuple of str
        The view of the poses, and the second.
    individual : str
        The animal's id.

    Returns
    -------
    xarray.Dataset
        Tracks with ``position`` and ``sd`` in the unit of the calibration. ``image_position``
        of the first view is what was tracked there; of the second, where the joints found in
        space appear. ``residual`` is the distance in px between the former and where the
        joint in space appears in the first view. A point is ``predicted`` in the second view
        and in space where that view shows less than half of its leg. The variables of the
        pose (``joint_angle`` and others) are those of :func:`tracks_from_poses`.
    """
    flat = tracks_from_poses(animal, track, fps=fps, view=views[0], individual=individual)
    tracks = make_tracks(
        track.poses.frames, point_names(animal), fps=fps, views=list(views),
        individual=individual, unit=rig.unit,
    )  # fmt: skip
    legs = len(animal.legs)
    of_point = np.array([*range(legs), *(i for i, leg in enumerate(animal.legs) for _ in leg.joints)])  # fmt: skip # noqa: E501
    support = np.nan_to_num(space.support)
    support = np.column_stack([support.max(axis=1, initial=0.0), support[:, of_point]])
    position = by_point(animal, space.body, space.joints)
    known = np.asarray(np.isfinite(position).all(axis=1))
    first = flat["origin"].to_numpy()[..., 0]
    second = np.where(support < IN_SPACE.shown, ORIGIN_CODE["predicted"], ORIGIN_CODE["measured"])
    both = np.where(first == ORIGIN_CODE["measured"], second, first)
    second, both = (np.where(known, o, ORIGIN_CODE["missing"]) for o in (second, both))
    sure = flat["confidence"].to_numpy()[..., 0]
    on_body = np.zeros((len(track), 1))
    residual = by_point(animal, on_body, space.residual_px[..., None])[:, 0]
    tracks["position"].to_numpy()[..., 0] = position
    tracks["origin"].to_numpy()[..., 0] = both
    tracks["confidence"].to_numpy()[..., 0] = np.where(known, np.minimum(sure, support), 0.0)
    tracks["residual"].to_numpy()[..., 0] = np.where(known, residual, np.nan)
    in_second = {
        "position": by_point(animal, space.body_uv, space.seen_uv),
        "confidence": np.where(known, support, 0.0),
        "origin": second,
    }
    for name, other in in_second.items():
        values = tracks[f"image_{name}"].to_numpy()
        values[:, 0] = flat[f"image_{name}"].to_numpy()[:, 0]
        values[:, 1, ..., 0] = other
    sd = by_point(animal, space.body_sd, space.joints_sd)[..., None]
    dims = ("time", "space", "keypoint", "individual")
    tracks = tracks.assign(sd=(dims, sd, {"units": rig.unit}))
    pose = ("joint_angle", "joint_angle_sd", "heading", "heading_sd", "scale", "segment_length")
    tracks = tracks.assign({name: flat[name] for name in pose})
    size = _size(animal, space, np.asarray(known.any(axis=1)))
    return tracks.assign_attrs(
        stick_animal=flat.attrs["stick_animal"], body_length=animal.body_length * size
    )


def _size(animal: StickAnimal, space: SpaceTrack, known: BoolArray) -> float:
    """Return units of the calibration in one of the species file, the median of known frames."""
    lengths = np.linalg.norm(np.diff(space.joints, axis=2), axis=-1)
    whole = np.nansum(lengths, axis=(1, 2))[known]
    return float(np.nanmedian(whole) / animal.lengths.sum())
