"""A foot that is held up: it makes no strides, and takes no part in the speed of the belt.

The truth is made (``walking.py``): 300 mm/s, strides of 0.3 s and so of 90 mm.
"""

from __future__ import annotations

import numpy as np
import pytest
from walking import Walk

from pawnb import gait
from pawnb.gait.analysis.missing_strides import say_no_strides
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.locomotion.time_scales import held_still, least_excursions


def with_front_right(way, *, noise=0.5, treadmill=True, drift=0.0):
    """A trot on a belt whose right front foot goes its own way, in the body's frame."""
    tracks = Walk().tracks(treadmill=treadmill, noise=noise, seed=1, drift=drift)
    n = tracks.sizes["time"]
    t = np.arange(n) / 250.0
    k = list(tracks["keypoint"].values).index("FR")
    jitter = noise * np.random.default_rng(2).standard_normal((n, 3))
    path = np.column_stack((40.0 + way(t), np.full(n, -15.0), np.full(n, 8.0)))
    path[:, 0] += (drift if treadmill else 300.0) * t
    tracks["position"].data[:, :, k, 0] = path + jitter
    return tracks


def held(t):
    return 0.0 * t


def paddling(t):
    return 6.0 * np.sin(2.0 * np.pi * t / 0.3)


@pytest.mark.parametrize("noise", [0.1, 0.5])
@pytest.mark.parametrize("treadmill", [True, False])
def test_a_foot_that_is_held_still_makes_no_strides(noise, treadmill):
    tables = gait.analyse(with_front_right(held, noise=noise, treadmill=treadmill))
    assert sorted(tables.strides["leg"].unique()) == ["FL", "HL", "HR"]
    assert tables.strides["period_s"].to_numpy() == pytest.approx(0.3, rel=0.03)
    assert tables.strides["speed"].to_numpy() == pytest.approx(300.0, rel=0.03)
    assert tables.strides["stride_length"].to_numpy() == pytest.approx(90.0, rel=0.03)
    (said,) = [note for note in tables.notes if "No strides are made" in note]
    assert "FR moves by less than 10% of what the feet do on the whole" in said
    assert not any("drifts in the picture" in note for note in tables.notes)


def test_a_foot_that_paddles_in_the_air_does_not_slow_the_belt_down():
    tables = gait.analyse(with_front_right(paddling, noise=0.2))
    assert tables.strides["speed"].mean() == pytest.approx(300.0, rel=0.01)
    assert tables.strides["stride_length"].mean() == pytest.approx(90.0, rel=0.01)
    assert any("FR is carried otherwise and not counted" in note for note in tables.notes)


def test_sound_feet_are_not_named():
    tables = gait.analyse(Walk().tracks(noise=0.2))
    assert sorted(tables.strides["leg"].unique()) == ["FL", "FR", "HL", "HR"]
    assert not any(
        "carried otherwise" in note or "No strides are made" in note for note in tables.notes
    )


def test_what_counts_as_held():
    # ranges from the 5th to the 95th percentile: 0.9 of the way of a straight line
    way = np.linspace(0.0, 1.0, 101)[:, None] * np.array([10.0, 10.0, 10.0, 1.1, 0.9])
    way = np.column_stack((way, np.full(101, np.nan)))
    settings = EventSettings(min_excursion_fraction=0.5)
    assert held_still(way, settings).tolist() == [False] * 4 + [True, False]
    least = least_excursions(way[:, :5], settings)
    assert least == pytest.approx([4.5, 4.5, 4.5, 0.495, 0.0])
    # what is stated holds for all feet
    stated = EventSettings(min_excursion=0.3)
    assert least_excursions(way[:, :5], stated).tolist() == [0.3] * 5


def test_no_longer_recording_is_asked_for_where_a_foot_is_held_still():
    tracks = with_front_right(held)
    (said,) = say_no_strides(gait.analyse(tracks, belt_speed=300.0))
    assert "no stride of FR" in said
    assert said.endswith("FR is held still, and a longer recording gives no more.")
    # a foot that is seen for a stride only does need one
    tracks["position"].loc[{"keypoint": "HL", "time": tracks["time"].to_numpy()[80:]}] = np.nan
    (said,) = say_no_strides(gait.analyse(tracks, belt_speed=300.0))
    assert said.endswith(
        "FR is held still, and a longer recording gives no more; for the others a longer recording "
        "is needed, or other settings of the event detection."
    )
