"""The path through candidates is that of a search over all paths, and survives a wrong turn."""

import itertools

import numpy as np
import pytest

from pawnb.core.pose.fit.candidates.viterbi import ViterbiTrellis


def steps_of(viterbi_trellis, before, velocity, now):
    return viterbi_trellis._steps(before, velocity, now)


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
    viterbi_trellis = ViterbiTrellis(4.0)
    for energy, joints in frames:
        viterbi_trellis.push(energy, joints)
    states = list(itertools.product(range(2), range(3)))

    def cost(path):
        total = sum(energy[state] for (energy, _), state in zip(frames, path, strict=True))
        for t in range(1, len(path)):
            for leg in range(2):
                before, now = frames[t - 1][1][leg], frames[t][1][leg]
                still = np.zeros_like(before)
                total += steps_of(viterbi_trellis, before, still, now)[
                    path[t - 1][leg], path[t][leg]
                ]
        return total

    best = min(itertools.product(states, repeat=4), key=cost)
    assert cost(viterbi_trellis.path()) == pytest.approx(cost(best))


def test_a_leg_that_goes_with_its_neighbour_for_a_while_comes_back():
    """Each frame alone prefers the neighbour's place in the middle; the path does not."""
    viterbi_trellis = ViterbiTrellis(4.0)
    greedy = []
    for t in range(12):
        own, neighbour = np.full((1, 4, 2), 3.0 * t), np.full((1, 4, 2), 3.0 * t + 60.0)
        wrong = 4 <= t < 7
        energy = np.array([6.0 if wrong else 0.0, 0.0 if wrong else 30.0])
        greedy.append(int(np.argmin(energy)))
        viterbi_trellis.push(energy, [np.concatenate([own, neighbour])])
    assert 1 in greedy
    assert viterbi_trellis.path() == [(0,)] * 12
