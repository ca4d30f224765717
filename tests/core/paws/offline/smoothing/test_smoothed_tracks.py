"""What is only predicted stays about the animal, or is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pawnb.core.paws.offline.smoothing.tracks import SmoothedTracks


def test_a_prediction_that_leaves_the_animal_is_missing_and_a_detection_is_not():
    tracks = SmoothedTracks.unknown(4, 3, 2, 3)
    x = np.zeros((4, 3, 3))
    x[:, 1, 0], x[:, 2, 1] = 10.0, 10.0
    x[2, 0] = x[3, 0] = 1e4, 0.0, 0.0
    measured = np.zeros((4, 3, 2, 2))
    measured[:3, 0] = np.nan  # in the last frame it is seen there
    tracks = replace(tracks, x=x, sd=np.ones_like(x), measured=measured)
    kept = tracks.within(20.0)
    lost = np.isnan(kept.x).all(axis=-1)
    assert np.argwhere(lost).tolist() == [[2, 0]]
    assert np.isnan(kept.sd[2, 0]).all()
    assert np.array_equal(kept.x[~lost], x[~lost])


def test_where_no_other_point_was_found_nothing_says_that_one_has_left():
    tracks = SmoothedTracks.unknown(2, 2, 1, 2)
    tracks = replace(tracks, x=np.full((2, 2, 2), 1e5), sd=np.ones((2, 2, 2)))
    assert np.isfinite(tracks.within(1.0).x).all()
