"""Videos of RGB pictures: Motion JPEG, finely coded, and H.264 of any quality."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np

from pawnb.arrays import ByteArray
from pawnb.errors import InputError

_QUALITY = 2
"""Quantiser scale of MJPEG: 2 is the finest that is of use."""


class _RgbVideoWriter:
    """Writes RGB pictures, the same bytes for the same pictures; a context manager."""

    _format = ""
    _codec = ""
    _pixels = ""
    _range = ""

    def __init__(
        self, path: Path, *, size: tuple[int, int], fps: float, options: dict[str, str]
    ) -> None:
        self._container = av.open(
            str(path), "w", format=self._format, options={"fflags": "+bitexact"}
        )
        rate = Fraction(fps).limit_denominator(10000)
        stream = self._container.add_stream(self._codec, rate=rate, options=options)
        self._stream = cast("av.VideoStream", stream)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = self._pixels

    def __enter__(self) -> _RgbVideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self._container.mux(self._stream.encode())
        self._container.close()

    def write(self, picture: ByteArray) -> None:
        """Append one picture (h, w, 3) uint8."""
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
        frame = frame.reformat(
            format=self._pixels, dst_colorspace="ITU601", dst_color_range=self._range
        )
        self._container.mux(self._stream.encode(frame))


class JpegVideoWriter(_RgbVideoWriter):
    """Writes RGB pictures as Motion JPEG, the same bytes for the same pictures.

    Parameters
    ----------
    path : Path
        The file, ``.avi``.
    size : tuple of int
        Width and height, px.
    fps : float
        Frames per second.
    """

    _format, _codec, _pixels, _range = "avi", "mjpeg", "yuvj422p", "JPEG"

    def __init__(self, path: Path, *, size: tuple[int, int], fps: float) -> None:
        options = {
            "flags": "+qscale+bitexact",
            "global_quality": str(_QUALITY * 118),  # in units of FF_QP2LAMBDA
            "threads": "1",
        }
        super().__init__(path, size=size, fps=fps, options=options)


class H264VideoWriter(_RgbVideoWriter):
    """Writes RGB pictures as H.264, as cameras and programs that save space do.

    H.264 has even sizes only: the last row and column are repeated where they are odd. Grey
    pictures have colour planes without colour, as most grey recordings in H.264.

    Parameters
    ----------
    path : Path
        The file, ``.mp4``.
    size : tuple of int
        Width and height of the pictures, px.
    fps : float
        Frames per second.
    crf : int
        Quality, from 0, the best, to 51; ffmpeg's own choice is 23.

    Raises
    ------
    InputError
        Where the installation has no encoder.
    """

    _format, _codec, _pixels, _range = "mp4", "libx264", "yuv420p", "MPEG"

    def __init__(self, path: Path, *, size: tuple[int, int], fps: float, crf: int) -> None:
        if self._codec not in av.codecs_available:
            raise InputError(
                f"this installation of PyAV cannot write H.264 (it has no {self._codec}); "
                "install PyAV from PyPI, or leave out h264-crf where a scene is rendered."
            )
        self._odd = [(0, size[1] % 2), (0, size[0] % 2), (0, 0)]
        even = (size[0] + size[0] % 2, size[1] + size[1] % 2)
        options = {"crf": str(crf), "threads": "1", "flags": "+bitexact"}
        super().__init__(path, size=even, fps=fps, options=options)

    def write(self, picture: ByteArray) -> None:
        """Append one picture (h, w, 3) uint8."""
        super().write(np.pad(picture, self._odd, mode="edge"))
