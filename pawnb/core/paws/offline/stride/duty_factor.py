"""When paws lift off: for which share of a stride, from touch-down to touch-down, they stand.

Touch-downs are mostly seen, lift-offs are often occluded behind the paw that lands beside. But an
animal that runs steadily stands for much the same share of every stride, left as right. That is
learnt from the recording's strides, and says when a paw that is occluded is due to lift off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pawnb.arrays import FloatArray, IntArray
from pawnb.core.paws.offline.stride.parameters import STRIDE
from pawnb.core.paws.offline.stride.stance import Stance


@dataclass(frozen=True)
class DutyFactor:
    """For which share of a stride each point stands.

    Parameters
    ----------
    share, sd : ndarray, shape (P,)
        The share and the standard deviation of a single one.
    stride, spread : float
        Usual length of a stride, frames, and the standard deviation of single ones.
    """

    share: FloatArray
    sd: FloatArray
    stride: float
    spread: float

    def due(
        self, point: int, now: Stance, following: Stance | None, *, frames: IntArray
    ) -> FloatArray:
        """Return what speaks against lifting off just before each of some frames.

        Parameters
        ----------
        point : int
            Its number.
        now, following : Stance
            The stance that ends with the lift-off, and the next one, None where none is known.
        frames : ndarray of int, shape (n,)
            The frames.

        Returns
        -------
        ndarray, shape (n,)
            Costs: half the squared distance from the expected lift-off, in standard deviations.
        """
        share, sd = self.share[point], self.sd[point]
        stride, more = self.stride, self.spread
        if now.first > 0 and following is not None:
            stride, more = float(following.first - now.first), 0.0
        if not self.is_usual(stride):
            return np.zeros(len(frames))
        if now.first > 0:
            at, more = now.first + share * stride, share * more
        elif following is not None:
            # it stood before the first frame
            at, more = following.first - (1.0 - share) * stride, (1.0 - share) * more
        else:
            return np.zeros(len(frames))
        square = (frames - at) ** 2 / ((sd * stride) ** 2 + more**2)
        return np.minimum(0.5 * square, STRIDE.most_cost)

    def shortest_swing(self, point: int) -> float:
        """Return the frames that a swing of a point lasts at least."""
        return STRIDE.duty_factor_hop * (1.0 - float(self.share[point])) * self.stride

    def is_usual(self, stride: float) -> bool:
        """Tell whether a stride is about as long as most."""
        return self.stride / STRIDE.unusual_ratio < stride < self.stride * STRIDE.unusual_ratio


def learn_duty_factor(
    stances: Sequence[Sequence[Stance]], kinds: Sequence[str]
) -> DutyFactor | None:
    """Learn for which share of a stride points stand.

    Parameters
    ----------
    stances : sequence
        Those of each point.
    kinds : sequence of str
        Kind of each point: those of a kind have one rhythm.

    Returns
    -------
    DutyFactor or None
        None with too few strides, or where they make up little of the recording.
    """
    strides = [
        (kind, now.stop - now.first, after.first - now.first)
        for kind, mine in zip(kinds, stances, strict=True)
        for now, after in pairwise(mine)
        if now.first > 0
    ]
    if len(strides) < STRIDE.duty_factor_least:
        return None
    length = np.array([stride for _, _, stride in strides], dtype=float)
    usual = float(np.median(length))
    kept = (length > usual / STRIDE.unusual_ratio) & (length < usual * STRIDE.unusual_ratio)
    shares = {}
    for kind in set(kinds):
        own = [k and of == kind for k, (of, _, _) in zip(kept, strides, strict=True)]
        found = np.array([stood / stride for _, stood, stride in strides])[own]
        if len(found) >= STRIDE.duty_factor_least:
            shares[kind] = _usual(found)
    if not shares:
        return None
    if float(length[kept].sum()) < STRIDE.duty_factor_covered * _lasts(stances):
        return None
    spread = STRIDE.duty_factor_mad * float(np.median(np.abs(length[kept] - usual)))
    share, sd = np.array([_of_kind(kind, shares) for kind in kinds]).T
    return DutyFactor(share, sd, usual, spread)


def _lasts(stances: Sequence[Sequence[Stance]]) -> int:
    """Return the frames from the first stance of any point to the last, times the points."""
    every = [one for mine in stances for one in mine]
    first, stop = min(one.first for one in every), max(one.stop for one in every)
    return len(stances) * (stop - first)


def _usual(shares: FloatArray) -> tuple[float, float]:
    """Return the middle of shares and its standard error."""
    middle = float(np.median(shares))
    sd = STRIDE.duty_factor_mad * float(np.median(np.abs(shares - middle)))
    return middle, STRIDE.of_median * float(np.hypot(sd, STRIDE.duty_factor_finest)) / np.sqrt(
        len(shares)
    )


def _of_kind(kind: str, shares: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """Return share and standard deviation of a kind, from its own strides and those of others."""
    middle = np.array([middle for middle, _ in shares.values()])
    more = np.array([0.0 if of == kind else STRIDE.like_others for of in shares])
    weight = 1.0 / (np.array([error for _, error in shares.values()]) ** 2 + more**2)
    return float(weight @ middle / weight.sum()), float(
        np.sqrt(STRIDE.duty_factor_finest**2 + 1.0 / weight.sum())
    )
