"""Further measures of strides: a walk whose steps are known, and leg angles made by hand."""

import numpy as np
import pytest
from walking import Walk

from pawnb.gait import analyse
from pawnb.gait.analysis.stride_measures import MEASURE_COLUMNS, measure_strides
from pawnb.gait.cycles import HEIGHT, LEG_ANGLE, LegSignals
from pawnb.gait.events.event_settings import EventSettings
from pawnb.gait.strides import Motion
from pawnb.trial import Animal, Calibration, Trial

WALK = Walk()
TRIAL = Trial(
    kind="tracks", name="t", fps=250.0, tracks_file="x.nc", calibration=Calibration(unit="mm"),
    animal=Animal(id="a", extra={"body_length": 80.0}), belt_speed=WALK.speed,
)  # fmt: skip


def test_steps_of_a_known_walk():
    strides = analyse(WALK.tracks(), trial=TRIAL).strides
    # 300 mm/s, a body of 80 mm
    np.testing.assert_allclose(strides["speed_bl"], 300.0 / 80.0, rtol=0.03)
    # left and right land half a cycle apart: half a stride length of 90 mm ahead of each other
    steps = strides["step_length"].dropna()
    np.testing.assert_allclose(steps, 45.0, atol=2.0)
    # feet run 15 mm to either side of the middle
    np.testing.assert_allclose(strides["step_width"].dropna(), 30.0, atol=0.5)
    right = strides["leg"].str.endswith("R")
    np.testing.assert_allclose(strides.loc[right, "aep_lateral"], 15.0, atol=1.0)
    np.testing.assert_allclose(strides.loc[~right, "aep_lateral"], -15.0, atol=1.0)
    # over the ground a foot rests in stance: all of the stride length lies in swing, less what
    # it moves between AEP and touch-down and between lift-off and PEP
    assert (strides["swing_distance"] < 90.0).all()
    assert (strides["swing_distance"] > 0.8 * 90.0).all()
    np.testing.assert_allclose(
        strides["excursion"], strides["aep_position"] - strides["pep_position"]
    )
    assert strides["excursion_deg"].isna().all()  # no leg angle in these tracks
    np.testing.assert_allclose(strides["heading_deg"], 0.0, atol=1e-9)


def test_angular_measures_of_a_triangle_wave():
    # stance 0.3 s from +30 to -30 degrees, swing 0.2 s back
    t = np.arange(0, 2.0, 0.001)
    x = t % 0.5
    angle = np.where(x < 0.3, 30 - 200 * x, -30 + 300 * (x - 0.3))
    signal = LegSignals(
        animal="a", trial="t", legs=("FR",), time_s=t, samples=angle[:, None], signal=LEG_ANGLE
    )
    strides = analyse(WALK.tracks(), trial=TRIAL).strides.drop(columns=list(MEASURE_COLUMNS))
    one = strides[strides["leg"] == "FR"].head(1).assign(start_s=0.5, stance_s=0.3, period_s=0.5)
    found = measure_strides(one, signals=[signal]).iloc[0]
    assert found["excursion_deg"] == pytest.approx(60.0, abs=0.5)
    assert found["swing_velocity_deg_s"] == pytest.approx(300.0, rel=0.01)
    assert found["stance_velocity_deg_s"] == pytest.approx(-200.0, rel=0.01)
    assert found["swing_peak_velocity_deg_s"] == pytest.approx(300.0, rel=0.01)
    assert found["stance_peak_velocity_deg_s"] == pytest.approx(-200.0, rel=0.01)


def test_a_foot_is_lifted_and_drags_as_it_was_made_to():
    """On the ground at 2 mm; in swing a half sine of 8 mm, or flat at 0.5 mm with a late hop."""
    t = np.arange(0, 1.0, 0.001)
    x = t % 0.5
    swing = np.clip((x - 0.3) / 0.2, 0, 1)
    clean = 2.0 + 8.0 * np.sin(np.pi * swing)
    drags = 2.0 + np.where((swing > 0) & (swing < 0.8), 0.5, 0.0) + 4.0 * (swing > 0.8)
    strides = analyse(WALK.tracks(), trial=TRIAL).strides.drop(columns=list(MEASURE_COLUMNS))
    one = strides[strides["leg"] == "FR"].head(1).assign(start_s=0.0, stance_s=0.3, period_s=0.5)
    found = []
    for height in (clean, drags):
        signal = LegSignals(
            animal="a", trial="t", legs=("FR",), time_s=t, samples=height[:, None], signal=HEIGHT,
            unit="mm",
        )  # fmt: skip
        found.append(measure_strides(one, signals=[signal]).iloc[0])
    # a quarter of the way through a half sine it has sin(45 degrees) of its height
    assert found[0]["swing_height"] == pytest.approx(8.0, abs=0.01)
    assert found[0]["toe_clearance"] == pytest.approx(8.0 * np.sin(np.pi / 4), abs=0.1)
    assert found[1]["swing_height"] == pytest.approx(4.0, abs=0.01)
    assert found[1]["toe_clearance"] == pytest.approx(0.5, abs=0.01)


def test_a_foot_drags_for_as_long_as_it_was_made_to():
    """One foot is lifted as a half sine of 8 mm; another slides at 0.5 mm for 0.7 of its swing.

    A half sine is below a quarter of its height for 2 asin(1/4) / pi of its time. The foot that
    slides rests for the first tenth of its swing: near the floor, but it is not dragged.
    """
    t = np.arange(0, 1.0, 0.001)
    swing = np.clip((t % 0.5 - 0.3) / 0.2, 0, 1)
    clean = 2.0 + 8.0 * np.sin(np.pi * swing)
    drags = 2.0 + np.where((swing > 0) & (swing < 0.8), 0.5, 0.0) + 8.0 * (swing > 0.8)
    before = np.floor(t / 0.5)  # whole strides made
    feet = {
        "FR": 100.0 * (before + swing), "HR": 100.0 * (before + np.clip((swing - 0.1) / 0.9, 0, 1))
    }  # fmt: skip
    motion = Motion(time_s=t, body=np.zeros_like(t), feet=feet)
    signal = LegSignals(
        animal="a", trial="t", legs=("FR", "HR"), time_s=t, samples=np.column_stack((clean, drags)),
        signal=HEIGHT, unit="mm",
    )  # fmt: skip
    strides = analyse(WALK.tracks(), trial=TRIAL).strides.drop(columns=list(MEASURE_COLUMNS))
    both = strides.groupby("leg").head(1).query("leg in ('FR', 'HR')").reset_index(drop=True)
    both = both.assign(leg=["FR", "HR"], start_s=0.0, stance_s=0.3, period_s=0.5)
    found = measure_strides(both, motion={"FR": motion, "HR": motion}, signals=[signal]).set_index(
        "leg"
    )["drag_fraction"]
    assert found["FR"] == pytest.approx(2 * np.arcsin(0.25) / np.pi, abs=0.02)
    assert found["HR"] == pytest.approx(0.7, abs=0.02)
    assert measure_strides(both, signals=[signal])["drag_fraction"].isna().all()
    settings = EventSettings(contact_height_fraction=0.05)
    low = measure_strides(
        both, motion={"FR": motion, "HR": motion}, signals=[signal], settings=settings
    ).set_index("leg")["drag_fraction"]
    # 0.4 mm: only what is lower than the foot that slides
    assert low["HR"] == pytest.approx(0.0, abs=0.02)


def test_an_animal_that_turns_tells_its_heading():
    heading = np.linspace(350.0, 440.0, 500)
    motion = Motion(time_s=np.arange(500) / 100.0, body=np.zeros(500), heading_deg=heading)
    mean, change = motion.heading_between(np.array([0.0]), np.array([4.99]))
    assert mean[0] == pytest.approx(35.0)
    assert change[0] == pytest.approx(90.0)
