"""A file that is cut short gives its first frames, each under its number, and says so."""

from __future__ import annotations

import struct

import av
import numpy as np
import pytest
from video_clips import (
    copy_packets,
    packet_bytes,
    picture,
    write_cine,
    write_clip,
    write_h264,
    write_mjpeg,
)

from pawnb.core.video import open_view
from pawnb.core.video.file import VideoFile
from pawnb.errors import VideoError
from pawnb.trial import View

N = 40
WITH_B = {"x264-params": "keyint=12:bframes=3:scenecut=0"}
FRAGMENTS = {"movflags": "frag_keyframe+empty_moov"}
ONE_BY_ONE = {"movflags": "frag_every_frame+empty_moov"}


def write_kind(folder, kind):
    """Write a clip of a kind: codec, container and how it is written."""
    codec, suffix, *how = kind.split()
    path = folder / f"clip.{suffix}"
    if codec == "h264":
        first = path if not how else folder / "first.mp4"
        write_h264(first, n=N, options=WITH_B)
        if how:
            copy_packets(first, path, options=FRAGMENTS if how == ["fragments"] else ONE_BY_ONE)
    elif codec == "mjpeg":
        write_mjpeg(path, n=N)
    else:
        write_clip(path, codec=codec, pix_fmt="yuv420p", n=N, options={"g": "12"})
    return path


def read_all(path):
    video = VideoFile(path)
    pictures = [
        video.grab(k).region(0, 0, video.width, video.height).copy() for k in range(video.n_frames)
    ]
    return pictures, video.notes


def may_end_at(data, at, borders, suffix):
    """Whether a file that ends there looks like a shorter recording, in every one of its bytes."""
    if suffix == "ts":  # tables may come between two pictures; video is FFmpeg's stream 256
        after = next((b for b in borders if b >= at), len(data))
        parts = [data[k + 1 : k + 3] for k in range(at, after, 188)]
        return at % 188 == 0 and all(part[0] & 31 != 1 or part[1] for part in parts)
    return suffix in ("m2ts", "flv") and at in borders


@pytest.mark.parametrize(
    "kind",
    [
        "h264 mkv", "h264 ts", "h264 m2ts", "h264 flv", "h264 mp4 fragments", "h264 mp4 one-by-one",
        "libvpx webm", "mpeg2video ts", "mjpeg mkv",
    ],
)  # fmt: skip
def test_a_file_cut_anywhere_tells_and_misnumbers_nothing(tmp_path, kind):
    path = write_kind(tmp_path, kind)
    whole, notes = read_all(path)
    assert (len(whole), notes) == (N, [])
    data = path.read_bytes()
    with av.open(str(path)) as container:
        borders = [p.pos for p in container.demux(video=0) if p.size]
    places = [*borders[5::9], *(at + 200 for at in borders[3::8]), len(data) - 1, len(data) // 2]
    # a transport stream cut between two of its packets
    places += [at // 188 * 188 for at in places] if kind.endswith(" ts") else []
    cut, most = path.with_name(f"cut.{path.suffix}"), 0
    for at in places:
        cut.write_bytes(data[:at])
        try:
            pictures, notes = read_all(cut)
        except VideoError:
            assert at < borders[16], f"at {at}: refused, though much of it is there"
            continue
        most = max(most, len(pictures))
        for number, one in enumerate(pictures):
            np.testing.assert_array_equal(one, whole[number], f"at {at}: frame {number}")
        if len(pictures) < N and not may_end_at(data, at, borders, kind.split()[1]):
            assert notes == [f"{cut} is cut short: ends with frame {len(pictures) - 1}."], at
    assert most >= N - 6  # it does not tell by leaving out much


def test_a_live_recording_of_unknown_length_is_whole_unless_a_block_is_cut(tmp_path):
    path = write_clip(
        tmp_path / "clip.webm", codec="libvpx", pix_fmt="yuv420p", n=N, options={"g": "12"}
    )
    live = copy_packets(path, tmp_path / "live.webm", options={"live": "1"})
    whole, notes = read_all(live)
    assert (len(whole), notes) == (N, [])
    live.write_bytes(live.read_bytes()[:-30])
    pictures, notes = read_all(live)
    assert len(pictures) == N - 1
    assert "cut short" in notes[0]


def test_a_container_that_never_tells_is_named(tmp_path):
    path = copy_packets(write_h264(tmp_path / "clip.mp4", n=9), tmp_path / "clip.nut")
    with open_view(View(name="cam1", video=path.name), tmp_path) as reader:
        assert reader.source.notes == [
            f"{path}: a file of this kind (nut) does not tell whether it is whole; look whether "
            "its last frame is."
        ]


def test_fragments_that_end_in_their_header_are_one_sentence(tmp_path):
    path = write_kind(tmp_path, "h264 mp4 fragments")
    data = path.read_bytes()
    for at in range(0, data.index(b"mdat") + 40, 9):
        path.write_bytes(data[:at])
        with pytest.raises(VideoError):
            read_all(path)


@pytest.mark.parametrize("write", [write_mjpeg, write_h264])
def test_frames_that_were_dropped_in_an_avi_are_not_missing_at_its_end(tmp_path, write):
    """FFmpeg writes an empty chunk for each, as capture programs do, and counts it."""
    kept = [*range(10), *range(14, 30)]
    path = write(tmp_path / "clip.avi", n=len(kept), times=kept)
    video = VideoFile(path)
    assert (video.n_frames, video.notes) == (len(kept), [])
    assert video.is_variable_rate
    path.write_bytes(path.read_bytes()[: packet_bytes(path, 20)[0]])
    assert "is cut short: it promises 30 frames" in " ".join(VideoFile(path).notes)


def test_a_copy_into_avi_at_twice_the_rate_is_whole(tmp_path):
    """Every other chunk is empty then, the last one too: none is missing."""
    whole = write_h264(tmp_path / "whole.avi", n=N, times=[2 * k for k in range(N)], rate=100)
    data = bytearray(whole.read_bytes())
    place = data.index(b"strh") + 8 + 32  # dwLength: ffmpeg counts two for the last frame
    assert struct.unpack_from("<I", data, place) == (2 * N - 1,)
    struct.pack_into("<I", data, place, 2 * N)
    whole.write_bytes(data)
    video = VideoFile(whole)
    assert (video.n_frames, video.notes, video.is_variable_rate) == (N, [], False)


def test_one_dropped_frame_in_an_avi_is_time_that_passes(tmp_path):
    video = VideoFile(write_mjpeg(tmp_path / "clip.avi", n=29, times=[*range(10), *range(11, 30)]))
    assert video.is_variable_rate
    np.testing.assert_allclose(np.diff(video.stamps_s)[8:11], [0.02, 0.04, 0.02])


def test_a_film_of_a_phantom_camera_is_read_and_tells_where_it_ends(tmp_path):
    pictures = [picture(k)[..., 0] for k in range(N)]
    path = write_cine(tmp_path / "run.cine", pictures)
    video = VideoFile(path)
    assert (video.n_frames, video.notes) == (N, [])
    assert video.stamps_s[:3].tolist() == [0.0, 0.001, 0.002]
    assert np.array_equal(video.grab(7).region(0, 0, video.width, video.height), pictures[7])
    for lacking in (1, pictures[0].size + 4, 3 * pictures[0].size):
        part = tmp_path / f"{lacking}.cine"
        part.write_bytes(path.read_bytes()[:-lacking])
        short = VideoFile(part)
        assert short.notes == [f"{part} is cut short: ends with frame {short.n_frames - 1}."]
        assert short.n_frames == N - -(-lacking // (8 + pictures[0].size))


@pytest.mark.parametrize(
    ("name", "program"), [("a.mraw", "Photron"), ("a.cihx", "Photron"), ("a.CINE", "Phantom")]
)
def test_a_format_of_a_camera_that_is_not_read_is_named_with_what_saves_it(tmp_path, name, program):
    # what Photron's pictures are: bits without a head; a cine of 12 packed bits (1024)
    (tmp_path / name).write_bytes(bytes(range(256)) * 64)
    if name == "a.CINE":
        write_cine(tmp_path / name, [picture(0)[..., 0]], compression=1024)
    with pytest.raises(VideoError, match=rf"{program}.*own format.*save the recording in .* TIFF"):
        open_view(View(name="side", video=name), tmp_path)
