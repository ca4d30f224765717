"""Any frame asked for first is bit for bit the one that reading from the start gives."""

from __future__ import annotations

import numpy as np
import pytest
from video_clips import damage, packet_bytes, plain_reading, write_clip, write_h264

from pawnb.core.video.file import VideoFile

STREAMS = {
    # no picture is whole by itself after the first: x264 writes recovery points
    "intra-refresh": "intra-refresh=1:keyint=12:bframes=0",
    "intra-refresh with B": "intra-refresh=1:keyint=12:bframes=3",
    "open groups": "open-gop=1:keyint=12:bframes=3:scenecut=0",
}


def whole_picture(video, index):
    return video.grab(index).region(0, 0, video.width, video.height)


@pytest.mark.parametrize(
    ("stream", "suffix"),
    [*((name, suffix) for name in STREAMS for suffix in ("mkv", "ts")), ("intra-refresh", "avi")],
)
def test_random_access_is_exact(tmp_path, stream, suffix):
    n = 40
    path = write_h264(tmp_path / f"clip.{suffix}", n=n, options={"x264-params": STREAMS[stream]})
    video = VideoFile(path)
    whole = [whole_picture(video, k).copy() for k in range(video.n_frames)]
    assert len(whole) == len(plain_reading(path)) == n
    for k in range(3, n, 3):
        video = VideoFile(path)
        # backwards, too: the frame before lies before what was decoded for this one
        for at in (k, k - 1, k - 2):
            np.testing.assert_array_equal(whole_picture(video, at), whole[at], f"frame {at}")
        video.close()


def test_hevc_with_open_groups_is_exact(tmp_path):
    options = {"x265-params": "keyint=20:bframes=3:open-gop=1:log-level=none"}
    path = write_clip(tmp_path / "clip.mkv", codec="libx265", pix_fmt="yuv420p", options=options)
    video = VideoFile(path)
    whole = [whole_picture(video, k).copy() for k in range(video.n_frames)]
    for k in (59, 41, 38, 21, 19, 18, 1):
        np.testing.assert_array_equal(whole_picture(VideoFile(path), k), whole[k])


def test_what_rests_on_a_damaged_picture_is_refused_until_the_refresh_is_over(tmp_path):
    """A recovery point does not mend at once: pictures up to its end rest on what was before."""
    path = write_h264(
        tmp_path / "clip.mkv", n=90, options={"x264-params": STREAMS["intra-refresh"]}
    )
    whole = plain_reading(path)
    start, size = packet_bytes(path, 25)
    damage(path, start + size // 2, size - size // 2)
    video, refused = VideoFile(path), []
    for k in range(video.n_frames):
        try:
            image = whole_picture(video, k)
        except ValueError:
            refused.append(k)
        else:
            assert np.abs(image.astype(int) - whole[k]).max() <= 3, f"frame {k} is another"
    assert refused
    assert min(refused) == 25
    assert max(refused) < 48  # the second refresh brings sound pictures again
