"""Where decoding can begin, read from the bytes of H.264 and HEVC packets."""

from __future__ import annotations

import pytest

from pawnb.core.video.units import Entry, read_entry

LENGTHS = b"\1ddd\xff\xe1"  # avcC: its fifth byte declares lengths of four bytes
FRESH = Entry(0, is_fresh=True)
NEVER = Entry(None, is_sure=False)


@pytest.mark.parametrize(
    ("codec", "data", "extradata", "expected"),
    [
        # start codes: 9 access unit delimiter, 7 SPS, 6 SEI, 5 IDR, 1 other slice (H.264 7-1)
        ("h264", b"\0\0\0\1\x09\xf0\0\0\1\x67\0\0\1\x65\x88", None, FRESH),
        ("h264", b"\0\0\1\x06\x05\0\0\1\x41\x9a", None, NEVER),
        # nal_ref_idc of 0: a picture on which none rests (7.4.1)
        ("h264", b"\0\0\1\x01\x9a", None, NEVER._replace(is_reference=False)),
        ("h264", b"\0\0\0\2\x06\x05\0\0\0\2\x65\x88", LENGTHS, FRESH),
        ("h264", b"\0\0\0\2\x41\x9a", LENGTHS, NEVER),
        ("h264", b"", None, Entry(None)),
        # H.265 7-1: 32 VPS, 19 IDR_W_RADL, 21 CRA, 1 TRAIL_R
        ("hevc", b"\0\0\1\x40\1\0\0\1\x26\1\xaf", None, FRESH),
        ("hevc", b"\0\0\1\x2a\1\xaf", None, Entry(0)),
        ("hevc", b"\0\0\1\x02\1\xaf", None, Entry(None)),
        ("mpeg4", b"\0\0\1\xb6\x10", None, Entry(0)),
    ],
)
def test_read_entry(codec, data, extradata, expected):
    assert read_entry(data, codec, extradata, is_key=True) == expected


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        # ue(v) recovery_frame_cnt, exact_match_flag, broken_link_flag, changing_slice_group_idc:
        ("1 1 0 00", 0),  # from here on
        ("00100 1 0 00", 3),  # codeNum 3 is 00100 (H.264, Table 9-2)
        ("000011110 1 0 00", 29),  # 30 - 1 frames of x264's keyint=30
        ("00100 0 0 00", None),  # an approximate match
        ("00100 1 1 00", None),  # what comes before was cut away
        ("0000000", None),
    ],
)
def test_recovery_point(message, expected):
    bits = message.replace(" ", "")
    payload = int(bits.ljust(-(-len(bits) // 8) * 8, "0"), 2).to_bytes(-(-len(bits) // 8), "big")
    # behind a message of type 5 and 300 bytes, whose size is written as 255 and 45
    sei = b"\x06\x05\xff\x2d" + b"u" * 300 + b"\x06" + bytes([len(payload)]) + payload + b"\x80"
    found = read_entry(b"\0\0\1" + sei + b"\0\0\1\x41\x9a", "h264", None, is_key=True)
    assert found == NEVER._replace(recovery=expected)


@pytest.mark.parametrize("end", range(1, 20))
def test_a_message_cut_short_is_none(end):
    data = (b"\0\0\1\x06\xff\xff\x06\x06\x01\xc4\x80" + b"\0\0\1\x41\x9a")[:end]
    assert read_entry(data, "h264", None, is_key=True).recovery is None


@pytest.mark.parametrize(
    ("extradata", "slice_"),
    [(None, b"\0\0\1\1\x06\1\xc4"), (LENGTHS, b"\0\0\0\5\1\x9f\x06\1\xc4")],
)
def test_messages_end_with_their_unit(extradata, slice_):
    """Interlaced x264: a picture timing (type 1), then a slice, whose bytes are no messages."""
    head = b"\0\0\1" if extradata is None else b"\0\0\0\5"
    data = head + b"\x06\x01\x01\x32\x80" + slice_
    expected = NEVER._replace(is_reference=False)
    assert read_entry(data, "h264", extradata, is_key=False) == expected
