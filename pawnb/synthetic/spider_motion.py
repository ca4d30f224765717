"""How the synthetic spider moves: its body along the arena, its feet stride by stride.

Everything is a smooth function of time, so that events are known to any fraction of a frame.
A foot that stands does not move at all. Phases are those of Pullar 2009, §4.2.4; stride
frequency and duty factor follow Table 4.5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pawnb.arrays import FloatArray
from pawnb.core.pose.animal import Leg
from pawnb.synthetic.spider_scene import (
    ARENA_WIDTH_MM,
    FULL_HEIGHT,
    PX_PER_MM,
    Individual,
    SpiderScene,
)

# AEP of each leg in cycles after that of R4 (§4.2.4, summed from the adjacent ipsilateral
# pairs and R4): L3 is 0.493 after L4, and so on. The contralateral pairs then follow within
# 0.03 of the printed ones.
_GAIT_PHASE = {
    "R4": 0.0, "R3": 0.512, "R2": 0.973, "R1": 1.350,
    "L4": 0.510, "L3": 1.003, "L2": 1.440, "L1": 1.808,
}  # fmt: skip

# where a foot stands in the middle of its stance, body frame (forward, outwards), units of
# the species file; and where crowding moves it
_FOOT = {"1": (28.5, 20.0), "2": (12.0, 29.5), "3": (-6.0, 26.5), "4": (-23.5, 18.5)}
_CROWDED = {"1": (-4.0, 1.5), "2": (2.5, -2.0), "3": (2.0, -1.5), "4": (3.0, 3.0)}
_LIFT = {"1": 3.6, "2": 3.6, "3": 3.2, "4": 3.0}
"""How high a foot is lifted in swing."""

COXA_HEIGHT = 6.0
_WALL_GAP_MM = 1.5
_LEAST_SWING = 0.3
"""Shortest swing, as a share of the period."""
_REACH = (0.645, 0.908)
"""How near to and far from the body-coxa joint a foot may stand, in lengths of its leg."""


@dataclass(frozen=True)
class BodyWander:
    """Place and heading of the body over time.

    Attributes
    ----------
    start_mm : ndarray (2,)
        Place at time 0 without the waves.
    velocity_mm_s : ndarray (2,)
        Mean velocity.
    heading_deg : float
        Mean heading.
    waves : dict of str to ndarray (m, 3)
        Amplitude, frequency in Hz and phase in cycles of the waves of ``along`` and ``across``
        (mm, along the mean heading and to its right), ``turn`` (degrees) and ``up`` (mm).
    """

    start_mm: FloatArray
    velocity_mm_s: FloatArray
    heading_deg: float
    waves: dict[str, FloatArray]

    def _wave(self, name: str, t: FloatArray) -> FloatArray:
        amplitude, frequency, phase = self.waves[name].T[..., None]
        return (
            (amplitude * np.sin(2 * np.pi * (frequency * np.ravel(t) + phase)))
            .sum(0)
            .reshape(np.shape(t))
        )

    def place(self, t: FloatArray) -> FloatArray:
        """Return X, Y of the cephalothorax-abdomen joint in mm, shape (..., 2)."""
        turn = np.radians(self.heading_deg)
        forward = np.array([np.cos(turn), np.sin(turn)])
        right = np.array([-np.sin(turn), np.cos(turn)])
        t = np.asarray(t, dtype=float)
        return (
            self.start_mm
            + t[..., None] * self.velocity_mm_s
            + self._wave("along", t)[..., None] * forward
            + self._wave("across", t)[..., None] * right
        )

    def heading(self, t: FloatArray) -> FloatArray:
        """Return the heading in degrees from +X towards +Y."""
        return self.heading_deg + self._wave("turn", np.asarray(t, dtype=float))

    def height(self, t: FloatArray) -> FloatArray:
        """Return how far the body is above its mean height, mm."""
        return self._wave("up", np.asarray(t, dtype=float))

    def to_arena(self, t: FloatArray, point: FloatArray) -> FloatArray:
        """Return points of the body's frame (forward, right; mm) in the arena, (..., 2)."""
        turn = np.radians(self.heading(t))
        cos, sin = np.cos(turn), np.sin(turn)
        x, y = point[..., 0], point[..., 1]
        return self.place(t) + np.stack([x * cos - y * sin, x * sin + y * cos], axis=-1)

    def from_arena(self, t: FloatArray, point: FloatArray) -> FloatArray:
        """Return points of the arena in the body's frame: the inverse of :meth:`to_arena`."""
        turn = np.radians(self.heading(t))
        cos, sin = np.cos(turn), np.sin(turn)
        x, y = np.moveaxis(point - self.place(t), -1, 0)
        return np.stack([x * cos + y * sin, y * cos - x * sin], axis=-1)


@dataclass(frozen=True)
class FootMotion:
    """One foot: where it stands, and how it moves from one place to the next.

    Attributes
    ----------
    touch_down_s, lift_off_s : ndarray (n,)
        Times of each stance.
    places_mm : ndarray (n, 2)
        Where the foot stands.
    lift_mm : float
        Height of the swing.
    arc_mm : ndarray (2,)
        How far the middle of the swing bulges sideways.
    """

    touch_down_s: FloatArray
    lift_off_s: FloatArray
    places_mm: FloatArray
    lift_mm: float
    arc_mm: FloatArray

    def place(self, t: FloatArray) -> FloatArray:
        """Return X, Y, Z of the tip in mm, shape (..., 3).

        A swing is a minimum-jerk movement; height and sideways bulge start and end without
        velocity or acceleration.
        """
        t = np.asarray(t, dtype=float)
        last = len(self.touch_down_s) - 2
        k = np.clip(np.searchsorted(self.touch_down_s, t, side="right") - 1, 0, last)
        off = self.lift_off_s[k]
        share = np.clip((t - off) / (self.touch_down_s[k + 1] - off), 0.0, 1.0)
        step = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        bump = 64.0 * (share * (1.0 - share)) ** 3
        step, bump = step[..., None], bump[..., None]
        plane = (1.0 - step) * self.places_mm[k] + step * self.places_mm[k + 1]
        return np.concatenate([plane + bump * self.arc_mm, bump * self.lift_mm], axis=-1)


@dataclass(frozen=True)
class SpiderMotion:
    """The whole animal's motion.

    Attributes
    ----------
    body : BodyWander
        The body.
    feet : dict of str to FootMotion
        The feet by leg.
    coxae_mm : dict of str to ndarray (2,)
        Body-coxa joints in the body's frame.
    side : dict of str to int
        1 on the right, -1 on the left.
    frequency_hz, duty_factor : float
        Means of the gait.
    """

    body: BodyWander
    feet: dict[str, FootMotion]
    coxae_mm: dict[str, FloatArray]
    side: dict[str, int]
    frequency_hz: float
    duty_factor: float

    def leg_angle(self, leg: str, t: FloatArray) -> FloatArray:
        """Return the total angle of a leg in degrees (Pullar 2009, §3.6).

        That of the tip about the body-coxa joint, 0 where the leg is perpendicular to the
        body's axis, positive forwards.
        """
        tip = self.feet[leg].place(t)[..., :2]
        reach = self.body.from_arena(t, tip) - self.coxae_mm[leg]
        return np.degrees(np.arctan2(reach[..., 0], self.side[leg] * reach[..., 1]))

    def shifted(self, by_mm: FloatArray) -> SpiderMotion:
        """Return the same motion elsewhere in the arena."""
        body = BodyWander(
            self.body.start_mm + by_mm,
            self.body.velocity_mm_s,
            self.body.heading_deg,
            self.body.waves,
        )
        feet = {
            leg: FootMotion(f.touch_down_s, f.lift_off_s, f.places_mm + by_mm, f.lift_mm, f.arc_mm)
            for leg, f in self.feet.items()
        }
        return SpiderMotion(
            body, feet, self.coxae_mm, self.side, self.frequency_hz, self.duty_factor
        )


def plan_motion(scene: SpiderScene, individual: Individual, *, duration_s: float) -> SpiderMotion:
    """Lay out a run.

    Parameters
    ----------
    scene : SpiderScene
        Speed, variability and seed.
    individual : Individual
        The animal.
    duration_s : float
        Length of the recording.

    Returns
    -------
    SpiderMotion
        Valid from time 0 to ``duration_s``; the body is near X = 0 at time 0.
    """
    rng = scene.rng(2)
    size = individual.size
    speed = rng.uniform(*scene.speed_mm_s)
    duty = 0.54 + 0.02 * np.clip(rng.standard_normal(), -1.5, 1.5)
    # Long strides would ask the stick animal's legs to reach further than they can, and its
    # neighbouring legs to cross: the stride frequency is that of §4.2.2 (5 to 8 Hz), the
    # speed therefore lower.
    travel = size * rng.uniform(*scene.stance_travel)
    frequency = speed * duty / travel
    body = _plan_body(scene, rng, (speed, frequency))
    coxae = {leg.name: size * np.array(leg.attach) for leg in individual.animal.legs}
    side = {leg.name: leg.side for leg in individual.animal.legs}
    feet = {}
    for leg in individual.animal.legs:
        # the coordination of an animal differs from the mean of all
        offset = _GAIT_PHASE[leg.name] + 0.02 * np.clip(rng.standard_normal(), -2, 2)
        plan = (frequency, duty, offset, duration_s)
        feet[leg.name] = _plan_foot(scene, rng, plan, body=body, leg=leg, size=size)
    return SpiderMotion(body, feet, coxae, side, frequency, duty)


def _plan_body(
    scene: SpiderScene, rng: np.random.Generator, gait: tuple[float, float]
) -> BodyWander:
    """Draw a nearly straight run with slow changes and waves locked to the stride."""
    speed, frequency = gait
    towards = 1 if rng.random() < 0.5 else -1
    course = (0.0 if towards > 0 else 180.0) + rng.uniform(-2.5, 2.5)
    direction = np.radians(course)
    slow = rng.uniform(0.5, 1.3, 3)
    phases = rng.uniform(0.0, 1.0, 7)
    speed_wave = 0.07 * speed / (2 * np.pi * slow[0])  # the speed varies by 7 %
    waves = {
        "along": [(speed_wave, slow[0], phases[0]), (0.25, 2 * frequency, phases[1])],
        "across": [(1.2, slow[1], phases[2]), (0.35, frequency, phases[3])],
        "turn": [(2.5, slow[2], phases[4]), (1.0, frequency, phases[5])],
        "up": [(0.35, 2 * frequency, phases[6])],
    }
    off_centre = rng.uniform(*scene.off_centre_mm) * (1 if rng.random() < 0.5 else -1)
    middle = FULL_HEIGHT / PX_PER_MM / 2.0 + off_centre
    return BodyWander(
        start_mm=np.array([0.0, middle]),
        velocity_mm_s=speed * np.array([np.cos(direction), 0.3 * np.sin(direction)]),
        heading_deg=course,
        waves={name: np.array(rows) for name, rows in waves.items()},
    )


def _plan_foot(
    scene: SpiderScene,
    rng: np.random.Generator,
    plan: tuple[float, float, float, float],
    *,
    body: BodyWander,
    leg: Leg,
    size: float,
) -> FootMotion:
    """Draw the strides of one foot."""
    frequency, duty, offset, duration_s = plan
    pair, period = leg.name[1], 1.0 / frequency
    n = int(np.ceil(duration_s * frequency)) + 7
    jitter = np.clip(rng.standard_normal(n), -2, 2) * scene.phase_sd * (2 if pair == "1" else 1)
    down = (np.arange(n) - 4.0 + offset % 1.0 + jitter) * period
    stance = (duty + 0.015 * np.clip(rng.standard_normal(n), -2, 2)) * period
    lift = np.minimum(down + stance, np.append(down[1:], np.inf) - _LEAST_SWING * period)
    forward, out = np.array(_FOOT[pair]) + scene.crowding * np.array(_CROWDED[pair])
    aim = size * np.array([forward, leg.side * out])
    aim = aim + scene.placement_sd_mm * np.clip(rng.standard_normal((n, 2)), -2, 2)
    places = body.to_arena((down + lift) / 2.0, aim)
    coxa = size * np.array(leg.attach)
    limits = size * sum(leg.lengths) * np.array(_REACH)
    for _ in range(10):
        for t in (down, lift):
            places = _within_reach(places, body.to_arena(t, np.tile(coxa, (n, 1))), limits)
    turn = np.radians(body.heading_deg)
    outwards = leg.side * np.array([-np.sin(turn), np.cos(turn)])
    return FootMotion(
        touch_down_s=down,
        lift_off_s=lift,
        places_mm=places,
        lift_mm=size * _LIFT[pair] * rng.uniform(0.85, 1.15),
        arc_mm=size * rng.uniform(-1.0, 1.0) * outwards,
    )


def _within_reach(places: FloatArray, coxa: FloatArray, limits: FloatArray) -> FloatArray:
    """Move feet in reach of their body-coxa joint, and off the walls."""
    away = places - coxa
    distance = np.hypot(*away.T)
    moved = coxa + away * (np.clip(distance, *limits) / distance)[:, None]
    middle = FULL_HEIGHT / PX_PER_MM / 2.0
    reach = ARENA_WIDTH_MM / 2.0 - _WALL_GAP_MM
    moved[:, 1] = np.clip(moved[:, 1], middle - reach, middle + reach)
    return np.asarray(moved)
