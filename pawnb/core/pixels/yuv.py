"""Pictures in YUV, and regions of any picture reduced by a whole factor.

All arithmetic is on integers, pixel by pixel; chroma is spread over its block of luma pixels
(nearest), see :mod:`pawnb.core.pixels.colour`.
"""

from __future__ import annotations

import functools

import cv2
import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.pixels.colour import ArrayBased, GreyPicture, PartPicture, Picture

_FIXED_POINT_BITS = 6
"""Binary digits kept behind the point while the three terms are added in int16."""
_BAND_ROWS = 64
"""Rows converted at once: the intermediate arrays stay in the processor's cache."""
LUMA_WEIGHTS: dict[str, tuple[float, float]] = {
    "bt601": (0.299, 0.114),
    "bt709": (0.2126, 0.0722),
    "smpte240m": (0.212, 0.087),
    "bt2020": (0.2627, 0.0593),
}
"""Kr and Kb of each standard (ITU-R BT.601-7, BT.709-6, BT.2020-2; SMPTE 240M)."""


class YuvPicture(ArrayBased):
    """Planar YUV, 8 bit, with any whole-number chroma subsampling.

    Parameters
    ----------
    luma : ndarray, shape (H, W), uint8
        Y.
    chroma_u, chroma_v : ndarray, shape (ceil(H / step_v), ceil(W / step_u)), uint8
        U (Cb) and V (Cr).
    steps : tuple of int
        Luma pixels a chroma sample spans along u and along v.
    standard : str
        A key of ``LUMA_WEIGHTS``.
    full_range : bool
        Whether Y spans 0..255 (JPEG) or 16..235 (video).

    Notes
    -----
    The conversion is the textbook one (Kr and Kb of the standard), rounded once at the
    end; libswscale's fast path is within a few grey levels of it.
    """

    is_colour = True

    def __init__(
        self,
        luma: np.ndarray,
        chroma_u: np.ndarray,
        chroma_v: np.ndarray,
        *,
        steps: tuple[int, int],
        standard: str = "bt601",
        full_range: bool = False,
    ) -> None:
        super().__init__(luma)
        self._u, self._v = chroma_u, chroma_v
        self._steps = steps
        self._tables = _yuv_tables(standard, full_range)
        self._matrix = _yuv_matrix(standard, full_range)

    def region(self, u0: int, v0: int, u1: int, v1: int) -> ByteArray:
        """Return that half-open region as a fresh RGB array.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.

        Returns
        -------
        ndarray of uint8, shape (v1 - v0, u1 - u0, 3)
            Its pixels.
        """
        out = np.empty((v1 - v0, u1 - u0, 3), np.uint8)
        for top in range(v0, v1, _BAND_ROWS):
            bottom = min(top + _BAND_ROWS, v1)
            out[top - v0 : bottom - v0] = self._band(u0, top, u1, bottom)
        return out

    def reduced(self, u0: int, v0: int, u1: int, v1: int, factor: int) -> ByteArray | None:
        """Return that region reduced by a whole factor, or None where planes do not allow it.

        The planes are reduced and then converted, ``factor`` squared fewer pixels than the
        other way round. Both are averages: they differ by rounding, and where colours lie
        outside what RGB can show.

        Parameters
        ----------
        u0, v0, u1, v1 : int
            Region in px, half open.
        factor : int
            How many px become one.

        Returns
        -------
        ndarray of uint8 or None
            The reduced region.
        """
        step_u, step_v = self._steps
        if factor < max(step_u, step_v) or any(
            end % step for end, step in ((u0, step_u), (u1, step_u), (v0, step_v), (v1, step_v))
        ):
            return None
        size = ((u1 - u0) // factor, (v1 - v0) // factor)
        chroma = (slice(v0 // step_v, v1 // step_v), slice(u0 // step_u, u1 // step_u))
        planes = (self._pixels[v0:v1, u0:u1], self._u[chroma], self._v[chroma])
        yuv = cv2.merge([_shrink(plane, size) for plane in planes])
        return np.asarray(cv2.transform(yuv, self._matrix))

    def luma(self) -> GreyPicture:
        """Return Y, stretched to 0..255, as a grey picture (a raw mosaic lies in Y)."""
        table = np.clip(self._tables[0] >> _FIXED_POINT_BITS, 0, 255).astype(np.uint8)
        return GreyPicture(cv2.LUT(self._pixels, table))

    def _band(self, u0: int, v0: int, u1: int, v1: int) -> np.ndarray:
        """Convert a few rows: table look-ups at chroma size, one addition at full size."""
        luma, red_v, green_u, green_v, blue_u = self._tables
        step_u, step_v = self._steps
        left, top = u0 // step_u, v0 // step_v
        right, bottom = -(-u1 // step_u), -(-v1 // step_v)
        cb, cr = self._u[top:bottom, left:right], self._v[top:bottom, left:right]
        chroma = cv2.merge(
            (
                cv2.LUT(cr, red_v),
                cv2.add(cv2.LUT(cb, green_u), cv2.LUT(cr, green_v)),
                cv2.LUT(cb, blue_u),
            )
        )
        if (step_u, step_v) != (1, 1):
            size = ((right - left) * step_u, (bottom - top) * step_v)
            chroma = cv2.resize(chroma, size, interpolation=cv2.INTER_NEAREST)
        u_off, v_off = u0 - left * step_u, v0 - top * step_v
        chroma = chroma[v_off : v_off + v1 - v0, u_off : u_off + u1 - u0]
        grey = cv2.LUT(self._pixels[v0:v1, u0:u1], luma)
        # cv2.add saturates in int16, far outside what the clip below lets through
        total = np.asarray(cv2.add(cv2.merge((grey, grey, grey)), chroma))
        np.right_shift(total, _FIXED_POINT_BITS, out=total)
        return np.clip(total, 0, 255, out=total).astype(np.uint8)


@functools.cache
def _yuv_matrix(standard: str, full_range: bool) -> np.ndarray:
    """Return the matrix (3, 4) that makes red, green, blue of Y, U, V and 1."""
    kr, kb = LUMA_WEIGHTS[standard]
    kg = 1.0 - kr - kb
    y_gain, y_zero, c_gain = (1.0, 0, 1.0) if full_range else (255 / 219, 16, 255 / 224)
    gains = np.array([
        [y_gain, 0.0, c_gain * 2 * (1 - kr)],
        [y_gain, -c_gain * 2 * kb * (1 - kb) / kg, -c_gain * 2 * kr * (1 - kr) / kg],
        [y_gain, c_gain * 2 * (1 - kb), 0.0],
    ])  # fmt: skip
    return np.column_stack([gains, -gains @ [y_zero, 128.0, 128.0]])


@functools.cache
def _yuv_tables(standard: str, full_range: bool) -> tuple[np.ndarray, ...]:
    """Return int16 tables, shape (256,): Y, V to red, U and V to green, U to blue."""
    red, green, blue = _yuv_matrix(standard, full_range)
    y_zero = 0 if full_range else 16
    code = np.arange(256)
    terms = (
        red[0] * (code - y_zero) + 0.5,  # the half makes the final shift round
        red[2] * (code - 128),
        green[1] * (code - 128),
        green[2] * (code - 128),
        blue[1] * (code - 128),
    )
    return tuple(np.rint(term * 2**_FIXED_POINT_BITS).astype(np.int16) for term in terms)


def _shrink(plane: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return a plane reduced to (width, height) by averaging."""
    h, w = plane.shape
    if size == (w, h):
        return plane
    if size == (w, h // 2):  # OpenCV's own way is ten times slower here
        return np.asarray(cv2.addWeighted(plane[0::2], 0.5, plane[1::2], 0.5, 0.0))
    return np.asarray(cv2.resize(plane, size, interpolation=cv2.INTER_AREA))


def reduce_region(picture: Picture, box: tuple[int, int, int, int], factor: int) -> ByteArray:
    """Return a region reduced by a whole factor: each pixel is the mean of a square.

    Parameters
    ----------
    picture : Picture
        The picture.
    box : tuple of int
        Left, top, right, bottom; width and height are multiples of ``factor``.
    factor : int
        Pixels of the picture along each side of a pixel of the result.

    Returns
    -------
    ndarray, shape (H / factor, W / factor, 3) RGB or (H / factor, W / factor) grey, uint8
        A fresh array.
    """
    if isinstance(picture, PartPicture):
        picture, box = picture.part(box)
    if factor == 1:
        return picture.region(*box)
    part = picture.reduced(*box, factor) if isinstance(picture, YuvPicture) else None
    if part is not None:
        return part
    size = ((box[2] - box[0]) // factor, (box[3] - box[1]) // factor)
    return np.asarray(cv2.resize(picture.region(*box), size, interpolation=cv2.INTER_AREA))
