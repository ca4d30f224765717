"""Reprojected paws of a rendered trial lie where the truth is, and disturb no evaluation."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from pawnb.io.native import read_tracks
from pawnb.schema import ORIGIN_CODE
from pawnb.trial import load_trial
from pawnb.workflow.evaluation.corrected_run import track_with_corrections
from pawnb.workflow.evaluation.errors import count_errors
from pawnb.workflow.reviewing.reproject import reproject
from pawnb.workflow.tracking.track import retrack, track


def silent(done, total):
    """Show no progress."""


def without_reprojected(tracks):
    """Tracks as they are before points are shown in the other views."""
    shown = tracks["image_origin"] == ORIGIN_CODE["reprojected"]
    return tracks.assign(
        image_position=tracks["image_position"].where(~shown),
        image_origin=tracks["image_origin"].where(~shown, ORIGIN_CODE["missing"]),
        image_confidence=tracks["image_confidence"].where(~shown, 0.0),
    )


def test_tracking_shows_paws_in_the_views_of_the_other_side(rendered_trial):
    """Fig. 8 of the paper is what the tracker gives, also after tracking again."""
    tracks = track(rendered_trial, method="paper", frames=(0, 4), progress=silent)
    far = tracks.sel(view=["cam1", "cam2"], keypoint=["FL", "HL"])
    assert (far["image_origin"] == ORIGIN_CODE["reprojected"]).all()
    assert np.isfinite(far["image_position"]).all()
    steps = [step["step"] for step in json.loads(tracks.attrs["provenance"])["steps"]]
    assert steps == ["track"]
    moved = tracks.copy(deep=True)
    for view in ("cam3", "cam4"):
        label = {"view": view, "keypoint": "FL", "individual": tracks["individual"].item()}
        moved["image_origin"].loc[label][2] = ORIGIN_CODE["edited"]
        moved["image_position"].loc[label][2:] += 3.0
    again = retrack(load_trial(rendered_trial), moved, 2, progress=silent)
    own = {"view": "cam1", "keypoint": "FL"}
    step = (again["image_position"] - tracks["image_position"]).sel(own).to_numpy()
    assert (step[:2] == 0).all()
    assert np.abs(step[2]).max() > 1.0
    assert (again["image_origin"].sel(own) == ORIGIN_CODE["reprojected"]).all()


@pytest.mark.slow
def test_far_paws_appear_in_the_other_views_and_are_not_judged(rendered_trial, tmp_path):
    tracks = without_reprojected(
        track(rendered_trial, method="slic-3d", frames=(0, 3), progress=silent)
    )
    shown = reproject(rendered_trial, tracks, out=tmp_path)
    again = read_tracks(tmp_path / "tracks.nc")
    assert (again["image_origin"] == shown["image_origin"]).all()
    label = {"view": "cam1", "keypoint": "FL"}
    assert (shown["image_origin"].sel(label) == ORIGIN_CODE["reprojected"]).all()
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    rows = truth[(truth["view"] == "cam1") & (truth["point"] == "FL") & (truth["frame"] < 3)]
    place = shown["image_position"].sel(label).isel(individual=0).to_numpy()
    # a paw is 8 px long at this scale
    assert np.linalg.norm(place - rows[["u", "v"]].to_numpy(), axis=1).max() < 8
    # nor does an evaluation count what no view tracked, or correct it there
    before, after = (count_errors(x, truth, threshold_px=2.0) for x in (tracks, shown))
    assert after.n_labels == before.n_labels
    assert after.median_px == before.median_px
    trial = load_trial(rendered_trial)
    run = track_with_corrections(
        shown, truth, lambda t, frame: retrack(trial, t, frame, progress=silent), threshold_px=2.0
    )
    assert len(run.interventions)
    edited = run.tracks["image_origin"].sel(label) == ORIGIN_CODE["edited"]
    assert not edited.any()
