"""Films that are a few frames apart, and films that are synchronised: movement made by formula."""

from itertools import combinations

import numpy as np
import pytest

from pawnb.core.calibration.synchronisation import find_unsynchronised

NAMES = ("a", "b", "c")


def motion(*late, n=160, seed=0):
    """Swings of legs as views see them, each some frames late, with movement of its own."""
    rng = np.random.default_rng(seed)
    t = np.arange(n + 40)
    swings = sum(np.exp(-(((t - at) / 1.5) ** 2)) for at in rng.uniform(0.0, n + 40, 12))
    return {
        name: swings[20 - k : 20 - k + n] + rng.uniform(0.0, 0.1, n)
        for name, k in zip(NAMES, late, strict=False)
    }


def unsynchronised(seen):
    """Compare all views that are seen."""
    return find_unsynchronised(seen, pairs=list(combinations(seen, 2)))


@pytest.mark.parametrize("k", [-5, -1, 1, 2, 3])
def test_the_film_that_is_late_is_named_and_by_how_many_frames(k):
    (found,) = unsynchronised(motion(0, k, 0))
    assert (found.view, found.lag_frames) == ("b", k)
    (found,) = unsynchronised(motion(k, 0, 0))
    assert (found.view, found.lag_frames) == ("a", k)
    (found,) = unsynchronised(motion(0, k))
    assert (found.view, found.other, found.lag_frames) == ("b", "a", k)


@pytest.mark.parametrize("seed", range(10))
def test_synchronised_films_and_what_cannot_be_told_are_not_doubted(seed):
    assert unsynchronised(motion(0, 0, 0, seed=seed)) == []
    alone = {**motion(0, seed=seed), "b": motion(0, seed=seed + 100)["a"]}  # other legs
    assert unsynchronised(alone) == []
    assert unsynchronised(motion(0, 2, n=50, seed=seed)) == []  # too short
    still = {**motion(0, seed=seed), "b": np.zeros(160)}
    assert unsynchronised(still) == []
