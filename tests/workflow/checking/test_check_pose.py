"""``pawnb check`` on a jointed animal."""

from __future__ import annotations

import cv2
import numpy as np
import pandas as pd
import pytest

from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.video import open_views
from pawnb.errors import InputWarning
from pawnb.trial import load_trial
from pawnb.widgets.stick_poser import StickPoser
from pawnb.workflow.checking.check import check_trial
from pawnb.workflow.tracking.track import track


def test_a_whole_trial_has_no_faults(rendered_spider):
    report = check_trial(rendered_spider)
    assert report.faults == []
    assert report.doubts == []
    text = report.text()
    for words in (
        "kind pose, animal spider-01, 125 frames per second",
        "view top: 24 frames of 384 x 307 px, grey",
        "species dolomedes: 8 legs, 43 degrees of freedom",
        "background: frames 0 to 9",
        "start pose: L1, L2, L3, L4, R1, R2, R3, R4 in frame 10",
    ):
        assert f"ok    {words}" in text


def change(folder, old, new):
    path = folder / "trial.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('species = "dolomedes"', 'species = "mine.toml"', "neither a built-in species"),
        ("    0,\n    10,", "    0,\n    30,", "background_frames is [0, 30]"),
        ("background_frames = [\n    0,\n    10,\n]", 'background = "empty.png"', "empty.png"),
        ('pose = "start_pose.csv"', 'pose = "other.csv"', "other.csv: no such file"),
        ("[start]", "[tracking]\nblurr = 1\n[start]", "unknown name 'blurr'"),
    ],
)
def test_faults_of_the_trial_are_found(small_spider, old, new, fault):
    change(small_spider, old, new)
    report = check_trial(small_spider)
    assert len(report.faults) == 1
    assert fault in report.faults[0]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"x": 900.0}, "outside the picture of 384 x 307 px"),
        ({"frame": 200}, "start pose of frame 200; the recording has frames 0 to 23"),
        ({"L1_BC": "x"}, "column 'L1_BC' is 'x'; expected a number"),
        ({"L9_BC": 1.0}, "unknown column 'L9_BC'"),
        ({"y": 20.0}, "is off the animal: 0 % of its body lies on what differs"),
    ],
)
def test_faults_of_the_start_pose_are_found(small_spider, changes, fault):
    path = small_spider / "start_pose.csv"
    pd.read_csv(path).assign(**changes).to_csv(path, index=False)
    report = check_trial(small_spider)
    assert len(report.faults) == 1
    assert fault in report.faults[0]


def test_a_pose_on_the_smaller_of_two_animals_is_no_fault(small_spider):
    """The spider's fellow beside it is 2 px thicker all around: the outline is the fellow's."""
    trial = load_trial(small_spider)
    with open_views(trial) as views:
        pictures = [views.frame(i)["top"].image().astype(np.int16) for i in range(24)]
    folder = small_spider / "twice"
    folder.mkdir()
    for i, picture in enumerate(pictures):
        fellow = cv2.erode(np.roll(picture - pictures[0], 130, axis=1), np.ones((5, 5)))
        beside = np.minimum(fellow, 0) if i >= 10 else 0
        cv2.imwrite(
            str(folder / f"{i:03d}.png"), np.clip(picture + beside, 0, 255).astype(np.uint8)
        )
    change(small_spider, 'video = "spider.avi"', 'video = "twice"')
    report = check_trial(small_spider)
    assert report.faults == []
    assert any("perhaps a second animal" in doubt for doubt in report.doubts)


@pytest.mark.slow
def test_joints_out_of_range_an_odd_size_and_the_edge_are_doubted(small_spider):
    path = small_spider / "start_pose.csv"
    start = pd.read_csv(path)
    # Tables 3.1 and 3.2 of Pullar 2009: the joint is at 35 degrees, its whole range 51
    start.assign(L1_BC=35 + 25.5 + 20).to_csv(path, index=False)
    (doubt,) = check_trial(small_spider).doubts
    assert doubt == "start pose of frame 10: joints beyond their range: L1_BC by 20 degrees"
    start.assign(scale=start["scale"] * 2.5).to_csv(path, index=False)
    doubts = check_trial(small_spider).doubts
    assert any("times as large as its species file says" in doubt for doubt in doubts)
    left = int(pd.read_csv(small_spider / "truth" / "tracks.csv")["u"].min()) + 8
    crop = f'video = "spider.avi"\ncrop = [{left}, 0, 384, 307]'
    change(small_spider, 'video = "spider.avi"', crop)
    start.assign(x=start["x"] - left).to_csv(path, index=False)
    doubts = check_trial(small_spider).doubts
    assert any("touches the edge of the picture" in doubt for doubt in doubts)


@pytest.mark.slow
def test_a_heading_against_the_way_the_animal_goes_is_doubted(small_spider):
    """A running spider posed the wrong way round was tracked as *good*, each leg as another."""
    start = pd.read_csv(small_spider / "start_pose.csv")
    turn = np.radians(start["heading"].iloc[0])
    with open_views(load_trial(small_spider)) as views:
        pictures = [views.frame(i)["top"].image().astype(np.int16) for i in range(24)]
    (small_spider / "goes").mkdir()
    for i, picture in enumerate(pictures):  # 0.8 px a frame, into the picture
        by = np.round(0.8 * (10 - i) * np.array([np.sin(turn), np.cos(turn)])).astype(int)
        moved = pictures[0] + np.roll(picture - pictures[0], by if i > 10 else (0, 0), (0, 1))
        cv2.imwrite(str(small_spider / "goes" / f"{i:03d}.png"), np.clip(moved, 0, 255))
    change(small_spider, 'video = "spider.avi"', 'video = "goes"')
    (doubt,) = [d for d in check_trial(small_spider).doubts if "backwards" in d]
    assert doubt.startswith("start pose of frame 10: the animal goes backwards from frame 10 to")
    assert "its heading is the wrong way round" in doubt
    turned = start.assign(heading=start["heading"] + 180.0)
    turned.to_csv(small_spider / "start_pose.csv", index=False)
    assert not [d for d in check_trial(small_spider).doubts if "backwards" in d]


@pytest.mark.slow
def test_sizes_are_compared_in_the_unit_of_the_species_file(small_spider):
    # 1.452 px per mm
    change(small_spider, 'px_per_unit = 1.452\nunit = "mm"', 'px_per_unit = 14.52\nunit = "cm"')
    assert check_trial(small_spider).doubts == []
    change(small_spider, 'unit = "cm"', 'unit = "mm"')
    (doubt,) = check_trial(small_spider).doubts
    # dolomedes.toml: a body of 28.2 mm; the pose is 0.8 as large as the scale for perspective
    assert "by px_per_unit the body is" in doubt
    assert "mm long" in doubt


def test_background_frames_with_the_animal_and_pixels_without_scale_are_doubted(small_spider):
    change(small_spider, "    0,\n    10,", "    8,\n    12,")
    change(small_spider, "[calibration]\npx_per_unit = 1.452", "[calibration]")
    doubts = check_trial(small_spider).doubts
    assert any(
        doubt.startswith("something moves in the background, frames 8 to 11") for doubt in doubts
    )
    assert "no px_per_unit in [calibration]: positions will be in px" in doubts


@pytest.mark.slow
def test_a_film_put_for_that_which_was_posed_is_said_wherever_its_pose_is_used(small_spider):
    """As where another run is saved under the name of a film: its pose was taken without a word."""
    pose, trial = small_spider / "start_pose.csv", load_trial(small_spider)
    widget = StickPoser(trial)
    widget.session.take(*read_start_pose(pose, widget.session.species))
    widget.close()
    assert "another film" not in widget.status
    assert not [doubt for doubt in check_trial(small_spider).doubts if "another film" in doubt]
    with open_views(trial) as views:
        pictures = [views.frame(i)["top"].image() for i in range(24)]
    (small_spider / "other").mkdir()
    for i, picture in enumerate(pictures):  # in another light
        light = np.where(np.arange(picture.shape[1]) // 40 % 2, 1.0, 0.7)
        cv2.imwrite(
            str(small_spider / "other" / f"{i:03d}.png"), (picture * light).astype(np.uint8)
        )
    change(small_spider, 'video = "spider.avi"', 'video = "other"')
    said = "the poses of view top were made in another film than it shows now"
    assert sum(doubt.startswith(said) for doubt in check_trial(small_spider).doubts) == 1
    again = StickPoser(small_spider)
    again.close()
    assert said in again.status
    with pytest.warns(InputWarning, match=said):
        track(small_spider, frames=(10, 12), settings={"choose_path": False})
