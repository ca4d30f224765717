"""The stick animal against the thesis's tables, and its geometry against itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pawnb.core.pose.poses import (
    join_poses,
    joint_positions,
    leg_angles,
    natural_pose,
    poses_from_joints,
    segment_directions,
    tip_positions,
)
from pawnb.core.pose.species_file import built_in_species, load_species, parse_species
from pawnb.errors import InputError

# Pullar 2009, Table 3.1 and 3.2, sums by leg
LEG_LENGTH_MM = {1: 34.2, 2: 35.0, 3: 33.9, 4: 40.0}
NATURAL_BC_DEG = {1: 90 - 55, 2: 90 - 76, 3: 90 - 108, 4: 90 - 117}
RANGE_DEG = {1: 51 + 102 + 83 + 14 + 119, 4: 54 + 56 + 17 + 8 + 138}


@pytest.fixture(scope="module")
def dolomedes():
    return load_species("dolomedes")


def test_dolomedes_is_the_thesis_animal(dolomedes):
    assert dolomedes.n_dof == 43
    assert dolomedes.leg_names == ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
    for leg in dolomedes.legs:
        pair = int(leg.name[1])
        assert sum(leg.lengths) == pytest.approx(LEG_LENGTH_MM[pair])
        assert leg.natural_deg[0] == NATURAL_BC_DEG[pair]
        if pair in RANGE_DEG:
            assert sum(leg.range_deg) == pytest.approx(RANGE_DEG[pair])
    assert dolomedes.joints[:5] == ("L1_BC", "L1_CT", "L1_PT", "L1_TM", "L1_MT")
    assert {e.name: (e.length, e.width) for e in dolomedes.body} == {
        "cephalothorax": (14.0, 12.0),
        "abdomen": (14.0, 10.0),
    }


def test_natural_range_of_leg_1_is_what_table_4_6_observes(dolomedes):
    # erratum 9: 35 +- 25.5 degrees, observed 10 to 61
    leg = dolomedes.leg("R1")
    low = leg.natural_deg[0] - leg.range_deg[0] / 2
    assert (low, low + leg.range_deg[0]) == (9.5, 60.5)


@pytest.mark.parametrize("name", built_in_species())
def test_every_built_in_animal_is_symmetrical(name):
    animal = load_species(name)
    partners = animal.mirrored_names()
    assert sorted(partners) == sorted(animal.leg_names)
    pose = natural_pose(animal, heading_deg=0.0)
    tips = dict(zip(animal.leg_names, tip_positions(animal, pose)[0], strict=True))
    for leg, other in partners.items():
        np.testing.assert_allclose(tips[leg], tips[other] * [1, -1], atol=1e-9)


def test_legs_lie_where_an_animal_seen_from_above_has_them(dolomedes):
    # heading +u: the front is to the right of the picture, the animal's right side below (v down)
    pose = natural_pose(dolomedes, xy=(100.0, 200.0), heading_deg=0.0, scale=5.0)
    tips = dict(zip(dolomedes.leg_names, tip_positions(dolomedes, pose)[0], strict=True))
    assert tips["R1"][1] > 200 > tips["L1"][1]
    assert tips["R1"][0] > tips["R2"][0] > 100 > tips["R4"][0]


def test_directions_and_leg_angle_of_a_straight_leg(dolomedes):
    # a straight leg's total angle is its body-coxa angle (Pullar 2009, section 3.6)
    pose = natural_pose(dolomedes, heading_deg=30.0, scale=4.0)
    angles = dict(zip(dolomedes.leg_names, leg_angles(dolomedes, pose)[0], strict=True))
    assert angles["L2"] == pytest.approx(14.0)
    assert angles["R4"] == pytest.approx(-27.0)
    # coxa 1 lies 55 degrees from the symmetry line, to the right of the heading
    assert segment_directions(dolomedes, pose)[0, 4 * 7] == pytest.approx(30.0 + 55.0)


angle = st.floats(-170, 170)


@pytest.mark.slow
@given(heading=st.floats(-180, 180), turn=st.lists(angle, min_size=40, max_size=40))
def test_pose_from_its_joints_is_the_pose(heading, turn):
    animal = load_species("dolomedes")
    pose = natural_pose(animal, frame=3, xy=(40.0, -7.0), heading_deg=heading, scale=3.0)
    pose = type(pose)(**{**vars(pose), "angles_deg": np.array([turn])})
    again = poses_from_joints(
        animal,
        joint_positions(animal, pose),
        frames=pose.frames,
        xy=pose.xy,
        heading_deg=pose.heading_deg,
        scale=pose.scale,
    )
    np.testing.assert_allclose(again.lengths_px, pose.lengths_px, atol=1e-9)
    np.testing.assert_allclose(
        (again.angles_deg - pose.angles_deg + 180) % 360, 180, rtol=0, atol=1e-6
    )


@given(heading=st.floats(-180, 180), x=st.floats(-500, 500), y=st.floats(-500, 500))
def test_turning_and_moving_the_body_moves_the_legs_rigidly(heading, x, y):
    animal = load_species("insect")
    still = joint_positions(animal, natural_pose(animal, scale=10.0))[0]
    moved = joint_positions(
        animal, natural_pose(animal, xy=(x, y), heading_deg=heading, scale=10.0)
    )[0]
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    np.testing.assert_allclose(moved, still @ np.array([[c, s], [-s, c]]) + [x, y], atol=1e-9)


def test_legs_longer_shorter_or_missing(dolomedes):
    changed = dolomedes.resized({"L1": 1.1, "L1_Ta": 0.5, "R4_Fe": 2.0})
    assert changed.leg("L1").lengths[0] == pytest.approx(2.9 * 1.1)
    assert changed.leg("L1").lengths[-1] == pytest.approx(4.2 * 1.1 * 0.5)
    assert changed.leg("R4").lengths[2] == pytest.approx(18.6)
    assert changed.leg("R1") == dolomedes.leg("R1")
    seven = dolomedes.without(["L3"])
    assert seven.n_dof == 38
    assert "L3" not in seven.leg_names
    with pytest.raises(InputError, match="no leg 'L9'"):
        dolomedes.without(["L9"])
    with pytest.raises(InputError, match="above 0"):
        dolomedes.resized({"L1": 0.0})
    with pytest.raises(InputError, match="no leg or segment 'L1_Xx'"):
        dolomedes.resized({"L1_Xx": 2.0})
    with pytest.raises(InputError, match="every leg"):
        dolomedes.without(dolomedes.leg_names)


def test_poses_are_cut_and_joined(dolomedes):
    parts = [natural_pose(dolomedes, frame=f, xy=(f, 0.0)) for f in (4, 5, 9)]
    poses = join_poses(parts)
    assert list(poses.frames) == [4, 5, 9]
    assert poses.at_frame(5).xy[0, 0] == 5
    assert len(poses.at_frame(6)) == 0


SPECIES = """
name = "two legs"
[[body]]
name = "trunk"
centre = [0.0, 0.0]
length = 4.0
width = 2.0
[[legs]]
left = "L"
right = "R"
attach = [1.0, 0.5]
segments = ["A", "B"]
joints = ["BA", "AB"]
lengths = [2.0, 3.0]
natural_deg = [0.0, 10.0]
range_deg = [90.0, 60.0]
"""


def test_own_species_file(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(SPECIES)
    animal = load_species("own.toml", folder=tmp_path)
    assert animal.joints == ("L_BA", "L_AB", "R_BA", "R_AB")
    assert animal.leg("L").attach == (1.0, -0.5)
    assert len(animal.leg("L").widths) == 3
    assert animal.body_length == 4.0
    assert animal.span == pytest.approx(11.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("range_deg = [90.0, 60.0]", "range_deg = [90.0, 400.0]", "joint AB has a range of 400"),
        ("range_deg = [90.0, 60.0]", "range_deg = [90.0, -5.0]", "joint AB has a range of -5"),
        ("range_deg = [90.0, 60.0]", "range_deg = [90.0]", "range_deg has 1 numbers; expected 2"),
        ("range_deg = [90.0, 60.0]", "range_deg = [0.0, 0.0]", "no joint is free"),
        ("natural_deg = [0.0, 10.0]", "natural_deg = [0.0, 270.0]", "natural orientation of 270"),
        ("lengths = [2.0, 3.0]", "lengths = [2.0, 0.0]", "segment B is 0 long"),
        ("lengths = [2.0, 3.0]", 'lengths = [2.0, "x"]', "lengths holds 'x'"),
        ('joints = ["BA", "AB"]', 'joints = ["BA", "BA"]', "two joints have one name"),
        ('joints = ["BA", "AB"]', 'joints = ["BA"]', "2 segments but 1 joints"),
        ("attach", "atach", r"unknown name 'atach' \(did you mean 'attach'"),
        ('right = "R"', 'right = "L"', "two legs are called 'L'"),
        ('left = "L"\nright = "R"\n', "", "names no leg"),
        # a joint's point is called L.BA, so with a dot no leg is found by its name
        ('left = "L"', 'left = "L.1"', r"'L.1' cannot name a leg or a joint; .* without a dot"),
        ('left = "L"', 'left = " "', "' ' cannot name a leg"),
        ('joints = ["BA", "AB"]', 'joints = ["B.A", "AB"]', "'B.A' cannot name"),
        ('joints = ["BA", "AB"]', 'joints = ["B_A", "AB"]', "'B_A' cannot name a joint"),
        ('left = "L"', 'left = "body"', "'body' is the name of something else"),
        ("attach = [1.0, 0.5]", "attach = [1.0, -0.5]", "right leg on the left side"),
        ("attach =", "free = []\nattach =", r"free is \[\]; expected a list of one or more"),
        ("width = 2.0", "width = 0.0", "width is 0"),
        ("attach =", "widths = [0.5, 0.2, 0.0]\nattach =", "a width is 0; expected numbers above"),
        ("width = 2.0", "", "width missing"),
        ("[[body]]", "[body]", r"write \[\[body\]\]"),
        ('name = "two legs"', "name = ", "not a TOML file"),
        ("attach =", 'free = ["AB", "CD"]\nattach =', "free names the joint 'CD'"),
    ],
)
def test_impossible_animals_are_refused_in_one_sentence(old, new, message):
    assert old in SPECIES
    with pytest.raises(InputError, match=message) as caught:
        parse_species(SPECIES.replace(old, new, 1), where="own.toml")
    assert "own.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_species(tmp_path):
    with pytest.raises(
        InputError, match=r"species 'spidr' \(did you mean 'spider'\?\): neither a built-in"
    ):
        load_species("spidr", folder=tmp_path)
