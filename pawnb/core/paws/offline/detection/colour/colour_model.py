"""What a paw looks like in one view, learnt from the clicks: a table of log-likelihood ratios.

A colour is looked up in a table of 32 x 32 x 32 bins (in a grey picture: of brightness, of
what it exceeds the still background by, and of what it exceeds the surroundings by). Its
entry is the logarithm of how much likelier the colour is on a paw than in the rest of the
picture around the animal. The paws' density is the mean of one Gaussian a picture, as light
comes from one side; each is grown from its clicks: pixels that belong to it and hang together
with a click are taken in, and the Gaussian is fitted again. The rest is a smoothed histogram
of what is near the paws, averaged with that of all that is about the animal.

Where much of what is about the animal would pass for paws by these bins, as on a belt as brown
as they are, the table is learnt anew of finer steps of colour; see
:mod:`pawnb.core.paws.offline.detection.colour.photometry.colour_quantisation`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from pawnb.arrays import AnyArray, BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from pawnb.core.paws.offline.detection.colour.detector_kernels import look_up, score_colours
from pawnb.core.paws.offline.detection.colour.photometry.background import to_grey
from pawnb.core.paws.offline.detection.colour.photometry.colour_quantisation import (
    FineColours,
    bin_numbers,
    features_of_bins,
    fine_colours_floor,
    fine_colours_near,
    histogram_of_bins,
    smooth_fine_colours,
)
from pawnb.core.paws.offline.detection.colour.photometry.paw_width import paw_width_at
from pawnb.core.paws.offline.detection.colour_parameters import COLOUR
from pawnb.core.pixels.masks import dilate, disk_mask, region_grow

_FILTERS = 8
"""Layout: px beside what is looked at that filters see."""


@dataclass(frozen=True)
class Appearance:
    """The appearance of paws in one view.

    Parameters
    ----------
    table : ndarray, shape (32768,), float32
        Log-likelihood ratio of each bin.
    paw_width_px : float
        Width of a paw's picture at the clicks, px of the view.
    around_px : int
        Side of the square over which a grey picture's surroundings are averaged.
    background : ndarray, optional
        What stands still in a whole grey picture of the view, uint8.
    usual : float
        Score that clicked paws have.
    mistaken : float
        Share of what is about the animal that would pass for paws by the usual bins.
    fine_colours : FineColours, optional
        What turns a colour into finer steps.
    """

    table: Float32Array
    paw_width_px: float
    around_px: int
    background: ByteArray | None = None
    usual: float = field(default_factory=lambda: COLOUR.colour_model_limit)
    mistaken: float = 0.0
    fine_colours: FineColours | None = None

    @property
    def is_faint(self) -> bool:
        """Whether paws are hardly distinguished from their surroundings, even by finer steps."""
        return self.fine_colours is not None and self.fine_colours.is_faint

    def score(
        self, pixels: ByteArray, origin: tuple[int, int] = (0, 0), *, shrink: int = 1
    ) -> AnyArray:
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
        if pixels.ndim == 3 and self.background is None and self.fine_colours is None:
            return score_colours(pixels, self.table)
        still = None
        if self.background is not None:
            (u0, v0), (h, w) = origin, pixels.shape[:2]
            pixels = to_grey(pixels)
            part = self.background[v0 : v0 + h * shrink, u0 : u0 + w * shrink]
            still = reduce(part, shrink)
        around = 2 * round(self.around_px / shrink / 2) + 1
        score = look_up(
            self.table, bin_numbers(pixels, around, still, fine_colours=self.fine_colours)
        )
        return score if self.fine_colours is None else self.fine_colours.stand_out(score)


def reduce(pixels: ByteArray, shrink: int) -> ByteArray:
    """Return a picture reduced by a whole factor."""
    if shrink == 1:
        return pixels
    h, w = pixels.shape[:2]
    size = (w // shrink, h // shrink)
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA))


def learn(
    pictures: Sequence[ByteArray],
    clicks: Sequence[FloatArray],
    *,
    around_px: int,
    backgrounds: Sequence[ByteArray | None] | None = None,
) -> Appearance:
    """Learn the appearance of paws in one view.

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
        The learnt appearance, without a background.
    """
    training_set = _prepare(pictures, clicks, around_px, backgrounds or [None] * len(pictures))
    look = training_set.learn()
    if training_set.is_colour and look.mistaken > COLOUR.colour_model_alike:
        is_faint = look.mistaken > COLOUR.colour_model_faint
        fine = training_set.learn(
            fine_colours_near(training_set.colours(is_faint), is_faint=is_faint)
        )
        look = replace(fine, mistaken=look.mistaken)
    return look


@dataclass(frozen=True)
class _TrainingSet:
    """What the appearance of paws is learnt from; see :func:`learn`."""

    pictures: Sequence[ByteArray]
    clicks: Sequence[FloatArray]
    around_px: int
    still: Sequence[ByteArray | None]
    width: float
    shrink: int

    @property
    def is_colour(self) -> bool:
        """Whether the pictures are in colour."""
        return self.pictures[0].ndim == 3

    def colours(self, is_faint: bool) -> ByteArray:
        """Return the colours (n, 3) at the clicks, smoothed as where paws are faint or not."""
        return np.concatenate(
            [
                smooth_fine_colours(picture, is_faint)[seed]
                for picture, seed in zip(self.pictures, self.patches(1), strict=True)
            ]
        )

    def patches(self, reach: int) -> list[BoolArray]:
        """Mark what is so near to the clicks of each picture."""
        return [
            disk_mask(picture.shape, uv, reach)
            for picture, uv in zip(self.pictures, self.clicks, strict=True)
        ]

    def learn(self, fine_colours: FineColours | None = None) -> Appearance:
        """Learn the appearance by the usual bins, or by finer steps of colour."""
        # a grey animal has other parts as bright as its paws: the whole picture tells against them
        near, wides = (
            (COLOUR.colour_model_reach, COLOUR.colour_model_wide)
            if self.is_colour
            else (COLOUR.reach_grey, (1.0,))
        )
        numbers = [
            bin_numbers(p, self.around_px, b, fine_colours=fine_colours)
            for p, b in zip(self.pictures, self.still, strict=True)
        ]
        seeds, rest = self.patches(1), [self.patches(round(w * self.width)) for w in wides]

        def told(near: float) -> tuple[FloatArray, float]:
            """Return the ratio learnt so near to the clicks, and what is usual at them."""
            close = self.patches(round(near * self.width))
            ratio = _ratio(
                numbers, seeds, close, rest, is_colour=self.is_colour, fine_colours=fine_colours
            )
            return ratio, float(np.median(_scores(ratio, numbers, seeds)))

        ratio, usual = told(near)
        if (
            self.is_colour
            and sum(map(len, self.clicks)) < COLOUR.colour_model_few
            and usual > COLOUR.colour_model_distinct
        ):
            ratio, usual = told(COLOUR.reach_few)
        limit = COLOUR.colour_model_sure * min(1.0, max(usual, 0.0) / 2.0)
        if fine_colours is not None:
            passing = self._passing(ratio, numbers, rest[0])
            limit = max(limit, min(passing, COLOUR.most_limit * usual))
        gain = COLOUR.colour_model_usual / max(usual - limit, COLOUR.least_margin)
        gain = float(np.clip(gain, 1.0, COLOUR.most_gain))
        table = np.clip(
            (ratio - limit) * gain, -COLOUR.colour_model_limit, COLOUR.colour_model_limit
        ).astype(np.float32)
        standing = [
            table[n] if fine_colours is None else fine_colours.stand_out(table[n]) for n in numbers
        ]
        at_clicks = np.median(
            np.concatenate([_even(s)[k] for s, k in zip(standing, seeds, strict=True)])
        )
        return Appearance(
            table,
            self.shrink * paw_width_at(numbers, table, self.clicks),
            self.around_px,
            usual=float(np.clip(at_clicks, COLOUR.least_usual, COLOUR.colour_model_limit)),
            mistaken=float(np.mean(_scores(table, numbers, rest[-1]) > 0.0)),
            fine_colours=fine_colours,
        )

    def _passing(
        self, ratio: FloatArray, numbers: Sequence[IntArray], rest: Sequence[BoolArray]
    ) -> float:
        """Return the ratio that few pixels of the rest, paws left out, have more than."""
        paws = self.patches(round(2.0 * COLOUR.colour_model_reach * self.width))
        others = [part & ~paw for part, paw in zip(rest, paws, strict=True)]
        return float(
            np.quantile(_scores(ratio, numbers, others), 1.0 - COLOUR.colour_model_passing)
        )


def _prepare(
    pictures: Sequence[ByteArray],
    clicks: Sequence[FloatArray],
    around_px: int,
    still: Sequence[ByteArray | None],
) -> _TrainingSet:
    """Return what is learnt from: of colour pictures what is about the clicks, not too fine."""
    width, shrink = float(max(picture.shape[1] for picture in pictures)), 1
    if pictures[0].ndim == 3:
        reach = round(max(COLOUR.colour_model_wide) * width)
        parts = [_about(*one, reach) for one in zip(pictures, clicks, strict=True)]
        # noise and fine marks of a large picture would pass for paws and for what is none
        shrink = max(1, round(width / COLOUR.learnt_width))
        width /= shrink
        parts = [_reduced(*part, shrink) for part in parts]
        pictures, clicks = [part[0] for part in parts], [part[1] for part in parts]
    return _TrainingSet(pictures, clicks, around_px, still, width, shrink)


def _scores(
    table: np.ndarray, numbers: Sequence[IntArray], where: Sequence[BoolArray]
) -> Float32Array:
    """Return the entries of a table for the marked pixels of all pictures."""
    return np.concatenate([_even(table[n])[mark] for n, mark in zip(numbers, where, strict=True)])


def _ratio(
    numbers: Sequence[IntArray],
    seeds: Sequence[BoolArray],
    close: Sequence[BoolArray],
    rest: Sequence[Sequence[np.ndarray]],
    *,
    is_colour: bool,
    fine_colours: FineColours | None,
) -> FloatArray:
    """Return the log-likelihood ratio of each bin.

    Parameters
    ----------
    numbers : sequence of ndarray, shape (h, w)
        The bin of every pixel of each picture.
    seeds, close : sequence of ndarray of bool, shape (h, w)
        The clicks, and how far paws may reach from them.
    rest : sequence of sequence of ndarray of bool
        What tells against paws: parts of all pictures that count alike.
    is_colour : bool
        Whether the pictures are in colour.
    fine_colours : FineColours, optional
        What the bins are of; see :class:`Appearance`.
    """
    features = features_of_bins(is_colour, fine_colours)
    floor = np.diag(COLOUR.floor_lab if is_colour else COLOUR.floor_grey) ** 2
    if fine_colours is not None:
        floor = fine_colours_floor()
    members = [n[seed] for n, seed in zip(numbers, seeds, strict=True)]
    grown = list(seeds)
    for _ in range(COLOUR.colour_model_rounds):
        positive = np.mean([_gaussian(features, features[m], floor) for m in members], axis=0)
        free = [~dilate(g) for g in grown]
        negative = np.mean(
            [
                histogram_of_bins(
                    np.concatenate([n[w & f] for n, w, f in zip(numbers, part, free, strict=True)])
                )
                for part in rest
            ],
            axis=0,
        )
        ratio = np.log(positive + 1e-12) - np.log(negative + 1e-12)
        grown = [
            region_grow((_even(ratio[n]) > COLOUR.colour_model_like) & r, seed)
            for n, r, seed in zip(numbers, close, seeds, strict=True)
        ]
        members = [
            n[g] if g.sum() > COLOUR.fewest_members else old
            for n, g, old in zip(numbers, grown, members, strict=True)
        ]
    return ratio


def _about(picture: ByteArray, clicks: FloatArray, reach: int) -> tuple[ByteArray, FloatArray]:
    """Return the part of a picture that the clicks' surroundings cover, and clicks in it."""
    margin = reach + _FILTERS
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
    return cv2.GaussianBlur(score.astype(np.float32), (3, 3), COLOUR.score_blur_px)


def _gaussian(features: FloatArray, members: FloatArray, floor: FloatArray) -> FloatArray:
    """Return the probability of each bin under a Gaussian fitted to some members."""
    middle = np.median(members, axis=0)
    step = members - middle
    covariance = step.T @ step / max(len(members) - 1, 1) * COLOUR.wider + floor
    away = features - middle
    power = np.einsum("ij,jk,ik->i", away, np.linalg.inv(covariance), away)
    weight = np.exp(-0.5 * power)
    return np.asarray(weight / weight.sum())
