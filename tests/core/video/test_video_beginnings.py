"""Films that were cut without being encoded anew begin with pictures that rest on lost ones."""

from __future__ import annotations

import av
import numpy as np
import pytest
from video_clips import N, barcode, need_codec, write_clip, write_h264

from pawnb.core.video import open_view
from pawnb.core.video.beginnings import Beginning
from pawnb.trial import View

OPEN_GOP = {"bf": "3", "g": "20", "x264-params": "open-gop=1:scenecut=0:b-adapt=0"}
OPEN_HEVC = {"x265-params": "keyint=20:open-gop=1:bframes=3:b-adapt=0:log-level=error"}


def from_packet(source, target, first):
    """Copy a video from that packet on, or from the key packet of that number (negative)."""
    with av.open(str(source)) as inp, av.open(str(target), "w") as out:
        stream = inp.streams.video[0]
        copy = out.add_stream_from_template(stream)
        packets = [p for p in inp.demux(stream) if p.size]
        keys = [k for k, p in enumerate(packets) if p.is_keyframe]
        for packet in packets[first if first >= 0 else keys[-first] :]:
            packet.stream = copy
            out.mux(packet)
    return target


def hevc(path):
    need_codec("libx265")
    return write_clip(path, codec="libx265", pix_fmt="yuv420p", options=OPEN_HEVC)


def mpeg4(path):
    options = {"bf": "2", "g": "12"}
    return write_clip(path, codec="mpeg4", pix_fmt="yuv420p", options=options)


CUTS = {
    "h264 between key frames, mkv": (write_h264, "mkv", 7, 20),
    "h264 between key frames, mp4": (write_h264, "mp4", 7, 20),
    "h264 between key frames, avi": (write_h264, "avi", 7, 20),
    "h264 open group, mkv": (lambda p: write_h264(p, options=OPEN_GOP), "mkv", -1, 20),
    "hevc open group, mkv": (hevc, "mkv", -1, 20),
    "mpeg4 between key frames, avi": (mpeg4, "avi", 3, 12),
}


@pytest.mark.parametrize("cut", CUTS)
def test_frame_zero_is_the_first_that_can_be_decoded(tmp_path, cut):
    write, suffix, packet, first = CUTS[cut]
    whole = write(tmp_path / f"whole.{'avi' if suffix == 'avi' else 'mp4'}")
    from_packet(whole, tmp_path / f"clip.{suffix}", packet)
    with open_view(View(name="v", video=f"clip.{suffix}"), tmp_path) as view:
        shown = [barcode(view.read(k)) for k in range(view.n_frames)]
        assert shown[0] >= first
        assert shown == list(range(shown[0], N))
        order = np.random.default_rng(1).permutation(view.n_frames)
        assert [barcode(view.read(k)) for k in order] == [shown[k] for k in order]
        (note,) = [note for note in view.source.notes if "cut off" in note]
        assert "begins in between" in note


@pytest.mark.parametrize("write", [write_h264, mpeg4])
def test_a_whole_film_loses_nothing_at_its_beginning(tmp_path, write):
    write(tmp_path / "clip.mkv")
    with open_view(View(name="v", video="clip.mkv"), tmp_path) as view:
        assert (view.n_frames, view.source.notes) == (N, [])


@pytest.mark.parametrize(("intra_only", "most"), [(True, 0), (False, 16)])
def test_few_packets_are_held_while_a_film_is_listed(intra_only, most):
    """Packets of uncompressed film are as large as its pictures."""
    beginning = Beginning(intra_only=intra_only)
    for number in range(100):
        beginning.add(av.Packet(8), is_restart=intra_only or number == 0)
    assert len(beginning._kept) == most
