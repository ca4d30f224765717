"""Axes of a calibration that are not those of the animal are said, with what to write."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walking import Walk

from pawnb.gait import analyse
from pawnb.trial import Animal, Calibration, Trial, View


def notes_of(tracks, **calibration):
    trial = Trial(
        kind="paws",
        name="m",
        fps=250.0,
        views=(View(name="cam1", video="a.avi"),),
        animal=Animal(id="m"),
        belt_speed=300.0,
        calibration=Calibration(dlt="d.csv", **calibration),
    )
    return analyse(tracks, trial=trial).notes


def along(degrees):
    return (np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0)


@pytest.mark.parametrize("turned_deg", [0.0, 10.0, 30.0, 60.0, 100.0])
def test_feet_that_go_aside_of_forward_are_said_with_their_direction(turned_deg):
    """The walk goes along a known direction; forward is x, as nobody said otherwise."""
    said = [n for n in notes_of(Walk().tracks(axis=along(turned_deg))) if "aside of forward" in n]
    assert len(said) == (turned_deg > 15.0)
    if said:
        assert f"{turned_deg:.0f} degrees aside of forward = [1.0, 0.0, 0.0]" in said[0]
        named = said[0].split("[calibration] forward = [")[1].split("]")[0]
        way = np.array([float(x) for x in named.split(",")])
        assert way @ along(turned_deg) > np.cos(np.radians(4.0))  # paws are lifted, too
        told = notes_of(Walk().tracks(axis=along(turned_deg)), forward=tuple(way))
        assert not [n for n in told if "forward" in n]


@pytest.mark.slow
def test_feet_that_are_lifted_downwards_are_said():
    below = Walk().tracks()
    below["position"].loc[{"space": "z"}] *= -1.0
    (said,) = [n for n in notes_of(below) if "lower in swing" in n]
    assert "is up = [0.0, 0.0, 1.0] the wrong way round?" in said
    assert not [n for n in notes_of(below, up=(0.0, 0.0, -1.0)) if "lower in swing" in n]
    assert not [n for n in notes_of(Walk().tracks()) if "lower in swing" in n]


@pytest.mark.slow
def test_where_feet_seem_to_swing_backwards_nothing_is_said_of_how_they_are_lifted():
    """Either the direction is wrong, or too few frames hide what is swing: up comes after it."""
    below = Walk().tracks()
    below["position"].loc[{"space": "z"}] *= -1.0
    notes = notes_of(below, forward=(-1.0, 0.0, 0.0))
    assert [n for n in notes if "the feet swing fastest backwards" in n]
    assert not [n for n in notes if "lower in swing" in n or "of up" in n]


def turned(tracks, rotation):
    """Tracks in the axes of a camera, as of Anipose without an origin that was set."""
    places = tracks["position"].to_numpy()
    places[:] = np.einsum("de,nekj->ndkj", rotation, places)
    return tracks


def on_the_ground(tracks, **calibration):
    trial = Trial(
        kind="tracks", name="m", fps=250.0, animal=Animal(id="m"), tracks_file="points.csv",
        calibration=Calibration(**calibration),
    )  # fmt: skip
    return analyse(tracks, trial=trial)


# x to the right, y down, z away from the camera
OF_A_CAMERA = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.mark.parametrize("treadmill", [True, False])
def test_the_axes_of_a_camera_are_said_with_the_direction_that_is_up(treadmill):
    walk = turned(Walk().tracks(treadmill=treadmill), OF_A_CAMERA)
    notes = notes_of(walk) if treadmill else on_the_ground(walk).notes
    (said,) = [n for n in notes if "aside of up" in n]
    assert "the feet are lifted 90 degrees aside of up = [0.0, 0.0, 1.0]" in said
    named = said.split("[calibration] up = [")[1].split("]")[0]
    up = np.array([float(x) for x in named.split(",")])
    assert up == pytest.approx([0.0, -1.0, 0.0], abs=0.02)
    notes = notes_of(walk, up=tuple(up)) if treadmill else on_the_ground(walk, up=tuple(up)).notes
    assert not [n for n in notes if "of up" in n or "is up" in n]


def test_an_animal_that_seems_to_climb_has_lengths_that_are_too_short():
    """Strides of 90 mm on level ground, seen in the axes of a camera that looks down at them."""
    rotation = Rotation.from_euler("xyz", [35.0, 50.0, -20.0], degrees=True).as_matrix()
    walk = turned(Walk().tracks(treadmill=False), rotation)
    tables = on_the_ground(walk)
    (said,) = [n for n in tables.notes if "the animal goes down" in n]
    assert "the animal goes down by 50 degrees where up = [0.0, 0.0, 1.0]" in said
    # the sine of its slope is the part of its way along z
    level = 90.0 * np.sqrt(1.0 - rotation[2, 0] ** 2)
    assert tables.strides["stride_length"].median() == pytest.approx(level, rel=0.02)
    (lifted,) = [n for n in tables.notes if "aside of up" in n]
    named = lifted.split("[calibration] up = [")[1].split("]")[0]
    up = tuple(float(x) for x in named.split(","))
    assert up == pytest.approx(rotation[:, 2], abs=0.02)
    tables = on_the_ground(walk, up=up)
    assert tables.strides["stride_length"].median() == pytest.approx(90.0, rel=0.01)
    assert not [n for n in tables.notes if "of up" in n or "goes down" in n]


@pytest.mark.parametrize("degrees", [0.0, 12.0])
def test_a_slope_that_animals_climb_needs_no_word(degrees):
    rotation = Rotation.from_euler("y", -degrees, degrees=True).as_matrix()
    notes = on_the_ground(turned(Walk().tracks(treadmill=False), rotation)).notes
    assert not [n for n in notes if "the animal goes up" in n or "of up" in n]
