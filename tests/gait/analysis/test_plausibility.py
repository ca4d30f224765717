"""Signs that something else than the feet was followed, or that the belt speed is wrong."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest
from walking import Walk

from pawnb.gait import analyse, analyse_events
from pawnb.gait.analysis.plausibility import say_implausible


def scored(frequencies):
    """Events of legs that step at different frequencies, in Hz."""
    rows = []
    for leg, hz in frequencies.items():
        for k in range(12):
            rows += [(leg, "TD", k / hz), (leg, "LO", (k + 0.6) / hz)]
    return pd.DataFrame(rows, columns=["leg", "event", "time_s"])


def test_legs_that_do_not_step_equally_often_are_named():
    # knees followed instead of feet gave 5.6 and 4.1 Hz on one belt
    notes = analyse_events(scored({"FR": 5.6, "HR": 4.1, "FL": 5.5})).notes
    (said,) = [note for note in notes if "strides a second" in note]
    assert "FR makes 5.6 strides a second and HR 4.1" in said
    for even in ({"FR": 5.0, "HR": 4.5}, {"FR": 5.0}):
        assert not any("strides a second" in n for n in analyse_events(scored(even)).notes)


@pytest.mark.slow
def test_a_real_foot_beside_one_that_is_none_is_said_of_tracks():
    feet = Walk().tracks(noise=0.2)
    odd = Walk(period=0.4, speed=225.0).tracks(noise=0.2)
    feet["position"].data[:, :, 1] = odd["position"].data[:, :, 1]
    notes = analyse(feet, belt_speed=300.0).notes
    assert any("HR 2.5; legs of one animal step equally often" in note for note in notes)
    assert not any(
        "equally" in n for n in analyse(Walk().tracks(noise=0.2), belt_speed=300.0).notes
    )


def test_duty_factors_that_are_far_apart_are_said():
    # the sides of the difference are those of the stride table: AEP to PEP, and TD to LO
    strides = pd.DataFrame(
        {
            "leg": np.repeat(["FR", "HR"], 5),
            "frequency_hz": 5.0,
            "duty_factor": np.repeat([0.70, 0.70], 5),
            "contact_duty_factor": np.repeat([0.50, 0.58], 5),
        }
    )
    (said,) = say_implausible(strides)
    assert "(FR 0.70 and 0.50)" in said
    assert say_implausible(strides[strides["leg"] == "HR"]) == []


@pytest.mark.parametrize(
    ("fps", "duty", "few"),
    [(30.0, 0.8, True), (60.0, 0.8, True), (250.0, 0.8, False), (60.0, 0.5, False)],
)
def test_swings_of_too_few_frames_to_tell_a_duty_factor_are_said(fps, duty, few):
    walk = Walk(duty=duty, period=0.25)
    tables = analyse(walk.tracks(fps=fps, noise=0.2), belt_speed=300.0)
    said = [note for note in tables.notes if "too long, and duty factors up to" in note]
    assert len(said) == int(few)
    # the true duty factor follows from the profile of the swing (walking.py)
    away = walk.exact_duty - tables.strides["duty_factor"].mean()
    assert (away > 0.03) == few
    if few:
        assert "swings of FR, HR, FL, HL have" in said[0]
        told = float(said[0].split("duty factors up to ")[1].split()[0])
        assert away < told + 0.005


@pytest.mark.slow
@pytest.mark.parametrize(("noise", "jitter"), [(0.2, False), (3.0, False), (15.0, True)])
def test_strides_that_are_jitter_are_said_to_be_unlike_each_other(noise, jitter):
    """Of 15 strides a leg, 15 are found with a noise of 4 % of their length, and 200 with 20 %."""
    walk = Walk(period=0.25, duty=0.4)
    tables = analyse(walk.tracks(fps=250.0, noise=noise, duration=4.0), belt_speed=300.0)
    assert any("jitter of the tracks: look" in note for note in tables.notes) == jitter
    assert (len(tables.strides) > 200) == jitter


def test_a_body_that_goes_backwards_is_said():
    strides = pd.DataFrame({"leg": "FR", "frequency_hz": 5.0, "duty_factor": 0.6,
                            "speed": [-3.0, 2.0, -0.5, 4.0]})  # fmt: skip
    (said,) = say_implausible(strides)
    assert said.startswith("2 of 4 strides have a negative speed")
    tables = analyse(Walk().tracks(noise=0.2), belt_speed=-300.0)
    assert any("have a negative speed" in note for note in tables.notes)


@pytest.mark.parametrize("duty", [0.5, 0.75])
def test_nothing_is_said_of_a_sound_walk(duty):
    strides = analyse(Walk(duty=duty).tracks(noise=0.3), belt_speed=300.0).strides
    assert say_implausible(strides) == []
    assert say_implausible(strides.iloc[:0]) == []


@pytest.mark.slow
def test_strides_of_an_animal_that_stands_still_are_said_to_be_jitter():
    """A spider that hung motionless had 39 strides of 8 legs, and nothing said that it stood."""
    rng = np.random.default_rng(0)
    tracks = Walk().tracks()
    feet = tracks["position"].mean("time")
    n = tracks.sizes["time"]
    # a tracker wanders slowly about where the foot is, by 0.3 of 60 mm and more between the feet
    wander = np.cumsum(rng.normal(0.0, 0.1, (n, *feet.shape)), axis=0)
    wander -= wander.mean(axis=0)
    tracks["position"].data[:] = feet.to_numpy() + 0.3 * wander / wander.std(axis=0)
    tables = analyse(tracks, belt_speed=0.0)
    assert len(tables.strides)
    said = [note for note in tables.notes if "stand still" in note]
    assert len(said) == 1, tables.notes
    assert "to be the jitter of the tracks" in said[0]


def test_one_foot_that_is_held_still_is_named():
    strides = analyse(Walk().tracks(noise=0.3), belt_speed=300.0).strides
    held = strides["leg"] == strides["leg"].iloc[0]
    strides.loc[held, ["excursion"]] = 0.1
    strides.loc[held, "pep_lateral"] = strides.loc[held, "aep_lateral"]
    (said,) = say_implausible(strides)
    assert said.startswith(f"{strides['leg'].iloc[0]} moves by 0.")  # % of the distance
    assert "these feet seem to be held still" in said


@pytest.mark.parametrize("fore", ["front", "hind"])
def test_hind_legs_that_step_ahead_of_front_legs_are_said(fore):
    """Clicks of front and hind paws exchanged in every view: nothing in the clicks shows it."""
    tracks = Walk().tracks(noise=0.2)
    if fore == "hind":
        other = {"FR": "HR", "HR": "FR", "FL": "HL", "HL": "FL"}
        tracks = tracks.assign_coords(
            keypoint=[other[str(k)] for k in tracks["keypoint"].to_numpy()]
        )
    said = [n for n in analyse(tracks, belt_speed=300.0).notes if "named the other way round" in n]
    assert len(said) == (fore == "hind")
    if said:
        assert "ahead of FR" in said[0]
        assert "ahead of FL" in said[0]


def test_legs_of_eight_are_compared_from_the_foremost_to_the_hindmost():
    # L1 ahead of L2 ahead of L3; what counts of a side is its first and its last leg
    legs = ["L1", "L2", "L3", "R1", "R2", "R3"]
    strides = pd.DataFrame(
        {
            "leg": np.repeat(legs, 5),
            "frequency_hz": 5.0,
            "excursion": 4.0,
            "aep_position": np.repeat([8.0, 9.0, 1.0, 8.0, 6.0, 1.0], 5),
            "pep_position": np.repeat([4.0, 5.0, -3.0, 4.0, 2.0, -3.0], 5),
        }
    )
    assert say_implausible(strides) == []
    turned = strides.assign(
        aep_position=-strides["pep_position"], pep_position=-strides["aep_position"]
    )
    (said,) = say_implausible(turned)
    assert "L3 steps 175% of an excursion ahead of L1" in said
    # one side alone is no sign of it: a track that jumped
    mixed = pd.concat([turned[turned["leg"].str[0] == "L"], strides[strides["leg"].str[0] == "R"]])
    assert say_implausible(mixed) == []


@pytest.mark.parametrize(
    ("frames", "said"), [(3.1, "a third too small"), (8.1, "up to a frame too short")]
)
def test_strides_of_too_few_frames_for_contact_or_speed_are_said(frames, said):
    # a walk of 25 frames a second whose contact is 0.6 of a stride; at 3.1 frames it is found to be
    # 0.16, and the speed 22 % too small; at 8.1 frames a swing that stops dead has 0.48
    walk = Walk(period=frames / 25.0, duty=0.6, speed=60.0 * 25.0 / frames)
    tables = analyse(walk.tracks(fps=25.0, duration=8.0), belt_speed=None, settings={})
    (note,) = (n for n in tables.notes if "strides have" in n)
    assert f"{frames:.2g} frames (median)" in note or f"{frames:.1f} frames (median)" in note
    assert said in note
    # what is said of belts is no advice here
    assert not any("are far apart" in n for n in tables.notes)


@pytest.mark.parametrize("duty", [0.35, 0.5, 0.65, 0.75])
def test_duty_factors_of_four_frames_in_a_stride_are_said_to_be_alike(duty):
    # 30 frames a second of a mouse that makes 8 strides a second: from 0.35 to 0.75 little is left
    tables = analyse(Walk(period=1 / 7.9, duty=duty).tracks(fps=30.0, duration=15.0))
    assert 0.45 < tables.strides["duty_factor"].median() < 0.65
    (note,) = (n for n in tables.notes if "strides have" in n)
    assert "frames (median): duty factors come out between 0.5 and 0.6 whatever they" in note


def test_enough_frames_need_no_word_on_contact():
    tables = analyse(Walk(period=0.3).tracks(fps=60.0), belt_speed=300.0)
    assert not any("strides have" in n for n in tables.notes)


@pytest.mark.slow
def test_split_belts_are_said_and_each_side_by_itself_has_the_speed_of_its_belt():
    # as in studies of locomotor adaptation: one belt twice as fast as the other
    fast = Walk(speed=400.0, duty=0.55).tracks(noise=0.2)
    slow = Walk(speed=200.0, duty=0.65).tracks(noise=0.2, seed=1)
    fast["position"].data[:, :, :2] = slow["position"].data[:, :, :2]  # FR, HR
    (note,) = (n for n in analyse(fast).notes if "split belts" in n)
    assert "--legs FL HL and --legs FR HR" in note
    told = re.search(
        r"of the left go backwards at (\S+) mm/s and those of the right at (\S+),", note
    )
    assert [float(x) for x in told.groups()] == pytest.approx([400.0, 200.0], rel=0.02)
    assert any("split belts" in n for n in analyse(fast, belt_speed=300.0).notes)
    for legs, speed in ((["FL", "HL"], 400.0), (["FR", "HR"], 200.0)):
        alone = analyse(fast, legs=legs)
        assert not any("split belts" in n for n in alone.notes)
        assert alone.strides["speed"].mean() == pytest.approx(speed, rel=0.01)
    assert not any("split" in n for n in analyse(Walk().tracks(noise=0.2)).notes)
