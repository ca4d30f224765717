"""The verdict where people meet it: the command's line and exit status, Python, the files."""

from __future__ import annotations

import hashlib
import json
import warnings

import numpy as np
import pandas as pd
import pytest

import pawnb
from pawnb import cli
from pawnb.errors import QualityWarning
from pawnb.schema import ORIGIN_CODE, add_provenance, make_tracks
from pawnb.workflow.batch.run import BatchReport
from pawnb.workflow.provenance.results import write_track_results
from pawnb.workflow.reviewing.quality import read_verdict, tell_failed

N = 50


def tracks_with(right, *, names=("FR", "HR")):
    """Two points 80 px apart that stand still, each found in so many of its frames, else missing.

    Nothing else speaks against them: the share that is there is the share expected to be right.
    """
    tracks = make_tracks(range(N), names, fps=100.0, views=["side"], space=("x", "y"))
    for p, share in enumerate(right):
        there = slice(0, round(share * N))
        for name in ("image_position", "position"):
            tracks[name][there, ..., 0, p, :] = 20.0 + 80.0 * p
            tracks[name][there, ..., 1, p, :] = 30.0
        tracks["image_origin"][there, :, p] = ORIGIN_CODE["measured"]
        tracks["image_confidence"][there, :, p] = 1.0
    return add_provenance(tracks, step="track", method="pawnb", settings={}, inputs={})


@pytest.fixture
def tracked_as(tmp_path, monkeypatch):
    """Return a function that runs ``pawnb track`` on a trial whose tracks are given."""
    (tmp_path / "trial.toml").write_text(
        '[trial]\nkind = "paws"\nname = "t"\nfps = 100.0\n[animal]\nid = "m"\n'
        '[[views]]\nname = "side"\nvideo = "side.avi"\npoints = ["FR", "HR"]\n'
        '[start]\npoints = "start.csv"\n'
    )

    def run(tracks, *words):
        def track(_trial, *, out, **_options):
            write_track_results(tracks, out)
            tell_failed(tracks, complete=True)
            return tracks

        monkeypatch.setattr("pawnb.workflow.tracking.track.track", track)
        return cli.main(["track", str(tmp_path), *words])

    return run


@pytest.mark.parametrize(
    ("right", "verdict", "status", "after"),
    [
        ((1.0, 0.96), "good", 0, "pawnb gait "),
        ((1.0, 0.84), "good but for HR (84 % of labels expected right) - HR is missing in 16 % of "
         "frames", 0, "review (pawnb.widgets.TrackReviewer), then pawnb gait "),
        ((1.0, 0.7), "look: HR (70 % of labels expected right) - HR is missing in 30 % of frames",
         0, "review (pawnb.widgets.TrackReviewer), then pawnb gait "),
        ((0.4, 0.1), "failed: HR (10 % of labels expected right) - HR is missing in 90 % of "
         "frames; FR (40 % of labels expected right) - FR is missing in 60 % of frames", 3,
         "click the points in more frames (pawnb suggest names some), and track again"),
    ],
)  # fmt: skip
def test_one_line_says_how_good_tracks_are(tracked_as, capsys, right, verdict, status, after):
    assert tracked_as(tracks_with(right)) == status
    said = capsys.readouterr()
    assert said.out.count("\n") == 1
    assert said.out.startswith(f"tracked 50 frames: {verdict}; wrote ")
    assert f"; next: {after}" in said.out
    assert said.err == ""  # it is not said twice


def test_the_folder_holds_the_verdict_and_the_manifest_knows_it(tmp_path):
    tracks = tracks_with((1.0, 0.7))
    write_track_results(tracks, tmp_path)
    document = json.loads((tmp_path / "quality.json").read_text())
    assert document == pawnb.assess_quality(tracks).document()
    assert document["verdict"] == read_verdict(tmp_path) == "look"
    assert document["points"]["HR"]["missing"] == 0.3
    listed = json.loads((tmp_path / "provenance.json").read_text())["files"]["quality.json"]
    assert listed["sha256"] == hashlib.sha256((tmp_path / "quality.json").read_bytes()).hexdigest()


def test_a_folder_without_a_verdict_has_none(tmp_path):
    assert read_verdict(tmp_path) == ""
    for text in ("", "[]", "{}", '{"verdict'):
        (tmp_path / "quality.json").write_text(text)
        assert read_verdict(tmp_path) == ""


def test_python_warns_of_tracks_that_failed_and_of_no_others():
    with pytest.warns(QualityWarning, match="^tracking failed: HR "):
        tell_failed(tracks_with((0.4, 0.1)), complete=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tell_failed(tracks_with((0.4, 0.1)), complete=False)
        tell_failed(tracks_with((1.0, 0.7)), complete=True)


def test_clicks_of_the_record_tell_the_size_of_the_animal():
    """HR is 80 px from FR in the tracks; the clicks have it 20 px away: the body is that long."""
    tracks = tracks_with((1.0, 1.0))
    tracks["image_position"][0, 0, 0, 1] = 40.0
    click = {"frame": 0, "view": "side", "v": 30.0}
    clicks = [click | {"point": "FR", "u": 20.0}, click | {"point": "HR", "u": 40.0}]
    assert pawnb.assess_quality(tracks).verdict == "good"
    told = add_provenance(tracks, step="track", start=clicks)
    assert pawnb.assess_quality(told).verdict == "failed"


@pytest.mark.parametrize(
    ("verdicts", "status", "said"),
    [
        (["good", "look"], 0, "2 tracked; tracks: 1 good, 1 look"),
        (["good", "failed"], 3, "2 tracked; tracks: 1 good, 1 failed"),
    ],
)
def test_a_batch_says_which_tracks_failed(monkeypatch, capsys, verdicts, status, said):
    table = pd.DataFrame(
        [(f"t{i}", "r", "tracked", "", verdict) for i, verdict in enumerate(verdicts)],
        columns=["trial", "out", "status", "said", "verdict"],
    )
    monkeypatch.setattr("pawnb.workflow.batch.run.batch", lambda *_a, **_o: BatchReport(table))
    assert cli.main(["batch", "somewhere"]) == status
    assert capsys.readouterr().out.strip() == said
    assert BatchReport(table).lost["trial"].tolist() == [f"t{i}" for i in np.flatnonzero(
        np.array(verdicts) == "failed")]  # fmt: skip


def test_help_names_the_exit_status(capsys):
    for command in ("track", "batch"):
        with pytest.raises(SystemExit):
            cli.main([command, "--help"])
        assert "3 where tracks were written and failed" in " ".join(capsys.readouterr().out.split())
