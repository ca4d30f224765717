"""When paws lift off: strides with a known share of stance, and what is expected of the next."""

import numpy as np
import pytest

from pawnb.core.paws.offline.stride.duty_factor import DutyFactor, learn_duty_factor
from pawnb.core.paws.offline.stride.stance import Stance

ORIGIN = np.zeros(3)


def walk(*, stride=50, share=0.6, begin=10, strides=6, late=()):
    """Stances of a point; the lift-offs of some strides are told 20 frames too late."""
    return [
        Stance(
            begin + k * stride,
            begin + k * stride + round(share * stride) + (20 if k in late else 0), ORIGIN,
        )
        for k in range(strides)
    ]  # fmt: skip


def test_the_share_of_a_stride_in_stance_is_learnt():
    duty_factor = learn_duty_factor([walk(), walk(begin=35)], ["front", "front"])
    np.testing.assert_allclose(duty_factor.share, 0.6)
    assert duty_factor.stride == 50.0
    # it differs by 0.02 of a stride, and the median of ten is told to 0.02 * 1.25 / sqrt(10)
    np.testing.assert_allclose(duty_factor.sd, np.hypot(0.02, 0.02 * 1.25 / np.sqrt(10)))


def test_lift_offs_that_are_told_wrongly_and_missed_stances_do_not_matter():
    mine = walk(late=(0, 3), strides=9)
    del mine[6]
    duty_factor = learn_duty_factor([mine], ["front"])
    np.testing.assert_allclose(duty_factor.share, 0.6)
    assert duty_factor.stride == 50.0


def test_points_of_a_kind_have_one_rhythm_and_learn_little_from_the_other():
    front, hind = walk(share=0.6), walk(share=0.7, begin=30)
    duty_factor = learn_duty_factor([front, hind, []], ["front", "hind", "front"])
    assert duty_factor.share[0] == duty_factor.share[2]
    assert 0.6 < duty_factor.share[0] < 0.65 < duty_factor.share[1] < 0.7
    # of a paw that was hardly seen as much is known as the other kind tells
    alone = learn_duty_factor([front[:2], hind], ["front", "hind"])
    np.testing.assert_allclose(alone.share, 0.7)
    assert alone.sd[0] > alone.sd[1]


@pytest.mark.parametrize("strides", [0, 1, 2])
def test_too_few_strides_teach_nothing(strides):
    assert learn_duty_factor([walk(strides=strides)], ["front"]) is None
    # before the first frame it stood nobody knows how long
    assert learn_duty_factor([walk(begin=0, strides=3)], ["front"]) is None


def test_strides_that_make_up_little_of_the_recording_teach_nothing():
    # four strides of 50 frames in 500 frames of two paws
    seldom, never = walk(strides=5), walk(begin=480, strides=1)
    assert learn_duty_factor([seldom, never], ["front", "front"]) is None
    assert learn_duty_factor([seldom], ["front"]) is not None


def test_strides_of_which_none_is_usual_teach_nothing():
    # the middle of 20 and 60 frames is 40, and neither is near it
    assert learn_duty_factor([walk(stride=20, strides=3), walk(stride=60, strides=3)], "ff") is None


RHYTHM = DutyFactor(share=np.array([0.6]), sd=np.array([0.02]), stride=50.0, spread=3.0)


@pytest.mark.parametrize(
    ("now", "following", "at", "sd"),
    [
        ((10, 35), 65, 10 + 0.6 * 55, 0.02 * 55),  # its own stride is 55 frames long
        ((10, 35), None, 10 + 0.6 * 50, np.hypot(0.02 * 50, 0.6 * 3)),
        ((0, 35), 65, 65 - 0.4 * 50, np.hypot(0.02 * 50, 0.4 * 3)),
    ],
)
def test_a_paw_is_due_at_its_share_of_the_stride(now, following, at, sd):
    frames = np.arange(35, 65)
    after = None if following is None else Stance(following, following + 30, ORIGIN)
    cost = RHYTHM.due(0, Stance(*now, ORIGIN), after, frames=frames)
    np.testing.assert_allclose(cost, np.minimum(0.5 * ((frames - at) / sd) ** 2, 8.0))
    assert cost.min() < 0.2


def test_a_swing_lasts_half_of_the_usual_at_least():
    # of strides of 50 frames it swings for 20
    assert RHYTHM.shortest_swing(0) == pytest.approx(10.0)


@pytest.mark.parametrize(("now", "following"), [((10, 35), 115), ((10, 35), 40), ((0, 35), None)])
def test_a_stride_that_is_not_whole_says_nothing(now, following):
    after = None if following is None else Stance(following, following + 30, ORIGIN)
    cost = RHYTHM.due(0, Stance(*now, ORIGIN), after, frames=np.arange(35, 65))
    np.testing.assert_array_equal(cost, 0.0)
