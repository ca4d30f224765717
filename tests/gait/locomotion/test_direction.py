"""Axes of a calibration that are not those of the animal are said, with what to write."""

import numpy as np
import pytest
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


def test_feet_that_are_lifted_downwards_are_said():
    below = Walk().tracks()
    below["position"].loc[{"space": "z"}] *= -1.0
    (said,) = [n for n in notes_of(below) if "lower in swing" in n]
    assert "is up = [0.0, 0.0, 1.0] the wrong way round?" in said
    assert not [n for n in notes_of(below, up=(0.0, 0.0, -1.0)) if "lower in swing" in n]
    assert not [n for n in notes_of(Walk().tracks()) if "lower in swing" in n]
