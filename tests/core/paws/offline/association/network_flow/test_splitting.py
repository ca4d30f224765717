"""Where tracklets are cut: where points meet, or seem to slide."""

import numpy as np
import pytest

from pawnb.core.paws.offline.association.network_flow.splitting import (
    split_at_crossings,
    split_sliding,
)
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet


def test_pieces_are_cut_where_they_meet_and_nowhere_else():
    frames = np.arange(40)
    ahead = np.column_stack([frames, 0.0 * frames]).astype(float)
    back = np.column_stack([40.0 - frames, 1.0 + 0.0 * frames])
    away = np.column_stack([frames, 100.0 + 0.0 * frames])
    tracklets = [Tracklet(0, list(frames), at, np.zeros(40)) for at in (ahead, back, away)]
    parts = split_at_crossings(tracklets, 6.0)
    # |40 - 2 t| and 1 apart: less than 6 from frame 18 to 22, least at 20
    assert sorted((p.first, p.last) for p in parts) == sorted(
        [(0, 17), (18, 19), (20, 22), (23, 39)] * 2 + [(0, 39)]
    )
    for part in parts:
        assert part.detection_indices == list(range(part.first, part.last + 1))
        assert len(part.at) == len(part.cost) == len(part.detection_indices)


def test_a_piece_is_cut_where_another_begins_beside_it():
    frames = np.arange(20)
    at = np.column_stack([frames, 0.0 * frames]).astype(float)
    whole = Tracklet(0, list(frames), at, np.zeros(20))
    late = Tracklet(9, [0], np.array([[9.0, 5.0]]), np.zeros(1))
    far = Tracklet(15, [0], np.array([[15.0, 50.0]]), np.zeros(1))
    parts = split_at_crossings([whole, late, far], 6.0)
    assert (0, 8) in [(p.first, p.last) for p in parts]
    assert (10, 19) in [(p.first, p.last) for p in parts]


def tracklet(at):
    return Tracklet(0, list(range(len(at))), at, np.zeros(len(at)))


DRIFT = np.array([-1.2, 0.05, 0.1])
AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def standing_twice(step, *, between=4, stands=(20, 20), vague=0.1):
    """A tracklet that stands, moves by a step on the ground, and stands again, with some noise."""
    rng = np.random.default_rng(5)
    share = np.concatenate(
        [np.zeros(stands[0]), np.linspace(0.0, 1.0, between + 2)[1:-1], np.ones(stands[1])]
    )
    still = share[:, None] * np.asarray(step) + rng.normal(0.0, [0.1, vague, 0.1], (len(share), 3))
    return tracklet(still + np.arange(len(share))[:, None] * DRIFT)


def cut(one, frames=4):
    return [
        (part.first, part.last)
        for part in split_sliding(
            [one], substrate_velocity=DRIFT, axes=AXES, paw_width=3.0, frames=frames
        )
    ]


def test_a_piece_that_stands_beside_where_it_stood_is_cut_in_between():
    """Nothing that stands slides by a paw width: one paw landed where the other lifted off."""
    (first, second) = cut(standing_twice([3.0, 0.0, 0.0]))
    assert (first[0], second[1]) == (0, 43)
    # it moves from frame 20 to frame 23
    assert 20 <= second[0] <= 24
    # also where it is after half a tracklet at a high frame rate, and to the side
    (first, second) = cut(standing_twice([0.0, 3.0, 0.0], between=1), frames=6)
    assert 19 <= second[0] <= 22


def test_that_a_paw_stands_is_not_told_by_its_depth():
    # two cameras on one side tell depth four times less well
    (first, _) = cut(standing_twice([3.0, 0.0, 0.0], vague=0.6))
    assert 20 <= first[1] <= 24


@pytest.mark.parametrize("step", [[0.0, 0.0, 0.0], [1.0, 0.4, 0.4]])
def test_a_piece_that_stays_on_its_place_is_not_cut(step):
    assert cut(standing_twice(step)) == [(0, 43)]


def test_a_swing_and_a_short_piece_are_no_slide():
    # between two stances a paw swings far: that takes longer than a slide
    assert cut(standing_twice([60.0, 0.0, 0.0], between=20)) == [(0, 59)]
    assert cut(standing_twice([3.0, 0.0, 0.0], between=2, stands=(3, 3))) == [(0, 7)]
