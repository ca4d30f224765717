"""Whether an animal goes to where its head is: on ways that are known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from walking_poses import walking_poses

from pawnb.core.pose.doubts.travel import goes_backwards, is_backwards
from pawnb.core.pose.species_file import load_species


@pytest.mark.parametrize(
    ("way", "told"),
    [((26.0, 0.0), False), ((-26.0, 0.0), True), ((0.0, 26.0), False), ((24.0, 0.0), None),
     ((-24.0, 0.0), None), ((np.nan, 0.0), None)],
)  # fmt: skip
def test_a_quarter_of_a_body_says_which_way(way, told):
    assert is_backwards(np.array(way), 0.0, body_px=100.0) is told


def test_a_recording_is_told_by_most_of_its_frames():
    animal = load_species("dolomedes")
    poses = walking_poses(animal)
    turned = dataclasses.replace(poses, heading_deg=poses.heading_deg + 180.0)
    assert not goes_backwards(animal, poses)
    assert goes_backwards(animal, turned)
    gone = turned.xy.copy()
    gone[20:] = np.nan
    assert goes_backwards(animal, dataclasses.replace(turned, xy=gone))


def test_an_animal_that_stands_goes_nowhere():
    animal = load_species("dolomedes")
    poses = walking_poses(animal)
    still = dataclasses.replace(
        poses, xy=np.tile(poses.xy[0], (len(poses), 1)), heading_deg=poses.heading_deg + 180.0
    )
    assert not goes_backwards(animal, still)
    nowhere = dataclasses.replace(poses, xy=np.full_like(poses.xy, np.nan))
    assert not goes_backwards(animal, nowhere)
