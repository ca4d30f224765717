"""A walking animal with known events: feet at rest on the substrate, minimum-jerk swings.

The motion: every leg n has touch-downs at ``(k + phase[n]) * period`` and lift-offs
``duty * period`` later. In stance the foot rests on the substrate; in swing it moves one
stride length forward along a minimum-jerk profile (Flash & Hogan 1985) and rises by
``16 x^2 (1 - x)^2`` of its swing height. Seen from the body, which moves steadily at ``speed``,
AEP comes where the swing's speed falls to the body's speed, shortly before touch-down, and PEP
shortly after lift-off; both follow from the profile, see ``exact_extremes``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

from pawnb.schema import ORIGIN_CODE, make_tracks

TROT = {"FR": 0.0, "HR": 0.5, "FL": 0.5, "HL": 0.0}


@dataclass(frozen=True, kw_only=True)
class Walk:
    """One steady walk; units are whatever ``speed`` is in."""

    period: float = 0.3
    duty: float = 0.6
    speed: float = 300.0
    phases: dict = field(default_factory=lambda: dict(TROT))
    swing_height: float = 8.0

    def foot(self, leg, t):
        """Distance along the substrate and height of a foot at times t."""
        cycle = np.asarray(t) / self.period - self.phases[leg]
        k, x = np.floor(cycle), np.mod(cycle, 1.0)
        s = np.clip((x - self.duty) / (1 - self.duty), 0.0, 1.0)
        eased = s**3 * (10 - 15 * s + 6 * s**2)
        stride = self.speed * self.period
        # the middle of stance lies below the shoulder
        start = self.speed * self.period * (self.phases[leg] + self.duty / 2)
        height = self.swing_height * 16 * s**2 * (1 - s) ** 2
        return start + stride * (k + eased), height

    def exact_contacts(self, leg, duration):
        """Times of touch-down and lift-off within the recording."""
        k = np.arange(-1, int(duration / self.period) + 2)
        down = (k + self.phases[leg]) * self.period
        up = down + self.duty * self.period
        return [x[(x > 0) & (x < duration)] for x in (down, up)]

    def exact_extremes(self, leg, duration):
        """Times of AEP and PEP: where the swing's speed equals that of the body."""
        early = self.early
        k = np.arange(-2, int(duration / self.period) + 2)
        down = (k + self.phases[leg]) * self.period
        up = down + self.duty * self.period
        return [v[(v > 0) & (v < duration)] for v in (down - early, up + early)]

    @property
    def early(self):
        """How long before touch-down a foot is at its AEP (after lift-off: at its PEP)."""
        level = 1 - self.duty  # the body's speed as a share of the swing's mean speed
        x = brentq(lambda s: 30 * s**2 * (1 - s) ** 2 - level, 0.0, 0.5)
        return x * (1 - self.duty) * self.period

    @property
    def exact_duty(self):
        """Duty factor from AEP to PEP: larger than from touch-down to lift-off."""
        return self.duty + 2 * self.early / self.period

    def tracks(
        self,
        *,
        fps=250.0,
        duration=3.0,
        treadmill=True,
        noise=0.0,
        seed=0,
        first_frame=0,
        unit="mm",
        scale=1.0,
        drift=0.0,
        axis=(1.0, 0.0, 0.0),
        origin=(0.0, 0.0, 0.0),
    ):
        """Tracks of the feet; on a treadmill the laboratory moves with the body."""
        frames = first_frame + np.arange(round(fps * duration))
        t = (frames - first_frame) / fps
        tracks = make_tracks(frames, list(self.phases), fps=fps, unit=unit)
        rng = np.random.default_rng(seed)
        ahead = np.array(axis) / np.linalg.norm(axis)
        for n, leg in enumerate(self.phases):
            x, z = self.foot(leg, t)
            along = x - (self.speed * t if treadmill else 0.0) + drift * t
            hip = np.array([0.0, 0.0, 0.0]) + 40.0 * (leg[0] == "F") * ahead
            side = np.cross([0.0, 0.0, 1.0], ahead) * (15.0 if "L" in leg else -15.0)
            path = along[:, None] * ahead + z[:, None] * [0.0, 0.0, 1.0] + hip + side + origin
            path = scale * (path + noise * rng.standard_normal(path.shape))
            tracks["position"].data[:, :, n, 0] = path
        tracks["confidence"].data[:] = 1.0
        tracks["origin"].data[:] = ORIGIN_CODE["measured"]
        return tracks
