"""Colour from the mosaic of a raw camera picture (bilinear), for the region asked for."""

from __future__ import annotations

import cv2

from pawnb.arrays import AnyArray
from pawnb.core.pixels.colour import PartPicture, Picture
from pawnb.core.pixels.yuv import YuvPicture
from pawnb.errors import VideoError

# cv2 names a pattern after its second row, from the second column on, so its letters
# are one pixel off the usual names: rggb (red at the top left) is "BayerBG" there.
_CV2_CODES = {
    "rggb": cv2.COLOR_BayerBG2RGB,
    "bggr": cv2.COLOR_BayerRG2RGB,
    "grbg": cv2.COLOR_BayerGB2RGB,
    "gbrg": cv2.COLOR_BayerGR2RGB,
}
_BORDER_PX = 2
"""Neighbours needed on each side; even, so that the mosaic keeps its phase."""


class MosaicPicture:
    """A grey picture whose pixels are red, green or blue in turn.

    Parameters
    ----------
    mosaic : Picture
        Grey values as the sensor gave them.
    pattern : str
        The two top-left pixels of the first row, then of the second: rggb, bggr, grbg
        or gbrg.

    Notes
    -----
    A region is debayered with two pixels around it and then trimmed, which is
    bit-identical to debayering the whole picture.
    """

    is_colour = True

    def __init__(self, mosaic: Picture, pattern: str) -> None:
        self._mosaic = mosaic
        self._code = _CV2_CODES[pattern]
        self.width, self.height = mosaic.width, mosaic.height

    def region(self, u0: int, v0: int, u1: int, v1: int) -> AnyArray:
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
        left, right = _with_border(u0, u1, self.width)
        top, bottom = _with_border(v0, v1, self.height)
        rgb = cv2.demosaicing(self._mosaic.region(left, top, right, bottom), self._code)
        return rgb[v0 - top : v1 - top, u0 - left : u1 - left].copy()


def _with_border(low: int, high: int, size: int) -> tuple[int, int]:
    """Widen a half-open span by the border, to an even start, within the picture."""
    return max(low - low % 2 - _BORDER_PX, 0), min(high + _BORDER_PX, size)


def debayered(picture: Picture, pattern: str, *, where: str) -> Picture:
    """Return the picture in colour, taking its grey values for a mosaic.

    Parameters
    ----------
    picture : Picture
        A grey picture; of a YUV picture the luma is the mosaic.
    pattern : str
        rggb, bggr, grbg or gbrg.
    where : str
        How a message names the video.

    Returns
    -------
    Picture
        The picture in colour.

    Raises
    ------
    VideoError
        If the picture holds RGB already, or is smaller than 4 x 4 px.
    """
    if isinstance(picture, PartPicture):
        picture = picture.whole()
    if isinstance(picture, YuvPicture):
        picture = picture.luma()
    if picture.is_colour:
        raise VideoError(
            f"{where}: bayer is {pattern!r}, but the pictures are in colour already; "
            "leave out bayer, or name the raw grey pictures."
        )
    if min(picture.width, picture.height) < 4:
        raise VideoError(
            f"{where}: a picture of {picture.width} x {picture.height} px is too small to "
            "debayer; expected at least 4 x 4."
        )
    return MosaicPicture(picture, pattern)
