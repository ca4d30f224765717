"""Frames that are decoded only where somebody looks hold what whole ones hold."""

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest
from video_clips import damage, packet_bytes, picture, write_clip, write_h264, write_mjpeg

from pawnb.core.pixels.bayer import debayered
from pawnb.core.pixels.colour import PartPicture
from pawnb.core.pixels.yuv import YuvPicture
from pawnb.core.video import open_view
from pawnb.errors import VideoError
from pawnb.trial import View

N = 12


def opened(path):
    return open_view(View(name="cam1", video=path.name), path.parent)


def as_avi(path, pictures, height=None):
    """JPEG pictures in an AVI as they are."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=50)
        stream.height, stream.width = cv2.imdecode(
            np.frombuffer(pictures[0], np.uint8), cv2.IMREAD_GRAYSCALE
        ).shape
        stream.height = height or stream.height
        stream.pix_fmt = "yuvj420p"
        for k, data in enumerate(pictures):
            packet = av.Packet(data)
            packet.pts = packet.dts = k
            packet.time_base = Fraction(1, 50)
            packet.stream = stream
            container.mux(packet)
    return path


def jpeg(number, **options):
    chosen = [x for k, v in options.items() for x in (getattr(cv2, f"IMWRITE_JPEG_{k}"), v)]
    return cv2.imencode(".jpg", picture(number)[..., ::-1], chosen)[1].tobytes()


CLIPS = {
    "420": lambda d: write_mjpeg(d / "clip.avi", n=N),
    "422": lambda d: write_clip(d / "clip.avi", codec="mjpeg", pix_fmt="yuvj422p", n=N),
    "444": lambda d: write_clip(d / "clip.avi", codec="mjpeg", pix_fmt="yuvj444p", n=N),
    "mov": lambda d: write_mjpeg(d / "clip.mov", n=N),
    "odd size": lambda d: write_mjpeg(d / "clip.avi", n=N, size=(171, 67)),
    "restart markers": lambda d: as_avi(
        d / "clip.avi", [jpeg(k, RST_INTERVAL=3) for k in range(N)]
    ),
    "libjpeg": lambda d: as_avi(d / "clip.avi", [jpeg(k) for k in range(N)]),
    "studio range": lambda d: write_clip(
        d / "clip.avi", codec="mjpeg", pix_fmt="yuv420p", n=N, options={"strict": "unofficial"}
    ),
}
WHOLE = {
    "h264": lambda d: write_h264(d / "clip.mp4", n=N),
    "progressive": lambda d: as_avi(d / "clip.avi", [jpeg(k, PROGRESSIVE=1) for k in range(N)]),
}


@pytest.mark.parametrize("name", [*CLIPS, *WHOLE])
def test_parts_are_those_of_whole_frames(tmp_path, name):
    path = (CLIPS | WHOLE)[name](tmp_path)
    with opened(path) as parts, opened(path) as reader:
        for k in [*range(N), 3, 9, 1]:
            part, whole = (r.frame_of(r.grab(k, partly=r is parts), k) for r in (parts, reader))
            assert np.array_equal(part.image(), whole.image())
            box = (33, 17, 151, 61)
            assert np.array_equal(part.crop(*box), whole.crop(*box))
            for box, factor in (((32, 16, 152, 64), 2), ((33, 16, 153, 60), 4)):
                a, b = (f.reduced(*box, factor=factor) for f in (part, whole))
                assert np.array_equal(a, b)
        assert type(parts.grab(5, partly=True)) is (PartPicture if name in CLIPS else YuvPicture)


def test_grey(tmp_path):
    grey = [cv2.imencode(".jpg", picture(k)[..., 1])[1].tobytes() for k in range(N)]
    with opened(as_avi(tmp_path / "clip.avi", grey)) as reader:
        part = reader.grab(5, partly=True)
        assert isinstance(part, PartPicture)
        assert not part.is_colour
        assert np.array_equal(part.region(0, 0, 160, 64), reader.read(5))


def test_packets_unlike_the_first_are_decoded_whole(tmp_path):
    pictures = [jpeg(k, **({"PROGRESSIVE": 1} if k == 4 else {})) for k in range(N)]
    pictures[7] = jpeg(7, QUALITY=30)  # other scales are no other kind
    pictures[8] = jpeg(8, SAMPLING_FACTOR=cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444)
    with opened(as_avi(tmp_path / "clip.avi", pictures)) as parts:
        kinds = [type(parts.grab(k, partly=True)) for k in range(1, N)]
        assert [k for k, kind in enumerate(kinds, 1) if kind is not PartPicture] == [4, 8]


def test_two_fields_are_left_to_ffmpeg(tmp_path):
    """Interlaced Motion JPEG: a packet holds two pictures of half the height, top field first."""
    fields = [b"".join(_field(picture(k)[top::2]) for top in (0, 1)) for k in range(N)]
    path = as_avi(tmp_path / "clip.avi", fields, height=64)
    with opened(path) as parts, opened(path) as reader:
        assert (reader.width, reader.height) == (160, 64)
        for k in range(N):
            part = parts.grab(k, partly=True)
            assert isinstance(part, YuvPicture)
            assert np.array_equal(part.region(0, 0, 160, 64), reader.read(k))


def _field(image):
    return cv2.imencode(".jpg", image[..., ::-1])[1].tobytes()


def test_a_damaged_packet_is_refused_as_before(tmp_path):
    path = write_mjpeg(tmp_path / "clip.avi", n=N)
    damage(path, *packet_bytes(path, 6))
    with opened(path) as reader:
        reader.grab(5, partly=True)
        with pytest.raises(VideoError, match="frame 6 cannot be decoded; the file is damaged"):
            reader.grab(6, partly=True)
        assert isinstance(reader.grab(7, partly=True), PartPicture)


def test_where_the_decoders_disagree_whole_frames_are_decoded(tmp_path, monkeypatch):
    """As on a machine whose FFmpeg transforms blocks in another way."""
    from pawnb.core.jpeg.coded import CodedPicture

    plain = CodedPicture.planes

    def other(self, *box):
        planes, origin = plain(self, *box)
        planes[0][3, 5] ^= 1
        return planes, origin

    monkeypatch.setattr(CodedPicture, "planes", other)
    with opened(write_mjpeg(tmp_path / "clip.avi", n=N)) as reader:
        assert {type(reader.grab(k, partly=True)) for k in range(N)} == {YuvPicture}


def test_mosaic_in_the_luma(tmp_path):
    with opened(write_mjpeg(tmp_path / "clip.avi", n=N)) as reader:
        part, whole = reader.grab(3, partly=True), reader.grab(4)
        assert isinstance(part, PartPicture)
        colours = [debayered(one, "rggb", where="cam1") for one in (part, part.whole(), whole)]
        regions = [one.region(20, 10, 60, 50) for one in colours]
        assert np.array_equal(regions[0], regions[1])
        assert not np.array_equal(regions[0], regions[2])
