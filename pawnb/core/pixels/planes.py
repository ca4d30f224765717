"""From the planes of a decoder to a picture, by the name of the pixel format."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypedDict

import numpy as np

from pawnb.arrays import ByteArray
from pawnb.core.pixels.colour import (
    GreyPicture,
    LazyPicture,
    PackedPicture,
    PalettePicture,
    Picture,
    PlanarPicture,
    is_grey,
)
from pawnb.core.pixels.yuv import YuvPicture

_CHROMA_STEPS = {"444p": (1, 1), "422p": (2, 1), "420p": (2, 2), "440p": (1, 2), "411p": (4, 1),
                 "410p": (4, 4)}  # fmt: skip
_PACKED = {"rgb24": (0, 1, 2), "bgr24": (2, 1, 0), "rgba": (0, 1, 2), "bgra": (2, 1, 0),
           "rgb0": (0, 1, 2), "bgr0": (2, 1, 0), "argb": (1, 2, 3), "abgr": (3, 2, 1),
           "0rgb": (1, 2, 3), "0bgr": (3, 2, 1)}  # fmt: skip
_GREY_BITS = {"gray10le": 10, "gray12le": 12, "gray14le": 14, "gray16le": 16}
# AVColorSpace; what is not tagged is BT.601, as for ffmpeg
_STANDARDS = {1: "bt709", 7: "smpte240m", 9: "bt2020", 10: "bt2020"}
_FULL_RANGE = 2


def picture_of_frame(frame: Any) -> Picture:
    """Return a decoded frame as one of the pictures of :mod:`pawnb.core.pixels.colour`.

    Parameters
    ----------
    frame : av.VideoFrame
        The frame; its planes are used without a copy.

    Returns
    -------
    Picture
        Formats that are not known here are converted by libswscale, whole.
    """
    name = frame.format.name
    palette = None
    if name == "pal8":  # blue, green, red, alpha
        palette = np.frombuffer(frame.planes[1], np.uint8)[:1024].reshape(256, 4)[:, 2::-1]
    images = planes_of_frame(frame)
    picture = None
    if images:
        picture = picture_of_planes(
            name, images, width=frame.width, height=frame.height, palette=palette,
            **shown_as(frame),
        )  # fmt: skip
    if picture is None:
        grey = name.startswith("gray") or (palette is not None and is_grey(palette))
        return LazyPicture(
            frame.width,
            frame.height,
            lambda: frame.to_ndarray(format="rgb24")[..., slice(None) if not grey else 0],
            is_colour=not grey,
        )
    return picture


def planes_of_frame(frame: Any) -> list[ByteArray]:
    """Return a frame's planes with their padding, (rows, bytes); none if stored bottom up.

    Of a frame with a palette, the indices only.
    """
    images = [_rows(p) for p in frame.planes[: 1 if frame.format.name == "pal8" else None]]
    return [] if any(image is None for image in images) else [i for i in images if i is not None]


class Shown(TypedDict):
    """What YUV samples mean."""

    standard: str
    full_range: bool


def shown_as(frame: Any) -> Shown:
    """Return the standard and the range of a frame, as :func:`picture_of_planes` takes them."""
    return Shown(
        standard=_STANDARDS.get(int(frame.colorspace), "bt601"),
        full_range=int(frame.color_range) == _FULL_RANGE,
    )


def _rows(plane: Any) -> ByteArray | None:
    """Return a plane's rows with their padding, without a copy; None if stored bottom up."""
    if plane.line_size <= 0:
        return None
    data = np.frombuffer(plane, np.uint8)
    rows = len(data) // plane.line_size
    return data[: rows * plane.line_size].reshape(rows, plane.line_size)


def picture_of_planes(
    pixel_format: str,
    planes: Sequence[ByteArray],
    *,
    width: int,
    height: int,
    standard: str,
    full_range: bool,
    palette: ByteArray | None = None,
) -> Picture | None:
    """Return the picture that decoded planes hold, without copying them.

    Parameters
    ----------
    pixel_format : str
        ffmpeg's name, such as ``yuv420p``.
    planes : sequence of ndarray, shape (rows, bytes), uint8
        The planes with their padding on the right and below.
    width, height : int
        Size of the picture, px.
    standard : str
        A key of ``LUMA_WEIGHTS``.
    full_range : bool
        Whether Y spans 0..255.
    palette : ndarray, shape (256, 3), uint8, optional
        RGB of each index, for ``pal8``.

    Returns
    -------
    Picture or None
        None for a format that is not known here.
    """
    steps = _CHROMA_STEPS.get(pixel_format.removeprefix("yuvj").removeprefix("yuv"))
    if steps is not None:
        columns, rows = -(-width // steps[0]), -(-height // steps[1])
        return YuvPicture(
            planes[0][:height, :width],
            planes[1][:rows, :columns],
            planes[2][:rows, :columns],
            steps=steps,
            standard=standard,
            full_range=full_range or pixel_format.startswith("yuvj"),
        )
    first = planes[0][:height]
    if pixel_format == "gray":
        return GreyPicture(first[:, :width])
    if pixel_format in _GREY_BITS:
        wide = first[:, : 2 * width].view("<u2")
        return GreyPicture(np.right_shift(wide, _GREY_BITS[pixel_format] - 8).astype(np.uint8))
    if pixel_format in _PACKED:
        channels = 3 if pixel_format in ("rgb24", "bgr24") else 4
        packed = first[:, : width * channels].reshape(height, width, channels)
        return PackedPicture(packed, _PACKED[pixel_format])
    if pixel_format == "gbrp":
        green, blue, red = (plane[:height, :width] for plane in planes)
        return PlanarPicture(red, green, blue)
    if pixel_format == "pal8" and palette is not None:
        return PalettePicture(first[:, :width], palette)
    return None
