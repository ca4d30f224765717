"""What tracking is asked for is looked through before anything is opened."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.errors import InputError
from pawnb.workflow.tracking.options import TrackOptions


@pytest.mark.parametrize("frames", [None, (0, 10), [0, 10], np.array([0, 10])])
def test_a_range_is_its_first_frame_and_one_past_its_last(frames):
    assert TrackOptions(frames=frames).frames is frames


@pytest.mark.parametrize("frames", [5, (0,), (0, 5, 10), (0.5, 3), "ab", np.array([0.0, 3.0])])
def test_other_ranges_are_one_sentence(frames):
    with pytest.raises(InputError, match=r"^frames is .*; expected the first and one past the"):
        TrackOptions(frames=frames)


@pytest.mark.parametrize("wrong", [{"method": 3}, {"settings": [1]}])
def test_methods_and_settings_have_names(wrong):
    with pytest.raises(InputError, match=r"; expected (its name|names and values)"):
        TrackOptions(**wrong)
