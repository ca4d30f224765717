"""A spider that walks: poses made by hand for tests of what comes after a tracker."""

import numpy as np

from pawnb.core.pose.poses import Poses
from pawnb.core.pose.track_result import PoseTrack, plain_track


def walking_poses(animal, n=40, *, scale=2.4, first=5, frequency=0.05):
    """Return n frames of an animal that runs to the lower right and swings its legs.

    The first joint of each leg follows a sine of 10 degrees, each leg a twentieth of a
    cycle behind the one before.
    """
    t = np.arange(n)
    heading = np.full(n, 30.0) + 2.0 * np.sin(2 * np.pi * t / 60)
    path = np.array([120.0, 90.0]) + np.outer(t, [1.3, 0.75])
    angles = np.tile(animal.natural_deg, (n, 1))
    for i, leg in enumerate(animal.legs):
        first_joint = next(joint for joint, free in zip(leg.joints, leg.free, strict=True) if free)
        column = animal.joints.index(f"{leg.name}_{first_joint}")
        angles[:, column] += 10 * np.sin(2 * np.pi * (frequency * t + 0.05 * i))
    shorter = 1.0 - 0.1 * np.abs(np.sin(np.arange(len(animal.lengths))))
    return Poses(
        frames=first + t,
        xy=path,
        heading_deg=heading,
        scale=np.full(n, scale),
        angles_deg=angles,
        lengths_px=np.tile(scale * animal.lengths * shorter, (n, 1)),
    )


def uncertain_track(animal, poses, seed=0):
    """Return a track of these poses in which every number of the uncertainty differs."""
    rng = np.random.default_rng(seed)
    plain = plain_track(animal, poses)
    noise = {
        name: rng.uniform(0.1, 2.0, getattr(plain, name).shape)
        for name in ("xy_sd_px", "heading_sd_deg", "angles_sd_deg", "places_sd_px")
    }
    for i, leg in enumerate(animal.legs):
        noise["places_sd_px"][:, i, len(leg.segments) + 1 :] = np.nan
    confidence = rng.uniform(0, 1, plain.confidence.shape)
    origin = rng.integers(1, 3, plain.origin.shape).astype(np.int8)
    return PoseTrack(poses=poses, confidence=confidence, origin=origin, **noise)
