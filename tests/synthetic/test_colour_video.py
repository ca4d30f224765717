"""Colour videos: the pictures given, the same bytes, and odd sizes in H.264."""

import av
import numpy as np
import pytest

from pawnb.synthetic.colour_video import H264VideoWriter, JpegVideoWriter


def pictures(height=48, width=64):
    v, u = np.mgrid[:height, :width]
    return [
        np.stack([60 + u + 9 * k, 80 + v, 200 - u - v], axis=2).clip(0, 255).astype(np.uint8)
        for k in range(5)
    ]


def write(path, *, crf=None, size=(64, 48)):
    more = {} if crf is None else {"crf": crf}
    kind = JpegVideoWriter if crf is None else H264VideoWriter
    with kind(path, size=size, fps=125.0, **more) as writer:
        for picture in pictures(*size[::-1]):
            writer.write(picture)
    return path


def read(path):
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.average_rate == 125
        return stream.codec_context.name, [
            frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)
        ]


@pytest.mark.parametrize(("crf", "codec"), [(None, "mjpeg"), (0, "h264"), (18, "h264")])
def test_pictures_come_back_in_their_order(tmp_path, crf, codec):
    name, frames = read(write(tmp_path / ("a.avi" if crf is None else "a.mp4"), crf=crf))
    assert name == codec
    assert len(frames) == 5
    for frame, picture in zip(frames, pictures(), strict=True):
        away = frame.astype(float) - picture
        assert np.abs(away).mean() < 3.0
        assert np.abs(away.mean(axis=(0, 1))).max() < 2.0


def test_a_higher_crf_is_worse(tmp_path):
    def error(crf):
        _, frames = read(write(tmp_path / f"{crf}.mp4", crf=crf))
        return np.abs(np.array(frames).astype(float) - pictures()).mean()

    assert error(10) < error(30) < error(45)


def test_odd_sizes_gain_a_row_and_a_column_at_the_end(tmp_path):
    v, u = np.mgrid[:47, :63]
    picture = np.stack([20 + 3 * u, 30 + 4 * v, 120 + 0 * u], axis=2).astype(np.uint8)
    with H264VideoWriter(tmp_path / "a.mp4", size=(63, 47), fps=125.0, crf=0) as writer:
        writer.write(picture)
    _, (frame,) = read(tmp_path / "a.mp4")
    assert frame.shape == (48, 64, 3)
    away = frame[:47, :63].astype(float) - picture
    # moved by one row, green would be 4 off, by one column red 3
    assert (np.abs(away.mean(axis=(0, 1))) < 2.0).all()


@pytest.mark.parametrize("crf", [None, 23])
def test_the_same_pictures_give_the_same_bytes(tmp_path, crf):
    ending = "avi" if crf is None else "mp4"
    one, other = (write(tmp_path / f"{name}.{ending}", crf=crf) for name in "ab")
    assert one.read_bytes() == other.read_bytes()
