"""Whose a paw is that two points took."""

import numpy as np

from pawnb.core.paws.offline.gap_closing.conflicts import ClosedGap, resolve_conflicts
from pawnb.core.paws.offline.gap_closing.gap import Gap

NONE = np.arange(0)


def closed(point, frames, taken, cost):
    """Return a stretch in which a point took detections (f, V)."""
    gap = Gap(NONE, np.asarray(frames), NONE, False, 1)
    stood = np.zeros(len(frames), bool)
    return ClosedGap(point, gap, np.asarray(taken), stood, np.empty((0, 3)), cost)


def resolve(stretches, otherwise):
    """Resolve conflicts where a stretch of a point that goes without costs ``otherwise[point]``."""
    told = []

    def close_again(one, against):
        told.append((one.point, against))
        taken = np.where(np.take_along_axis(against, one.taken[..., None], 2)[..., 0] > 0, 2, 1)
        return closed(one.point, one.gap.frames, taken, otherwise[one.point])

    return resolve_conflicts(stretches, close_again, 3), told


def test_the_point_that_finds_something_else_more_easily_goes_without():
    front = closed(0, [4, 5, 6], [[1, 1], [1, 1], [1, 1]], 5.0)
    hind = closed(1, [5, 6, 7], [[1, 1], [1, 1], [1, 1]], 5.0)
    for otherwise, goes in (({0: 6.0, 1: 30.0}, 0), ({0: 30.0, 1: 6.0}, 1)):
        after, told = resolve([front, hind], otherwise)
        assert after[1 - goes] is (front, hind)[1 - goes]
        assert after[goes].cost == 6.0
        # in the frames that both have, and in no other
        against = dict(told)[goes]
        np.testing.assert_array_equal(
            (against[..., 1] > 0).all(axis=1), [[0, 1, 1], [1, 1, 0]][goes]
        )
        assert not against[..., [0, 2]].any()


def test_a_stretch_on_the_paws_of_two_others_leaves_both():
    # each of its rivals alone would rather give way than make it leave one of the two
    wrong = closed(0, [0, 1, 2, 3], [[1, 1]] * 4, 100.0)
    rivals = [closed(p, f, [[1, 1]] * 2, 5.0) for p, f in ((1, [0, 1]), (2, [2, 3]))]
    after, _ = resolve([*rivals, wrong], {0: 20.0, 1: 9.0, 2: 9.0})
    assert [one.cost for one in after] == [5.0, 5.0, 20.0]


def test_points_may_meet_in_one_picture_and_follow_each_other():
    one = closed(0, [4, 5], [[1, 0], [1, 0]], 5.0)
    for other in (
        closed(1, [4, 5], [[1, 2], [1, 2]], 5.0),
        closed(1, [6, 7], [[1, 0], [1, 0]], 5.0),
        closed(1, [4, 5], [[-1, -1], [-1, -1]], 5.0),
        closed(0, [4, 5], [[1, 0], [1, 0]], 5.0),
    ):
        after, told = resolve([one, other], {0: 0.0, 1: 0.0})
        assert after == [one, other]
        assert not told
