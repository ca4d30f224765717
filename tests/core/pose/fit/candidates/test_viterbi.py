"""The path through candidates is that of a search over all paths, and survives a wrong turn."""

import itertools

import numpy as np
import pytest

from pawnb.core.pose.fit.candidates.parameters import CANDIDATES
from pawnb.core.pose.fit.candidates.viterbi import extend_trellis
from pawnb.core.pose.fit.candidates.viterbi_kernels import step_costs

JUMP_PX = 4.0


def trellis_of(frames):
    """Return the trellis of the last of some frames, each its energy and its joints."""
    trellis = None
    for energy, joints in frames:
        trellis = extend_trellis(trellis, energy, tuple(joints), jump_px=JUMP_PX)
    return trellis


def random_frames(seed: int, n_frames: int, counts: tuple[int, int]):
    """Candidates so far apart that velocities, which depend on the path, are all zero."""
    rng = np.random.default_rng(seed)
    frames = []
    for _ in range(n_frames):
        joints = [rng.choice([0.0, 200.0, 400.0, 600.0], (c, 3, 2)) for c in counts]
        frames.append((rng.uniform(0, 90, counts), joints))
    return frames


@pytest.mark.parametrize("seed", range(5))
def test_best_path_is_that_of_trying_all(seed):
    frames = random_frames(seed, 4, (2, 3))
    trellis = trellis_of(frames)
    states = list(itertools.product(range(2), range(3)))

    def cost(path):
        total = sum(energy[state] for (energy, _), state in zip(frames, path, strict=True))
        for t in range(1, len(path)):
            for leg in range(2):
                before, now = frames[t - 1][1][leg], frames[t][1][leg]
                steps = step_costs(before, now, JUMP_PX, CANDIDATES.most_step)
                total += steps[path[t - 1][leg], path[t][leg]]
        return total

    best = min(itertools.product(states, repeat=4), key=cost)
    assert cost(trellis.path()) == pytest.approx(cost(best))


def test_a_leg_that_goes_with_its_neighbour_for_a_while_comes_back():
    """Each frame alone prefers the neighbour's place in the middle; the path does not."""
    greedy, frames = [], []
    for t in range(12):
        own, neighbour = np.full((1, 4, 2), 3.0 * t), np.full((1, 4, 2), 3.0 * t + 60.0)
        wrong = 4 <= t < 7
        energy = np.array([6.0 if wrong else 0.0, 0.0 if wrong else 30.0])
        greedy.append(int(np.argmin(energy)))
        frames.append((energy, [np.concatenate([own, neighbour])]))
    assert 1 in greedy
    assert trellis_of(frames).path() == [(0,)] * 12


def test_a_trellis_is_not_changed_by_the_frames_after_it():
    """Two recordings that begin alike can be followed on from the same frame."""
    frames = random_frames(7, 4, (2, 3))
    start = trellis_of(frames[:2])
    cost, path = start.cost.copy(), start.path()
    for energy, joints in frames[2:]:
        extend_trellis(start, energy, tuple(joints), jump_px=JUMP_PX)
    np.testing.assert_array_equal(start.cost, cost)
    assert start.path() == path
