"""start_pose.csv and pose.csv."""

import numpy as np
import pytest

from pawnb.core.pose.pose_table import (
    animal_factors,
    pose_names,
    pose_table,
    read_start_pose,
    write_start,
)
from pawnb.core.pose.poses import Poses, natural_pose
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.io.pose import read_pose, write_pose

DOLOMEDES = load_species("dolomedes")


def _read(tmp_path, text):
    path = tmp_path / "start_pose.csv"
    path.write_text(text)
    return read_start_pose(path, DOLOMEDES)


def test_a_joint_left_out_is_natural_and_lengths_follow_the_scale(tmp_path):
    animal, poses = _read(
        tmp_path, "frame,x,y,heading,scale,L1_BC,R4_MT\n7,310.5,200,-90,2.4,50,\n"
    )
    assert animal == DOLOMEDES
    assert poses.frames.tolist() == [7]
    assert poses.xy.tolist() == [[310.5, 200.0]]
    assert (poses.heading_deg[0], poses.scale[0]) == (-90.0, 2.4)
    # Table 3.2 of Pullar 2009: the body-coxa joint of leg 2 is at 90 - 76 degrees
    assert poses.angles_deg[0, animal.joints.index("L1_BC")] == 50.0
    assert poses.angles_deg[0, animal.joints.index("L2_BC")] == 14.0
    assert poses.angles_deg[0, animal.joints.index("R4_MT")] == 0.0
    # Table 3.1: the tibia of leg 1 is 7.1 mm
    assert poses.lengths_px[0, animal.segments.index("L1_Ti")] == pytest.approx(2.4 * 7.1)


def test_proportions_are_read_and_written_again(tmp_path):
    animal, poses = _read(
        tmp_path,
        "frame,x,y,heading,scale,L1_scale,L2_scale,R1_Ti_scale\n9,1,2,3,4,0,1.2,0.5\n8,1,2,3,4,,,\n",
    )
    assert animal.leg_names == ("L2", "L3", "L4", "R1", "R2", "R3", "R4")
    assert poses.frames.tolist() == [8, 9]
    assert animal.leg("L2").lengths[2] == pytest.approx(1.2 * 8.5)
    assert animal.leg("R1").lengths[4] == pytest.approx(0.5 * 7.1)
    assert animal_factors(animal, DOLOMEDES) == {"L1": 0.0, "L2": 1.2, "R1_Ti": 0.5}
    again = write_start(tmp_path / "again.csv", animal, poses, species=DOLOMEDES)
    animal_again, poses_again = read_start_pose(again, DOLOMEDES)
    assert animal_factors(animal_again, animal) == {}
    np.testing.assert_allclose(poses_again.lengths_px, poses.lengths_px)
    np.testing.assert_allclose(poses_again.angles_deg, poses.angles_deg, atol=1e-4)


def test_pose_csv_has_the_columns_of_the_contract_and_is_a_start_too(tmp_path):
    pose = natural_pose(DOLOMEDES, frame=3, xy=(50.123456789, 60), heading_deg=10, scale=2)
    pose = Poses(**{**vars(pose), "lengths_px": pose.lengths_px * 0.9})
    names = pose_names(DOLOMEDES)
    table = pose_table(DOLOMEDES, plain_track(DOLOMEDES, pose))
    path = write_pose(table, tmp_path / "pose.csv", names=names)
    head = path.read_text().splitlines()[0].split(",")
    assert head[:9] == ["frame", "x", "y", "heading", "L1_BC", "L1_CT", "L1_PT", "L1_TM", "L1_MT"]
    # 43 degrees of freedom, of which 40 are joints; then scale, and 8 legs of 7 segments
    assert head[44] == "scale"
    assert head[45] == "L1_Co_px"
    assert len(head) == 45 + 56
    _, again = read_start_pose(path, DOLOMEDES)
    np.testing.assert_allclose(again.lengths_px, pose.lengths_px, atol=1e-4)
    assert read_pose(path, names=names)["x"][0] == pytest.approx(50.123457, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("frame,x,y,heading\n1,2,3,4\n", "column 'scale' is missing"),
        ("frame,x,y,heading,scale,L1_BD\n1,2,3,4,5,6\n", "did you mean 'L1_BC'"),
        ("frame,x,y,heading,scale,L1_TF\n1,2,3,4,5,6\n", "unknown column 'L1_TF'"),
        ("frame,x,y,heading,scale\n", "no rows"),
        ("frame,x,y,heading,scale\n1,2,3,4,5\n1,2,3,4,5\n", "frame 1 is there twice"),
        ("frame,x,y,heading,scale\n-1,2,3,4,5\n", "counted from 0"),
        ("frame,x,y,heading,scale\n1,2,,4,5\n", "line 2, column 'y' is empty"),
        ("frame,x,y,heading,scale\n1,2,3,4,0\n", "scale is 0; expected px above 0"),
        ("frame,x,y,heading,scale,L1_scale\n1,2,3,4,5,1\n2,2,3,4,5,2\n", "keeps its proportions"),
        ("frame,x,y,heading,scale,L1_scale\n1,2,3,4,5,-1\n", "expected a factor above 0"),
        ("frame,x,y,heading,scale,L1_Ti_scale\n1,2,3,4,5,0\n", "expected a factor above 0"),
    ],
)
def test_faults_are_named(tmp_path, text, match):
    with pytest.raises(InputError, match=match):
        _read(tmp_path, text)
