"""Going on with an interrupted run on a jointed animal: as if it had been one run."""

from __future__ import annotations

import json
import signal
import warnings
from collections import Counter

import pandas as pd
import pytest

from pawnb import cli
from pawnb.core.pose.fit.sequence.one_direction import Follower
from pawnb.core.pose.pullar2009.tracker import _Tracker
from pawnb.errors import InputError, InputWarning
from pawnb.io.native import read_tracks
from pawnb.synthetic import render_spider_trial
from pawnb.workflow.batch.run import batch
from pawnb.workflow.tracking.track import track
from pawnb.workflow.tracking.unfinished import KEPT_FILE, _differing

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

QUICK = {"choose_path": False}


@pytest.fixture
def fitted(monkeypatch):
    """Frames that either method has looked at, in their order."""
    numbers = []
    advance, infer = Follower.advance, _Tracker._infer

    def advance_too(self, state, frame):
        numbers.append(frame.index)
        return advance(self, state, frame)

    def infer_too(self, number, guess):
        numbers.append(number)
        return infer(self, number, guess)

    monkeypatch.setattr(Follower, "advance", advance_too)
    monkeypatch.setattr(_Tracker, "_infer", infer_too)
    return numbers


def run(*args, stop_at=None, **ask):
    """Track, interrupted as by Ctrl-C once that many frames are done; return what was said, too."""

    interrupted = []

    def progress(done, _total):
        # two ways are followed at once: not every number is told
        if stop_at is not None and done >= stop_at and not interrupted:
            interrupted.append(done)
            signal.raise_signal(signal.SIGINT)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", InputWarning)
        tracks = track(*args, **ask, progress=progress)
    return tracks, " ".join(str(warning.message) for warning in caught)


def starts(spider, *frames):
    """Return poses of the still spider in several frames."""
    pose = pd.read_csv(spider / "start_pose.csv")
    return pd.concat([pose.assign(frame=frame) for frame in frames])


@pytest.mark.parametrize(
    ("method", "posed", "frames"),
    [
        ("pawnb", (12, 17), (10, 19)),
        ("paper", (14,), (12, 17)),
        pytest.param("pawnb", (14,), (8, 20), marks=pytest.mark.slow),
        pytest.param("paper", (12, 18), (10, 20), marks=pytest.mark.slow),
    ],
)
def test_a_second_run_goes_on_and_ends_as_one_run_would(
    rendered_spider, tmp_path, fitted, method, posed, frames
):
    parts, n = tmp_path / "parts", frames[1] - frames[0]
    ask = {"method": method, "frames": frames, "start": starts(rendered_spider, *posed)}
    if method == "paper":
        ask["settings"] = {"leg_lengths": "start"}
    whole = track(rendered_spider, **ask, out=tmp_path / "whole")
    all_frames = list(fitted)
    part, said = run(rendered_spider, **ask, out=parts, stop_at=2)
    assert "interrupted: frames" in said
    assert part.sizes["time"] < whole.sizes["time"]
    assert (parts / KEPT_FILE).exists()
    fitted.clear()
    _, said = run(rendered_spider, **ask, out=parts, stop_at=4)
    assert "going on with the run that was interrupted" in said
    assert f" of {n} frames were found before" in said
    more = list(fitted)
    fitted.clear()
    again, said = run(rendered_spider, **ask, out=parts)
    assert "going on" in said
    assert 0 < len(fitted) < len(all_frames) - len(more)
    assert Counter(fitted) <= Counter(all_frames)
    assert again.identical(whole)
    files = sorted(path.name for path in parts.iterdir())
    assert files == sorted(path.name for path in (tmp_path / "whole").iterdir())
    for name in files:
        if name != "tracks.nc":  # HDF5 writes the same data, not always the same bytes
            assert (parts / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_legs_that_cross_go_on_with_all_that_was_open(tmp_path, fitted):
    """A running spider whose frames leave several places of its legs open."""
    spider, frames = tmp_path / "spider", (16, 44)
    render_spider_trial(spider, frames=60, scale=0.4, seed=2, difficulty="hard", motion="run")
    whole = track(spider, frames=frames)
    for done in (8, 20):
        fitted.clear()
        run(spider, frames=frames, out=tmp_path, stop_at=done)
    again, said = run(spider, frames=frames, out=tmp_path)
    assert "going on" in said
    assert again.identical(whole)


def test_a_run_that_differs_begins_anew_and_says_why(rendered_spider, tmp_path, fitted):
    ask = {"frames": (12, 17), "start": starts(rendered_spider, 14), "out": tmp_path}
    run(rendered_spider, **ask, settings=QUICK, stop_at=2)
    before = (tmp_path / KEPT_FILE).read_bytes()
    # nothing is lost for a start pose that cannot be used
    off = ask["start"].assign(x=ask["start"]["x"] / 3)
    with pytest.raises(InputError, match="not on the animal"):
        run(rendered_spider, **{**ask, "start": off}, settings=QUICK)
    assert (tmp_path / KEPT_FILE).read_bytes() == before
    fitted.clear()
    tracks, said = run(rendered_spider, **ask)
    assert f"interrupted in {tmp_path} had other settings (choose_path); tracking begins" in said
    assert sorted(fitted) == [12, 13, 14, 15, 16]
    assert tracks.sizes["time"] == 5
    assert not (tmp_path / KEPT_FILE).exists()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"settings": {"a": 1, "b": 3}}, "other settings (b)"),
        ({"start": [{"x": 2}], "inputs": {"a.avi": "2"}}, "another start pose and other files"),
        ({"method": "pawnb", "settings": {"c": 1}}, "another method"),
        ({"frames": [0, 9]}, "other frames"),
        ({"code": "2"}, "another version of pawnb"),
    ],
)
def test_what_differs_is_named(change, said):
    old = {
        "step": "track", "settings": {"a": 1, "b": 2}, "start": [{"x": 1}], "method": "paper",
        "inputs": {"a.avi": "1"}, "frames": [0, 8], "code": "1",
    }  # fmt: skip
    assert _differing(json.dumps(old), json.dumps(old | change)) == said
    assert _differing("pawnb candidates", json.dumps(old)) == "a record that cannot be read"


def test_the_command_says_how_to_go_on_and_a_batch_does(small_spider, capsys, monkeypatch, fitted):
    counted = Follower.advance

    def advance(self, state, frame):
        if len(fitted) == 4:
            signal.raise_signal(signal.SIGINT)
        return counted(self, state, frame)

    monkeypatch.setattr(Follower, "advance", advance)
    words = ["track", str(small_spider), "--set", "choose_path=false"]
    assert cli.main(words) == cli.EXIT_INTERRUPTED
    said = capsys.readouterr().out
    assert "run it again to go on" in said
    out = small_spider / "results"
    done = read_tracks(out / "tracks.nc").sizes["time"]
    assert f"tracked {done} frames" in said
    assert done < 14
    (row,) = batch([small_spider], settings=QUICK).table.itertuples()
    assert row.status == "tracked"
    assert f"going on with the run that was interrupted in {out}" in row.said
    assert read_tracks(out / "tracks.nc").sizes["time"] == 14
    assert not (out / KEPT_FILE).exists()
