"""Grey videos: one plane, the pictures given, the same bytes."""

import av
import numpy as np

from pawnb.synthetic.grey_video import GreyVideoWriter


def pictures():
    rng = np.random.default_rng(5)
    v, u = np.mgrid[:48, :64]
    return [np.clip(60 + u + v + 20 * k + rng.normal(0, 2, u.shape), 0, 255).astype(np.uint8)
            for k in range(4)]  # fmt: skip


def write(path):
    with GreyVideoWriter(path, size=(64, 48), fps=125.0) as writer:
        for picture in pictures():
            writer.write(picture)
    return path


def test_pictures_come_back_grey(tmp_path):
    with av.open(str(write(tmp_path / "a.avi"))) as container:
        assert container.streams.video[0].average_rate == 125
        frames = list(container.decode(video=0))
    assert [frame.format.name for frame in frames] == ["gray"] * 4
    for frame, picture in zip(frames, pictures(), strict=True):
        difference = frame.to_ndarray().astype(float) - picture
        assert difference.std() < 2.0
        assert abs(difference.mean()) < 0.2


def test_the_same_pictures_give_the_same_bytes(tmp_path):
    assert write(tmp_path / "a.avi").read_bytes() == write(tmp_path / "b.avi").read_bytes()
