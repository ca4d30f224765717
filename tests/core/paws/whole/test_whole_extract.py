"""The part of a view that is searched."""

import numpy as np
import pytest

from pawnb.core.paws.whole.extract import Region


def _follow(frames: int, paws: np.ndarray, clutter: np.ndarray) -> Region:
    """Return a region after paws (frames, 4) moved and poor clutter (frames, 12) was there too."""
    region = Region(np.array([600.0, 200.0]), np.array([200.0, 50.0]), (1200, 400))
    for t in range(frames):
        u = np.concatenate([paws[t], clutter[t]])
        found = np.column_stack([u, np.full(len(u), 200.0)])
        region.follow(found, np.repeat([0.95, 0.03], [4, 12]))
    return region


def test_the_searched_region_follows_paws_not_what_little_looks_like_them():
    frames = 200
    ahead = np.linspace(0.0, 200.0, frames)[:, None]
    paws = np.array([520.0, 560.0, 660.0, 680.0]) + ahead
    # an edge of the belt comes into the picture behind the animal, as the animal leaves it
    clutter = np.full((frames, 12), 620.0)
    clutter[60:] = 350.0
    region = _follow(frames, paws, clutter)
    # the region lags behind by 1 / FOLLOW frames, 17 px, and clutter has a tenth of the weight
    assert region.centre[0] == pytest.approx(800.0 - 17.0, abs=0.1 * (800.0 - 350.0))
    left, _, right, _ = region.box()
    assert left < paws[-1].min()
    assert paws[-1].max() < right


def test_the_searched_region_stays_where_the_animal_stays():
    frames = 100
    paws = np.tile([520.0, 560.0, 660.0, 680.0], (frames, 1))
    region = _follow(frames, paws, np.linspace(700.0, 900.0, frames)[:, None] + np.zeros(12))
    assert region.centre[0] == pytest.approx(600.0, abs=20.0)
