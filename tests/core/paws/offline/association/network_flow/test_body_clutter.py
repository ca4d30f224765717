"""Noses and ears among the paws of a made-up walk: what stays while the belt moves is no paw."""

import numpy as np
import pytest
from test_tracklet_association import FPS, THICKNESS, N, walk

from pawnb.core.paws.offline.association.network_flow.body_clutter import without_body_clutter
from pawnb.core.paws.offline.association.network_flow.tracklets import Tracklet

BELT = np.array([-24.0 / (0.65 * 32.0), 0.0, 0.0])
"""Of :func:`walk`: 24 long in 0.65 of a stride of 32 frames."""


def tracklet(at, first=0):
    return Tracklet(first, list(range(len(at))), at, np.zeros(len(at)))


@pytest.fixture
def nose():
    rng = np.random.default_rng(3)
    sway = 3.0 * np.sin(2.0 * np.pi * np.arange(N) / FPS / 1.3)
    return np.column_stack([55.0 + sway, 0.0 * sway, 15.0 + 0.0 * sway]) + rng.normal(
        scale=0.05, size=(N, 3)
    )


def test_a_nose_is_left_out_and_paws_are_kept_whole_or_in_parts(nose):
    truth = walk()
    whole = [tracklet(truth[:, p]) for p in range(4)]
    swing = tracklet(truth[20:34, 0], 20)
    turn = tracklet(truth[17:25, 0], 17)  # lifts off: slow for a moment
    kept = without_body_clutter([*whole, tracklet(nose), swing, turn], BELT, paw_width=THICKNESS)
    assert kept == [*whole, swing, turn]


def test_parts_of_a_nose_too_short_to_tell_are_kept(nose):
    paws = [tracklet(walk()[:, p]) for p in range(4)]
    short = tracklet(nose[40:45], 40)
    assert short in without_body_clutter([*paws, short], BELT, paw_width=THICKNESS)


def test_where_no_paw_moves_with_the_belt_nothing_is_left_out(nose):
    still = [tracklet(np.broadcast_to(walk()[0, p], (N, 3))) for p in range(4)]
    tracklets = [*still, tracklet(nose)]
    assert without_body_clutter(tracklets, BELT, paw_width=THICKNESS) == tracklets
    assert without_body_clutter(tracklets, 0.0 * BELT, paw_width=THICKNESS) == tracklets
