"""What happens in a recording of the synthetic spider, frame by frame, before it is painted."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.pose.poses import Poses
from pawnb.errors import InputError
from pawnb.synthetic.spider_legs import LegBuilder
from pawnb.synthetic.spider_motion import COXA_HEIGHT, SpiderMotion, plan_motion
from pawnb.synthetic.spider_scene import (
    DRIFT_PX,
    EMPTY_FRAMES,
    FPS,
    FULL_WIDTH,
    PX_PER_MM,
    SHUTTER_S,
    Individual,
    SpiderScene,
)

_MARGIN_MM = 2.5
"""What hairs, palps and the outline of the body add to the joints."""


@dataclass(frozen=True)
class SpiderRecording:
    """What happens in a recording, in the n frames with the animal.

    Attributes
    ----------
    scene, individual, motion
        What is filmed.
    n_frames : int
        Number of all frames.
    poses : Poses
        The poses of the n frames.
    joints_px : ndarray (n, moments, legs, segments + 1, 2)
        Joints and tips at several moments of the exposure; the middle one is the frame's.
    bodies : ndarray (n, moments, 3)
        u, v in px and heading in degrees of the cephalothorax-abdomen joint.
    heights_mm : ndarray (n, moments, legs, segments + 1)
        Heights of joints and tips above the panel.
    body_heights_mm : ndarray (n, moments)
        Height of the cephalothorax-abdomen joint.
    whole : ndarray (n,) of bool
        Whether all of the animal is in view.
    """

    scene: SpiderScene
    individual: Individual
    motion: SpiderMotion
    n_frames: int
    poses: Poses
    joints_px: FloatArray
    bodies: FloatArray
    heights_mm: FloatArray
    body_heights_mm: FloatArray
    whole: BoolArray

    def middle(self, values: FloatArray) -> FloatArray:
        """Return values (n, moments, ...) at the middle of the exposure."""
        return np.asarray(values[:, values.shape[1] // 2])


def record_spider(scene: SpiderScene, individual: Individual, frames: int) -> SpiderRecording:
    """Plan the run and lay out every frame.

    Parameters
    ----------
    scene : SpiderScene
        The scene.
    individual : Individual
        The animal.
    frames : int
        Number of frames.

    Returns
    -------
    SpiderRecording
        Everything but the pictures.

    Raises
    ------
    InputError
        If no frame holds the whole animal.
    """
    motion = plan_motion(scene, individual, duration_s=frames / FPS)
    builder = LegBuilder(scene, individual)
    if scene.motion == "run":
        motion, times = _enter(scene, builder, motion, frames)
    else:
        motion, times = _hold(scene, builder, motion, frames)
    n, moments = times.shape
    posture = builder.posture(motion, times.ravel())
    px = posture.joints_mm[..., :2] * scene.px_per_mm - 0.5
    bodies = np.column_stack([posture.poses.xy, posture.poses.heading_deg])
    joints = px.reshape(n, moments, *px.shape[1:])
    heights = posture.joints_mm[..., 2].reshape(n, moments, *px.shape[1:-1])
    body_heights = individual.size * COXA_HEIGHT + motion.body.height(times)
    bodies = bodies.reshape(n, moments, 3)
    poses = posture.poses.take(slice(moments // 2, None, moments))
    numbers = np.arange(frames)
    if scene.motion == "drift":
        turn = scene.rng(8).uniform(0, 2 * np.pi)
        step = DRIFT_PX * np.array([np.cos(turn), np.sin(turn)])
        drift = (numbers - EMPTY_FRAMES)[:, None] * step
        joints = joints + drift[:, None, None, None]
        bodies[:, :, :2] += drift[:, None]
        poses = dataclasses.replace(poses, xy=poses.xy + drift)
    poses = dataclasses.replace(poses, frames=numbers)
    inside, whole = _in_view(scene, individual, joints[:, moments // 2], poses)
    here = inside & (numbers >= EMPTY_FRAMES)
    if not (here & whole).any():
        raise InputError(
            f"in {frames} frames the animal is never wholly in view; render more, for instance 120."
        )
    return SpiderRecording(
        scene=scene,
        individual=individual,
        motion=motion,
        n_frames=frames,
        poses=poses.take(here),
        joints_px=joints[here],
        bodies=bodies[here],
        heights_mm=heights[here],
        body_heights_mm=body_heights[here],
        whole=whole[here],
    )


def _moments(scene: SpiderScene) -> int:
    """Return at how many moments of the exposure the animal is drawn."""
    if scene.motion == "still":
        return 1
    return 7 if scene.scale > 0.7 else 5


def _enter(
    scene: SpiderScene, builder: LegBuilder, motion: SpiderMotion, frames: int
) -> tuple[SpiderMotion, FloatArray]:
    """Move the run so that its first foot comes into view just after the empty frames."""
    moments = _moments(scene)
    open_s = SHUTTER_S * ((np.arange(moments) + 0.5) / moments - 0.5)
    times = np.arange(frames)[:, None] / FPS + open_s
    before = builder.posture(motion, np.arange(EMPTY_FRAMES) / FPS)
    width = FULL_WIDTH / PX_PER_MM
    x = before.joints_mm[..., 0]
    towards = np.cos(np.radians(motion.body.heading_deg))
    by = -_MARGIN_MM - x.max() if towards > 0 else width + _MARGIN_MM - x.min()
    return motion.shifted(np.array([by, 0.0])), times


def _hold(
    scene: SpiderScene, builder: LegBuilder, motion: SpiderMotion, frames: int
) -> tuple[SpiderMotion, FloatArray]:
    """Hold one posture of the run in the middle of the picture."""
    at = float(scene.rng(8).uniform(0.0, 0.5 * frames / FPS))
    width = FULL_WIDTH / PX_PER_MM
    x = builder.posture(motion, np.array([at])).joints_mm[..., 0]
    by = width / 2.0 - 0.5 * (x.min() + x.max())
    return motion.shifted(np.array([by, 0.0])), np.full((frames, 1), at)


def _in_view(
    scene: SpiderScene, individual: Individual, joints: FloatArray, poses: Poses
) -> tuple[BoolArray, BoolArray]:
    """Return in which frames any part of the animal, and all of it, is in the picture."""
    turn = np.radians(poses.heading_deg)
    axis = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    ends = [
        part.centre[0] + sign * part.length / 2
        for part in individual.animal.body
        for sign in (-1, 1)
    ]
    body = [poses.xy + poses.scale[:, None] * end * axis for end in ends]
    points = np.concatenate([joints.reshape(len(joints), -1, 2), np.stack(body, axis=1)], axis=1)
    low, high = points.min(axis=1), points.max(axis=1)
    margin = _MARGIN_MM * scene.px_per_mm
    size = np.array([scene.width, scene.height])
    inside = ((high > -margin) & (low < size - 1 + margin)).all(axis=1)
    return inside, ((low > 0) & (high < size - 1)).all(axis=1)
