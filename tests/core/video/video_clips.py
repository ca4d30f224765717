"""Small clips whose pictures carry their frame number as a barcode, written with PyAV."""

from __future__ import annotations

import struct
from fractions import Fraction

import av
import numpy as np
import pytest

WIDTH, HEIGHT, N = 160, 64, 60
_BITS, _BLOCK = 10, 16
H264 = {"bf": "3", "g": "20", "sc_threshold": "0"}


def picture(number: int, *, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """RGB ramps that differ from frame to frame, with the number in black and white blocks."""
    v, u = np.mgrid[:height, :width]
    ramps = (u * 255 // width, v * 255 // height, (u + v + 5 * number) % 256)
    rgb = np.stack(ramps, axis=-1).astype(np.uint8)
    for bit in range(_BITS):
        rgb[:_BLOCK, bit * _BLOCK : (bit + 1) * _BLOCK] = 235 if number >> bit & 1 else 20
    return rgb


def barcode(image: np.ndarray) -> int:
    """The number in a picture (RGB or grey)."""
    grey = image if image.ndim == 2 else image[..., 1]
    blocks = [grey[4:12, b * _BLOCK + 4 : b * _BLOCK + 12].mean() > 128 for b in range(_BITS)]
    return sum(int(on) << bit for bit, on in enumerate(blocks))


def need_codec(name: str) -> None:
    """Skip the test where this PyAV cannot encode with that codec."""
    try:
        av.codec.Codec(name, "w")
    except ValueError:
        pytest.skip(f"this PyAV has no encoder {name}")


def write_clip(path, *, codec, pix_fmt, n=N, options=None, times=None, rate=50, size=None):
    """Write ``n`` pictures; ``times`` are their display times in frames."""
    need_codec(codec)
    width, height = size or (WIDTH, HEIGHT)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=rate, options=options or {})
        stream.width, stream.height, stream.pix_fmt = width, height, pix_fmt
        for number in range(n):
            rgb = picture(number, width=width, height=height)
            frame = av.VideoFrame.from_ndarray(rgb, format="rgb24").reformat(format=pix_fmt)
            frame.pts = number if times is None else times[number]
            frame.time_base = Fraction(1, rate)
            for packet in stream.encode(frame):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
    return path


def write_mjpeg(path, n=N, **more):
    return write_clip(path, codec="mjpeg", pix_fmt="yuvj420p", n=n, **more)


def write_h264(path, n=N, **more):
    more.setdefault("options", H264)
    return write_clip(path, codec="libx264", pix_fmt="yuv420p", n=n, **more)


def write_cine(path, pictures, *, fps=1000, compression=0):
    """Write grey pictures as Vision Research's "Cine File Format" lays them out, 8 bits a pixel.

    CINEFILEHEADER (44 bytes), BITMAPINFOHEADER (40), SETUP (mark ST at 140, FrameRate at 768), the
    place of each picture (8 bytes each), and before each picture a note that ends with its size.
    """
    height, width = pictures[0].shape
    setup = bytearray(0x2000)
    struct.pack_into("<2sH", setup, 140, b"ST", len(setup))
    struct.pack_into("<I", setup, 768, fps)
    struct.pack_into("<I", setup, 896, 8)  # RealBPP
    n, at = len(pictures), 84 + len(setup)
    places = [at + 8 * n + k * (8 + width * height) for k in range(n)]
    head = struct.pack("<2s3HiIiI3Iq", b"CI", 44, 0, 1, 0, n, 0, n, 44, 84, at, 0)
    size = struct.pack(
        "<IiiHHIIiiII", 40, width, height, 1, 8, compression, width * height, 0, 0, 0, 0
    )
    rows = [struct.pack("<II", 8, width * height) + one[::-1].tobytes() for one in pictures]
    path.write_bytes(b"".join([head, size, setup, struct.pack(f"<{n}q", *places), *rows]))
    return path


def copy_packets(source, target, *, skip_ticks=0, options=None):
    """Copy a video without encoding; what comes before ``skip_ticks`` is hidden (edit list)."""
    more = {"avoid_negative_ts": "disabled", "use_editlist": "1"} if skip_ticks else {}
    with (
        av.open(str(source)) as inp,
        av.open(str(target), "w", options=more | (options or {})) as out,
    ):
        stream = inp.streams.video[0]
        copy = out.add_stream_from_template(stream)
        for packet in inp.demux(stream):
            if packet.size:
                packet.pts -= skip_ticks
                packet.dts -= skip_ticks
                packet.stream = copy
                out.mux(packet)
    return target


def packet_bytes(path, number):
    """Where a packet lies in the file: position and size, bytes."""
    with av.open(str(path)) as container:
        packets = [p for p in container.demux(video=0) if p.size]
        return packets[number].pos, packets[number].size


def damage(path, start, count):
    """Overwrite bytes of a file."""
    data = bytearray(path.read_bytes())
    data[start : start + count] = b"\x55" * count
    path.write_bytes(data)


def store(path, *, bottom_up):
    """Declare the rows of an uncompressed AVI as stored bottom up or top down.

    In a BITMAPINFOHEADER a positive biHeight means bottom up.
    """
    data = bytearray(path.read_bytes())
    at = data.index(b"strf") + 16
    (height,) = struct.unpack_from("<i", data, at)
    struct.pack_into("<i", data, at, abs(height) if bottom_up else -abs(height))
    path.write_bytes(data)
    return path


def give_palette(path, palette):
    """Make a grey AVI (Y800) one of 256 colours, (256, 3) RGB, as many cameras write it."""
    data = bytearray(path.read_bytes())
    at = data.index(b"strf") + 8
    data[at + 16 : at + 20] = b"\0\0\0\0"  # biCompression: BI_RGB
    struct.pack_into("<I", data, at + 32, 256)  # biClrUsed
    entries = np.zeros((256, 4), np.uint8)
    entries[:, :3] = np.asarray(palette)[:, ::-1]
    (size,) = struct.unpack_from("<I", data, at - 4)
    for place in (4, 16, data.index(b"strl") - 4, at - 4):  # RIFF, hdrl, strl, strf
        struct.pack_into("<I", data, place, struct.unpack_from("<I", data, place)[0] + 1024)
    data[at + size : at + size] = entries.tobytes()
    path.write_bytes(data)
    return path


def plain_reading(path) -> list[np.ndarray]:
    """All pictures in order, as PyAV and libswscale give them when nothing is sought."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
