"""Expected errors of tracks by colour: small doubts are in vain, a recording that failed is not."""

import numpy as np
import pytest

from pawnb.core.suspects.expected import calibrated_anew


def test_small_doubts_count_little_unless_much_of_the_recording_is_doubted():
    counted = np.ones((100, 1, 1), dtype=bool)
    good = np.full((100, 1, 1), 0.1)  # each label is 90 % right by the verdict
    # rendered colour films (benchmarks/learn_errors_left.py): 107 stated of 1437, and 0 wrong
    assert calibrated_anew(good, counted).sum() < 1.5
    failed = np.full((100, 1, 1), 0.9)
    assert calibrated_anew(failed, counted).sum() > 95
    # one label placed by hand does not count among the doubted, nor where nothing was tracked
    mixed = np.where(np.arange(100)[:, None, None] < 30, 0.9, 0.1)
    half = calibrated_anew(mixed, counted & (mixed < 0.5))
    assert half[-1, 0, 0] == pytest.approx(calibrated_anew(good, counted)[0, 0, 0])
    assert calibrated_anew(good, ~counted)[0, 0, 0] == half[-1, 0, 0]
    # the order in which labels are doubted stays
    assert (np.diff(calibrated_anew(np.linspace(0, 1, 9), np.ones(9, dtype=bool))) > 0).all()
