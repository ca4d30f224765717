"""What is left over of an outline: painted animals of which it is known what they have more."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from painted_spider import paint, panel

from pawnb.core.pose.background import Background
from pawnb.core.pose.doubts.limbs_left_over import limbs_left_over
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.start_proposal.silhouette import find_silhouette

SIZE, AT = (420, 420), (210.0, 210.0)


@pytest.fixture(scope="module")
def seen():
    """Return a painted spider of eight legs, its pose, and its outline."""
    animal, rng = load_species("dolomedes"), np.random.default_rng(0)
    pose = natural_pose(animal, xy=AT, heading_deg=35.0, scale=2.4)
    empty = np.stack([paint(animal, None, SIZE, rng) for _ in range(8)]).astype(np.float32)
    background = Background(
        mean=empty.mean(axis=0), sd=empty.std(axis=0), n_frames=8, source="painted"
    )
    outline = find_silhouette(paint(animal, pose, SIZE, rng, empty=panel(SIZE)), background)
    return animal, pose, outline


def without(animal, pose, leg):
    """Return the animal without a leg, and its pose."""
    fewer = animal.without([leg])
    columns = [animal.joints.index(name) for name in fewer.joints]
    segments = [animal.segments.index(name) for name in fewer.segments]
    pose = dataclasses.replace(
        pose, angles_deg=pose.angles_deg[:, columns], lengths_px=pose.lengths_px[:, segments]
    )
    return fewer, pose


def test_nothing_is_left_over_of_an_animal_that_has_its_pose(seen):
    animal, pose, outline = seen
    assert limbs_left_over(outline, animal, pose) < 0.1


def test_a_leg_that_the_stick_animal_lacks_is_left_over(seen):
    """It is a leg's length less what lies near the body and its neighbours."""
    animal, pose, outline = seen
    for leg in ("L1", "R2", "L4"):
        assert 0.5 < limbs_left_over(outline, *without(animal, pose, leg)) < 1.2


def test_legs_of_half_the_length_leave_their_outer_halves_over(seen):
    """Eight halves are four legs: eight of their own, less 5 % of the leg span each."""
    animal, pose, outline = seen
    short = dataclasses.replace(pose, lengths_px=pose.lengths_px / 2)
    assert 5.0 < limbs_left_over(outline, animal, short) < 8.0


def test_a_stick_animal_the_wrong_way_round_leaves_limbs_over(seen):
    animal, pose, outline = seen
    turned = dataclasses.replace(pose, heading_deg=pose.heading_deg + 180.0)
    assert limbs_left_over(outline, animal, turned) > 1.0
