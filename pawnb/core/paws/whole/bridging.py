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
    sideways : float
        Points change their speed so much less to the side than forward and up.
    hold, slip : float
        Standard deviation of where a point stands, and of what it moves there from frame to
        frame, in ``noise``.
    lifting : float
        Standard deviation of how lift-off changes the speed, in ``kick``.
    covered : float
        Cost of standing where another paw covers the point.
    rising, swinging : int
        Frames after lift-off in which a paw may look poor, and in which it swings for certain.
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
    sideways: float = 0.3
    hold: float = 0.4
    slip: float = 0.1
    lifting: float = 0.5
    covered: float = 0.6
    rising: int = 0
    swinging: int = 0
    alike: float = 0.5
    most: int = 40
    most_within: int = 150


@dataclass(frozen=True)
class Start:
    """A point that stands where stories begin.

    Parameters
    ----------
    place, drift : ndarray, shape (d,)
        Where it stands, and the speed of the ground.
    lift : ndarray, shape (d,)
        How much its speed changes at lift-off.
    """

    place: np.ndarray
    drift: np.ndarray
    lift: np.ndarray


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
    start : Start, optional
        Where the point stands, if it does: it goes on standing until it lifts off.
    across : ndarray, shape (d,), optional
        Unit vector to the side.
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
        start: Start | None = None,
        across: np.ndarray | None = None,
    ) -> None:
        self.d, self.telling = state.shape[1], telling
        self.mean = state.reshape(1, -1).copy()
        self.covariance = np.kron(covariance, np.eye(self.d))[None]
        self._start = start
        self._standing = np.array([start is not None])
        if start is not None:
            self.mean[0, : self.d] = start.place
            self._hold(np.zeros(1, int), np.full((1, self.d), (telling.hold * telling.noise) ** 2))
        self.cost = np.zeros(1)
        self.geometry, self.thickness_px, self.own = geometry, thickness_px, own
        self._home = state[0]
        along = np.eye(self.d)
        if across is not None:
            along -= (1.0 - telling.sideways**2) * np.outer(across, across)
        plain = telling.jerk**2 * np.kron(_GAIN @ _GAIN.T, along)
        kick = telling.kick**2 * np.kron(_JUMP, along)
        self._noise = np.stack([plain, 4.0 * plain + kick])
        # how a paw lifts off is known better than how it is kicked
        self._known = (telling.lifting**2 - 1.0) * kick
        self._table = np.ascontiguousarray(geometry.table.T)
        self._spread = (np.array([telling.good, telling.bad]) * thickness_px[:, None]) ** 2
        self._extra = np.array([0.0, telling.bad_cost])
        self._past: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self._hidden = np.zeros(1, bool)
        self._origin = np.zeros(1, int)
        self._since = np.zeros(1, int)  # frames since it lifted off, 0 if it did not
        self._taken = np.full((1, len(thickness_px)), -1)

    def advance(self, *, lifting: float = 0.0) -> None:
        """Go on by one frame: every story plainly, and with a kick.

        What stands goes with the ground, whatever is seen; a kick is its lift-off.

        Parameters
        ----------
        lifting : float
            Cost of lifting off now.
        """
        n, d = len(self.cost), self.d
        standing = np.flatnonzero(self._standing)
        spread = self.covariance.diagonal(axis1=1, axis2=2)[standing, :d]
        self.mean, self.covariance = loops.advance(self.mean, self.covariance, self._noise)
        # every paw that stands lifts off once
        price = np.where(self._standing, lifting, self.telling.kick_cost)
        self.cost = np.concatenate([self.cost, self.cost + price])
        self._origin = np.tile(np.arange(n), 2)
        self._taken = np.full((2 * n, len(self.thickness_px)), -1)
        since = np.where(self._since > 0, self._since + 1, 0)
        self._since = np.concatenate([since, np.where(self._standing, 1, since)])
        self._standing = np.concatenate([self._standing, np.zeros(n, bool)])
        if self._start is not None and len(standing):
            self._hold(standing, spread + (self.telling.slip * self.telling.noise) ** 2)
            # some time between the frames
            self.mean[n + standing, :d] += 0.5 * self._start.lift
            self.mean[n + standing, d : 2 * d] += self._start.lift
            self.covariance[n + standing] += self._known

    def _hold(self, which: np.ndarray, variance: np.ndarray) -> None:
        """Let stories stand where they are, with variances (stories, d) of that."""
        if self._start is None:
            return
        d = self.d
        self.mean[which, d : 2 * d], self.mean[which, 2 * d :] = self._start.drift, 0.0
        own = np.zeros((len(which), 3 * d))
        own[:, :d], own[:, d : 2 * d] = variance, (self.telling.slip * self.telling.noise) ** 2
        self.covariance[which] = own[:, :, None] * np.eye(3 * d)

    def see(
        self, view: int, at: np.ndarray, cost: np.ndarray, *, rising: np.ndarray | None = None
    ) -> None:
        """Take in one of a view's candidates, or none.

        Parameters
        ----------
        view : int
            Its number.
        at : ndarray, shape (c, 2)
            Where each candidate says the point is, px.
        cost : ndarray, shape (c,)
            What speaks against each: a poor look, or that another point explains it.
        rising : ndarray, shape (c,), optional
            The same for a paw that has just lifted off; default as for others.
        """
        told = self.telling
        seen = told.seen if self.own[view] else told.seen_across
        missed = self.cost if self.own[view] else self.cost - np.log(1.0 - seen)
        if not len(at):
            self.cost = missed
            return
        nothing = np.log(told.clutter / self.thickness_px[view] ** 2 * 2.0 * np.pi / seen)
        rises = (self._since > 0) & (self._since <= told.rising)
        if rising is None or not rises.any():
            self.mean, self.covariance, self.cost, origin, candidate = self._seen(
                view, slice(None), missed, at, nothing + cost
            )
        else:
            parts = []
            for group, against in ((~rises, cost), (rises, rising)):
                i = np.flatnonzero(group)
                *state, origin, candidate = self._seen(view, i, missed, at, nothing + against)
                parts.append((*state, i[origin], candidate))
            both = [np.concatenate(part) for part in zip(*parts, strict=True)]
            # as many are kept as of one group
            keep = np.argsort(both[2], kind="stable")[: told.most_within]
            self.mean, self.covariance, self.cost, origin, candidate = (part[keep] for part in both)
        self._origin, self._taken = self._origin[origin], self._taken[origin]
        self._standing, self._since = self._standing[origin], self._since[origin]
        self._taken[:, view] = candidate

    def _seen(
        self,
        view: int,
        which: np.ndarray | slice,
        missed: np.ndarray,
        at: np.ndarray,
        against: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return what becomes of some stories that take in one of a view's candidates, or none."""
        return loops.see(
            self.mean[which], self.covariance[which], missed[which], self.cost[which],
            self._table[view], at, against, self._spread[view], self._extra, _GATE,
            self.telling.most_within,
        )  # fmt: skip

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
        self,
        doubt: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray],
        *,
        certain: bool = False,
        covered: np.ndarray | None = None,
    ) -> None:
        """End the frame: forget unlikely stories and those that tell the same.

        Parameters
        ----------
        doubt : callable
            What speaks against positions and speeds (b, d), given which (b,) have just lifted
            off, as a cost (b,).
        certain : bool
            Whether the frame had a certain place, so that nothing is hidden.
        covered : ndarray of bool, shape (V,), optional
            Views in which another paw covers the point if it stands.
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
            if covered is not None and covered[self.own].all():
                price = np.where(self._standing & hidden, told.covered, price)
            self.cost = self.cost + price
        recent = (self._since > 0) & (self._since <= told.swinging)
        self.cost = self.cost + doubt(self.mean[:, :d], self.mean[:, d : 2 * d], recent)
        spread = self.covariance.diagonal(axis1=1, axis2=2)[:, : 2 * d]
        # rounding may take a variance below nothing
        grain = 0.5 * told.noise + told.alike * np.sqrt(np.maximum(spread, 0.0))
        # one that stands is another story than one that is where it would be
        key = np.column_stack([self.mean[:, : 2 * d], self._standing])
        grain = np.column_stack([grain, np.full(len(grain), 0.5)])
        keep = loops.different(key, grain, self.cost, _LAG, told.most)
        self.mean, self.cost = self.mean[keep], self.cost[keep]
        # rounding makes it lopsided, and that grows from frame to frame
        covariance = self.covariance[keep]
        self.covariance = 0.5 * (covariance + covariance.transpose(0, 2, 1))
        self._hidden = hidden[keep]
        self._standing, self._since = self._standing[keep], self._since[keep]
        self._past.append((self._origin[keep], self._taken[keep], self._standing))

    def best(self) -> np.ndarray:
        """Return which candidate (frames, V) the likeliest story took, -1 where none."""
        return np.stack([taken for taken, _ in self._told()])

    def stood(self) -> np.ndarray:
        """Return in which frames (frames,) the point stands in the likeliest story."""
        return np.array([standing for _, standing in self._told()], dtype=bool)

    def _told(self) -> list[tuple[np.ndarray, bool]]:
        """Return what the likeliest story took in each frame, and whether it stood."""
        at = int(np.argmin(self.cost))
        told = []
        for origin, taken, standing in reversed(self._past):
            told.append((taken[at], bool(standing[at])))
            at = int(origin[at])
        return told[::-1]


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
