"""The packet index on containers that are told, not written."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.video.packets import Packet, PacketIndex

SIZE = 90


def packet(pts, dts, position=None, *, key=False, hidden=False, fresh=False):
    return Packet(pts, dts, position, SIZE, hidden, 0 if key else None, fresh)


def index(packets, **more):
    options = {"tick_s": 0.02, "intra_only": False, "trusts_pts": True, "reorders": 1} | more
    return PacketIndex(packets, **options)


# I P B B | I P B B in the order of decoding; shown I B B P
GROUPS = [
    packet(0, -1, 100, key=True, fresh=True), packet(3, 0, 200), packet(1, 1, 300),
    packet(2, 2, 400), packet(4, 3, 500, key=True, fresh=True), packet(7, 4, 600),
    packet(5, 5, 700), packet(6, 6, 800),
]  # fmt: skip


def test_display_times_number_the_packets():
    found = index(GROUPS)
    assert found.n_frames == 8
    assert found.numbers.tolist() == [0, 3, 1, 2, 4, 7, 5, 6]
    assert [found.restarts_for(k) for k in (0, 3, 4, 7)] == [[(0, 0)], [(0, 0)], [(4, 4)], [(4, 4)]]
    np.testing.assert_allclose(found.stamps_s, np.arange(8) * 0.02)
    assert not found.is_variable_rate


def test_leading_pictures_of_an_open_group_are_decoded_from_the_group_before():
    """The second key frame is stored before two pictures that are shown before it."""
    packets = [packet(0, -1, key=True), packet(3, 0, key=True), packet(1, 1), packet(2, 2)]
    found = index(packets)
    assert found.restarts_for(2) == [(0, 0)]
    assert found.restarts_for(3) == [(1, 3)]
    assert found.spoilt_by(0) == {0, 2, 3}  # not the key frame itself


@pytest.mark.parametrize(
    "packets",
    [
        [p._replace(pts=None) for p in GROUPS],
        [p._replace(pts=7) if p.pts == 6 else p for p in GROUPS],
    ],
    ids=["missing", "repeated"],
)
def test_without_display_times_pictures_are_counted_from_where_display_begins_anew(packets):
    found = index(packets)
    assert found.numbers is None
    assert found.n_frames == 8
    assert found.restarts_for(6) == [(4, 4)]
    assert found.spoilt_by(5) == {4, 5, 6, 7}


def test_counting_does_not_begin_at_a_key_frame_that_is_shown_late():
    packets = [p._replace(pts=None, is_fresh=False) for p in GROUPS]
    assert index(packets).restarts_for(7) == [(0, 0)]


def test_hidden_packets_are_decoded_but_not_numbered():
    packets = [p._replace(is_hidden=p.pts < 2) for p in GROUPS]
    found = index(packets)
    assert found.n_frames == 6
    assert found.numbers.tolist() == [-1, 1, -1, 0, 2, 5, 3, 4]
    assert found.restarts_for(0) == [(0, 0)]
    assert not found.is_shown(0, 0)


def test_packets_missing_at_the_end_leave_out_what_may_not_be_next():
    """Cut after P: the two pictures shown before it are not there, so it is not frame 1."""
    assert index(GROUPS[:2], is_cut=True).n_frames == 1
    assert index(GROUPS[:6], is_cut=True).n_frames == 5


def test_uneven_times_are_variable_and_rounded_ones_are_not():
    def times(ticks):
        packets = [packet(t, t, key=True) for t in ticks]
        return index(packets, tick_s=0.001, intra_only=True)

    sixty = np.rint(np.arange(300) * 1000 / 60).astype(int).tolist()
    assert not times(sixty).is_variable_rate
    assert times([*sixty[:100], *sixty[101:]]).is_variable_rate  # one picture dropped


def test_one_frame_that_an_avi_dropped_is_seen():
    """Its ticks are frames: 0 1 2 4 lies within a tick of an even line."""
    packets = [packet(t, t, key=True) for t in (0, 1, 2, 4, 5)]
    assert index(packets, intra_only=True, counts_ticks=True).is_variable_rate
    assert not index(packets[:3], intra_only=True, counts_ticks=True).is_variable_rate
    assert not index(packets[:1], intra_only=True, counts_ticks=True).is_variable_rate


@pytest.mark.parametrize("since", [-2, 0, -200])
def test_recordings_put_one_behind_the_other_are_evenly_spaced_in_their_order(since):
    """Time begins anew in the second: among the times of the first, or before them."""
    second = [p._replace(pts=p.pts + since, dts=p.dts + since) for p in GROUPS]
    first = [p._replace(pts=p.pts + 60, dts=p.dts + 60) for p in GROUPS]
    found = index([*first, *second], rate_hz=50.0)
    assert found.begins_anew
    assert found.numbers is None  # counted
    np.testing.assert_allclose(found.stamps_s, np.arange(16) / 50)
    assert not found.is_variable_rate
    assert not index(GROUPS).begins_anew


def test_landing_is_certain_or_nothing():
    found = index(GROUPS)
    assert found.identify(500, SIZE, dts=3) == 4
    assert found.identify(501, SIZE, dts=3) is None
    assert found.identify(None, SIZE, dts=3) is None
    assert found.identify(500, SIZE - 1, dts=3) is None
    twice = index([packet(0, 0, 100, key=True), packet(1, 1, 100), packet(2, 2, 100)])
    assert twice.identify(100, SIZE, dts=1) == 1
    assert twice.identify(100, SIZE, dts=None) is None


def test_seeking_steps_back_to_the_start():
    packets = [packet(10 * k, 10 * k, k, key=True) for k in range(100)]
    assert index(packets).seek_ticks(50, step=100) == [500, 400, 300, 100, 0]
    assert index([packet(None, None, 0, key=True)]).seek_ticks(0, step=1) == []


def test_after_a_recovery_point_pictures_are_exact_once_so_many_references_have_come():
    """Two references after the second key packet; a picture that is none does not count."""
    packets = [packet(k, k, key=k == 0, fresh=k == 0) for k in range(8)]
    packets[3] = packets[3]._replace(recovery=2, is_sure=False)
    packets[4] = packets[4]._replace(is_reference=False)
    found = index(packets)
    assert found.restarts_for(5) == [(0, 0)]
    assert found.restarts_for(6) == [(3, 6), (0, 0)]  # should it fail, from where it cannot
    assert found.spoilt_by(1) == {1, 2, 3, 4, 5}
    packets[3] = packets[3]._replace(recovery=7)  # the recovery comes after the end
    assert index(packets).restarts_for(7) == [(0, 0)]
