"""What a pose tracker returns: poses with their uncertainty, confidence and origin."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pawnb.arrays import AnyArray, FloatArray, IntArray
from pawnb.core.pose.animal import StickAnimal
from pawnb.core.pose.poses import Poses, join_poses
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, ORIGINS


@dataclass(frozen=True, kw_only=True)
class PoseTrack:
    """The tracked poses of one animal in n frames.

    Standard deviations are NaN where the method has none.

    Parameters
    ----------
    poses : Poses
        The poses, frames ascending.
    xy_sd_px : ndarray, shape (n, 2)
        Standard deviation of ``poses.xy``, px.
    heading_sd_deg : ndarray, shape (n,)
        Standard deviation of the heading, degrees.
    angles_sd_deg : ndarray, shape (n, n_joints)
        Standard deviation of the free joints, degrees.
    places_sd_px : ndarray, shape (n, n_legs, most segments + 1, 2)
        Standard deviation of the places of joints and tips, as ``joint_positions`` gives
        them, px.
    confidence : ndarray, shape (n, n_legs)
        How well each leg is explained by the picture, 0 to 1.
    origin : ndarray of int8, shape (n, n_legs)
        Codes of :data:`pawnb.schema.ORIGIN_CODE`: ``measured`` where the picture placed the
        leg, ``predicted`` where only its motion and its neighbours did.
    estimated : mapping
        What the method estimated by itself, for the provenance: names to plain values.

    Raises
    ------
    InputError
        If the shapes do not belong together, frames do not ascend, or a code is unknown.
    """

    poses: Poses
    xy_sd_px: FloatArray
    heading_sd_deg: FloatArray
    angles_sd_deg: FloatArray
    places_sd_px: FloatArray
    confidence: FloatArray
    origin: IntArray
    estimated: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n, joints = self.poses.angles_deg.shape
        legs = self.confidence.shape[-1]
        most = self.places_sd_px.shape[2] if self.places_sd_px.ndim == 4 else 0
        for name, shape in {
            "xy_sd_px": (n, 2),
            "heading_sd_deg": (n,),
            "angles_sd_deg": (n, joints),
            "places_sd_px": (n, legs, most, 2),
            "confidence": (n, legs),
            "origin": (n, legs),
        }.items():
            found = getattr(self, name).shape
            if found != shape:
                raise InputError(f"pose track: {name} has shape {found}; expected {shape}.")
        if n > 1 and (np.diff(self.poses.frames) <= 0).any():
            raise InputError("pose track: frames do not ascend; sort them.")
        if n and not (self.origin.min() >= 0 and self.origin.max() < len(ORIGINS)):
            raise InputError(f"pose track: an origin is none of the codes 0 to {len(ORIGINS) - 1}.")

    def __len__(self) -> int:
        return len(self.poses)

    def take(self, which: IntArray | slice) -> PoseTrack:
        """Return some of the frames: an index array, a mask or a slice."""
        rest = {name: getattr(self, name)[which] for name in _ARRAYS}
        return PoseTrack(poses=self.poses.take(which), estimated=self.estimated, **rest)


_ARRAYS = tuple(
    f.name for f in dataclasses.fields(PoseTrack) if f.name not in ("poses", "estimated")
)


def plain_track(
    animal: StickAnimal,
    poses: Poses,
    *,
    confidence: AnyArray | float = 1.0,
    origin: AnyArray | str = "measured",
) -> PoseTrack:
    """Return a track without uncertainties.

    Parameters
    ----------
    animal : StickAnimal
        The animal.
    poses : Poses
        Its poses, frames ascending.
    confidence : ndarray, shape (n, n_legs), or float
        Confidence of each leg.
    origin : ndarray of int8, shape (n, n_legs), or str
        Codes, or one word of :data:`pawnb.schema.ORIGINS` for all.

    Returns
    -------
    PoseTrack
        The track; standard deviations are NaN.
    """
    n, joints, legs = len(poses), len(animal.joints), len(animal.legs)
    most = max(len(leg.segments) for leg in animal.legs)
    codes = np.asarray(ORIGIN_CODE[origin] if isinstance(origin, str) else origin, dtype=np.int8)
    return PoseTrack(
        poses=poses,
        xy_sd_px=np.full((n, 2), np.nan),
        heading_sd_deg=np.full(n, np.nan),
        angles_sd_deg=np.full((n, joints), np.nan),
        places_sd_px=np.full((n, legs, most + 1, 2), np.nan),
        confidence=np.broadcast_to(np.asarray(confidence, dtype=float), (n, legs)).copy(),
        origin=np.broadcast_to(codes, (n, legs)).copy(),
    )


def join_tracks(parts: list[PoseTrack]) -> PoseTrack:
    """Return tracks of several stretches in one, in the order given.

    What was ``estimated`` is that of the first.
    """
    joined = {name: np.concatenate([getattr(p, name) for p in parts]) for name in _ARRAYS}
    return PoseTrack(
        poses=join_poses([p.poses for p in parts]), estimated=parts[0].estimated, **joined
    )
