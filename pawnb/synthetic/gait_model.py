"""How the synthetic mouse runs: strides that vary, exact events, and the body above them.

Everything is a continuous function of time, so that touch-down and lift-off are
exact to the fraction of a frame. Positions here are (forward, left, up) in mm,
fixed to the laboratory: the belt moves towards -forward at the belt's speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from pawnb.arrays import FloatArray, IntArray
from pawnb.synthetic.scene import LEGS, SceneSettings

PAW_HEIGHT_MM = 1.2
"""Height of the tracked point above the belt while the paw stands."""

_GAIT_PHASE = {"FR": 0.0, "HL": 0.03, "FL": 0.5, "HR": 0.53}
"""Touch-down of each leg in the stride of FR, cycles: a trot in which the hind paw follows."""

_CENTRE_MM = {"F": 15.5, "H": -18.5}
"""Middle of a stance forward of the middle of the body (nose-tail 87 mm)."""

_TRACK_MM = {"F": 8.5, "H": 12.0}
"""Half the distance between left and right paws."""

_LIFT_MM = {"F": 10.5, "H": 6.0}
_DRAW_IN_MM = {"F": 3.5, "H": 1.0}
"""How far a paw comes in under the body in swing."""

_LIFT_SHAPE = {"F": (1.3, 2.2), "H": (1.6, 1.8)}
"""Height in swing goes as ``s**a (1 - s)**b``; front paws are highest early."""

_SETTLING_S = 1.0
"""Time before the first frame, so that recordings may begin anywhere in a stride."""


@dataclass(frozen=True)
class LegMotion:
    """The path of one paw's tracked point; arrays have one entry a stride.

    Attributes
    ----------
    touch_down_s, lift_off_s : ndarray (n,)
        Exact times; stride k stands from ``touch_down_s[k]`` to ``lift_off_s[k]``.
    placed : ndarray (n, 2)
        Where the paw is put down, (forward, left) in mm, laboratory frame.
    lift_mm, draw_in_mm : ndarray (n,)
        Height of the swing that follows, and how far it leads to the left.
    swing_poly : ndarray (n - 1, 6)
        Forward position in swing as a polynomial of the time since lift-off,
        lowest order first.
    belt_speed : float
        mm / s.
    shape : tuple of float
        Exponents of the height in swing.
    """

    touch_down_s: FloatArray
    lift_off_s: FloatArray
    placed: FloatArray
    lift_mm: FloatArray
    draw_in_mm: FloatArray
    swing_poly: FloatArray
    belt_speed: float
    shape: tuple[float, float]

    def phase(self, time_s: FloatArray) -> FloatArray:
        """Return 0-1 through stance, from touch-down, and 1-2 through swing; shape (t,)."""
        time_s = np.asarray(time_s, dtype=float)
        k = self._stride(time_s)
        stance = (time_s - self.touch_down_s[k]) / (self.lift_off_s[k] - self.touch_down_s[k])
        swing = (time_s - self.lift_off_s[k]) / (self.touch_down_s[k + 1] - self.lift_off_s[k])
        return np.where(time_s < self.lift_off_s[k], stance, 1.0 + swing)

    def position(self, time_s: FloatArray) -> FloatArray:
        """Return the tracked point (t, 3): forward, left, up in mm, laboratory frame."""
        time_s = np.asarray(time_s, dtype=float)
        k = self._stride(time_s)
        since_down = time_s - self.touch_down_s[k]
        since_lift = np.maximum(time_s - self.lift_off_s[k], 0.0)
        standing = time_s < self.lift_off_s[k]
        forward = self.placed[k, 0] - self.belt_speed * since_down
        swinging = np.zeros_like(forward)
        for order in range(5, -1, -1):
            swinging = swinging * since_lift + self.swing_poly[k, order]
        s = since_lift / (self.touch_down_s[k + 1] - self.lift_off_s[k])
        ease = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)  # minimum jerk
        a, b = self.shape
        arc = s**a * (1.0 - s) ** b / (a**a * b**b / (a + b) ** (a + b))
        left = self.placed[k, 1] + ease * (self.placed[k + 1, 1] - self.placed[k, 1])
        left = left + self.draw_in_mm[k] * arc
        up = PAW_HEIGHT_MM + self.lift_mm[k] * arc
        return np.stack([np.where(standing, forward, swinging), left, up], axis=-1)

    def extremes(self) -> tuple[FloatArray, FloatArray]:
        """Return the times (n - 1,) of PEP and of AEP: the turning points of each swing."""
        pep, aep = [], []
        for k, poly in enumerate(self.swing_poly):
            duration = self.touch_down_s[k + 1] - self.lift_off_s[k]
            roots = np.roots((poly[1:] * np.arange(1, 6))[::-1])
            real = np.sort(roots[np.abs(roots.imag) < 1e-9].real)
            inside = real[(real > 0) & (real < duration)]
            pep.append(self.lift_off_s[k] + inside[0])
            aep.append(self.lift_off_s[k] + inside[-1])
        return np.array(pep), np.array(aep)

    def _stride(self, time_s: FloatArray) -> IntArray:
        """Return the number of the stride that holds each time."""
        k = np.searchsorted(self.touch_down_s, time_s, side="right") - 1
        return np.clip(k, 0, len(self.touch_down_s) - 2)


@dataclass(frozen=True)
class BodyMotion:
    """Slow wandering and stride-locked bobbing of the body."""

    cycles: CubicSpline
    slow: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]
    locked: dict[str, tuple[int, float, float]]

    def value(self, name: str, time_s: FloatArray) -> np.ndarray:
        """Return one coordinate at some times: forward, left, up (mm), pitch, roll, yaw (rad)."""
        time_s = np.asarray(time_s, dtype=float)
        amplitude, frequency, phase = self.slow[name]
        angle = 2 * np.pi * (time_s[..., None] * frequency + phase)
        harmonic, size, lag = self.locked[name]
        beat = size * np.sin(2 * np.pi * (harmonic * self.cycles(time_s) + lag))
        return np.sum(amplitude * np.sin(angle), axis=-1) + beat


@dataclass(frozen=True)
class Gait:
    """A whole run: the paths of the paws by leg and the motion of the body."""

    legs: dict[str, LegMotion]
    body: BodyMotion
    earliest_s: float
    """First time at which a recording may begin."""
    mean_period_s: float


def mean_gait(settings: SceneSettings) -> tuple[float, float]:
    """Return the mean stride frequency (Hz) and duty factor.

    Where the settings leave them open they follow from the speed: about 5 Hz and 0.6
    at 0.3 m/s, faster and shorter on the ground with speed, which is the trend in
    mice (Clarke & Still 1999, Physiol. Behav. 66: 723-729).
    """
    speed = settings.belt_speed_mm_s / 1000.0
    frequency = settings.stride_frequency_hz or (2.6 + 8.0 * speed) / settings.size**0.5
    duty = settings.duty_factor or float(np.clip(0.75 - 0.5 * speed, 0.55, 0.75))
    return frequency, duty


def plan_gait(settings: SceneSettings, duration_s: float) -> Gait:
    """Lay out every stride of a run.

    Parameters
    ----------
    settings : SceneSettings
        Speed, variability and seed.
    duration_s : float
        Length of the recording.

    Returns
    -------
    Gait
        Valid from ``earliest_s`` for ``duration_s`` and two strides more.
    """
    rng = np.random.default_rng([settings.seed, 1])
    frequency, duty = mean_gait(settings)
    n = int(np.ceil((duration_s + _SETTLING_S) * frequency * 1.25)) + 8
    # neighbouring strides resemble each other: first-order autoregression, r = 0.5
    wander = np.zeros(n)
    noise = rng.standard_normal(n)
    for k in range(1, n):
        wander[k] = 0.5 * wander[k - 1] + np.sqrt(0.75) * noise[k]
    periods = (1.0 + settings.period_sd * np.clip(wander, -2.5, 2.5)) / frequency
    starts = np.concatenate([[0.0], np.cumsum(periods)])[:n] - 2.0 / frequency
    body = _plan_body(settings, CubicSpline(starts, np.arange(n)), rng)
    legs = {leg: _plan_leg(leg, settings, (starts, periods, duty), body, rng) for leg in LEGS}
    return Gait(legs=legs, body=body, earliest_s=_SETTLING_S, mean_period_s=1.0 / frequency)


def _plan_body(
    settings: SceneSettings, cycles: CubicSpline, rng: np.random.Generator
) -> BodyMotion:
    """Draw the slow components and set the stride-locked ones."""
    size = settings.size
    amplitudes = {
        "forward": settings.drift_mm,
        "left": settings.sway_mm,
        "up": 0.6 * size,
        "pitch": np.radians(2.0),
        "roll": np.radians(1.5),
        "yaw": np.radians(2.0) + 0.008 * settings.sway_mm,
    }
    slow = {}
    for name, amplitude in amplitudes.items():
        share = rng.uniform(0.6, 1.0, 3) * np.array([0.6, 0.3, 0.15])
        frequency = rng.uniform([0.15, 0.45, 0.9], [0.4, 0.8, 1.4])
        slow[name] = (amplitude * share, frequency, rng.uniform(0.0, 1.0, 3))
    locked = {
        "forward": (2, 0.4 * size, 0.10),
        "left": (1, 0.8 * size, 0.25),
        "up": (2, 0.8 * size, 0.35),
        "pitch": (2, np.radians(1.0), 0.0),
        "roll": (1, np.radians(2.0), 0.1),
        "yaw": (1, np.radians(1.5), 0.6),
    }
    return BodyMotion(cycles=cycles, slow=slow, locked=locked)


def _plan_leg(
    leg: str,
    settings: SceneSettings,
    schedule: tuple[FloatArray, FloatArray, float],
    body: BodyMotion,
    rng: np.random.Generator,
) -> LegMotion:
    """Draw the strides of one leg about the common schedule."""
    starts, periods, duty = schedule
    girdle, n, speed = leg[0], len(starts), settings.belt_speed_mm_s
    jitter = np.clip(rng.standard_normal(n), -2.5, 2.5) * settings.phase_jitter
    down = starts + (_GAIT_PHASE[leg] + jitter) * periods
    # hind paws stand a little longer than front paws
    mean_duty = duty + (0.01 if girdle == "H" else -0.01)
    duties = mean_duty + settings.duty_sd * np.clip(rng.standard_normal(n), -2.0, 2.0)
    stride = np.append(np.diff(down), periods[-1])
    lift = down + np.clip(duties, 0.5, 0.8) * stride
    # a stance is centred under the limb whatever its length, plus where the paw happened to land
    reach = speed * (lift - down) / 2.0
    aim = body.value("forward", down) + _CENTRE_MM[girdle] * settings.size + reach
    side = 1.0 if leg[1] == "L" else -1.0
    heading = body.value("yaw", down) * _CENTRE_MM[girdle] * settings.size
    across = body.value("left", down) + heading + side * _TRACK_MM[girdle] * settings.size
    scatter = np.clip(rng.standard_normal((n, 2)), -2.5, 2.5) * settings.placement_sd_mm
    placed = np.stack([aim, across], axis=1) + scatter * [1.0, 0.6]
    heights = _LIFT_MM[girdle] * settings.size * (1.0 + 0.1 * rng.uniform(-1.0, 1.0, n))
    # the leg already moves back when it lands, at this share of the belt's speed
    retraction = rng.uniform(0.35, 0.75, n)
    poly = np.zeros((n, 6))
    for k in range(n - 1):
        begin = placed[k, 0] - speed * (lift[k] - down[k])
        poly[k] = _quintic(
            (begin, -speed), (placed[k + 1, 0], -speed * retraction[k]), down[k + 1] - lift[k]
        )
    return LegMotion(
        touch_down_s=down,
        lift_off_s=lift,
        placed=placed,
        lift_mm=heights,
        draw_in_mm=np.full(n, -side * _DRAW_IN_MM[girdle] * settings.size),
        swing_poly=poly[:-1],
        belt_speed=speed,
        shape=_LIFT_SHAPE[girdle],
    )


def _quintic(begin: tuple[float, float], end: tuple[float, float], duration: float) -> FloatArray:
    """Return the minimum-jerk polynomial between two (position, speed), without acceleration."""
    (x0, v0), (x1, v1) = begin, end
    t = duration
    gap = x1 - x0 - v0 * t
    turn = (v1 - v0) * t
    return np.array(
        [
            x0,
            v0,
            0.0,
            (10.0 * gap - 4.0 * turn) / t**3,
            (-15.0 * gap + 7.0 * turn) / t**4,
            (6.0 * gap - 3.0 * turn) / t**5,
        ]
    )
