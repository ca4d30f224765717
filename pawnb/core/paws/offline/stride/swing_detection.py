"""Where stances leave room for swings, and when those begin and end as far as stances tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pawnb.arrays import BoolArray, FloatArray
from pawnb.core.paws.offline.stride.duty_factor import DutyFactor
from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.stance import Stance, Substrate


@dataclass(frozen=True)
class Swing:
    """A swing before it is fitted.

    Parameters
    ----------
    point : int
        Number of the point.
    times, sd : tuple of float
        Frames of lift-off and landing, and their standard deviations.
    begin, end : ndarray, shape (d,)
        Where in frame 0 the ground was from which it lifts off, and on which it lands.
    is_whole : bool
        Whether stances before and after it are known.
    """

    point: int
    times: tuple[float, float]
    sd: tuple[float, float]
    begin: FloatArray
    end: FloatArray
    is_whole: bool = True


def since_landing(
    stances: Sequence[Sequence[Stance]], x: FloatArray, *, seen: BoolArray, substrate: Substrate
) -> list[list[Stance]]:
    """Let stances begin where the paw was first seen on its place, certain or not.

    Places just after a landing are often not certain, as where two paws come together; a swing
    that seems to end when they are again would be one of another stride.

    Parameters
    ----------
    stances : sequence
        Those of each point.
    x : ndarray, shape (n, P, d)
        Tracks.
    seen : ndarray of bool, shape (n, P)
        Where a view that tracks the point shows it.
    substrate : Substrate
        What they stand on.

    Returns
    -------
    list of list of Stance
        The same stances, some of them longer.
    """
    axes, near = substrate.motion_model.axes, STRIDE.on_place * substrate.motion_model.paw_width
    frames = np.arange(len(x))
    longer = []
    for p, mine in enumerate(stances):
        own: list[Stance] = []
        for one in mine:
            off = (x[:, p] - substrate.places(one, frames)) @ axes[[0, -1]].T
            on = seen[:, p] & (np.hypot(*off.T) < near)
            first = one.first - int(np.argmin(np.append(on[: one.first][::-1], False)))
            if own:
                first = min(one.first, max(first, own[-1].stop + 1))
            own.append(replace(one, first=first))
        longer.append(own)
    return longer


def find_swings(
    stances: Sequence[Sequence[Stance]],
    seen: BoolArray,
    duty_factor: DutyFactor | None,
    *,
    certain: BoolArray,
    fps: float,
    substrate_velocity: FloatArray,
) -> list[Swing]:
    """Return the swings between stances, and those after the last and before the first one.

    Parameters
    ----------
    stances : sequence
        Those of each point.
    seen, certain : ndarray of bool, shape (n, P)
        Where a view that tracks the point shows it, and where places are certain.
    duty_factor : DutyFactor, optional
        When they lift off; without it only swings between stances are found.
    fps : float
        Frames per second.
    substrate_velocity : ndarray, shape (d,)
        Speed of the ground.

    Returns
    -------
    list of Swing
        The swings.
    """
    found = []
    for p, mine in enumerate(stances):
        ends = _StanceEnds(seen[:, p], certain[:, p], duty_factor, p, fps)
        for now, after in pairwise(mine):
            if after.first - now.stop >= STRIDE.least_frames:
                land = ends.touch_down(after)
                lift = ends.lift_off(now, after.first - now.first, land[1])
                found.append(_swing(p, lift, land, now.origin, after.origin))
        if duty_factor is None or not mine:
            continue
        steps = [after.origin - now.origin for now, after in pairwise(mine)]
        step = np.median(steps, axis=0) if steps else -duty_factor.stride * substrate_velocity
        stride = duty_factor.stride
        spread = float(np.hypot(duty_factor.spread, STRIDE.swing_detection_spread * stride))
        # the share is that of stances as they seem
        swung = (1.0 - duty_factor.share[p]) * stride + 2.0 * STRIDE.still_near
        swung_sd = np.hypot(duty_factor.sd[p] * stride, (1.0 - duty_factor.share[p]) * spread)
        first, last = mine[0], mine[-1]
        if first.first > 0:
            land = ends.touch_down(first)
            lift = land[0] - swung, swung_sd
            found.append(_swing(p, lift, land, first.origin - step, first.origin, whole=False))
        if last.first > 0 and last.stop < len(seen):
            lift = ends.lift_off(last, stride, float(np.hypot(spread, ends.touch_down(last)[1])))
            land = lift[0] + swung, swung_sd
            found.append(_swing(p, lift, land, last.origin, last.origin + step, whole=False))
    return found


def _swing(
    point: int,
    lift: tuple[float, float],
    land: tuple[float, float],
    begin: FloatArray,
    end: FloatArray,
    *,
    whole: bool = True,
) -> Swing:
    """Return a swing, given when it begins and ends, each with its standard deviation."""
    return Swing(point, (lift[0], land[0]), (lift[1], land[1]), begin, end, whole)


@dataclass(frozen=True)
class _StanceEnds:
    """When stances of one point begin and end, frames, and how surely."""

    seen: BoolArray  # (n,)
    certain: BoolArray  # (n,)
    duty_factor: DutyFactor | None
    point: int
    fps: float

    def lift_off(self, stance: Stance, stride: float, end_sd: float) -> tuple[float, float]:
        """Return when a stance ends and the standard deviation: as seen, and as due.

        The stride that begins with it lasts ``stride`` frames; when it ends is known to ``end_sd``.
        """
        observed = self._is_seen(
            stance.stop - STRIDE.swing_detection_around,
            stance.stop + STRIDE.swing_detection_around + 1,
        )
        at = stance.stop - STRIDE.half_frame - STRIDE.still_near
        if observed:
            known = self.certain[stance.stop - 1 : stance.stop + 1].all()
            sd = self._sd(1.0 if known else STRIDE.swing_detection_open)
        else:
            sd = max(
                self._sd(STRIDE.swing_detection_vague),
                STRIDE.swing_detection_anywhere * self._unseen(stance.stop),
            )
        duty_factor = self.duty_factor
        if duty_factor is None or stance.first == 0 or not duty_factor.is_usual(stride):
            return at, sd
        share = duty_factor.share[self.point]
        due = stance.first - STRIDE.half_frame - STRIDE.still_near + share * stride
        # it divides the stride in between: neither end of that counts whole
        ends = (1.0 - share) * self.touch_down(stance)[1], share * end_sd
        due_sd = float(np.linalg.norm([duty_factor.sd[self.point] * stride, *ends]))
        weight = np.array([sd, due_sd]) ** -2.0
        return float(weight @ [at, due] / weight.sum()), float(weight.sum() ** -0.5)

    def touch_down(self, stance: Stance) -> tuple[float, float]:
        """Return when a stance begins, and the standard deviation."""
        observed = self._is_seen(
            stance.first - STRIDE.swing_detection_around - 1,
            stance.first + STRIDE.swing_detection_around,
        )
        vague = (
            STRIDE.swing_detection_vague
            if not observed
            else 1.0
            if self.certain[stance.first]
            else STRIDE.swing_detection_open
        )
        return stance.first - STRIDE.half_frame + STRIDE.still_near, self._sd(vague)

    def _unseen(self, frame: int) -> int:
        """Return for how many frames about one the point is not seen."""
        before, after = self.seen[:frame][::-1], self.seen[frame:]
        return sum(int(np.argmax(np.append(part, True))) for part in (before, after))

    def _is_seen(self, first: int, stop: int) -> bool:
        """Tell whether the point is seen in all of some frames."""
        return bool(self.seen[max(0, first) : stop].all())

    def _sd(self, vague: float) -> float:
        """Return the standard deviation of an edge that is known so vaguely."""
        return vague * (STRIDE.touch_s * self.fps + STRIDE.swing_detection_touch)
