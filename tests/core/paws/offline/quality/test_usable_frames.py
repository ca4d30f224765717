"""Ends of a recording without the animal are found and named; what was clicked is kept."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.paws.offline.quality.usable_frames import find_usable_frames


def find(chance, clicked=(), *, first=0, limit=0.5):
    chance = np.asarray(chance, float)
    frames = first + np.arange(len(chance))
    return find_usable_frames(chance, frames, clicked=np.isin(frames, clicked), limit=limit)


def test_an_animal_that_passes_the_camera():
    """By hand: in view in frames 185 to 299 of 100 to 407."""
    part = find([0.1] * 85 + [0.8] * 115 + [0.2] * 108, [235], first=100)
    assert (part.first, part.stop, round(part.right, 6)) == (185, 300, 0.8)
    assert [(a, b, round(right, 6)) for a, b, right in part.left_out] == [
        (100, 184, 0.1), (300, 407, 0.2),
    ]  # fmt: skip
    assert part.words() == (
        "if the animal is not in view in frames 100 to 184 (10 % of labels expected right) and "
        "300 to 407 (20 % of labels expected right), write frames = [185, 300] under [trial] and "
        "track again"
    )


def test_it_leaves_at_one_end():
    part = find([0.9] * 30 + [0.0] * 20, [3])
    assert (part.first, part.stop, part.left_out) == (0, 30, ((30, 49, 0.0),))


@pytest.mark.parametrize(
    ("chance", "clicked"),
    [
        ([0.9] * 50, [3]),  # all of it is well
        ([0.2] * 50, [3]),  # none of it is
        ([0.1] * 20 + [0.9] * 30, [10]),  # a person saw the animal there
        ([0.9] * 20 + [0.1] * 10 + [0.9] * 20, [3]),  # a poor stretch between
    ],
)
def test_nothing_is_cut_off(chance, clicked):
    assert find(chance, clicked) is None


@given(st.lists(st.floats(0, 1), min_size=1, max_size=40))
def test_no_other_part_has_more_above_the_limit(chance):
    """Against every part there is, counted one by one."""
    part = find(chance)
    gain = {
        (i, j): float(np.sum(np.array(chance[i:j]) - 0.5))
        for i in range(len(chance)) for j in range(i + 1, len(chance) + 1)
    }  # fmt: skip
    best = max(gain.values())
    if part is not None:
        assert gain[part.first, part.stop] == pytest.approx(best)
        for first, last, right in part.left_out:
            assert right <= 0.5 + 1e-9
            assert right == pytest.approx(np.mean(chance[first : last + 1]))
    elif best > 1e-9:
        assert gain[0, len(chance)] == pytest.approx(best)
