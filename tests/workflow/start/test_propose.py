"""Proposed starts against the truth of rendered scenes."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

import pawnb
from pawnb.core.paws.start_proposal import proposal as propose
from pawnb.errors import InputError
from pawnb.schema import START_COLUMNS
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import load_trial
from pawnb.workflow.start.sureness import sureness_in_words

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

# half a hind paw: 20 px in the paper's pictures, 2048 px wide; this scene is 410 px wide
HALF_PAW_PX = 20 * 0.2


def silent(done, total):
    """Show no progress."""


@pytest.fixture(scope="module")
def proposal(rendered_trial):
    return pawnb.propose_start(rendered_trial, progress=silent)


def off(proposal, folder):
    """Return every proposed point with its distance from the truth, px."""
    truth = pd.read_csv(folder / "truth" / "tracks.csv")
    both = proposal.start.merge(truth, on=["frame", "view", "point"], suffixes=("", "_true"))
    return both.assign(px=np.hypot(both["u"] - both["u_true"], both["v"] - both["v_true"]))


def test_every_paw_is_found_within_half_a_paw(proposal, rendered_trial):
    assert tuple(proposal.start.columns) == START_COLUMNS
    assert proposal.start["frame"].unique().tolist() == [proposal.frame]
    asked = [(v.name, p) for v in load_trial(rendered_trial).views for p in v.points]
    found = list(zip(proposal.start["view"], proposal.start["point"], strict=True))
    assert sorted(found) == sorted(asked)
    table = off(proposal, rendered_trial)
    assert len(table) == 8
    assert table["px"].max() < HALF_PAW_PX
    assert (table["visible"] == 1).all()


# CIELAB a* and b* of the paws are 14 and 14; of the belts 31 and -25, 34 and 0
@pytest.mark.parametrize("belt", [(110, 62, 120), (158, 83, 107)])
def test_paws_are_found_on_belts_as_red_as_they_are(tmp_path, monkeypatch, belt):
    settings = {"belt_rgb": belt, "n_views": 2}
    render_mouse_trial(tmp_path / "mouse", frames=60, scale=0.25, seed=4, settings=settings)
    proposal = pawnb.propose_start(tmp_path / "mouse", progress=silent)
    table = off(proposal, tmp_path / "mouse")
    assert len(table) == 4
    assert table["px"].max() < HALF_PAW_PX * 0.25 / 0.2
    assert proposal.sure > 0.5
    # what has the redness of half the picture is never sure
    monkeypatch.setattr(propose, "_LOOKS_IN_TURN", ("red",))
    with pytest.raises(InputError, match="shows the paws so clearly"):
        pawnb.propose_start(tmp_path / "mouse", progress=silent)


def test_how_sure_it_is_in_numbers_and_words(proposal):
    points = proposal.points
    assert points["point"].tolist() == ["FR", "HR", "FL", "HL"]
    assert points["sure"].between(0.1, 1.0).all()
    assert proposal.sure == points["sure"].min()
    assert [sureness_in_words(x) for x in points["sure"]] == points["words"].tolist()
    assert proposal.text().splitlines()[0].startswith(f"proposed start in frame {proposal.frame}")
    order = [sureness_in_words(x) for x in (0.0, 0.1, 0.3, 0.9)]
    assert order == [
        "not found, place it by hand", "unsure, check it", "fairly sure, look at it", "sure",
    ]  # fmt: skip


def test_a_proposal_is_a_start_for_the_tracker(proposal, rendered_trial):
    frames = (proposal.frame, proposal.frame + 1)
    tracks = pawnb.track(
        rendered_trial, start=proposal.start, frames=frames, method="paper", progress=silent
    )
    first = pawnb.tracks_table(tracks.isel(time=[0]))
    assert (first.dropna(subset=["u"])["origin"] == "edited").sum() == len(proposal.start)


def test_a_side_seen_by_one_view_is_found_on_the_ground(small_trial):
    trial = load_trial(small_trial)
    coefs = np.loadtxt(small_trial / "DLTcoefs.csv", delimiter=",")
    np.savetxt(small_trial / "DLTcoefs.csv", coefs[:, :3], delimiter=",")
    proposal = pawnb.propose_start(
        dataclasses.replace(trial, views=trial.views[:3]), progress=silent
    )
    table = off(proposal, small_trial)
    assert table.groupby("view")["point"].apply(set).to_dict() == {
        "cam1": {"FR", "HR"}, "cam2": {"FR", "HR"}, "cam3": {"FL", "HL"},
    }  # fmt: skip
    assert table["px"].max() < HALF_PAW_PX


def test_only_the_frames_asked_for_are_looked_through(rendered_trial):
    counted = []
    proposal = pawnb.propose_start(
        rendered_trial, frames=[4, 0, 2], progress=lambda done, total: counted.append((done, total))
    )
    assert proposal.frame in (0, 2, 4)
    # of three frames it is not sure, and looks again in two other ways
    assert proposal.sure < 0.25
    assert counted == [(k, 3 * -(-k // 3)) for k in range(1, 10)]


def test_what_cannot_be_proposed_is_said(rendered_trial):
    trial = load_trial(rendered_trial)
    with pytest.raises(InputError, match="found 40; expected some of 0 to 39"):
        pawnb.propose_start(trial, frames=[0, 40], progress=silent)
    with pytest.raises(InputError, match="found none"):
        pawnb.propose_start(trial, frames=[], progress=silent)
    with pytest.raises(InputError, match="is not calibrated"):
        pawnb.propose_start(dataclasses.replace(trial, calibration=None), progress=silent)
    snout = tuple(dataclasses.replace(view, points=("snout",)) for view in trial.views)
    with pytest.raises(InputError, match="found point 'snout'"):
        pawnb.propose_start(dataclasses.replace(trial, views=snout), frames=[0], progress=silent)
    alone = tuple(
        dataclasses.replace(view, points=(point,))
        for view, point in zip(trial.views, ("FR", "HR", "FL", "HL"), strict=True)
    )
    with pytest.raises(InputError, match="no point is tracked by two views"):
        pawnb.propose_start(dataclasses.replace(trial, views=alone), frames=[0], progress=silent)


def test_left_and_right_are_not_sure_where_axes_are_left_handed(small_trial):
    coefs = np.loadtxt(small_trial / "DLTcoefs.csv", delimiter=",")
    coefs[[1, 5, 9]] *= -1
    np.savetxt(small_trial / "DLTcoefs.csv", coefs, delimiter=",")
    proposal = pawnb.propose_start(small_trial, progress=silent)
    assert proposal.points["sure"].max() < 0.25
    assert "left and right" in proposal.text()


def test_paws_of_a_real_mouse_that_are_not_found_are_not_proposed(real_data):
    """One of four paws was called sure there, and was that of the other side."""
    with pytest.raises(InputError, match="click the points instead"):
        pawnb.propose_start(real_data("real-clips") / "mouse_wheel_two_views", progress=silent)


def test_parameters_are_set_by_the_caller_and_recorded(proposal, rendered_trial):
    assert proposal.parameters["found"] == 0.1
    # no paw is surer than 1, so that none is sure enough
    with pytest.raises(InputError, match="no frame shows the paws so clearly"):
        pawnb.propose_start(rendered_trial, settings={"paw_proposal.found": 1.5}, progress=silent)
    with pytest.raises(InputError, match="paw_proposal: unknown name 'find'"):
        pawnb.propose_start(rendered_trial, settings={"paw_proposal.find": 1}, progress=silent)
