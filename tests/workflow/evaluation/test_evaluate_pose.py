"""The thesis's tables 4.1 and 4.2 on a person's own recording, from Python and the command line."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "core" / "pose"))
from walking_poses import walking_poses

from pawnb.cli import main
from pawnb.core.pose.as_tracks import tracks_from_poses
from pawnb.core.pose.poses import join_poses
from pawnb.core.pose.species_file import load_species
from pawnb.core.pose.track_result import plain_track
from pawnb.errors import InputError
from pawnb.io.native import write_tracks
from pawnb.schema import make_tracks
from pawnb.trial import Animal, Trial
from pawnb.workflow.evaluation.against_truth import PoseTruth
from pawnb.workflow.evaluation.evaluate_pose import evaluate_directions, evaluate_still

ANIMAL = load_species("spider")


@pytest.fixture
def still(tmp_path):
    """Tracks of 30 frames: the animal stands, and x errs by 1 and -1 px in turn; then it leaps."""
    poses = join_poses([walking_poses(ANIMAL, 1)] * 30)
    poses.frames[:] = np.arange(30)
    poses.xy[:20, 0] += np.where(np.arange(20) % 2, 1.0, -1.0)
    poses.xy[20:, 0] += 50.0
    return write_tracks(
        tracks_from_poses(ANIMAL, plain_track(ANIMAL, poses), fps=125.0, view="top"),
        tmp_path / "tracks.nc",
    )


@pytest.mark.slow
def test_jitter_is_that_of_the_frames_asked_for(still, tmp_path, capsys):
    found = evaluate_still(still, frames=(0, 19))
    x = found.tables["still"].set_index("measure").loc["x"]
    assert x["range"] == pytest.approx(2.0)
    assert x["sd"] == pytest.approx(np.sqrt(20 / 19))  # n - 1
    assert main(["evaluate", str(still), "--still", "0", "19", "--out", str(tmp_path / "e")]) == 0
    assert "x: 1.03 (2) px" in capsys.readouterr().out
    assert len(pd.read_csv(tmp_path / "e" / "evaluation_still.csv")) > 20


def test_frames_that_were_not_tracked_are_refused(still):
    with pytest.raises(InputError, match=r"^frames 5 to 5000 were asked for; the results have"):
        evaluate_still(still, frames=(5, 5000))


@pytest.mark.parametrize("disturb", [{"disturb_px": -1.0}, {"disturb_deg": float("nan")}])
def test_a_disturbance_that_cannot_be_is_refused(tmp_path, disturb):
    # refused before anything is opened or tracked
    trial = Trial(kind="pose", name="t", fps=100.0, animal=Animal(id="a"), folder=tmp_path)
    with pytest.raises(InputError, match=r"^disturb is .*; expected numbers, 0 or more"):
        evaluate_directions(trial, **disturb)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["truth", "--method", "paper"], "--method is for --directions and would not be heeded"),
        (["truth", "--disturb", "1", "2"], "--disturb is for --directions and would not be"),
        (["--still", "0", "5", "--threshold", "5"], "--threshold is for TRUTH and would not be"),
    ],
)
def test_an_option_of_another_question_is_refused(tmp_path, capsys, words, said):
    """``--method paper`` beside a truth printed the errors of another method, as if it were its."""
    assert main(["evaluate", str(tmp_path), *words]) == 2
    assert said in capsys.readouterr().err


def test_a_threshold_of_poses_is_refused(tmp_path):
    """The same errors were printed whatever it was."""
    with pytest.raises(InputError, match=r"^a threshold of 5 px is for points"):
        PoseTruth().measure(make_tracks([0], ["body"], fps=100.0), tmp_path, threshold_px=5.0)


def test_one_question_at_a_time(still, capsys):
    assert main(["evaluate", str(still)]) == 2
    assert "expected one of TRUTH, --still FIRST LAST and --directions" in capsys.readouterr().err
    assert main(["evaluate", str(still), "truth", "--directions"]) == 2
    with pytest.raises(InputError, match="two poses or more; found 1"):
        evaluate_still(still, frames=(5, 5))


def test_directions_are_for_jointed_animals(small_trial):
    with pytest.raises(InputError, match="jointed animals"):
        evaluate_directions(small_trial)


@pytest.mark.slow
def test_both_directions_agree_on_a_still_spider(small_spider, capsys):
    """From start poses disturbed by 3 px and 3 degrees: heading and leg angles within a degree."""
    assert main(["evaluate", str(small_spider), "--directions", "--disturb", "3", "3"]) == 0
    out = capsys.readouterr().out
    assert "frames 10 to 23, forwards against reverse" in out
    values = {line.split(":")[0]: float(line.split()[-2]) for line in out.splitlines()[1:]}
    assert values["heading"] < 0.5
    legs = [value for name, value in values.items() if name.startswith("total leg")]
    assert len(legs) == 4
    assert np.median(legs) < 1.0
