"""Bytes that no camera wrote: a video of any bytes gives pictures or one sentence, and soon."""

from __future__ import annotations

import os
import random
import time

import pytest
from video_clips import copy_packets, write_clip, write_h264, write_mjpeg

from pawnb.core.video.file import VideoFile
from pawnb.core.video.pictures import PictureFolder
from pawnb.errors import VideoError

WORDS = (b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff", b"\0\0\xff\xff")


def scrambled(data, rng):
    """Bytes changed, left out or put in at a few places, or cut off; the header is hit often."""
    kind = rng.randrange(5)
    for _ in range(rng.choice([1, 2, 5, 30])):
        at = rng.randrange(min(len(data), rng.choice([300, 3000, len(data)])))
        word = rng.choice(WORDS)
        some = data[: rng.randrange(1, 100)]
        data = (
            data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
            data[:at] + word + data[at + 4 :],
            data[:at] + data[at + rng.randrange(1, 60) :],
            data[:at] + some + data[at:],
            data[: max(at, 10)],
        )[kind]
    return data


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["mp4", "mkv", "ts", "avi", "webm"])
def test_scrambled_videos(tmp_path, suffix):
    path, rng = tmp_path / f"clip.{suffix}", random.Random(suffix)  # noqa: S311
    if suffix == "webm":
        write_clip(path, codec="libvpx", pix_fmt="yuv420p", n=20, options={"g": "9"})
    elif suffix == "avi":
        write_mjpeg(path, n=20)
    elif suffix == "mp4":
        first = write_h264(tmp_path / "first.mp4", n=20, options={"bf": "2", "g": "9"})
        copy_packets(first, path, options={"movflags": "frag_keyframe+empty_moov"})
    else:
        write_h264(path, n=20, options={"x264-params": "intra-refresh=1:keyint=9"})
    whole, opened, begun = path.read_bytes(), 0, time.monotonic()
    for _ in range(100):
        path.write_bytes(scrambled(whole, rng))
        try:
            video = VideoFile(path)
        except VideoError:
            continue
        opened += 1
        for number in (video.n_frames - 1, video.n_frames // 2, 0):
            try:
                video.grab(number)
            except VideoError as error:
                assert len(str(error)) < 500 + len(str(path))  # noqa: PT017
        video.close()
    assert opened > 10
    assert time.monotonic() - begun < 60


def test_a_name_is_a_file_s_whatever_it_looks_like(tmp_path, monkeypatch):
    """To FFmpeg, names may be addresses, and files lists of addresses to fetch."""
    monkeypatch.chdir(tmp_path)
    for name in ("pipe:0", "http://localhost:1/a.mp4", "concat:a.mp4|b.mp4", "-"):
        with pytest.raises(VideoError, match="no such file"):
            VideoFile(name)
    write_mjpeg(tmp_path / "clip.avi", n=3)
    os.rename("clip.avi", "pipe:0")  # noqa: PTH104
    assert VideoFile("pipe:0").n_frames == 3
    playlist = tmp_path / "clip.m3u8"
    playlist.write_text("#EXTM3U\n#EXTINF:1,\nhttp://localhost:1/a.ts\n#EXT-X-ENDLIST\n")
    with pytest.raises(VideoError):
        VideoFile(playlist)


@pytest.mark.parametrize("make", [VideoFile, PictureFolder])
def test_pipes_and_devices_are_not_waited_for(tmp_path, make):
    pipe, device = tmp_path / "000.png", tmp_path / "001.png"
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    for path in (pipe, device):
        begun = time.monotonic()
        with pytest.raises(VideoError, match=r"a named pipe|a device"):
            make(path)
        assert time.monotonic() - begun < 1


def test_a_picture_that_says_it_is_larger_than_any_is_one_sentence(tmp_path):
    import struct
    import zlib

    def chunk(kind, body):
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    head = struct.pack(">IIBBBBB", 2_000_000, 2_000_000, 8, 2, 0, 0, 0)
    file = tmp_path / "0.png"
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"x") + chunk(b"IEND", b"")
    )
    with pytest.raises(VideoError, match="cannot be read as a picture"):
        PictureFolder(file)
