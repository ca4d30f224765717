"""The legs of the synthetic spider in space: joints from the place of body and foot.

A leg lies in an arch: coxa and femur rise from the body, tibia, metatarsus and tarsus fall to
the ground. Seen from above, a segment is as long as its tilt leaves it. In the plane of the
picture the leg bends at the free joints of the species file by angles that follow the
stride; the body-coxa joint then turns the leg so that its tip is on the foot's place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import Leg
from pawnb.core.pose.poses import Poses
from pawnb.errors import InputError
from pawnb.synthetic.spider_motion import COXA_HEIGHT, SpiderMotion
from pawnb.synthetic.spider_scene import Individual, SpiderScene

# tilt of each segment above the horizontal: a fixed part in degrees, a share of the rise
# (unknown 1) and a share of the knee's bend downwards (unknown 2)
_FIXED = np.array([5.0, -8.0, 0.0, 0.0, 0.0, 0.0, 0.0])
_OF_RISE = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
_OF_BEND = np.array([0.0, 0.0, 0.0, 0.5, 0.9, 1.0, 1.05])
_STEPS = 30
_CLOSE = 1e-11

# bends in the plane of the picture, degrees, positive forwards: mean, change per 20 degrees
# of the leg's angle, change when the foot is fully lifted
_BENDS = {
    "1": {
        "CT": (3.0, 7.0, 4.0), "PT": (-5.0, 6.0, 4.0), "TM": (-1.0, 1.0, 0.5),
        "MT": (-4.0, 5.0, -9.0),
    },
    "2": {
        "CT": (5.0, 8.0, 4.0), "PT": (-4.0, 6.0, 4.0), "TM": (-0.5, 1.0, 0.5),
        "MT": (-3.0, 6.0, -9.0),
    },
    "3": {
        "CT": (0.0, 5.0, 3.0), "PT": (1.0, 4.0, 3.0), "TM": (0.0, 1.0, 0.5),
        "MT": (2.0, 6.0, -8.0),
    },
    "4": {
        "CT": (-8.0, 4.0, 3.0), "PT": (-1.0, 2.0, 1.0), "TM": (0.0, 0.7, 0.5),
        "MT": (2.0, 5.0, -8.0),
    },
}  # fmt: skip
_OWN_BEND_DEG = 1.5
"""Standard deviation of the mean bend of a joint from one leg to the next."""


@dataclass(frozen=True)
class Posture:
    """The animal at n moments.

    Attributes
    ----------
    poses : Poses
        The pose in the picture; frames are 0 to n - 1.
    joints_mm : ndarray (n, legs, segments + 1, 3)
        Joints and tips in the arena, Z above the panel.
    """

    poses: Poses
    joints_mm: FloatArray


class LegBuilder:
    """Puts the legs of one individual to the feet of its run.

    Parameters
    ----------
    scene : SpiderScene
        The scene.
    individual : Individual
        The animal.
    """

    def __init__(self, scene: SpiderScene, individual: Individual) -> None:
        self._scene = scene
        self._individual = individual
        rng = scene.rng(3)
        self._own = {
            leg.name: {
                joint: _OWN_BEND_DEG * np.clip(rng.standard_normal(), -2, 2)
                for joint in ("CT", "PT", "TM", "MT")
            }
            for leg in individual.animal.legs
        }

    def posture(self, motion: SpiderMotion, t: FloatArray) -> Posture:
        """Return the posture at times ``t`` in s, shape (n,).

        Raises
        ------
        InputError
            If a foot is out of its leg's reach.
        """
        scene, individual = self._scene, self._individual
        heading, place = motion.body.heading(t), motion.body.place(t)
        angles, lengths, joints = [], [], []
        for leg in individual.animal.legs:
            turns, flat, points = self._leg(leg, motion, t)
            angles.append(turns[:, leg.free])
            lengths.append(flat)
            joints.append(points)
        poses = Poses(
            frames=np.arange(len(t)),
            xy=place * scene.px_per_mm - 0.5,
            heading_deg=heading,
            scale=np.full(len(t), individual.size * scene.px_per_mm),
            angles_deg=np.concatenate(angles, axis=1),
            lengths_px=np.concatenate(lengths, axis=1) * scene.px_per_mm,
        )
        return Posture(poses, np.stack(joints, axis=1))

    def _leg(
        self, leg: Leg, motion: SpiderMotion, t: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return turns (n, joints) in degrees, projected lengths and joints of one leg in mm."""
        lengths = self._individual.size * np.array(leg.lengths)
        foot = motion.feet[leg.name].place(t)
        root = motion.body.to_arena(t, np.broadcast_to(motion.coxae_mm[leg.name], (len(t), 2)))
        height = self._individual.size * COXA_HEIGHT + motion.body.height(t)
        turns = self._bends(leg, motion, t)
        # directions of the segments in the picture with the coxa straight out, forwards positive
        bent = np.radians(np.cumsum(turns, axis=1))
        reach = foot[:, :2] - root
        tilt = _solve_arch(lengths, bent, np.hypot(*reach.T), foot[:, 2] - height)
        if tilt is None:
            raise InputError(f"the foot of {leg.name} is out of reach in this scene.")
        flat = lengths * np.cos(tilt)
        sideways = (flat * np.exp(1j * bent)).sum(axis=1)
        heading = motion.body.heading(t)
        towards = np.degrees(np.arctan2(reach[:, 1], reach[:, 0]))
        forwards = 90.0 - leg.side * (towards - heading) - np.degrees(np.angle(sideways))
        turns[:, 0] = (forwards + 180.0) % 360.0 - 180.0
        direction = np.radians(heading[:, None] + leg.side * (90.0 - np.cumsum(turns, axis=1)))
        steps = np.stack(
            [flat * np.cos(direction), flat * np.sin(direction), lengths * np.sin(tilt)], axis=-1
        )
        first = np.concatenate([root, height[:, None]], axis=1)[:, None]
        return turns, flat, np.concatenate([first, first + np.cumsum(steps, axis=1)], axis=1)

    def _bends(self, leg: Leg, motion: SpiderMotion, t: FloatArray) -> FloatArray:
        """Return the turns of the joints beyond the first, (n, joints), degrees."""
        foot = motion.feet[leg.name]
        lifted = foot.place(t)[:, 2] / foot.lift_mm
        swing = (motion.leg_angle(leg.name, t) - leg.natural_deg[0]) / 20.0
        turns = np.tile(leg.natural_deg, (len(t), 1)).astype(float)
        turns[:, 0] = 0.0
        for joint, (mean, by_swing, by_lift) in _BENDS[leg.name[1]].items():
            j = leg.joints.index(joint)
            change = by_swing * np.tanh(swing) + by_lift * lifted
            bend = mean + self._own[leg.name][joint] + self._scene.bend_share * change
            end = 0.5 * leg.range_deg[j]
            # bends stay within the joint's range, softly
            turns[:, j] = leg.natural_deg[j] + end * np.tanh(bend / end)
        return turns


def _solve_arch(
    lengths: FloatArray, bent: FloatArray, reach: FloatArray, drop: FloatArray
) -> FloatArray | None:
    """Return the tilt of each segment (n, segments) in rad that takes the tip to the foot.

    Newton's method for the rise and the knee's bend; ``reach`` is the horizontal distance of
    the foot and ``drop`` its height, both from the body-coxa joint. None where there is no
    solution.
    """
    turn = np.exp(1j * bent)
    whole = lengths.sum()
    rise = np.arccos(np.clip(0.9 * reach / whole, 0.1, 0.99))
    bend = 1.7 * rise
    for _ in range(_STEPS):
        tilt = np.radians(_FIXED) + rise[:, None] * _OF_RISE - bend[:, None] * _OF_BEND
        out, up = lengths * np.cos(tilt), lengths * np.sin(tilt)
        flat = (out * turn).sum(axis=1)
        wrong = np.stack([np.abs(flat) - reach, up.sum(axis=1) - drop])
        if np.abs(wrong).max() < _CLOSE:
            return np.asarray(tilt) if np.abs(tilt).max() < np.pi / 2 else None
        slope = [
            (flat.conj() * (-(up * share) * turn).sum(axis=1)).real / np.abs(flat)
            for share in (_OF_RISE, -_OF_BEND)
        ]
        lift = [(out * share).sum(axis=1) for share in (_OF_RISE, -_OF_BEND)]
        det = slope[0] * lift[1] - slope[1] * lift[0]
        step_rise = (wrong[0] * lift[1] - wrong[1] * slope[1]) / det
        step_bend = (wrong[1] * slope[0] - wrong[0] * lift[0]) / det
        rise = rise - np.clip(step_rise, -0.3, 0.3)
        bend = bend - np.clip(step_bend, -0.3, 0.3)
    return None
