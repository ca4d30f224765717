"""AEP, PEP, TD and LO of one foot: analytic signals, and what must hold for any signal."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from walking import Walk

from pawnb.errors import InputError
from pawnb.gait.events import Extreme, find_extremes, stance_velocity, stance_velocity_over_time
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.events.ground_contact import find_contacts, measure_height
from pawnb.schema import build_settings
from pawnb.signals import differentiate

FS = 250.0


def sawtooth(period=75, stance=45, n=600):
    """Foot that goes back steadily for ``stance`` samples and forward for the rest."""
    x = np.mod(np.arange(n), period)
    return np.where(x < stance, stance - x, (x - stance) * stance / (period - stance))


def test_sawtooth_has_its_corners():
    found, rejected = find_extremes(sawtooth(), min_excursion=10, min_stance=5, min_swing=5)
    assert not rejected
    assert [e.kind for e in found] == [-1, 1] * 7 + [-1]
    np.testing.assert_allclose(
        [e.sample for e in found if e.kind < 0], 45 + 75 * np.arange(8), atol=0.5
    )
    np.testing.assert_allclose(
        [e.sample for e in found if e.kind > 0], 75 * np.arange(1, 8), atol=0.5
    )
    assert found[1].position == pytest.approx(45.0, abs=0.5)


def test_smooth_extremes_between_samples():
    # maxima of sin(2 pi (t - 0.3) / 80) lie at 20.3 + 80 k, minima 40 later
    t = np.arange(500)
    found, _ = find_extremes(
        np.sin(2 * np.pi * (t - 0.3) / 80), min_excursion=1, min_stance=1, min_swing=1
    )
    times = np.array([e.sample for e in found])
    np.testing.assert_allclose(times, 20.3 + 40 * np.arange(len(times)), atol=0.01)


def test_short_swing_is_taken_out_and_reported():
    x = sawtooth()
    x[200:206] += np.array([0, 12, 24, 24, 12, 0])  # a tracking error in mid-stance
    found, rejected = find_extremes(x, min_excursion=10, min_stance=8, min_swing=8)
    clean, _ = find_extremes(sawtooth(), min_excursion=10, min_stance=8, min_swing=8)
    np.testing.assert_allclose([e.sample for e in found], [e.sample for e in clean], atol=0.6)
    assert len(rejected) == 1
    assert rejected[0].why.endswith(" frames is shorter than 8.0")
    assert 199 < rejected[0].start < rejected[0].end < 206
    kept, none = find_extremes(x, min_excursion=10, min_stance=1, min_swing=1)
    assert len(kept) == len(clean) + 2
    assert not none


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_of_two_extremes_in_one_place_the_further_stays(sign):
    # a slow fall from 60 to 40, then within three samples up to 70: too fast for a swing, so
    # the fall was no stance, and the AEP is the one at 70 (mirrored: the PEP at -70)
    corners = {0: 0, 40: 60, 60: 40, 63: 70, 120: 0, 160: 60, 200: 0}
    x = sign * np.interp(np.arange(201), list(corners), list(corners.values()))
    found, rejected = find_extremes(x, min_excursion=15, min_stance=8, min_swing=8)
    assert [round(e.sample) for e in found] == [63, 120, 160]
    assert [e.kind * sign for e in found] == [1, -1, 1]
    assert len(rejected) == 1
    # and the other way round in time
    found, _ = find_extremes(x[::-1].copy(), min_excursion=15, min_stance=8, min_swing=8)
    assert [200 - round(e.sample) for e in found] == [160, 120, 63]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(0, 6), st.floats(0, 20), st.floats(0, 20))
def test_events_alternate_and_keep_their_distance(seed, noise, min_stance, min_swing):
    rng = np.random.default_rng(seed)
    x = sawtooth() + noise * rng.standard_normal(600)
    x[rng.integers(0, 550) :][:30] = np.nan
    found, _ = find_extremes(x, min_excursion=8, min_stance=min_stance, min_swing=min_swing)
    gap = np.flatnonzero(np.isnan(x)).mean()
    for a, b in pairwise(found):
        assert b.sample > a.sample
        if not a.sample < gap < b.sample:  # within one run
            assert a.kind == -b.kind
            assert b.sample - a.sample >= (min_stance if a.kind > 0 else min_swing)
            assert a.kind * a.position > a.kind * b.position


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 200), st.floats(0.1, 50), st.floats(-500, 500))
def test_extremes_follow_scale_and_place(seed, scale, offset):
    rng = np.random.default_rng(seed)
    x = sawtooth(n=300) + rng.standard_normal(300)
    one, _ = find_extremes(x, min_excursion=10, min_stance=5, min_swing=5)
    two, _ = find_extremes(scale * x + offset, min_excursion=10 * scale, min_stance=5, min_swing=5)
    np.testing.assert_allclose([e.sample for e in one], [e.sample for e in two], atol=1e-6)
    np.testing.assert_allclose(
        [scale * e.position + offset for e in one],
        [e.position for e in two],
        atol=1e-6 * (1 + scale),
    )


def test_stance_velocity_is_the_belts():
    x = sawtooth()
    found, _ = find_extremes(x, min_excursion=10, min_stance=5, min_swing=5)
    velocity = differentiate(x, dt=1 / FS)
    assert stance_velocity(velocity, found) == pytest.approx(-FS, rel=1e-9)
    assert np.isnan(stance_velocity(velocity, found[:1]))


def abrupt(period=75, stance=45, n=600):
    """Speed over the substrate: 0 in stance, constant in swing; changes within one sample."""
    x = np.mod(np.arange(n), period)
    return np.where(x < stance, 0.0, 100.0)


def alternating():
    found, _ = find_extremes(sawtooth(), min_excursion=10, min_stance=5, min_swing=5)
    return found


def test_abrupt_contacts_are_where_the_speed_changes():
    found = find_contacts(abrupt(), alternating(), fraction=0.2, rise=1.0)
    np.testing.assert_allclose(
        [c.sample for c in found if c.kind == "TD"], 75 * np.arange(1, 8), atol=1
    )
    lifts = [c.sample for c in found if c.kind == "LO"]
    np.testing.assert_allclose(lifts, 44 + 75 * np.arange(len(lifts)), atol=1)
    kinds = [c.kind for c in found]
    assert kinds == ["LO", "TD"] * 7


def test_a_linear_landing_is_followed_to_zero():
    # speed rises from 0 at 45 to its peak at 60 and falls to 0 at 75, linearly
    x = np.mod(np.arange(600), 75)
    speed = np.clip(np.minimum(x - 45, 75 - x) / 15, 0, None) * 100
    found = find_contacts(speed, alternating(), fraction=0.2, rise=0.0)
    for contact in found:
        exact = 0.0 if contact.kind == "TD" else 45.0
        error = (contact.sample - exact + 37) % 75 - 37
        # not followed beyond a quarter of the fraction: 0.05 of 15 samples
        assert abs(error) == pytest.approx(0.75, abs=1e-9)
    # a threshold alone would be 3 samples off
    late = find_contacts(speed, alternating(), fraction=0.2, rise=1e9)
    assert min(abs((c.sample - (0 if c.kind == "TD" else 45) + 37) % 75 - 37) for c in late) > 2.9


def test_height_decides_where_the_foot_is_still_up():
    # the foot stops at 75 k but comes down only at 75 k + 6
    x = np.mod(np.arange(600), 75)
    up = np.where((x >= 45) | (x < 6), 10.0, 0.0)
    found = alternating()
    height = measure_height(np.where(x < 6, 0.0, up), found, fraction=0.25)
    assert height.ground == 0.0
    assert height.limit == pytest.approx(2.5)
    slow = find_contacts(abrupt(), found, fraction=0.2, rise=2.0)
    low = find_contacts(abrupt(), found, fraction=0.2, rise=2.0, height=height._replace(up=up))
    shift = [b.sample - a.sample for a, b in zip(slow, low, strict=True) if a.kind == "TD"]
    np.testing.assert_allclose(shift, 6.0, atol=1.0)


def test_height_that_does_not_rise_says_nothing():
    rng = np.random.default_rng(0)
    assert measure_height(rng.standard_normal(600), alternating(), fraction=0.25) is None


def test_contacts_alternate_and_need_their_swing_in_sight():
    x = Walk(duty=0.6).foot("FR", np.arange(750) / FS)[0] - 300.0 * np.arange(750) / FS
    found, _ = find_extremes(x, min_excursion=10, min_stance=5, min_swing=5)
    speed = differentiate(x, dt=1 / FS) + 300.0
    speed[210:216] = np.nan
    kinds = [c.kind for c in find_contacts(speed, found, fraction=0.2)]
    assert kinds.count("TD") < sum(e.kind > 0 for e in found)
    assert all(a != b for a, b in pairwise(kinds))


def test_a_foot_that_never_slows_has_no_contact():
    assert find_contacts(np.full(600, 50.0), alternating(), fraction=0.2) == []


def test_extremes_know_nothing_of_an_empty_track():
    found, rejected = find_extremes(np.full(50, np.nan), min_excursion=1, min_stance=1, min_swing=1)
    assert found == []
    assert rejected == []
    assert Extreme(1.0, 1, 2.0).kind == 1


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"cutoff_hz": 0}, r"^setting 'cutoff_hz' is 0\.0; expected a number above 0\.$"),
        ({"max_gap_s": -1}, r"^setting 'max_gap_s' is -1\.0; expected 0 or more\.$"),
        ({"contact_speed_fraction": 0.5}, r"is 0\.5; expected above 0 and at most 0\.45\.$"),
        ({"min_confidence": 1.5}, r"is 1\.5; expected 0 to 1\.$"),
        ({"jump_factor": 0.5}, r"is 0\.5; expected 1 or more, or null to keep jumps\.$"),
        ({"min_stance_s": float("nan")}, r"min_stance_s is nan; expected a number\.$"),
        ({"substrate": "water"}, r"expected one of 'auto', 'treadmill', 'ground'"),
        ({"cutof_hz": 3}, r"^test: unknown name 'cutof_hz' \(did you mean 'cutoff_hz'\?\)"),
    ],
)
def test_settings_that_cannot_be_meant_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        build_settings(EventSettings, values, where="test")


def test_stance_velocity_from_stance_to_stance():
    # stances from AEP at 0 and 20 to PEP at 10 and 30: -2 in the first, -4 in the second
    velocity = np.full(41, 3.0)
    velocity[:11], velocity[20:31] = -2.0, -4.0
    extremes = [Extreme(float(s), kind, 0.0) for s, kind in ((0, 1), (10, -1), (20, 1), (30, -1))]
    found = stance_velocity_over_time(velocity, extremes)
    assert found[5] == -2.0
    assert found[15] == pytest.approx(-3.0)  # half way between the middles at 5 and 25
    assert found[[25, 40]].tolist() == [-4.0, -4.0]
    assert np.isnan(stance_velocity_over_time(velocity, extremes[:1])).all()


def test_a_foot_that_is_carried_along_has_no_swing():
    # three swings of speed 10 and one, drifting, of 1: less than 0.2 of the usual peak
    speed = np.zeros(81)
    extremes = []
    for k, top in enumerate((10.0, 10.0, 1.0, 10.0)):
        speed[20 * k + 10 : 20 * k + 18] = top
        extremes += [Extreme(20.0 * k + 9, -1, 0.0), Extreme(20.0 * k + 18, 1, 1.0)]
    extremes.append(Extreme(80.0, -1, 0.0))
    found = find_contacts(speed, extremes, fraction=0.2)
    assert [c.kind for c in found] == ["LO", "TD"] * 3
    assert not any(40 < c.sample < 60 for c in found)
    all_alike = np.where(speed == 1.0, 10.0, speed)
    assert len(find_contacts(all_alike, extremes, fraction=0.2)) == 8
