"""Posing the stick animal without a browser."""

import json

import numpy as np
import pandas as pd
import pytest

from pawnb.core.pose.animal import LEFT, RIGHT
from pawnb.core.pose.handles import beyond_range, handles, leg_places, reach_tip, turn_joint
from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.poses import joint_positions, natural_pose, tip_positions
from pawnb.core.pose.species_file import load_species
from pawnb.errors import InputError
from pawnb.io.pose import films_of_poses
from pawnb.trial import Animal, Calibration, Trial
from pawnb.widgets.stick_drawing import describe
from pawnb.widgets.stick_session import StickSession

SPECIES = load_species("dolomedes")
XY, HEADING, SCALE = (300.0, 250.0), 25.0, 3.0


@pytest.fixture
def session(tmp_path):
    trial = Trial(
        kind="pose",
        name="t",
        fps=125.0,
        animal=Animal(id="a", species="dolomedes"),
        folder=tmp_path,
        calibration=Calibration(px_per_unit=SCALE, unit="mm"),
    )
    made = StickSession(trial, SPECIES, size=(640, 512), span=(0, 99), frame=20)
    made.drag("body", *XY)
    far = np.array(XY) + 100 * np.array([np.cos(np.radians(HEADING)), np.sin(np.radians(HEADING))])
    made.drag("heading", *far)
    return made


def places(session):
    return joint_positions(session.animal(), session.poses())[0]


def test_the_first_pose_is_natural_in_the_middle_and_not_saved(tmp_path):
    trial = Trial(kind="pose", name="t", fps=1.0, animal=Animal(id="a"), folder=tmp_path)
    made = StickSession(trial, SPECIES, size=(641, 513), span=(0, 9))
    assert made.pose.xy == (320, 256)
    np.testing.assert_allclose(made.poses().angles_deg[0], SPECIES.natural_deg)
    # without a calibration the legs span half of the picture's shorter side
    assert made.pose.scale * SPECIES.span == pytest.approx(513 / 2)
    assert not made.saved
    assert not made.path.exists()
    assert "Press P" in made.prompt()


def test_body_heading_and_span(session):
    assert session.pose.xy == XY
    assert session.pose.heading_deg == pytest.approx(HEADING)
    expected = natural_pose(SPECIES, frame=20, xy=XY, heading_deg=HEADING, scale=SCALE)
    np.testing.assert_allclose(places(session), joint_positions(SPECIES, expected)[0], atol=1e-9)
    session.drag("span", XY[0] + 90.0, XY[1])
    # the handle lies on the circle through the tips of the longest legs, stretched
    assert session.pose.scale == pytest.approx(2 * 90 / SPECIES.span)
    with pytest.raises(InputError, match="outside the picture"):
        session.drag("body", 700, 100)


@pytest.mark.parametrize("name", ["L1", "R2", "L4", "R4"])
@pytest.mark.parametrize("joint", ["CT", "PT", "TM", "MT"])
def test_dragging_a_joint_turns_the_leg_there_and_what_is_further_out_follows(session, name, joint):
    leg = SPECIES.leg(name)
    i, k = SPECIES.leg_names.index(name), leg.joints.index(joint)
    before = places(session)[i]
    # a quarter turn of the place about the free joint before it
    turning = max(j for j in range(k) if leg.free[j])
    arm = before[k] - before[turning]
    to = before[turning] + 1.7 * np.array([-arm[1], arm[0]])  # further off: only direction counts
    session.drag(f"{name}.{joint}", *to)
    after = places(session)[i]
    np.testing.assert_allclose(after[: turning + 1], before[: turning + 1], atol=1e-9)
    np.testing.assert_allclose(after[k] - after[turning], [-arm[1], arm[0]], atol=1e-6)
    # everything further out has turned with it, as one stiff piece
    out = before[k:] - before[turning]
    np.testing.assert_allclose(
        after[k:] - after[turning], np.stack([-out[:, 1], out[:, 0]], axis=1), atol=1e-6
    )
    others = [j for j in range(8) if j != i]
    np.testing.assert_allclose(places(session)[others, 1:], joint_positions(
        SPECIES, natural_pose(SPECIES, xy=XY, heading_deg=HEADING, scale=SCALE))[0][others, 1:],
        atol=1e-9)  # fmt: skip


def test_dragging_a_tip_brings_the_whole_leg_and_keeps_lengths(session):
    before = places(session)[2]
    to = before[-1] * 0.8 + before[0] * 0.2 + [3.0, -2.0]
    lengths = session.poses().lengths_px.copy()
    session.drag("L3", *to)
    after = places(session)[2]
    np.testing.assert_allclose(after[-1], to, atol=0.05)
    np.testing.assert_allclose(after[0], before[0], atol=1e-9)
    np.testing.assert_allclose(session.poses().lengths_px, lengths)
    turned = np.abs(session.pose.legs["L3"].angles_deg - np.array(SPECIES.leg("L3").natural_deg))
    assert (turned[np.array(SPECIES.leg("L3").free)] > 0.1).all()  # no joint does it alone
    assert (turned[~np.array(SPECIES.leg("L3").free)] == 0).all()


def test_a_tip_with_ctrl_turns_the_last_joint_alone(session):
    before = places(session)[0]
    session.drag("L1", *(before[-2] + [0.0, 10.0]), whole=False)
    after = places(session)[0]
    np.testing.assert_allclose(after[:-1], before[:-1], atol=1e-9)
    step = after[-1] - after[-2]
    np.testing.assert_allclose(step, [0, np.hypot(*(before[-1] - before[-2]))], atol=1e-9)


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_reaching_stays_within_the_ranges_where_it_can(side):
    leg = next(leg for leg in SPECIES.legs if leg.side == side and leg.name.endswith("2"))
    steps = 3.0 * np.array(leg.lengths)
    rng = np.random.default_rng(1)
    half = np.array(leg.range_deg) / 2
    for _ in range(20):
        # a place that some pose well within the ranges reaches
        wanted = np.array(leg.natural_deg) + rng.uniform(-0.5, 0.5, len(half)) * half
        root = np.array([100.0, 80.0])
        about = {"heading_deg": 40.0, "steps_px": steps}
        to = leg_places(leg, root, angles_deg=wanted, **about)[-1]
        found = reach_tip(leg, root, angles_deg=np.array(leg.natural_deg), to=to, **about)
        end = leg_places(leg, root, angles_deg=found, **about)[-1]
        assert np.hypot(*(end - to)) < 0.02 * steps.sum()
        assert beyond_range(leg, found).max() < 5.0


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_out_of_reach_a_leg_is_straight_and_stays_so(side):
    """The geometry of a chain: straight, it points to the place; dragged on, it does not move."""
    for leg in (leg for leg in SPECIES.legs if leg.side == side):
        root, steps = np.array([100.0, 80.0]), 3.0 * np.array(leg.lengths)
        about = {"heading_deg": 40.0, "steps_px": steps}
        angles = np.array(leg.natural_deg)
        natural = leg_places(leg, root, angles_deg=angles, **about)[-1]
        for turn_deg in (-30.0, 0.0, 30.0):
            turn = np.radians(turn_deg)
            out = natural - root
            out = [out[0] * np.cos(turn) - out[1] * np.sin(turn),
                   out[0] * np.sin(turn) + out[1] * np.cos(turn)]  # fmt: skip
            to = root + 6.0 * np.array(out)
            straight = root + steps.sum() * np.array(out) / np.hypot(*out)
            found = reach_tip(leg, root, angles_deg=angles, to=to, **about)
            again = reach_tip(leg, root, angles_deg=found, to=to, **about)
            ends = [leg_places(leg, root, angles_deg=a, **about) for a in (found, again)]
            np.testing.assert_allclose(ends[0][-1], straight, atol=0.01 * steps.sum())
            np.testing.assert_allclose(ends[1], ends[0], atol=0.005 * steps.sum())


def test_handles_are_the_joints_that_turn_and_the_tip():
    # Table 3.2: trochanter-femur and femur-patella do not turn
    assert handles(SPECIES.leg("R1")) == {"R1.CT": 1, "R1.PT": 4, "R1.TM": 5, "R1.MT": 6, "R1": 7}


def test_turning_wraps_angles(session):
    leg = SPECIES.leg("L1")
    angles = np.array(leg.natural_deg)
    at = leg_places(
        leg, np.zeros(2), heading_deg=0, angles_deg=angles, steps_px=np.array(leg.lengths)
    )
    for turn in range(0, 720, 70):
        arm = at[1] - at[0]
        cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        to = at[0] + [arm[0] * cos - arm[1] * sin, arm[0] * sin + arm[1] * cos]
        out = turn_joint(leg, at, angles, at=1, to=to)
        assert -180 <= out[0] < 180
        assert (out[0] - angles[0] - turn + 180) % 360 - 180 == pytest.approx(0, abs=1e-6)


def test_mirror_makes_the_pose_symmetrical(session):
    session.drag("L2", *(places(session)[1][-1] + [15, -10]))
    session.set_length(0.9, "L3")
    session.toggle_missing("L4")
    session.mirror("left")
    pose = session.pose
    for k in range(1, 5):
        left, right = pose.legs[f"L{k}"], pose.legs[f"R{k}"]
        np.testing.assert_allclose(left.angles_deg, right.angles_deg)
    # reflected about the body's axis, the left tips lie on the right ones
    turn = np.radians(pose.heading_deg)
    axis = np.array([np.cos(turn), np.sin(turn)])
    animal = session.animal()
    tips = tip_positions(animal, session.poses())[0] - pose.xy
    names = animal.leg_names
    assert names == ("L1", "L2", "L3", "R1", "R2", "R3")
    for k in range(3):
        reflected = 2 * (tips[k] @ axis) * axis - tips[k]
        np.testing.assert_allclose(reflected, tips[k + 3], atol=1e-6)
    with pytest.raises(InputError, match="expected left or right"):
        session.mirror("top")


def test_length_and_missing_reach_the_file(session):
    session.select("R2.PT")
    session.set_length(0.8)
    session.toggle_missing("L4")
    animal, poses = read_start_pose(session.path, SPECIES)
    assert animal.leg_names == ("L1", "L2", "L3", "R1", "R2", "R3", "R4")
    np.testing.assert_allclose(animal.leg("R2").lengths, 0.8 * np.array(SPECIES.leg("R2").lengths))
    assert poses.frames.tolist() == [20]
    np.testing.assert_allclose(joint_positions(animal, poses)[0], places(session), atol=1e-3)
    with pytest.raises(InputError, match=r"0\.2 to 3"):
        session.set_length(0.0)
    session.toggle_missing("L4")
    assert read_start_pose(session.path, SPECIES)[0].leg_names == SPECIES.leg_names


def test_raised_segments_keep_their_length_in_the_picture_through_the_file(session, tmp_path):
    poses = session.poses()
    poses.lengths_px[0, :7] *= 0.85  # leg L1 is raised
    session.propose(SPECIES, poses, notes=("L1 is unsure.",))
    assert session.path.read_text() != ""
    before = session.path.read_text()
    assert session.proposed
    assert "Enter" in session.prompt()
    assert "L1 is unsure." in session.remarks()
    session.accept()
    assert session.path.read_text() != before
    assert not session.proposed
    again = StickSession(session.trial, SPECIES, size=(640, 512), span=(0, 99))
    assert again.saved  # it is in its file
    np.testing.assert_allclose(again.poses().lengths_px, poses.lengths_px, rtol=1e-4)
    # the animal's own lengths are as they were: the leg is raised, not short
    np.testing.assert_allclose(again.animal().lengths, SPECIES.lengths)
    assert again.frame == 20


def test_undo_and_redo(session):
    file = session.path
    start = file.read_text()
    session.drag("L1.PT", 500, 300)
    bent = file.read_text()
    session.mirror("left")
    assert session.undo()
    assert file.read_text() == bent
    assert session.undo()
    assert file.read_text() == start
    assert session.redo()
    assert file.read_text() == bent
    session.drag("body", 200, 200)
    assert not session.can_redo
    # back to before the first change: the file keeps what was saved last, and that is said
    while session.undo():
        pass
    assert not session.saved
    assert "Press P" in session.prompt()


def test_a_pose_belongs_to_one_frame(session):
    session.go(33)
    assert session.pose_frame == 20
    assert "belongs to frame 20" in session.prompt()
    session.pose_here()
    assert session.poses().frames.tolist() == [33]
    assert pd.read_csv(session.path)["frame"].tolist() == [33]
    session.go(40)
    session.drag("body", 100, 100)  # changing it takes it along
    assert session.pose_frame == 40
    session.undo()
    assert session.frame == 33
    with pytest.raises(InputError, match="not in the trial"):
        session.go(100)


def test_tracking_may_start_from_several_frames(session):
    """Two poses, each changed where it belongs, are in the file; lengths are of the animal."""
    session.go(60)
    assert "Shift+F" in session.prompt()
    session.pose_here_too()
    assert session.posed_frames == [20, 60]
    session.drag("body", 100.0, 120.0)
    session.set_length(0.8, "L2")
    animal, poses = read_start_pose(session.path, SPECIES)
    assert poses.frames.tolist() == [20, 60]
    np.testing.assert_allclose(poses.xy, [XY, (100.0, 120.0)])
    flat = poses.scale[:, None] * animal.lengths
    np.testing.assert_allclose(poses.lengths_px, flat, rtol=1e-4)
    # at the other frame, its own pose is the one that is changed
    session.go(20)
    assert (session.pose_frame, session.pose.xy) == (20, XY)
    session.drag("body", 310.0, 260.0)
    assert session.poses().xy.tolist() == [[310.0, 260.0], [100.0, 120.0]]
    assert "Frames 20 and 60 have poses" in session.prompt()
    # opened again, both are there
    again = StickSession(session.trial, SPECIES, size=(640, 512), span=(0, 99), frame=60)
    assert again.posed_frames == [20, 60]
    assert (again.frame, again.pose.xy) == (60, (100.0, 120.0))
    assert again.pose.length_of("L2") == pytest.approx(0.8)
    again.drop()
    assert read_start_pose(again.path, SPECIES)[1].frames.tolist() == [20]
    with pytest.raises(InputError, match="at least one pose"):
        again.drop()
    assert again.undo()
    assert (again.posed_frames, again.frame) == ([20, 60], 60)
    assert read_start_pose(again.path, SPECIES)[1].frames.tolist() == [20, 60]
    # a pose that moves onto a frame that has one takes its place
    again.go(40)
    again.pose_here()
    assert again.posed_frames == [20, 40]


@pytest.mark.slow
def test_poses_keep_in_which_film_they_were_made(session):
    """The file of poses has no column for it: its columns are a contract."""
    films = {"one": "p0123456789abcdef", "two": "pfedcba9876543210"}

    def opened(film):
        return StickSession(session.trial, SPECIES, size=(640, 512), span=(0, 99), film=film)

    def kept():
        return sorted(films_of_poses(session.path).values())

    assert kept() == []  # a session that knows no film
    first = opened(films["one"])
    first.go(60)
    first.pose_here_too()
    # the pose that was there before may be of any film
    assert kept() == [films["one"]] * 2
    assert not [c for c in pd.read_csv(session.path) if "film" in c]
    # another film, in which one of the two is made again: the other is of the first still
    second = opened(films["two"])
    second.go(60)
    second.drag("body", 111.0, 122.0)
    second.set_length(0.9, "L2")
    assert kept() == [films["one"], films["two"]]
    second.undo()
    second.undo()
    assert kept() == [films["one"]] * 2
    session.path.with_suffix(".films.json").write_bytes(b"[\xff")
    assert kept() == []


def test_a_proposal_leaves_the_poses_of_other_frames(session):
    pose = natural_pose(SPECIES, frame=70, xy=(200.0, 200.0), scale=SCALE)
    session.go(50)
    session.pose_here_too()
    session.propose(SPECIES, pose)
    assert session.proposed
    assert read_start_pose(session.path, SPECIES)[1].frames.tolist() == [20, 50]
    session.accept()
    # it takes the place of the pose that was looked at
    assert read_start_pose(session.path, SPECIES)[1].frames.tolist() == [20, 70]


def test_ranges_are_advice_and_are_spoken_of(session):
    assert "within their range" in session.remarks()
    where = places(session)[0]
    back = 2 * where[0] - where[1]
    session.drag("L1.CT", *back)  # turned round
    # 180 degrees from its natural orientation; its range is 51 to both sides together
    assert session.pose.beyond()["L1.BC"] == pytest.approx(180 - 25.5, abs=0.01)
    assert "L1.BC by 154" in session.remarks()
    assert session.saved
    session.reset_leg("L1")
    assert session.pose.beyond() == {}
    session.drag("body", 10, 10)
    assert "out of the picture" in session.remarks()


def test_a_file_that_was_there_is_kept_beside(session):
    first = session.path.read_text()
    again = StickSession(session.trial, SPECIES, size=(640, 512), span=(0, 99))
    assert again.pose.xy == XY
    again.drag("body", 100, 100)
    assert session.path.with_name("start_pose.before.csv").read_text() == first


def test_what_cannot_be_dragged(session):
    for handle in ("L1.FP", "L1.BC", "L9", "L9.PT", "nose"):
        with pytest.raises(InputError):
            session.drag(handle, 10, 10)
    for leg in SPECIES.leg_names[1:]:
        session.toggle_missing(leg)
    with pytest.raises(InputError, match="last leg"):
        session.toggle_missing("L1")


def test_what_the_browser_gets_is_plain_json_and_complete(session):
    session.toggle_missing("R3")
    told = json.loads(json.dumps(describe(session)))
    assert told["xy"] == list(XY)
    assert [leg["missing"] for leg in told["legs"]] == [n == "R3" for n in SPECIES.leg_names]
    leg = told["legs"][0]
    assert leg["half"] == [25.5, 51.0, 0.0, 0.0, 41.5, 7.0, 59.5]  # half of Table 3.2
    assert leg["free"] == [True, True, False, False, True, True, True]
    np.testing.assert_allclose(leg["lengths"], SPECIES.leg("L1").lengths, rtol=1e-6)


def test_a_second_window_never_writes_over_the_pose_of_the_first(session):
    trial = session.trial
    other = StickSession(trial, SPECIES, size=(640, 512), span=(0, 99))
    session.drag("body", 200.0, 210.0)
    with pytest.raises(InputError, match="changed by another window or program since it was"):
        other.drag("body", 400.0, 310.0)
    assert other.pose.xy == XY  # not shown as if it were kept
    again = StickSession(trial, SPECIES, size=(640, 512), span=(0, 99))
    assert again.pose.xy == (200.0, 210.0)
    again.drag("body", 250.0, 210.0)
    with pytest.raises(InputError, match="run its cell"):
        session.undo()
    assert session.pose.xy == (200.0, 210.0)
    assert session.can_undo
    # a proposal is in no file yet, and can be looked at; taking it is refused as well
    session.propose(SPECIES, natural_pose(SPECIES, frame=20, xy=(90.0, 90.0), scale=SCALE))
    with pytest.raises(InputError, match="run its cell"):
        session.accept()
    assert StickSession(trial, SPECIES, size=(640, 512), span=(0, 99)).pose.xy == (250.0, 210.0)
