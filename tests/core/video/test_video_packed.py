"""MPEG-4 in AVI whose B pictures are packed, two in a packet, as DivX and Xvid write it."""

from __future__ import annotations

import av
import numpy as np
import pytest
from video_clips import N, barcode, packet_bytes, write_clip

from pawnb.core.video import open_view
from pawnb.core.video.packed import display_times
from pawnb.trial import View

PICTURE = b"\0\0\1\xb6"


def pack(source, target):
    """Pack a clip: a picture carries the B picture that is shown before it, an empty one follows.

    The comment whose p says so is that of DivX; an empty picture is one that is not coded.
    """
    with av.open(str(source)) as inp, av.open(str(target), "w") as out:
        stream = inp.streams.video[0]
        copy = out.add_stream_from_template(stream)
        data = [bytes(p) for p in inp.demux(stream) if p.size]
        is_b = [d[d.index(PICTURE) + 4] >> 6 == 2 for d in data]
        packed = []
        for k, picture in enumerate(data):
            following = data[k + 1] if k + 1 < len(data) and is_b[k + 1] else None
            if is_b[k]:
                # the next of several B pictures, or where the last stood an empty one
                packed.append(following or PICTURE + b"\x50\x00")
                continue
            packed.append(picture + following if following else picture)
        packed[0] = b"\0\0\1\xb2DivX503b1393p" + packed[0]
        for k, picture in enumerate(packed):
            packet = av.Packet(picture)
            packet.stream, packet.pts, packet.dts = copy, k, k
            packet.time_base, packet.is_keyframe = stream.time_base, not is_b[k] and k % 12 == 0
            out.mux(packet)
    return target


@pytest.mark.parametrize("n_b", [1, 2])
def test_packed_pictures_are_read_in_the_order_in_which_they_are_shown(tmp_path, n_b):
    options = {"bf": str(n_b), "g": "12"}
    write_clip(tmp_path / "a.avi", codec="mpeg4", pix_fmt="yuv420p", options=options)
    pack(tmp_path / "a.avi", tmp_path / "clip.avi")
    with (
        open_view(View(name="v", video="a.avi"), tmp_path) as plain,
        open_view(View(name="v", video="clip.avi"), tmp_path) as view,
    ):
        assert view.n_frames == N
        assert not view.is_variable_rate
        for k in np.random.default_rng(2).permutation(N):
            assert barcode(view.read(k)) == k
            np.testing.assert_array_equal(view.read(k), plain.read(k))


def test_packed_pictures_of_a_file_that_is_cut_anywhere(tmp_path):
    options = {"bf": "2", "g": "12"}
    write_clip(tmp_path / "a.avi", codec="mpeg4", pix_fmt="yuv420p", options=options)
    data = pack(tmp_path / "a.avi", tmp_path / "clip.avi").read_bytes()
    first = packet_bytes(tmp_path / "clip.avi", 20)[0]
    for at in range(first, first + 400, 41):
        (tmp_path / "clip.avi").write_bytes(data[:at])
        with open_view(View(name="v", video="clip.avi"), tmp_path) as view:
            shown = [barcode(view.read(k)) for k in range(view.n_frames)]
            assert shown == list(range(len(shown)))
            assert len(shown) > 12
            assert "is cut short" in " ".join(view.source.notes)


def test_display_times():
    """I P B B P B: shown as I B B P B P."""
    at_once = [False, False, True, True, False, True]
    assert display_times(list(range(6)), at_once) == [0, 3, 1, 2, 5, 4]
