"""What a paw looks like in one view, learnt from the clicks: a table of log-likelihood ratios.

A colour is looked up in a table of 32 x 32 x 32 bins (in a grey picture: of brightness, of
what it exceeds the still background by, and of what it exceeds the surroundings by). Its
entry is the logarithm of how much likelier the colour is on a paw than in the rest of the
picture around the animal. The paw's density is one Gaussian, grown from the clicks: pixels
that belong to it and hang together with a click are taken in, and the Gaussian is fitted
again. The rest is a smoothed histogram.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from pawnb.core.paws.whole.still import to_grey

_BINS = 32
_SHIFT = 3
_ROUNDS = 4
_REACH = 0.03
"""A paw reaches this far from its click, as a share of the picture's width."""
_LEARNT_WIDTH = 1024
"""Larger colour pictures are reduced to about this width before their look is learnt."""
_WIDE = 0.06
_LIMIT = 6.0
"""Largest log-likelihood ratio either way: one pixel never decides alone."""


@dataclass(frozen=True)
class Appearance:
    """The look of the paws in one view.

    Parameters
    ----------
    table : ndarray, shape (32768,), float32
        Log-likelihood ratio of each bin.
    thickness_px : float
        Thickness of a paw's picture at the clicks, px of the view.
    around_px : int
        Side of the square over which a grey picture's surroundings are averaged.
    background : ndarray, optional
        What stands still in a whole grey picture of the view, uint8.
    """

    table: np.ndarray
    thickness_px: float
    around_px: int
    background: np.ndarray | None = None

    def score(
        self, pixels: np.ndarray, origin: tuple[int, int] = (0, 0), *, shrink: int = 1
    ) -> np.ndarray:
        """Return the log-likelihood ratio (h, w) float32 of a part of the view.

        Parameters
        ----------
        pixels : ndarray, shape (h, w, 3) or (h, w)
            The part, reduced, uint8.
        origin : tuple of int
            Its left and top in the view, px.
        shrink : int
            Factor by which the part was reduced.

        Returns
        -------
        ndarray, shape (h, w)
            The ratio.
        """
        still = None
        if self.background is not None:
            (u0, v0), (h, w) = origin, pixels.shape[:2]
            pixels = to_grey(pixels)
            part = self.background[v0 : v0 + h * shrink, u0 : u0 + w * shrink]
            still = reduce(part, shrink)
        around = 2 * round(self.around_px / shrink / 2) + 1
        return np.asarray(self.table.take(bin_numbers(pixels, around, still)))


def reduce(pixels: np.ndarray, shrink: int) -> np.ndarray:
    """Return a picture reduced by a whole factor."""
    if shrink == 1:
        return pixels
    h, w = pixels.shape[:2]
    size = (w // shrink, h // shrink)
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def bin_numbers(
    pixels: np.ndarray, around_px: int, background: np.ndarray | None = None
) -> np.ndarray:
    """Return the bin (h, w) of each pixel of an RGB or a grey picture."""
    pixels = cv2.GaussianBlur(pixels, (3, 3), 0.8)
    if pixels.ndim == 2:
        p = pixels.astype(np.int32)
        over_around = _over(p, cv2.blur(pixels, (around_px, around_px)))
        # the same where nothing is known to stand still: it then says nothing
        over_still = np.zeros_like(p) if background is None else _over(p, background)
        return ((p >> _SHIFT) << 10) | (over_still << 5) | over_around
    # five bits each of red, green and blue, in one number
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR555).view(np.uint16)[..., 0]


def _over(pixels: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return by how many steps of 8 grey levels pixels exceed others, from -8 as 0 to 31."""
    return np.asarray(np.clip((pixels - base + (8 << _SHIFT)) >> _SHIFT, 0, _BINS - 1))


def _features(is_colour: bool) -> np.ndarray:
    """Return the features of the middle of every bin: CIE Lab, or three grey levels."""
    n = np.arange(_BINS**3)
    levels = np.stack([n >> 10, (n >> 5) & 31, n & 31], axis=1) * 8.0 + 3.5
    if not is_colour:
        return levels
    lab = cv2.cvtColor((levels[None] / 255.0).astype(np.float32), cv2.COLOR_RGB2LAB)
    return lab[0].astype(float)


def learn(
    pictures: Sequence[np.ndarray],
    clicks: Sequence[np.ndarray],
    *,
    around_px: int,
    backgrounds: Sequence[np.ndarray | None] | None = None,
) -> Appearance:
    """Learn the look of the paws in one view.

    Parameters
    ----------
    pictures : sequence of ndarray
        The surroundings of the animal in each clicked frame, RGB or grey, uint8.
    clicks : sequence of ndarray, shape (n, 2)
        Clicks in each of them, px of that picture.
    around_px : int
        See :class:`Appearance`.
    backgrounds : sequence of ndarray, optional
        What stands still in each of them.

    Returns
    -------
    Appearance
        The learnt look, without a background.
    """
    is_colour, shrink = pictures[0].ndim == 3, 1
    features = _features(is_colour)
    width: float = max(picture.shape[1] for picture in pictures)
    if is_colour:
        parts = [_about(*one, round(_WIDE * width)) for one in zip(pictures, clicks, strict=True)]
        # noise and fine marks of a large picture would pass for paws and for what is none
        shrink = max(1, round(width / _LEARNT_WIDTH))
        width /= shrink
        parts = [_reduced(*part, shrink) for part in parts]
        pictures, clicks = [part[0] for part in parts], [part[1] for part in parts]
    still = backgrounds or [None] * len(pictures)
    numbers = [bin_numbers(p, around_px, b) for p, b in zip(pictures, still, strict=True)]
    reach = [
        _patch(n.shape, uv, round(_REACH * width)) for n, uv in zip(numbers, clicks, strict=True)
    ]
    # a grey animal has other parts as bright as its paws: the whole picture tells against them
    far = _WIDE if is_colour else 1.0
    wide = [_patch(n.shape, uv, round(far * width)) for n, uv in zip(numbers, clicks, strict=True)]
    seeds = [_patch(shape.shape, uv, 1) for shape, uv in zip(numbers, clicks, strict=True)]
    floor = np.diag([5.0, 2.0, 2.0] if is_colour else [12.0, 12.0, 12.0]) ** 2
    members = np.concatenate([number[seed] for number, seed in zip(numbers, seeds, strict=True)])
    grown = seeds
    for _ in range(_ROUNDS):
        positive = _gaussian(features, features[members], floor)
        outside = np.concatenate(
            [n[w & ~_spread(g)] for n, w, g in zip(numbers, wide, grown, strict=True)]
        )
        negative = _histogram(outside)
        table = np.log(positive + 1e-12) - np.log(negative + 1e-12)
        limit = 1.5
        grown = [
            _grow((_even(table[n]) > limit) & r, seed)
            for n, r, seed in zip(numbers, reach, seeds, strict=True)
        ]
        taken = np.concatenate([n[g] for n, g in zip(numbers, grown, strict=True)])
        if len(taken) > 9:
            members = taken
    table = np.clip(table - limit, -_LIMIT, _LIMIT).astype(np.float32)
    return Appearance(table, shrink * _thickness(numbers, table, clicks), around_px)


def _about(picture: np.ndarray, clicks: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the part of a picture that the clicks' surroundings cover, and clicks in it."""
    margin = reach + 8  # filters see a little farther
    low = np.maximum(np.floor(clicks.min(axis=0)).astype(int) - margin, 0)
    high = np.ceil(clicks.max(axis=0)).astype(int) + margin + 1
    return picture[low[1] : high[1], low[0] : high[0]], clicks - low


def _reduced(picture: np.ndarray, clicks: np.ndarray, shrink: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a picture reduced by a whole number, and clicks in it."""
    h, w = (side // shrink for side in picture.shape[:2])
    part = picture[: h * shrink, : w * shrink]
    small = cv2.resize(part, (w, h), interpolation=cv2.INTER_AREA)
    return small, (clicks + 0.5) / shrink - 0.5


def _even(score: np.ndarray) -> np.ndarray:
    """Take the noise of single pixels out of a score."""
    return cv2.GaussianBlur(score.astype(np.float32), (3, 3), 0.6)


def _patch(shape: tuple[int, ...], uv: np.ndarray, reach: int) -> np.ndarray:
    """Mark the pixels within ``reach`` of some positions."""
    mark = np.zeros(shape[:2], bool)
    for u, v in np.round(np.atleast_2d(uv)).astype(int):
        mark[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1] = True
    return mark


def _spread(mask: np.ndarray) -> np.ndarray:
    """Widen a mask by two pixels: edges of a paw are neither paw nor surroundings."""
    return cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0


def _gaussian(features: np.ndarray, members: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """Return the probability of each bin under a Gaussian fitted to some members."""
    middle = np.median(members, axis=0)
    step = members - middle
    covariance = step.T @ step / max(len(members) - 1, 1) * 1.3 + floor
    away = features - middle
    power = np.einsum("ij,jk,ik->i", away, np.linalg.inv(covariance), away)
    weight = np.exp(-0.5 * power)
    return np.asarray(weight / weight.sum())


def _histogram(numbers: np.ndarray) -> np.ndarray:
    """Return the smoothed frequency of each bin."""
    count = np.bincount(numbers, minlength=_BINS**3).astype(float)
    count = gaussian_filter(count.reshape(_BINS, _BINS, _BINS), 0.7).ravel()
    return count / count.sum() * 0.99 + 0.01 / _BINS**3


def _grow(mask: np.ndarray, seed: np.ndarray) -> np.ndarray:
    """Return the connected parts of a mask that touch a seed."""
    _, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    touched = np.unique(labels[seed & mask])
    return np.isin(labels, touched[touched > 0])


def _thickness(
    numbers: Sequence[np.ndarray], table: np.ndarray, clicks: Sequence[np.ndarray]
) -> float:
    """Measure how thick the paws are at the clicks: twice the distance to their edge."""
    found = []
    for number, uv in zip(numbers, clicks, strict=True):
        mask = (cv2.GaussianBlur(table[number], (3, 3), 0.6) > 0).astype(np.uint8)
        depth = cv2.distanceTransform(mask, cv2.DIST_L2, 5)
        for u, v in np.round(uv).astype(int):
            for reach in (1, 2, 3, 5):
                near = depth[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
                if near.max() > 1:
                    found.append(2.0 * float(near.max()))
                    break
    return float(np.median(found)) if found else 6.0
