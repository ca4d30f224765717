"""Right of the animal, in pictures from above and from below and in space."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.gait import analyse
from pawnb.gait.locomotion.foot_trajectories import FootPaths
from pawnb.gait.locomotion.sides import place_across
from pawnb.io.formats import read_any_tracks
from pawnb.kinematics import body_frame_of_path

LEGS = ("FR", "HR", "FL", "HL")
UP = np.array([0.0, 0.0, 1.0])


def standing(right, *, axes=2, legs=LEGS, spread=1.0):
    """Feet of an animal that faces along u; those of the right are at ``right`` along v."""
    rng = np.random.default_rng(3)
    positions = spread * rng.standard_normal((200, axes, 4))
    positions[:, 1] += np.array([right, right, -right, -right])
    feet = FootPaths(source="top", unit="px", legs=legs, positions=positions)
    forward = [1.0, 0.0, 0.0][:axes]
    return feet, body_frame_of_path(
        np.zeros((200, axes)), forward, at_rest=True, method="laboratory"
    )


# seen from above, v downwards in the picture, right of an animal that faces along u is along v
@pytest.mark.parametrize(("right", "said"), [(20.0, 0), (-20.0, 1)])
def test_right_legs_are_on_the_right_from_above_and_from_below(right, said):
    across, notes = place_across(*standing(right), up=None)
    np.testing.assert_allclose(np.median(across, axis=0), [20, 20, -20, -20], atol=0.5)
    assert len(notes) == said
    assert all("seen from below, or in a mirror" in note for note in notes)


@pytest.mark.parametrize("legs", [LEGS, ("paw1", "paw2", "paw3", "paw4"), ("FR", "HR", "a", "b")])
def test_from_the_side_and_without_names_of_sides_it_is_as_from_above(legs):
    right, spread = (-0.1, 1.0) if legs == LEGS else (-20.0, 1.0)
    feet, frame = standing(right, legs=legs, spread=spread)
    across, notes = place_across(feet, frame, up=None)
    np.testing.assert_allclose(across, feet.positions[:, 1])
    assert not notes


def test_in_space_right_legs_on_the_left_are_said_and_left_there():
    # right of forward (1, 0, 0) with up (0, 0, 1) is (0, -1, 0)
    across, notes = place_across(*standing(-20.0, axes=3), up=UP)
    assert across[:, 0].mean() > 0
    assert not notes
    across, notes = place_across(*standing(20.0, axes=3), up=UP)
    assert across[:, 0].mean() < 0
    assert "names of left and right exchanged" in notes[0]


@pytest.mark.slow
def test_a_real_mouse_filmed_from_below_has_its_right_paws_on_its_right(real_data):
    # the film of B-SOiD's open field is taken from below, as its data say
    tracks = read_any_tracks(real_data("mouse-openfield-dlc") / "raw_clip1DLC.csv", fps=60.0)
    tables = analyse(tracks)
    places = tables.strides.groupby("leg")["aep_lateral"].median()
    assert (places[["FR", "HR"]] > 10).all()
    assert (places[["FL", "HL"]] < -10).all()
    assert any("seen from below" in note for note in tables.notes)
