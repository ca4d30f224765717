"""What a place looks like at several scales: brightness, edges, texture, surroundings, colour."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from pawnb.arrays import ByteArray, Float32Array, IntArray
from pawnb.core.paws.offline.detection.parameters import LEARNT

_SLOPES, _SHADES = 1.5, 32
"""Mathematics: units of features; each is standardised before anything is learnt from it, so that
they change nothing."""
_DIRECTIONS = 8
"""Layout: directions of a ring."""
_TURNS = np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS)
"""Layout: their angles, rad."""
_TOWARDS = np.stack([np.cos(_TURNS), np.sin(_TURNS)])[..., None]
"""Layout: unit vectors of them, (2, directions, 1)."""


@dataclass(frozen=True)
class _Ring:
    """What lies at a distance in each of eight directions.

    Parameters
    ----------
    of : ndarray of float32, shape (h, w)
        What is looked at there.
    radius : float
        The distance, in places.
    minus : ndarray of float32, shape (h, w), optional
        What is taken from it at the place itself.
    """

    of: np.ndarray
    radius: float
    minus: np.ndarray | None = None

    def put(self, xy: IntArray, places: IntArray, *, into: Float32Array) -> None:
        """Write the eight values (8, m) about m places at positions (2, 1, m)."""
        x, y = (xy + self.radius * _TOWARDS).astype(np.float32)
        cv2.remap(self.of, x, y, cv2.INTER_LINEAR, dst=into, borderMode=cv2.BORDER_REPLICATE)
        if self.minus is not None:
            into -= self.minus.ravel()[places]


class PictureFeatures:
    """Features of the places of one picture, computed where they are asked for.

    Gaussian derivatives at four scales, their differences, the structure tensor (Bigün &
    Granlund 1987), brightness (and colour) on three rings about the place, direction by
    direction, so that what lies ahead and what lies behind are distinguished. No scale is finer
    than a pixel of the picture at half its size, where all of them are computed.

    Parameters
    ----------
    grey : ndarray of uint8, shape (H, W)
        A picture at the working scale.
    colour : ndarray of uint8, shape (H, W, 2), or None
        Its colour channels.
    spacing : int
        Px between places, even.

    Raises
    ------
    ValueError
        If the spacing is odd.
    """

    def __init__(self, grey: np.ndarray, colour: np.ndarray | None, spacing: int) -> None:
        if spacing % 2:
            raise ValueError(f"places {spacing} px apart; the spacing must be even.")
        h, w = grey.shape[0] // spacing, grey.shape[1] // spacing
        self.shape = (h, w)
        # pyrDown keeps every other pixel: from here on places are among them
        odd = spacing // 2 % 2
        offset, step = spacing // 4, spacing // 2

        def halved(x: np.ndarray) -> np.ndarray:
            return cv2.pyrDown(x[odd:, odd:])

        def on_grid(x: np.ndarray) -> np.ndarray:
            return np.ascontiguousarray(x[offset::step, offset::step][:h, :w])

        fine = cv2.GaussianBlur(halved(grey).astype(np.float32) / 255, (0, 0), LEARNT.fine_sd_px)
        gx, gy = (cv2.Sobel(fine, cv2.CV_32F, *d, ksize=1, scale=2) for d in ((1, 0), (0, 1)))
        brightness = on_grid(fine)
        gx_grid, gy_grid = on_grid(gx), on_grid(gy)
        maps = _structure(gx, gy, on_grid)
        maps += [
            brightness,
            gx_grid * _SLOPES,
            gy_grid * _SLOPES,
            _length(gx_grid, gy_grid) * _SLOPES,
        ]
        near = on_grid(cv2.GaussianBlur(fine, (0, 0), LEARNT.near_sd_px))
        middle = cv2.GaussianBlur(near, (0, 0), LEARNT.middle_sd_px / spacing)
        far = cv2.GaussianBlur(middle, (0, 0), LEARNT.far_sd_px / spacing)
        for x, gain in ((near, 1.0), (middle, 2.0), (far, 4.0)):
            dx, dy = (cv2.Sobel(x, cv2.CV_32F, *d, scale=gain) for d in ((1, 0), (0, 1)))
            maps += [x, dx, dy, _length(dx, dy)]
        maps += [(brightness - near) * 4, (near - middle) * 4, (middle - far) * 4]
        ground = LEARNT.ring_minus * near
        self._parts: list[np.ndarray | _Ring] = [np.stack(maps).reshape(len(maps), -1)]
        self._parts += [
            _Ring(near if i == 0 else middle, radius / spacing, ground)
            for i, radius in enumerate(LEARNT.rings_px)
        ]
        shades = None if colour is None else halved(colour)
        for channel in range(0 if shades is None else 2):
            shade = on_grid(shades[..., channel]).astype(np.float32) / _SHADES - 4  # type: ignore[index]
            smooth = cv2.GaussianBlur(shade, (0, 0), LEARNT.colour_sd_px / spacing)
            self._parts.append(np.stack([shade, smooth]).reshape(2, -1))
            if channel == 0:
                self._parts.append(_Ring(smooth, LEARNT.rings_px[0] / spacing))

    def at(self, places: IntArray) -> Float32Array:
        """Return the features of some places.

        Parameters
        ----------
        places : ndarray of int, shape (m,)
            Numbers of places, row by row.

        Returns
        -------
        ndarray of float32, shape (m, F)
            F is 47 without colour and 59 with it.
        """
        count = sum(_DIRECTIONS if isinstance(p, _Ring) else len(p) for p in self._parts)
        found = np.empty((count, len(places)), np.float32)
        xy = np.stack(np.divmod(places, self.shape[1])[::-1])[:, None]
        begin = 0
        for part in self._parts:
            if isinstance(part, _Ring):
                end = begin + _DIRECTIONS
                part.put(xy, places, into=found[begin:end])
            else:
                end = begin + len(part)
                np.take(part, places, axis=1, out=found[begin:end], mode="clip")
            begin = end
        return found.T


def feature_maps(grey: ByteArray, colour: ByteArray | None, spacing: int) -> Float32Array:
    """Return the features of every place, float32 (h, w, F); see :class:`PictureFeatures`.

    Parameters
    ----------
    grey : ndarray, shape (h, w)
        The picture.
    colour : ndarray, shape (h, w, k), optional
        Its colours.
    spacing : int
        Distance of places, px.

    Returns
    -------
    ndarray of float32, shape (rows, columns, F)
        Features of the places.
    """
    features = PictureFeatures(grey, colour, spacing)
    h, w = features.shape
    return features.at(np.arange(h * w)).reshape(h, w, -1)


def _length(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return lengths of vectors; those of cv2.magnitude differ with where arrays lie in memory."""
    return np.asarray(np.sqrt(x * x + y * y))


def _structure(
    gx: np.ndarray, gy: np.ndarray, on_grid: Callable[[np.ndarray], np.ndarray]
) -> list[np.ndarray]:
    """Return strength, coherence and direction (doubled) of the texture."""
    xx, yy, xy = (
        on_grid(cv2.GaussianBlur(p, (0, 0), LEARNT.texture_sd_px))
        for p in (gx * gx, gy * gy, gx * gy)
    )
    apart = np.sqrt((xx - yy) ** 2 + 4 * xy**2)
    total = np.maximum(xx + yy, 0) + LEARNT.texture_least
    return [np.sqrt(total) * 4, apart / total, (xx - yy) / total, 2 * xy / total]
