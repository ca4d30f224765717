"""Pose tracks as Tracks, the currency of the other parts, and back.

The points are ``body``, the tips (``L1``) and the joints (``L1.CT``). The angles travel beside
them as variables along ``joint``, with heading, scale and projected lengths; the animal itself
is the attribute ``stick_animal``, so that a ``tracks.nc`` can be read without its species file.
"""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np

from pawnb.arrays import AnyArray, FloatArray, IntArray
from pawnb.core.pose.animal import Ellipse, Leg, StickAnimal
from pawnb.core.pose.poses import Poses, joint_positions
from pawnb.core.pose.track_result import PoseTrack
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, Tracks, check_tracks, make_tracks

BODY_POINT = "body"
"""Name of the point at the origin of the body's frame."""


def point_names(animal: StickAnimal) -> tuple[str, ...]:
    """Return the points of an animal's Tracks: body, tips, then the joints leg by leg."""
    joints = [f"{leg.name}.{joint}" for leg in animal.legs for joint in leg.joints]
    return (BODY_POINT, *animal.leg_names, *joints)


def tracks_from_poses(
    animal: StickAnimal,
    track: PoseTrack,
    *,
    fps: float,
    view: str,
    individual: str = "animal",
    px_per_unit: float | None = None,
    unit: str = "px",
) -> Tracks:
    """Return a pose track as Tracks.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    track : PoseTrack
        Its poses.
    fps : float
        Frames per second.
    view : str
        Name of the view.
    individual : str
        The animal's id.
    px_per_unit : float, optional
        Scale of the view; ``position`` and ``sd`` are in ``unit`` with it, in px without.
    unit : str
        Unit of length.

    Returns
    -------
    xarray.Dataset
        Tracks (x to the right, y down), with ``joint_angle`` and ``joint_angle_sd`` (time,
        joint, individual) in degrees, ``heading`` and ``heading_sd`` (time, individual) in
        degrees, ``scale`` (time, individual) in px per unit of the species file and
        ``segment_length`` (time, segment, individual) in px. ``sd`` is there where the
        method tells it.
    """
    poses, legs = track.poses, animal.legs
    tracks = make_tracks(
        poses.frames,
        point_names(animal),
        fps=fps,
        views=[view],
        space=("x", "y"),
        individual=individual,
        unit="px" if px_per_unit is None else unit,
    )
    places = by_point(animal, poses.xy, joint_positions(animal, poses))
    sd = by_point(animal, track.xy_sd_px, track.places_sd_px)
    leg_of_point = np.array(
        [*range(len(legs)), *(i for i, leg in enumerate(legs) for _ in leg.joints)]
    )
    confidence = np.column_stack(
        [track.confidence.max(axis=1, initial=0.0), track.confidence[:, leg_of_point]]
    )
    origin = np.column_stack([_best_origin(track.origin), track.origin[:, leg_of_point]])
    factor = 1.0 if px_per_unit is None else 1.0 / px_per_unit
    missing = (origin == ORIGIN_CODE["missing"])[:, None]
    places = np.where(missing, np.nan, places)
    tracks["position"].to_numpy()[..., 0] = places * factor
    tracks["image_position"].to_numpy()[:, 0, :, :, 0] = places
    for prefix, at in (("", ...), ("image_", (slice(None), 0))):
        tracks[f"{prefix}confidence"].to_numpy()[at][..., 0] = confidence
        tracks[f"{prefix}origin"].to_numpy()[at][..., 0] = origin
    tracks = _with_pose(tracks, animal, track)
    if np.isfinite(sd).any():
        dims = ("time", "space", "keypoint", "individual")
        tracks = tracks.assign(sd=(dims, sd[..., None] * factor, {"units": tracks.attrs["units"]}))
    if px_per_unit is not None:
        tracks = tracks.assign_attrs(px_per_unit=float(px_per_unit))
    body_length = animal.body_length * float(np.nanmedian(poses.scale)) * factor
    tracks = tracks.assign_attrs(body_length=body_length)
    return tracks.assign_attrs(stick_animal=json.dumps(_document(animal), sort_keys=True))


def _with_pose(tracks: Tracks, animal: StickAnimal, track: PoseTrack) -> Tracks:
    """Return Tracks with angles, heading, scale and lengths of segments."""
    poses, degrees = track.poses, {"units": "degrees"}
    joint, segment = ("time", "joint", "individual"), ("time", "segment", "individual")
    tracks = tracks.assign_coords(joint=list(animal.joints), segment=list(animal.segments))
    return tracks.assign(
        joint_angle=(joint, poses.angles_deg[..., None], degrees),
        joint_angle_sd=(joint, track.angles_sd_deg[..., None], degrees),
        heading=(("time", "individual"), poses.heading_deg[:, None], degrees),
        heading_sd=(("time", "individual"), track.heading_sd_deg[:, None], degrees),
        scale=(("time", "individual"), poses.scale[:, None], {"units": f"px/{animal.unit}"}),
        segment_length=(segment, poses.lengths_px[..., None], {"units": "px"}),
    )


def is_pose(tracks: Tracks) -> bool:
    """Say whether Tracks are those of a jointed animal, with all that :func:`poses_of` needs."""
    return "stick_animal" in tracks.attrs and "joint_angle" in tracks


def animal_of(tracks: Tracks) -> StickAnimal:
    """Return the stick animal that Tracks carry; raises InputError where they carry none."""
    if not is_pose(tracks):
        raise InputError("these tracks hold points only; expected those of a jointed animal.")
    document: dict[str, Any] = json.loads(tracks.attrs["stick_animal"])
    parts = {"body": Ellipse, "legs": Leg}
    for name, cls in parts.items():
        document[name] = tuple(
            cls(**{k: tuple(v) if isinstance(v, list) else v for k, v in item.items()})
            for item in document[name]
        )
    return StickAnimal(**document)


def poses_of(tracks: Tracks) -> PoseTrack:
    """Return the pose track that Tracks hold: the inverse of :func:`tracks_from_poses`.

    Parameters
    ----------
    tracks : xarray.Dataset
        Tracks of one jointed animal.

    Returns
    -------
    PoseTrack
        The poses of the first individual, px of the view.

    Raises
    ------
    InputError
        If these are not Tracks, or not of a jointed animal.
    """
    check_tracks(tracks)
    animal = animal_of(tracks)
    one = tracks.isel(individual=0)
    n, most = one.sizes["time"], max(len(leg.segments) for leg in animal.legs)
    image = one["image_position"].isel(view=0).transpose("time", "keypoint", "image_space")
    points = [str(name) for name in one["keypoint"].to_numpy()]
    sd = np.full((n, len(animal.legs), most + 1, 2), np.nan)
    xy_sd = np.full((n, 2), np.nan)
    # in space it is not that of the view's px
    if "sd" in one and one.sizes["space"] == 2:
        px = float(one.attrs.get("px_per_unit", 1.0))
        values = one["sd"].transpose("time", "keypoint", "space").to_numpy() * px
        xy_sd = values[:, points.index(BODY_POINT)]
        for i, leg in enumerate(animal.legs):
            names = [*(f"{leg.name}.{joint}" for joint in leg.joints), leg.name]
            sd[:, i, : len(names)] = values[:, [points.index(name) for name in names]]
    tips = [points.index(name) for name in animal.leg_names]
    seen = ("confidence", "origin")
    if one.sizes["space"] == 3:
        seen = ("image_confidence", "image_origin")
        one = one.isel(view=0)
    confidence, origin = (one[name].transpose("time", "keypoint").to_numpy() for name in seen)
    return PoseTrack(
        poses=Poses(
            frames=one["frame"].to_numpy(),
            xy=image.to_numpy()[:, points.index(BODY_POINT)],
            heading_deg=one["heading"].to_numpy(),
            scale=one["scale"].to_numpy(),
            angles_deg=one["joint_angle"].transpose("time", "joint").to_numpy(),
            lengths_px=one["segment_length"].transpose("time", "segment").to_numpy(),
        ),
        xy_sd_px=xy_sd,
        heading_sd_deg=one["heading_sd"].to_numpy(),
        angles_sd_deg=one["joint_angle_sd"].transpose("time", "joint").to_numpy(),
        places_sd_px=sd,
        confidence=confidence[:, tips],
        origin=origin[:, tips],
    )


def by_point(animal: StickAnimal, body: FloatArray, places: FloatArray) -> AnyArray:
    """Return values of body and joints in the order of :func:`point_names`.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    body : ndarray, shape (n, d)
        Values of the body.
    places : ndarray, shape (n, n_legs, most segments + 1, d)
        Values of joints and tips.

    Returns
    -------
    ndarray, shape (n, d, n_points)
        The values.
    """
    tips = [places[:, i, len(leg.segments)] for i, leg in enumerate(animal.legs)]
    joints = [
        places[:, i, j] for i, leg in enumerate(animal.legs) for j in range(len(leg.segments))
    ]
    return np.stack([body, *tips, *joints], axis=-1)


def _best_origin(origin: IntArray) -> IntArray:
    """Return the origin of the body: measured where any leg is, else that of the legs."""
    measured = (origin == ORIGIN_CODE["measured"]).any(axis=1)
    known = origin.max(axis=1, initial=ORIGIN_CODE["missing"])
    return np.where(measured, ORIGIN_CODE["measured"], known).astype(np.int8)


def _document(animal: StickAnimal) -> dict[str, Any]:
    """Return an animal as plain values."""
    values = dataclasses.asdict(animal)
    return {name: value for name, value in values.items() if name not in ("joints", "segments")}
