"""What a point did where no piece of path is certain: several stories told side by side.

Between two certain pieces a point may be hidden, half hidden, or seen by one view only, and
what looks like it may belong to another. Each story (hypothesis) carries a Kalman state;
in every frame and view it may take in a candidate or none, and it may be kicked: a paw that
lifts off changes its speed at once. Only the likeliest stories are kept, and the piece that
follows decides between them: multiple hypothesis tracking (Reid 1979, IEEE Trans. Automat.
Contr. 24: 843-854) with the end known.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pawnb.core.paws.whole import bridging_loops as loops
from pawnb.core.paws.whole.geometry import Geometry

_STEP = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
_GAIN = np.array([[1 / 6], [0.5], [1.0]])
_JUMP = np.array([[1 / 3, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.0]])
"""Covariance of a change of speed at any moment of the frame."""
_GATE = 16.0
_LAG = 25.0
"""Stories dearer than the best by this are forgotten."""
_ASTRAY = 50.0


@dataclass(frozen=True)
class Telling:
    """How stories are told; costs are minus log-probabilities.

    Parameters
    ----------
    jerk : float
        Usual standard deviation of the change of acceleration from frame to frame.
    kick : float
        Standard deviation of the change of speed where a point is kicked.
    noise : float
        Standard deviation of a place that is certain.
    reach : float
        A point does not go farther than this while no piece is certain.
    kick_cost : float
        Cost of a kick.
    good, bad : float
        Standard deviation of a candidate, and of one that is half hidden or blurred, in
        thicknesses of a paw.
    bad_cost : float
        Cost of a bad candidate.
    clutter : float
        Candidates that are nothing, per square thickness.
    seen, seen_across : float
        Chance that a view sees the point: one that tracks it, and one from the other side.
    hide, stay, show, half : float
        Cost of becoming hidden to all views that track the point, of staying so, of coming
        out again, and of being seen by none but one of two.
    alike : float
        Stories nearer to each other than so many of their standard deviations tell the same.
    most, most_within : int
        Stories kept from frame to frame, and from view to view within a frame: a paw that
        comes out again is told dearly by the first view and made good by the next.
    """

    jerk: float
    kick: float
    noise: float
    reach: float
    kick_cost: float = 2.0
    good: float = 0.15
    bad: float = 0.6
    bad_cost: float = 2.0
    clutter: float = 0.05
    seen: float = 0.7
    seen_across: float = 0.15
    hide: float = 2.0
    stay: float = 0.6
    show: float = 1.0
    half: float = 0.2
    alike: float = 0.5
    most: int = 40
    most_within: int = 150


class Stories:
    """The likeliest stories of one point up to a frame.

    Parameters
    ----------
    state : ndarray, shape (3, d)
        Position, speed and acceleration at the beginning.
    covariance : ndarray, shape (3, 3)
        Their covariance, the same along each axis.
    geometry : Geometry
        The views.
    thickness_px : ndarray, shape (V,)
        Thickness of a paw in each view.
    own : ndarray of bool, shape (V,)
        Views that track the point.
    telling : Telling
        How they are told.
    """

    def __init__(
        self,
        state: np.ndarray,
        covariance: np.ndarray,
        *,
        geometry: Geometry,
        thickness_px: np.ndarray,
        own: np.ndarray,
        telling: Telling,
    ) -> None:
        self.d = state.shape[1]
        self.mean = state.reshape(1, -1).copy()
        self.covariance = np.kron(covariance, np.eye(self.d))[None]
        self.cost = np.zeros(1)
        self.geometry, self.thickness_px, self.own = geometry, thickness_px, own
        self.telling = telling
        self._home = state[0]
        plain = telling.jerk**2 * np.kron(_GAIN @ _GAIN.T, np.eye(self.d))
        kick = 4.0 * plain + telling.kick**2 * np.kron(_JUMP, np.eye(self.d))
        self._noise = np.stack([plain, kick])
        self._table = np.ascontiguousarray(geometry.table.T)
        self._spread = (np.array([telling.good, telling.bad]) * thickness_px[:, None]) ** 2
        self._extra = np.array([0.0, telling.bad_cost])
        self._past: list[tuple[np.ndarray, np.ndarray]] = []
        self._hidden = np.zeros(1, bool)
        self._origin = np.zeros(1, int)
        self._taken = np.full((1, len(thickness_px)), -1)

    def advance(self) -> None:
        """Go on by one frame: every story plainly, and with a kick."""
        n = len(self.cost)
        self.mean, self.covariance = loops.advance(self.mean, self.covariance, self._noise)
        self.cost = np.concatenate([self.cost, self.cost + self.telling.kick_cost])
        self._origin = np.tile(np.arange(n), 2)
        self._taken = np.full((2 * n, len(self.thickness_px)), -1)

    def see(self, view: int, at: np.ndarray, cost: np.ndarray) -> None:
        """Take in one of a view's candidates, or none.

        Parameters
        ----------
        view : int
            Its number.
        at : ndarray, shape (c, 2)
            Where each candidate says the point is, px.
        cost : ndarray, shape (c,)
            What speaks against each: a poor look, or that another point explains it.
        """
        told = self.telling
        seen = told.seen if self.own[view] else told.seen_across
        missed = self.cost if self.own[view] else self.cost - np.log(1.0 - seen)
        if not len(at):
            self.cost = missed
            return
        nothing = np.log(told.clutter / self.thickness_px[view] ** 2 * 2.0 * np.pi / seen)
        self.mean, self.covariance, self.cost, origin, candidate = loops.see(
            self.mean, self.covariance, missed, self.cost, self._table[view], at,
            nothing + cost, self._spread[view], self._extra, _GATE, told.most_within,
        )  # fmt: skip
        self._origin, self._taken = self._origin[origin], self._taken[origin]
        self._taken[:, view] = candidate

    def stand(self, at: np.ndarray) -> None:
        """Take in a certain place (d,)."""
        self.mean, self.covariance, self.cost = loops.stand(
            self.mean, self.covariance, self.cost, at, self.telling.noise**2
        )

    def expect(
        self, at: np.ndarray, axes: np.ndarray, variance: np.ndarray, *, most: float
    ) -> None:
        """Take in where the point is expected.

        Parameters
        ----------
        at, variance : ndarray, shape (d,)
            The expected place, and its variances along the axes.
        axes : ndarray, shape (d, d)
            Unit vectors.
        most : float
            Largest cost of being elsewhere.
        """
        self.mean, self.covariance, self.cost = loops.expect(
            self.mean, self.covariance, self.cost, at, axes, variance, most
        )

    def settle(
        self, doubt: Callable[[np.ndarray, np.ndarray], np.ndarray], *, certain: bool = False
    ) -> None:
        """End the frame: forget unlikely stories and those that tell the same.

        Parameters
        ----------
        doubt : callable
            What speaks against positions and speeds (b, d), as a cost (b,).
        certain : bool
            Whether the frame had a certain place, so that nothing is hidden.
        """
        told, d = self.telling, self.d
        far = loops.beyond(self.mean[:, :d], self._home, told.reach)
        self.cost = self.cost + np.where(far, _ASTRAY, 0.0)
        hidden = np.zeros(len(far), bool)
        if not certain:
            price, hidden = loops.hiding(
                self._taken, self.own, self._hidden[self._origin], told.hide, told.stay,
                told.show, told.half,
            )  # fmt: skip
            self.cost = self.cost + price
        self.cost = self.cost + doubt(self.mean[:, :d], self.mean[:, d : 2 * d])
        spread = self.covariance.diagonal(axis1=1, axis2=2)[:, : 2 * d]
        grain = 0.5 * told.noise + told.alike * np.sqrt(spread)
        keep = loops.different(self.mean[:, : 2 * d], grain, self.cost, _LAG, told.most)
        self.mean, self.cost = self.mean[keep], self.cost[keep]
        # rounding makes it lopsided, and that grows from frame to frame
        covariance = self.covariance[keep]
        self.covariance = 0.5 * (covariance + covariance.transpose(0, 2, 1))
        self._hidden = hidden[keep]
        self._past.append((self._origin[keep], self._taken[keep]))

    def best(self) -> np.ndarray:
        """Return which candidate (frames, V) the likeliest story took, -1 where none."""
        at = int(np.argmin(self.cost))
        told = []
        for origin, taken in reversed(self._past):
            told.append(taken[at])
            at = int(origin[at])
        return np.stack(told[::-1])


def state_after(
    places: np.ndarray, drift: np.ndarray, *, telling: Telling, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return state (3, d) and covariance (3, 3) at the last of consecutive certain places.

    Parameters
    ----------
    places : ndarray, shape (n, d)
        The places.
    drift : ndarray, shape (d,)
        Speed before anything is known of it.
    telling : Telling
        How points move.
    speed : float
        Standard deviation of an unknown speed.
    """
    noise = telling.jerk**2 * _GAIN @ _GAIN.T
    mean = np.stack([places[0], drift, np.zeros(places.shape[1])])
    P = np.diag([telling.noise**2, speed**2, (3.0 * telling.jerk) ** 2])
    for place in places[1:]:
        mean, P = _STEP @ mean, _STEP @ P @ _STEP.T + noise
        gain = P[:, 0] / (P[0, 0] + telling.noise**2)
        mean = mean + gain[:, None] * (place - mean[0])
        P = P - np.outer(gain, P[0])
    return mean, P
