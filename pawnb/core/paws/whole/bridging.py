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
    most : int
        Stories kept.
    """

    jerk: float
    kick: float
    noise: float
    reach: float
    kick_cost: float = 3.0
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
    most: int = 40


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
        self._step = np.kron(_STEP, np.eye(self.d))
        self._noise = telling.jerk**2 * np.kron(_GAIN @ _GAIN.T, np.eye(self.d))
        self._kick = 4.0 * self._noise + telling.kick**2 * np.kron(_JUMP, np.eye(self.d))
        self._past: list[tuple[np.ndarray, np.ndarray]] = []
        self._hidden = np.zeros(1, bool)
        self._origin = np.zeros(1, int)
        self._taken = np.full((1, len(thickness_px)), -1)

    def advance(self) -> None:
        """Go on by one frame: every story plainly, and with a kick."""
        n = len(self.cost)
        mean = self.mean @ self._step.T
        covariance = self._step @ self.covariance @ self._step.T
        self.mean = np.concatenate([mean, mean])
        self.covariance = np.concatenate([covariance + self._noise, covariance + self._kick])
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
        told, scale, d = self.telling, self.thickness_px[view], self.d
        seen = told.seen if self.own[view] else told.seen_across
        missed = self.cost if self.own[view] else self.cost - np.log(1.0 - seen)
        if not len(at):
            self.cost = missed
            return
        x, P = self.mean[:, :d], self.covariance
        J = self.geometry.jacobian(x)[:, view]
        PH = P[:, :, :d] @ J.transpose(0, 2, 1)
        S = (J @ PH[:, :d])[None] + np.eye(2) * (
            np.array([told.good, told.bad])[:, None, None, None] * scale
        ) ** 2
        inverse, size = _inverse(S)
        step = at[None] - self.geometry.project(x)[:, view, None]
        square = np.einsum("bci,kbij,bcj->kbc", step, inverse, step, optimize=True)
        own = 0.5 * square + 0.5 * np.log(size)[..., None]
        own[1] += told.bad_cost
        own[square > _GATE] = np.inf
        kind = np.argmin(own, axis=0)
        best = np.min(own, axis=0) + np.log(told.clutter / scale**2 * 2.0 * np.pi / seen)
        best = best + cost[None] + self.cost[:, None]
        b, c = np.nonzero(np.isfinite(best))
        total = np.concatenate([missed, best[b, c]])
        keep = np.argsort(total, kind="stable")[: told.most]
        plain, new = keep[keep < len(missed)], keep[keep >= len(missed)] - len(missed)
        b, c = b[new], c[new]
        K = PH[b] @ inverse[kind[b, c], b]
        taken = self._taken[b]
        taken[:, view] = c
        self.mean = np.concatenate(
            [self.mean[plain], self.mean[b] + (K @ step[b, c][..., None])[..., 0]]
        )
        self.covariance = np.concatenate([P[plain], P[b] - K @ PH[b].transpose(0, 2, 1)])
        self.cost = total[keep[np.argsort(keep >= len(missed), kind="stable")]]
        self._origin = np.concatenate([self._origin[plain], self._origin[b]])
        self._taken = np.concatenate([self._taken[plain], taken])

    def stand(self, at: np.ndarray) -> None:
        """Take in a certain place (d,)."""
        P, d = self.covariance, self.d
        S = P[:, :d, :d] + np.eye(d) * self.telling.noise**2
        inverse = np.linalg.inv(S)
        step = at - self.mean[:, :d]
        square = np.einsum("bi,bij,bj->b", step, inverse, step)
        self.cost = self.cost + 0.5 * square + 0.5 * np.log(np.linalg.det(S))
        K = P[:, :, :d] @ inverse
        self.mean = self.mean + np.einsum("bij,bj->bi", K, step)
        self.covariance = P - K @ P[:, :d]

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
        away = np.linalg.norm(self.mean[:, :d] - self._home, axis=1)
        self.cost = self.cost + np.where(away > told.reach, _ASTRAY, 0.0)
        views = (self._taken[:, self.own] >= 0).sum(axis=1)
        hidden = (views == 0) & (not certain)
        if not certain:
            was = self._hidden[self._origin]
            part = told.half * (1.0 - views / max(1, int(self.own.sum())))
            self.cost = self.cost + np.where(
                hidden, np.where(was, told.stay, told.hide), np.where(was, told.show, 0.0) + part
            )
        self.cost = self.cost + doubt(self.mean[:, :d], self.mean[:, d : 2 * d])
        order = np.argsort(self.cost, kind="stable")
        order = order[self.cost[order] < self.cost[order[0]] + _LAG]
        key = np.round(self.mean[order, : 2 * d] / told.noise).astype(int)
        _, first = np.unique(key, axis=0, return_index=True)
        keep = order[np.sort(first)][: told.most]
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


def _inverse(S: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return inverses and determinants of 2 x 2 matrices."""
    a, b, c, d = S[..., 0, 0], S[..., 0, 1], S[..., 1, 0], S[..., 1, 1]
    size = a * d - b * c
    inverse = np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    return inverse / size[..., None, None], size


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
