"""Joint ranges: Tables 4.6 and 5.1 of Pullar (2009) from animals made to have them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pawnb.errors import InputError
from pawnb.gait.joints import (
    ANGLE_COLUMNS,
    RANGE_COLUMNS,
    get_joint_angles,
    joint_extremes,
    joint_range_table,
)

# paper 2009: Table 4.6 (max, min; coxa-trochanter of leg 4 as in the text), Table 3.2
# (mechanical ranges) and Table 5.1 (percent), legs 1 to 4
MAXIMA = {"BC": (61, 54, 11, -21), "CT": (48, 44, 22, 2), "PT": (22, 26, 17, 7)}
MINIMA = {"BC": (10, -4, -53, -54), "CT": (-21, -27, -21, -28), "PT": (-37, -27, -16, -9)}
WHOLE = {"BC": (51, 65, 67, 54), "CT": (102, 102, 46, 56), "PT": (83, 68, 36, 17)}
SHARE = {"BC": (100, 91, 96, 61), "CT": (68, 70, 93, 54), "PT": (71, 78, 92, 88)}


def pose_of(shift, *, frames=41):
    """Return poses in which every joint swings once between its extremes, moved by shift."""
    swing = np.linspace(0, 1, frames)
    columns = {"frame": np.arange(frames), "L1_BC_sd": np.full(frames, 99.0)}
    for joint in MAXIMA:
        for k in range(4):
            low, high = MINIMA[joint][k], MAXIMA[joint][k]
            for side in "LR":
                columns[f"{side}{k + 1}_{joint}"] = low + (high - low) * swing + shift
    columns["L1_Co_px"] = np.full(frames, 500.0)
    return pd.DataFrame(columns)


def mechanical():
    rows = [
        (joint, f"{s}{k + 1}", WHOLE[joint][k]) for joint in WHOLE for k in range(4) for s in "LR"
    ]
    return pd.DataFrame(rows, columns=["joint", "leg", "range_deg"])


def study():
    # two animals moved by -3 and +3 degrees; the second has two trials
    return pd.concat(
        [
            get_joint_angles(pose_of(-3.0), animal="a", trial="1"),
            get_joint_angles(pose_of(1.0), animal="b", trial="1"),
            get_joint_angles(pose_of(5.0), animal="b", trial="2"),
        ]
    )


def test_tables_of_the_paper():
    table = joint_range_table(study(), mechanical=mechanical())
    assert tuple(table.columns) == RANGE_COLUMNS
    assert table["joint"].tolist() == ["BC"] * 4 + ["CT"] * 4 + ["PT"] * 4
    assert table["pair"].tolist() == ["1", "2", "3", "4"] * 3
    for joint in MAXIMA:
        own = table[table["joint"] == joint]
        np.testing.assert_allclose(own["max_mean_deg"], MAXIMA[joint])
        np.testing.assert_allclose(own["min_mean_deg"], MINIMA[joint])
        # the paper rounds ranges apart from extremes (59 for 54 + 4), so shares agree to a degree
        moved = own["share_percent"] * own["mechanical_deg"] / 100.0
        printed = np.array(SHARE[joint]) * WHOLE[joint] / 100.0
        np.testing.assert_allclose(moved, printed, atol=1.2)
    # animals count, not trials: means of -3 and 3, of which the deviation is 3 sqrt 2
    np.testing.assert_allclose(table["max_sd_deg"], 3 * np.sqrt(2))
    np.testing.assert_allclose(table["range_sd_deg"], 0.0, atol=1e-9)
    assert set(table["n_animals"]) == {2}
    twin = joint_range_table(study(), mechanical=mechanical().assign(range_deg=60.0))
    assert not np.allclose(twin["share_percent"][:4], SHARE["BC"], atol=5.0)


def test_one_wrong_frame_can_be_trimmed():
    angles = study()
    angles.iloc[20, angles.columns.get_loc("angle_deg")] = 170.0
    angles.iloc[21, angles.columns.get_loc("angle_deg")] = -170.0
    wild = joint_extremes(angles)
    tame = joint_extremes(angles, trim=0.05)
    assert wild["max_deg"].max() == 170.0
    assert tame["max_deg"].max() < 66.0
    assert wild["min_deg"].min() == -170.0
    assert tame["min_deg"].min() > -60.0
    assert set(tame["n_frames"]) == {41}


def test_angles_from_tracks_are_those_of_the_table():
    pose = pose_of(0.0)
    names = [c for c in pose if c.split("_")[-1] in MAXIMA]
    values = pose[names].to_numpy()[:, :, None]
    tracks = xr.Dataset(
        {"joint_angle": (("time", "joint", "individual"), values)},
        coords={"joint": names, "individual": ["a"]},
    )
    found = get_joint_angles(tracks, trial="1")
    expected = get_joint_angles(pose, animal="a", trial="1")
    assert tuple(found.columns) == ANGLE_COLUMNS
    assert set(found["joint"]) == set(MAXIMA)  # neither standard deviations nor lengths
    key = list(ANGLE_COLUMNS)
    pd.testing.assert_frame_equal(
        found.sort_values(key, ignore_index=True), expected.sort_values(key, ignore_index=True)
    )


def test_legs_without_a_place_stand_alone():
    pose = pd.DataFrame({"tail_KN": [0.0, 10.0], "FL_KN": [0.0, 30.0], "FR_KN": [0.0, 50.0]})
    table = joint_range_table(get_joint_angles(pose, animal="a"))
    assert table["pair"].tolist() == ["1", "tail"]
    assert table["range_mean_deg"].tolist() == [40.0, 10.0]
    assert table["range_sd_deg"].isna().all()
    assert table["share_percent"].isna().all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: get_joint_angles(pose_of(0.0)), r"^joint angles: give the animal, for pose\.csv"),
        (lambda: get_joint_angles(pd.DataFrame({"x": [1.0]}), animal="a"), r"none found; expected"),
        (lambda: get_joint_angles(xr.Dataset()), r"these tracks have no joint_angle"),
        (lambda: joint_extremes(study(), trim=0.5), r"^joint angles: 2952 angles, trim 0\.5; exp"),
        (lambda: joint_extremes(study().drop(columns="leg")), r"leg"),
        (
            lambda: joint_range_table(study(), mechanical=mechanical().assign(range_deg=-1.0)),
            r"^mechanical ranges: a range is negative or missing; expected degrees\.$",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.slow
def test_smoothed_angles_have_their_true_range_and_gaps_are_not_bridged():
    """A joint of 20 degrees' range and one that is still, each with errors of 1 degree.

    The extremes of 120 normal errors are 2.6 SD away on average (Tippett 1925).
    """
    rng = np.random.default_rng(3)
    frames = np.arange(120)
    moves, still = 10.0 * np.sin(frames / 4.0), np.full(120, -5.0)
    pose = pd.DataFrame({"frame": frames, "L1_BC": moves, "L1_CT": still})
    pose[["L1_BC", "L1_CT"]] += rng.normal(size=(120, 2))
    ranges = {
        smooth: joint_extremes(get_joint_angles(pose, animal="a", smooth=smooth)).set_index("joint")
        for smooth in (False, True)
    }
    assert ranges[False]["range_deg"]["CT"] > 4.0
    assert ranges[False]["range_deg"]["BC"] > 22.0
    assert ranges[True]["range_deg"]["CT"] < 2.0
    assert ranges[True]["range_deg"]["BC"] == pytest.approx(20.0, abs=1.2)
    # frames without a row part a joint's angles; what is shorter than five frames is left out
    steps = pose.assign(L1_BC=np.where(frames < 60, 0.0, 90.0), L1_CT=0.0)
    parted = steps[~steps["frame"].between(50, 59) & ~steps["frame"].between(100, 116)]
    angles = get_joint_angles(parted, animal="a", smooth=True)
    own = angles.loc[angles["joint"] == "BC", "angle_deg"].to_numpy()
    np.testing.assert_allclose(own, np.r_[np.zeros(50), np.full(40, 90.0)], atol=1e-6)
    few = get_joint_angles(pose.head(3), animal="a", smooth=True)
    np.testing.assert_array_equal(few["angle_deg"], np.r_[pose["L1_BC"][:3], pose["L1_CT"][:3]])
