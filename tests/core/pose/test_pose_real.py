"""The default pose tracker on real animals: a hanging orb weaver and a walking fly."""

from pathlib import Path

import numpy as np
import pytest

import pawnb
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.fit.explanation import fit_to_picture
from pawnb.core.pose.fit.tracker import track_pose
from pawnb.core.pose.poses import tip_positions

BENCHMARKS = str(Path(__file__).parents[3] / "benchmarks")


def _quality(animal, track):
    return pawnb.assess_quality(tracks_from_poses(animal, track, fps=25.0, view="top"))


@pytest.mark.slow
def test_legs_of_a_hanging_spider_from_a_disturbed_start(real_data, monkeypatch):
    monkeypatch.syspath_prepend(BENCHMARKS)
    import real_animals as real
    from pose_real import line_errors

    folder = real_data("spider-nephila")
    animal, drawn = real.spider_start(folder, frame=0)
    with real.opened(real.SPIDER, folder) as (reader, background):
        start = real.disturbed(drawn, 0)
        track = track_pose(reader, start, animal=animal, background=background, frames=(0, 601))
    assert _quality(animal, track).verdict == "good"
    # legs drawn by hand to 2 px; the aim is 6 px
    away = line_errors(animal, track.poses.at_frame(600), real.drawn_legs(folder))
    assert max(away.values()) < 6.0, away


@pytest.mark.slow
@pytest.mark.parametrize("frame", [0, 200, 570])
def test_the_start_pose_of_a_hanging_spider_does_not_depend_on_how_it_was_disturbed(
    real_data, monkeypatch, frame
):
    monkeypatch.syspath_prepend(BENCHMARKS)
    import real_animals as real
    from pose_real import line_errors

    folder = real_data("spider-nephila")
    animal, drawn = real.spider_start(folder, frame=frame)
    lines, found = real.drawn_legs(folder), []
    with real.opened(real.SPIDER, folder) as (reader, background):
        for seed in range(5):
            pose, _ = fit_to_picture(
                reader.frame(frame), real.disturbed(drawn, seed), animal=animal,
                background=background,
            )  # fmt: skip
            found.append(line_errors(animal, pose, lines))
    # she hangs still, so what was drawn in frame 600 holds in all of these frames
    good = np.mean([px < 6.0 for away in found for px in away.values()])
    assert good >= 0.98, found


@pytest.mark.slow
@pytest.mark.parametrize("seed", [None, 0])
def test_most_leg_tips_of_a_walking_fly(real_data, monkeypatch, seed):
    monkeypatch.syspath_prepend(BENCHMARKS)
    import real_animals as real

    folder = real_data("flies-topview") / "clip_inverted"
    animal, start = real.fly_start(folder)
    start = start if seed is None else real.disturbed(start, seed)
    tips = real.fly_tips(folder)
    tips = tips[tips["score"] > 0.5]
    with real.opened(real.FLY, folder) as (reader, background):
        frames = (0, reader.n_frames)
        track = track_pose(reader, start, animal=animal, background=background, frames=frames)
    found = tip_positions(animal, track.poses)
    legs = [animal.leg_names.index(leg) for leg in tips["leg"]]
    away = np.hypot(*(found[tips["frame"], legs] - tips[["u", "v"]].to_numpy()).T)
    near = {leg: np.mean(away[tips["leg"] == leg] <= 12.0) for leg in animal.leg_names}
    # 12 px is the aim, three times what SLEAP's points are good to; hind legs hide under the wings,
    # which are spread in the first 18 of these frames and folded later
    assert min(near["L1"], near["R1"], near["L2"], near["R2"]) > 0.7, near
    assert min(near["L3"], near["R3"]) > 0.5, near
    assert np.mean(away <= 12.0) >= 0.75, near
    # by SLEAP where it is sure, 89 and 91 % are right
    told = _quality(animal, track)
    sure = tips["score"].to_numpy() > 0.7
    assert told.verdict == "look"
    assert abs(told.expected_right - np.mean(away[sure] <= 12.0)) < 0.05
