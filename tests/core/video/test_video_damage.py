"""Missing, damaged and cut-short videos: one sentence, with the frame number."""

from __future__ import annotations

import numpy as np
import pytest
from video_clips import (
    copy_packets,
    damage,
    packet_bytes,
    plain_reading,
    write_clip,
    write_h264,
    write_mjpeg,
)

from pawnb.core.video import open_view
from pawnb.errors import VideoError
from pawnb.trial import View

pytestmark = pytest.mark.slow


def opened(path, **view):
    return open_view(View(name="cam1", video=path.name, **view), path.parent)


def refusal(call, *args):
    with pytest.raises(VideoError) as caught:
        call(*args)
    return str(caught.value)


def cut(path, packet):
    """Cut a file in the middle of a packet."""
    start, size = packet_bytes(path, packet)
    path.write_bytes(path.read_bytes()[: start + size // 2])
    return path


def assert_right_or_refused(path, whole):
    """Every frame is the one of the undamaged file, or is refused; return those refused."""
    refused = []
    with opened(path) as reader:
        for k in range(reader.n_frames):
            try:
                image = reader.read(k)
            except VideoError:
                refused.append(k)
            else:
                assert np.abs(image.astype(int) - whole[k]).max() <= 3, f"frame {k} is another"
    return refused


def test_no_such_video(tmp_path):
    write_mjpeg(tmp_path / "cam1.avi", n=2)
    assert refusal(opened, tmp_path / "cam11.avi") == (
        f"view 'cam1': {tmp_path / 'cam11.avi'}: no such file (did you mean 'cam1.avi'?); "
        "expected a video file, a folder of pictures or a glob such as frames/*.png."
    )


def test_not_a_video(tmp_path):
    path = tmp_path / "notes.avi"
    path.write_text("cam1 was out of focus")
    assert refusal(opened, path) == (
        f"view 'cam1': {path}: not a video that can be read (Invalid data found when processing "
        "input); it may be cut short, damaged or of another kind."
    )


def test_an_empty_file_and_a_link_to_nothing_are_called_so(tmp_path):
    (tmp_path / "empty.mp4").touch()
    assert "the file is empty (0 bytes)" in refusal(opened, tmp_path / "empty.mp4")
    (tmp_path / "link.mp4").symlink_to("gone.mp4")
    assert "link.mp4: a link to gone.mp4, which is not there" in refusal(
        opened, tmp_path / "link.mp4"
    )


def test_mp4_without_its_table_is_refused(tmp_path):
    """The table of an mp4 stands at the end unless it was moved: cut short, nothing is left."""
    path = cut(write_h264(tmp_path / "clip.mp4"), 50)
    assert "it may be cut short" in refusal(opened, path)


@pytest.mark.parametrize("packet", [63, 64, 87, 118])
@pytest.mark.parametrize("kind", ["mjpeg-avi", "h264-avi", "h264-mp4"])
def test_a_file_cut_short_ends_with_its_last_certain_frame(tmp_path, kind, packet):
    path = tmp_path / f"clip.{kind[-3:]}"
    if kind == "h264-mp4":
        whole = write_h264(tmp_path / "whole.mp4", n=120)
        copy_packets(whole, path, options={"movflags": "faststart"})
    elif kind == "h264-avi":
        write_h264(path, n=120)
    else:
        write_mjpeg(path, n=120)
    whole = plain_reading(path)
    cut(path, packet)
    assert assert_right_or_refused(path, whole) == []
    with opened(path) as reader:
        n = reader.n_frames
        note = f"{path} is cut short: it promises 120 frames and ends with frame {n - 1}."
        assert packet - 16 <= n <= packet
        assert kind != "mjpeg-avi" or n == packet
        assert reader.source.notes == [note]
        assert refusal(reader.frame, n) == (
            f"view 'cam1': {path} has no frame {n}; it has {n} frames, 0 to {n - 1} ({note})."
        )


def test_a_packet_that_cannot_be_decoded(tmp_path):
    path = write_mjpeg(tmp_path / "clip.avi")
    start, size = packet_bytes(path, 30)
    damage(path, start, size)
    with opened(path) as reader:
        reader.read(29)
        message = (
            f"{path}: frame 30 cannot be decoded; the file is damaged there or shortly before."
        )
        assert refusal(reader.read, 30) == f"view 'cam1': {message}"
        reader.read(31)


@pytest.mark.parametrize("suffix", ["mp4", "avi"])
@pytest.mark.parametrize(
    ("number", "share"), [(8, 1.0), (20, 1.0), (26, 1.0), (33, 1.0), (41, 1.0), (5, 0.5), (25, 0.5)]
)
def test_what_rests_on_a_damaged_picture_is_refused(tmp_path, suffix, number, share):
    """A picture lost amid B-frames must not let wrong ones through, or shift the numbers.

    Damaged by half, a picture comes out of the decoder all the same, patched up, and after
    the B-frames that rest on it.
    """
    path = write_h264(tmp_path / f"clip.{suffix}")
    whole = plain_reading(path)
    start, size = packet_bytes(path, number)
    kept = 4 if share == 1.0 else size // 2
    damage(path, start + kept, size - kept)
    refused = assert_right_or_refused(path, whole)
    key = number // 20 * 20  # key frames at 0, 20, 40
    # without the key frame the decoder does not let go of up to three pictures before it
    group = range(key - 3 if number == key else key, key + 20)
    assert refused
    assert set(refused) <= set(group)


def test_open_groups_carry_damage_into_the_next(tmp_path):
    """Pictures stored after a key frame and shown before it rest on the group before."""
    options = {"bf": "3", "g": "20", "x264-params": "open-gop=1:scenecut=0"}
    path = write_h264(tmp_path / "clip.mp4", options=options)
    whole = plain_reading(path)
    start, size = packet_bytes(path, 14)
    damage(path, start + 4, size - 4)
    assert assert_right_or_refused(path, whole)


def test_frames_that_are_not_there(tmp_path):
    path = write_mjpeg(tmp_path / "clip.avi", n=5)
    with opened(path) as reader:
        for k in (5, -1):
            assert refusal(reader.frame, k) == (
                f"view 'cam1': {path} has no frame {k}; it has 5 frames, 0 to 4."
            )


def test_crop_outside_the_picture(tmp_path):
    path = write_mjpeg(tmp_path / "clip.avi", n=2)
    assert refusal(lambda: opened(path, crop=(0, 0, 200, 60))) == (
        f"view 'cam1': crop is [0, 0, 200, 60], but the picture of {path} is 160 x 64 px; keep "
        "u0, v0, u1, v1 inside it."
    )


def test_region_outside_the_view(tmp_path):
    path = write_mjpeg(tmp_path / "clip.avi", n=2)
    with opened(path, crop=(10, 10, 60, 50)) as reader:
        frame = reader.frame(1)
        for region in ((0, 0, 51, 40), (-1, 0, 5, 5), (5, 5, 5, 9)):
            assert refusal(frame.crop, *region) == (
                f"frame 1: the region {list(region)} is empty or reaches outside the view of "
                "50 x 40 px."
            )


def test_bayer_of_a_colour_video(tmp_path):
    path = write_clip(tmp_path / "clip.mkv", codec="ffv1", pix_fmt="bgr0", n=2)
    assert refusal(lambda: opened(path, bayer="rggb")).startswith(
        "view 'cam1': bayer is 'rggb', but the pictures are in colour already"
    )


def test_a_closed_file_is_not_read(tmp_path):
    path = write_mjpeg(tmp_path / "clip.avi", n=3)
    reader = opened(path)
    reader.close()
    reader.close()
    assert refusal(reader.frame, 1) == (
        f"view 'cam1': {path} is closed; open it again to read frame 1."
    )
