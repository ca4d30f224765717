"""Legs that lie along another one: poses in which it is known which do."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from walking_poses import walking_poses

from pawnb.core.pose.doubts.on_another_leg import legs_on_another
from pawnb.core.pose.poses import joint_positions, poses_from_joints
from pawnb.core.pose.species_file import load_species


def doubled(share, *, leg="L2", on="L1"):
    """Return a walking spider of which one leg is on another's place in a share of 40 frames."""
    animal = load_species("dolomedes")
    poses = walking_poses(animal)
    places, names = joint_positions(animal, poses), list(animal.leg_names)
    i, j = names.index(leg), names.index(on)
    rows = slice(0, round(share * len(poses)))
    places[rows, i, 1:] = places[rows, j, 1:]
    bent = poses_from_joints(
        animal, places, frames=poses.frames, xy=poses.xy, heading_deg=poses.heading_deg,
        scale=poses.scale,
    )  # fmt: skip
    return animal, bent


def test_a_walking_spider_has_its_legs_apart():
    animal = load_species("dolomedes")
    assert legs_on_another(animal, walking_poses(animal)) == {}


@pytest.mark.parametrize("leg", ["L2", "R3"])
def test_a_leg_that_lies_along_another_is_named_with_it(leg):
    on = {"L2": "L1", "R3": "R4"}[leg]
    found = legs_on_another(*doubled(0.75, leg=leg, on=on))
    assert found[leg] == (on, 0.75)


def test_legs_that_meet_now_and_then_are_not():
    assert legs_on_another(*doubled(0.4)) == {}


def test_frames_without_the_animal_do_not_count():
    animal, poses = doubled(0.6)
    gone = poses.xy.copy()
    gone[24:] = np.nan  # of 40 frames, the first 24 have L2 on L1
    found = legs_on_another(animal, dataclasses.replace(poses, xy=gone))
    assert found["L2"] == ("L1", 1.0)
    nowhere = dataclasses.replace(poses, xy=np.full_like(poses.xy, np.nan))
    assert legs_on_another(animal, nowhere) == {}
