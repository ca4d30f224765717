"""Grey videos: one-component JPEG pictures in an AVI file."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import cv2

from pawnb.arrays import ByteArray

_QUALITY = 95


class GreyVideoWriter:
    """Writes grey pictures as Motion JPEG, the same bytes for the same pictures.

    ffmpeg's own encoder knows no grey Motion JPEG, its decoder does: every picture is coded
    by itself, has no colour planes, and is decoded fast.

    Parameters
    ----------
    path : Path
        The file, ``.avi``.
    size : tuple of int
        Width and height, px.
    fps : float
        Frames per second.
    """

    def __init__(self, path: Path, *, size: tuple[int, int], fps: float) -> None:
        self._container = av.open(str(path), "w", format="avi", options={"fflags": "+bitexact"})
        rate = Fraction(fps).limit_denominator(10000)
        self._stream = self._container.add_stream(
            "mjpeg", rate=rate, options={"flags": "+bitexact"}
        )
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuvj420p"
        self._time_base, self._count = 1 / rate, 0

    def __enter__(self) -> GreyVideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self._container.close()

    def write(self, picture: ByteArray) -> None:
        """Append one picture (h, w) uint8."""
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        packet = av.Packet(data.tobytes())
        packet.stream = self._stream
        packet.pts = packet.dts = self._count
        packet.time_base = self._time_base
        packet.is_keyframe = True
        self._container.mux(packet)
        self._count += 1
