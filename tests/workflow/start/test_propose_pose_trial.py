"""A proposed start pose and the grid's scale of a rendered spider."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

import pawnb
from pawnb.core.pose.pose_table import read_start_pose
from pawnb.core.pose.poses import tip_positions
from pawnb.errors import InputError, InputWarning
from pawnb.synthetic import render_spider_trial
from pawnb.trial import load_trial
from pawnb.workflow.calibration.scale import find_grid_scale
from pawnb.workflow.start.propose_pose import PoseStart, propose_pose_start
from pawnb.workflow.start.sureness import SURE_FROM


def silent(done, total):
    """Show no progress."""


@pytest.fixture(scope="module")
def spider(tmp_path_factory):
    folder = tmp_path_factory.mktemp("spider") / "trial"
    return render_spider_trial(folder, frames=16, scale=0.5, seed=1, motion="still").parent


@pytest.fixture(scope="module")
def proposal(spider):
    return pawnb.propose_start(spider, progress=silent)


def test_the_proposal_is_right(proposal, spider):
    assert isinstance(proposal, PoseStart)
    truth = pd.read_csv(spider / "truth" / "pose.csv").set_index("frame").loc[proposal.frame]
    span = proposal.animal.span * truth["scale"]
    assert np.hypot(*(proposal.pose.xy[0] - truth[["x", "y"]])) < 0.03 * span
    assert abs((proposal.pose.heading_deg[0] - truth["heading"] + 180) % 360 - 180) < 5
    tracks = pd.read_csv(spider / "truth" / "tracks.csv")
    tips = tracks[tracks["frame"] == proposal.frame].set_index("point")[["u", "v"]]
    off = (
        tip_positions(proposal.animal, proposal.pose)[0] - tips.loc[list(proposal.animal.leg_names)]
    )
    assert np.hypot(off["u"], off["v"]).max() < 0.05 * span


def test_how_sure_it_is_in_numbers_and_words(proposal):
    assert proposal.legs["leg"].tolist() == list(proposal.animal.leg_names)
    assert proposal.legs["sure"].between(0, 1).all()
    assert proposal.sure == proposal.legs["sure"].min()
    lines = proposal.text().splitlines()
    assert lines[0].startswith(f"proposed start pose in frame {proposal.frame}: {proposal.words}")
    assert len(lines) == 9 + len(proposal.notes)


def test_it_is_saved_as_the_start_pose(proposal, tmp_path):
    path = proposal.save(tmp_path / "start_pose.csv")
    animal, poses = read_start_pose(path, proposal.animal)
    assert poses.frames.tolist() == [proposal.frame]
    np.testing.assert_allclose(
        tip_positions(animal, poses), tip_positions(proposal.animal, proposal.pose), atol=0.01
    )


def test_frames_outside_the_trial_are_refused(spider):
    with pytest.raises(InputError, match="expected some of 0 to 15"):
        pawnb.propose_start(spider, frames=[99], progress=silent)


@pytest.mark.slow
def test_the_grid_of_the_rendered_panel(spider):
    # 4.84 px per mm at full size (section 4.1 of the thesis: 0.557 px = 0.023 cm at half of it)
    found = find_grid_scale(spider, spacing=10.0)
    assert found.px_per_unit == pytest.approx(2.42, rel=5e-3)


@pytest.mark.slow
def test_parameters_are_those_of_the_trial_and_recorded(proposal, spider):
    assert proposal.parameters["noise_sds"] == 4.0
    trial = load_trial(spider)
    # nothing is so far from the background: grey values end at 255
    trial = dataclasses.replace(trial, tracking={"pose_proposal": {"noise_sds": 1000.0}})
    with pytest.raises(InputError, match="no animal was found whole"):
        pawnb.propose_start(trial, progress=silent)


HANGING = """[trial]
kind = "pose"
name = "n"
fps = 60.0
frames = [600, 661]
[animal]
id = "n"
species = "spider"
[[views]]
name = "top"
video = "spider_video.mp4"
crop = [1000, 20, 1280, 360]
"""


@pytest.mark.slow
def test_legs_that_are_not_found_for_want_of_an_empty_scene_are_said_to_be(real_data, tmp_path):
    """A spider hangs still throughout: she is in the median of all frames as well."""
    folder, picture = real_data("spider-nephila"), "background_synth_without_female.png"
    for name in ("spider_video.mp4", picture):
        (tmp_path / name).symlink_to(folder / name)
    (tmp_path / "trial.toml").write_text(HANGING)
    with pytest.warns(InputWarning, match="no empty frames"):
        found = pawnb.propose_start(tmp_path, progress=silent)
    assert not (found.legs["sure"] >= 0.5).all()
    assert any("a picture of the empty scene (background)" in note for note in found.notes)
    (tmp_path / "trial.toml").write_text(HANGING + f'background = "{picture}"\n')
    found = pawnb.propose_start(tmp_path, progress=silent)
    assert (found.legs["sure"] >= 0.5).all()
    assert not any("background" in note for note in found.notes)


@pytest.mark.slow
def test_a_leg_that_lies_on_the_edge_of_a_wing_is_not_sure(real_data, tmp_path):
    folder = real_data("flies-topview") / "clip_inverted"
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "pose"\nname = "fly"\nfps = 25.0\n[animal]\nid = "f"\nspecies = "insect"\n'
        f'[[views]]\nname = "top"\nvideo = "{folder}/frame*.png"\n'
        f'background = "{folder}/background.png"\n'
    )
    start = propose_pose_start(tmp_path, progress=lambda *_: None)
    tips = pd.read_csv(folder / "points.csv").set_index(["frame", "node"])
    u, v = tips.loc[(start.frame, "hindlegL4"), ["x", "y"]]
    animal, pose = start.animal, start.pose
    tip = tip_positions(animal, pose)[0, animal.leg_names.index("L3")]
    sure = start.legs.set_index("leg")["sure"]
    # SLEAP, with a score of 0.89, has the tip of that leg elsewhere
    assert np.hypot(*(tip - [u, v])) > 20.0
    assert sure["L3"] < SURE_FROM
    assert (sure.drop("L3") >= SURE_FROM).all()
