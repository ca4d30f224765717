"""ClickInitialiser with proposed paws: accepted, left to be clicked, or impossible."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from pawnb.trial import load_trial
from pawnb.widgets import ClickInitialiser


@pytest.fixture
def opened(small_trial):
    made = []

    def open_it(trial, **options):
        made.append(ClickInitialiser(trial, path=small_trial / "new.csv", **options))
        return made[-1]

    yield open_it
    for widget in made:
        widget.close()


@pytest.mark.slow
def test_proposed_paws_are_taken_at_a_press(small_trial, opened):
    widget = opened(small_trial, propose=True)
    assert widget.status.startswith("Proposed points are dashed: drag those that are wrong, then ")
    assert "Proposed: FR " in widget.status
    assert "Not accepted yet: FR, HR, FL, HL." in widget.status
    assert widget.actions[0]["text"] == "Accept all"
    seen = widget.overlay(widget.frame)["views"].values()
    assert {chip["state"] for view in seen for chip in view["chips"]} == {"predicted"}
    assert not (small_trial / "new.csv").exists()
    widget.edit("action", {"action": "accept", "frame": widget.frame})
    assert "roposed" not in widget.status
    taken = pd.read_csv(small_trial / "new.csv")
    truth = pd.read_csv(small_trial / "truth" / "tracks.csv")
    both = taken.merge(truth, on=["frame", "view", "point"], suffixes=("", "_true"))
    assert len(both) == 8
    # half a hind paw, in pictures a fifth of 2048 px wide
    assert np.hypot(both["u"] - both["u_true"], both["v"] - both["v_true"]).max() < 20 / 5


@pytest.mark.slow
def test_landmarks_are_left_to_be_clicked(small_trial, opened):
    trial = load_trial(small_trial)
    first, *others = trial.views
    views = (dataclasses.replace(first, points=("nose", *first.points)), *others)
    widget = opened(dataclasses.replace(trial, views=views), propose=True)
    assert "Proposed points are dashed" in widget.status
    widget.edit("action", {"action": "accept", "frame": widget.frame})
    assert set(widget.start["point"]) == {"FR", "HR", "FL", "HL"}
    # all that is proposed has been accepted: what is left is to be clicked
    assert widget.status.startswith("Click nose in cam1")
    assert "roposed" not in widget.status
    assert "accept" not in [action["id"] for action in widget.actions]
    assert "Not clicked in any view yet: nose." in widget.status


def test_without_a_proposal_the_points_are_clicked(small_trial, opened):
    trial = dataclasses.replace(load_trial(small_trial), calibration=None)
    widget = opened(trial, propose=True)
    assert "No paws are proposed: trial 'synthetic-normal-01' is not calibrated" in widget.status
    widget.edit("click", {"frame": 0, "view": "cam1", "u": 100.0, "v": 60.0})
    assert len(widget.start) == 1
    assert "Clicked:" not in widget.status
    widget.edit("click", {"frame": 5, "view": "cam1", "u": 101.0, "v": 60.0})
    widget.edit("click", {"frame": 2, "view": "cam1", "u": 101.0, "v": 60.0})
    assert "Clicked: frames 0, 2, 5. Not clicked in any view yet: " in widget.status
