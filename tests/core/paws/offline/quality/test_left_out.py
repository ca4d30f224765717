"""What left-out clicks say of labels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import expit

from pawnb.core.paws.offline.quality.left_out import LeftOutClick, offsets


def clicks(point, right, wrong, odds=0.0):
    return [
        LeftOutClick(point, 0.5, one, np.array([odds])) for one in [True] * right + [False] * wrong
    ]


def found(*some):
    return offsets([c for own in some for c in own], log_odds=lambda signs: signs[:, 0])


def test_nothing_is_said_without_clicks():
    assert offsets([]) == {}


def test_many_clicks_tell_the_offset_of_a_recording():
    """900 of 1000 right where even odds are expected: the logit of 0.9."""
    assert found(clicks(0, 900, 100))[0] == pytest.approx(np.log(9), abs=0.05)
    assert found(clicks(0, 500, 500))[0] == pytest.approx(0.0, abs=1e-6)


def test_few_clicks_tell_little():
    """One hit and a normal prior with sd 0.5: 4 x = 1 - expit(x), then again about x."""
    first = found(clicks(0, 1, 0))[0]
    of_all = next(x for x in np.linspace(0, 1, 100_001) if 4 * x >= 1 - expit(x))
    assert 4 * (first - of_all) == pytest.approx(1 - expit(first), abs=1e-3)
    assert first < 0.3


def test_what_was_expected_says_less_than_what_surprises():
    sure, unsure = found(clicks(0, 0, 3, odds=4.0))[0], found(clicks(0, 0, 3, odds=-4.0))[0]
    assert sure < -0.8 < unsure < 0


def test_a_point_differs_from_its_recording_as_far_as_its_own_clicks_say():
    of = found(clicks(0, 5, 0), clicks(1, 0, 5), clicks(2, 1, 1))
    assert of[0] > of[2] > of[1]
