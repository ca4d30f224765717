"""Trials whose tracks failed, or end early, are named where their gait is told."""

from __future__ import annotations

import json
import shutil

import pytest
from trotting import LEGS, walking_tracks

from pawnb.core.paws.offline.quality.assessment import PointQuality, Quality
from pawnb.schema import add_provenance, make_tracks
from pawnb.workflow.gait.drawing.source_drawings import SourceTracks
from pawnb.workflow.gait.notes.tracking_notes import notes_on_tracking
from pawnb.workflow.gait.run import run_gait
from pawnb.workflow.tracking.track import track


def quality(verdict, **right):
    points = tuple(
        PointQuality(leg, "failed" if share < 0.5 else "good", share, share, 0.0, 0.0, ())
        for leg, share in right.items()
    )
    mean = sum(right.values()) / len(right)
    return Quality(verdict, mean, mean, 0.0, 0.0, ("L1 is missing",), points)


def seen(judged=None, *, animal="m1", trial="t1", **step):
    """Tracks of a trial with a verdict that is given."""
    tracks = walking_tracks(trial, animal)
    if step:
        tracks = add_provenance(tracks, step="track", **step)
    one = SourceTracks(tracks=tracks, animal=animal, trial=trial, legs={leg: leg for leg in LEGS})
    vars(one)["quality"] = judged
    return one


def test_a_trial_whose_tracks_failed_is_named():
    """It was pooled with the others, and only the number of such trials stood in the methods."""
    (note,) = notes_on_tracking([seen(), seen(quality("failed", FR=0.1, HR=0.3), trial="t2")])
    assert note.where == "t2"
    assert note.what.startswith("tracking failed: L1 is missing. No gait can be told from it, and")
    assert not notes_on_tracking([seen(quality("good", FR=0.95, HR=0.97))])


def test_a_point_that_failed_beside_good_ones_is_named():
    (note,) = notes_on_tracking([seen(quality("look", FR=0.02, HR=1.0, FL=1.0))])
    assert "tracking of FR (2 %) failed: so much of its labels is expected" in note.what


def test_where_animals_have_trials_of_one_name_it_is_said_whose():
    judged = quality("failed", FR=0.1)
    notes = notes_on_tracking([seen(judged), seen(animal="m2"), seen(judged, animal="m3")])
    assert [note.where for note in notes] == ["m1 t1", "m3 t1"]


@pytest.mark.parametrize("said", [(), ("interrupted: frames 0 to 499 of 0 to 799 are tracked.",)])
def test_tracks_that_end_where_a_run_was_stopped(said):
    """Once: a run that was stopped by Ctrl-C has said so itself, one of a batch has not."""
    step = {"frames": [0, 800], "notes": list(said)}
    notes = notes_on_tracking([seen(complete=False, **step)])
    assert len(notes) == 1 - len(said)
    assert not said or not notes
    for note in notes:
        assert "tracking was stopped: frames 0 to 499 of 0 to 799 are tracked" in note.what
    assert not notes_on_tracking([seen(complete=True, **step)])


@pytest.mark.slow
def test_a_real_fly_of_which_tracking_fails(real_data, tmp_path):
    """Its worst clip from one click: 35 % of marks are right (docs/accuracy)."""
    clip = real_data("real-clips") / "fly_ball_left"
    shutil.copytree(clip, tmp_path / "fly", copy_function=shutil.copyfile)
    with pytest.warns(match="tracking failed: L1"):
        track(tmp_path / "fly", out=tmp_path / "fly" / "results")
    run = run_gait(tmp_path / "fly", figures="none")
    (note,) = [note for note in run.tables.notes if "tracking failed" in note]
    assert note.startswith("fly_ball_left: tracking failed: L1 (")
    assert "tracking failed" in (run.out / "notes.csv").read_text()


def test_clicks_that_contradict_each_other_and_films_that_are_cut_are_named():
    """Both were known when the trial was tracked, and nobody who read its gait heard of it."""
    one = seen(quality("good", FR=1.0))
    tracks = make_tracks(range(40), LEGS, fps=50.0, views=["side"], space=("x", "y"))
    tracks["image_position"][:] = 7.0
    vars(one)["tracks"] = tracks
    leg, other, frame, view = LEGS[0], LEGS[1], 20, "side"
    click = {"view": view, "frame": frame, "point": leg, "sure": 0.97, "u": 7.0, "v": 7.0,
             "other": other, "beside": [frame - 10]}  # fmt: skip
    tracks.attrs |= {"doubted_clicks": json.dumps([click]), "cuts": json.dumps({view: [frame]})}
    cut, clicked = (note.what for note in notes_on_tracking([one]))
    assert f"is cut, or leaps, from frame {frame - 1} to {frame}. A stride across it" in cut
    assert f"under each other's names in frame {frame} (if not in {frame - 10})" in clicked
