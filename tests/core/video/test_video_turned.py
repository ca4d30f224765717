"""Pictures are shown as a file says that the camera was held."""

from __future__ import annotations

import struct
from fractions import Fraction
from types import SimpleNamespace

import av
import numpy as np
import pytest
from video_clips import plain_reading, write_clip, write_h264, write_mjpeg

from pawnb.core.pixels.turned import turn_of_frame
from pawnb.core.video import VideoFile, open_view
from pawnb.trial import View

# the matrix of ISO/IEC 14496-12, 8.3.2: u' = a u + c v, v' = b u + d v; what a player shows
HELD = {
    "clockwise": ((0, 1, -1, 0), lambda image: np.rot90(image, -1), "90 degrees clockwise"),
    "anticlockwise": ((0, -1, 1, 0), np.rot90, "90 degrees anticlockwise"),
    "upside down": ((-1, 0, 0, -1), lambda image: np.rot90(image, 2), "turned by 180 degrees"),
    "mirror": ((-1, 0, 0, 1), np.fliplr, "are mirrored, "),
    "mirror, turned": ((0, 1, 1, 0), lambda image: image.swapaxes(0, 1), "mirrored and turned"),
}


def hold(path, matrix):
    """Write into the header of an MP4 or MOV how the camera was held."""
    data = bytearray(path.read_bytes())
    at = data.index(b"tkhd") + 4 + 40  # version 0: the matrix stands 40 bytes into the box
    a, b, c, d = (value * 65536 for value in matrix)
    data[at : at + 36] = struct.pack(">9i", a, b, 0, c, d, 0, 0, 0, 1 << 30)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("write", [write_h264, write_mjpeg])
@pytest.mark.parametrize("held", HELD)
def test_pictures_are_turned(tmp_path, held, write):
    matrix, shown, words = HELD[held]
    path = hold(write(tmp_path / "clip.mov", n=12), matrix)
    expected = [shown(image) for image in plain_reading(path)]
    with open_view(View(name="cam1", video=path.name), tmp_path) as view:
        height, width = expected[0].shape[:2]
        assert (view.width, view.height) == (width, height)
        for k in (5, 0, 11):
            # libswscale, which reads plainly here, rounds chroma in another way
            assert np.abs(view.read(k).astype(int) - expected[k]).max() <= 3
            part = view.grab(k, partly=True).region(11, 7, 40, 60)
            np.testing.assert_array_equal(part, view.read(k)[7:60, 11:40])
        (note,) = view.source.notes
        assert words in note
        assert (view.again().width, view.again().height) == (width, height)


def test_a_crop_is_counted_in_the_picture_as_shown(tmp_path):
    path = hold(write_h264(tmp_path / "clip.mp4", n=3), HELD["clockwise"][0])
    with open_view(View(name="c", video=path.name, crop=(0, 100, 64, 160)), tmp_path) as view:
        whole = VideoFile(path).grab(1).region(0, 0, 64, 160)
        np.testing.assert_array_equal(view.read(1), whole[100:])


def test_what_says_nothing_or_an_angle_between_is_shown_as_it_is(tmp_path):
    path = write_h264(tmp_path / "clip.mp4", n=3)
    assert VideoFile(path).notes == []
    data = bytearray(hold(path, (1, 1, -1, 1)).read_bytes())
    path.write_bytes(data)
    assert (VideoFile(path).width, VideoFile(path).notes) == (160, [])


def test_pixels_that_are_not_square_are_said(tmp_path):
    path = write_clip(tmp_path / "clip.mp4", codec="mpeg4", pix_fmt="yuv420p", n=3)
    with av.open(str(path)) as source, av.open(str(tmp_path / "dv.mp4"), "w") as target:
        stream = target.add_stream("mpeg4", rate=50)
        stream.width, stream.height, stream.pix_fmt = 160, 64, "yuv420p"
        stream.codec_context.sample_aspect_ratio = Fraction(16, 15)
        for frame in source.decode(video=0):
            target.mux(stream.encode(frame))
        target.mux(stream.encode())
    assert VideoFile(path).notes == []
    (note,) = VideoFile(tmp_path / "dv.mp4").notes
    assert "1.07 times as wide as high" in note


def test_pictures_that_are_interlaced_are_said(tmp_path):
    options = {"x264-params": "tff=1"}
    write_h264(tmp_path / "clip.mp4", n=4, options=options)
    (note,) = VideoFile(tmp_path / "clip.mp4").notes
    assert "interlaced" in note
    assert "doubles fps" in note


def test_side_data_that_list_their_kinds_are_read():
    # PyAV 19: side_data is a mapping of kinds to data, where those before listed the data
    data = struct.pack("9i", 0, 65536, 0, -65536, 0, 0, 0, 0, 1 << 30)
    told = {"SEI_UNREGISTERED": b"", "DISPLAYMATRIX": data}
    assert turn_of_frame(SimpleNamespace(side_data=told)).words == "turned by 90 degrees clockwise"
    assert turn_of_frame(SimpleNamespace(side_data={"SEI_UNREGISTERED": b""})) is None
