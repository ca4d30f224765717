"""Going on after an interruption, and correcting, without decoding anything twice."""

from __future__ import annotations

import shutil
import signal

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pawnb import cli
from pawnb.core.rig import load_rig
from pawnb.core.video.viewset import ViewSet
from pawnb.errors import InputWarning
from pawnb.io.native import read_tracks
from pawnb.trial import load_trial
from pawnb.workflow.provenance.results import provenance_steps
from pawnb.workflow.tracking import kept_candidates
from pawnb.workflow.tracking.kept_candidates import CANDIDATES_FILE
from pawnb.workflow.tracking.track import retrack, track

pytestmark = pytest.mark.slow  # scenes are rendered and tracked

N = 12
WRITTEN = ("tracks.nc", "tracks.csv", "points3d.csv", "quality.json", "provenance.json")


@pytest.fixture(autouse=True)
def nothing_in_memory(monkeypatch):
    monkeypatch.setattr(kept_candidates, "_in_memory", type(kept_candidates._in_memory)())


@pytest.fixture
def decoded(monkeypatch):
    """Ranges of frames that were gone through."""
    ranges, plain = [], ViewSet.frames

    def frames(self, start, stop, **options):
        ranges.append((start, stop))
        return plain(self, start, stop, **options)

    monkeypatch.setattr(ViewSet, "frames", frames)
    return ranges


def interrupt_at(k):
    """Send an interrupt, as Ctrl-C does, once k frames are done."""

    def progress(done, _total):
        if done == k:
            signal.raise_signal(signal.SIGINT)

    return progress


def test_a_second_run_goes_on_and_ends_as_one_run_would(small_trial, tmp_path, decoded):
    trial = load_trial(small_trial)
    whole = track(trial, frames=(0, N), out=tmp_path / "whole")
    with pytest.warns(InputWarning, match=f"interrupted: frames 0 to .* of 0 to {N - 1}"):
        part = track(trial, frames=(0, N), out=tmp_path / "parts", progress=interrupt_at(5))
    done = part.sizes["time"]
    assert 5 <= done < N
    assert read_tracks(tmp_path / "parts" / "tracks.nc").sizes["time"] == done
    decoded.clear()
    again = track(trial, frames=(0, N), out=tmp_path / "parts")
    assert decoded == [(done, N)]
    xr.testing.assert_identical(again, whole)
    files = sorted(path.name for path in (tmp_path / "whole").iterdir())
    assert CANDIDATES_FILE in files
    for name in files:
        if name != "tracks.nc":  # HDF5 writes the same data, not always the same bytes
            left, right = (tmp_path / folder / name for folder in ("whole", "parts"))
            assert left.read_bytes() == right.read_bytes(), name


@pytest.mark.parametrize("method", ["paper", "slic-2d"])
def test_methods_that_go_frame_by_frame_go_on_as_well(small_trial, tmp_path, decoded, method):
    trial = load_trial(small_trial)
    ask = {"method": method, "frames": (0, N)}
    whole = track(trial, **ask)
    with pytest.warns(InputWarning, match="interrupted"):
        part = track(trial, **ask, out=tmp_path, progress=interrupt_at(5))
    done = part.sizes["time"]
    assert 5 <= done < N
    decoded.clear()
    again = track(trial, **ask, out=tmp_path)
    # the last frame done is entered again, so that colours are those of its paws
    assert decoded == [(done - 1, N)]
    # every state is made anew from the rows before, as after a correction: the same to
    # within a pixel of pictures 2048 px wide, not to the last digit
    scale = 2048 / 1024
    away = np.abs(again["image_position"] - whole["image_position"]).to_numpy() * scale
    assert np.nanmax(away) < 1.0
    assert again["time"].equals(whole["time"])
    assert (again["image_origin"] == whole["image_origin"]).all()
    made = provenance_steps(again)
    assert [(step["complete"], step["gone_on_from"]) for step in made] == [(True, done - 1)]


def test_one_view_with_a_scale_goes_on_in_the_same_unit(small_trial, tmp_path):
    document, *views = (small_trial / "trial.toml").read_text().split("[[views]]")
    start = views[-1][views[-1].index("[start]") :]
    scale = '[calibration]\npx_per_unit = 2.0\nunit = "mm"\n'
    (small_trial / "trial.toml").write_text(document + "[[views]]" + views[0] + start + scale)
    clicks = pd.read_csv(small_trial / "start.csv")
    clicks[clicks["view"] == "cam1"].to_csv(small_trial / "start.csv", index=False)
    ask = {"method": "slic-2d", "frames": (0, N), "out": tmp_path}
    with pytest.warns(InputWarning, match="interrupted"):
        track(small_trial, **ask, progress=interrupt_at(5))
    again = track(small_trial, **ask)
    in_px = again["image_position"].isel(view=0).to_numpy()
    np.testing.assert_allclose(again["position"], in_px / 2.0)


@pytest.mark.parametrize("change", [{"settings": {"n_best": 2}}, {"frames": (0, N - 1)}])
def test_a_run_that_differs_starts_anew(small_trial, tmp_path, decoded, change):
    trial = load_trial(small_trial)
    ask = {"method": "slic-3d", "frames": (0, N), "out": tmp_path}
    with pytest.warns(InputWarning, match="interrupted"):
        track(trial, **ask, progress=interrupt_at(5))
    decoded.clear()
    track(trial, **{**ask, **change})
    assert decoded[0][0] == 0


def test_landmarks_go_on_with_the_paws(small_trial, tmp_path, decoded):
    text = (small_trial / "trial.toml").read_text()
    for leg in ("HR", "HL"):
        text = text.replace(f'"{leg}",', f'"{leg}", "nose",')
    (small_trial / "trial.toml").write_text(text)
    trial = load_trial(small_trial)
    truth = pd.read_csv(small_trial / "truth" / "landmarks3d.csv").query("frame == 0")
    rig = load_rig(trial)
    nose = rig.project(truth.set_index("point").loc[["nose"], ["x", "y", "z"]].to_numpy())[0]
    clicks = pd.DataFrame(
        [(0, name, "nose", *uv) for name, uv in zip(rig.names, nose, strict=True)],
        columns=["frame", "view", "point", "u", "v"],
    )
    ask = {"frames": (0, N), "start": pd.concat([pd.read_csv(small_trial / "start.csv"), clicks])}
    whole = track(trial, **ask, out=tmp_path / "whole")
    with pytest.warns(InputWarning, match="interrupted"):
        part = track(trial, **ask, out=tmp_path / "parts", progress=interrupt_at(5))
    done = part.sizes["time"]
    assert np.isfinite(part["position"].sel(keypoint="nose")).all()
    decoded.clear()
    again = track(trial, **ask, out=tmp_path / "parts")
    # paws are not looked for twice; the nose is followed through all frames
    assert decoded == [(0, done), (done, N)]
    xr.testing.assert_identical(again, whole)


def test_another_video_is_searched_anew(small_trial, tmp_path, decoded):
    trial = load_trial(small_trial)
    ask = {"frames": (0, 4), "settings": {"evidence": "colour"}}  # views that do not fit are poor
    track(trial, **ask, out=tmp_path / "out")
    shutil.copy(small_trial / "cam1.avi", small_trial / "cam2.avi")
    decoded.clear()
    track(trial, **ask, out=tmp_path / "out")
    assert decoded == [(0, 4)]


@pytest.mark.parametrize("where", ["folder", "memory"])
def test_tracking_again_decodes_nothing_and_is_the_same_as_if_it_had(
    small_trial, tmp_path, decoded, where
):
    trial = load_trial(small_trial)
    out = tmp_path / "out" if where == "folder" else None
    tracks = track(trial, frames=(0, N), out=out)
    if where == "folder":
        kept_candidates._in_memory.clear()
    decoded.clear()
    quick = retrack(trial, tracks, 6, out=out)
    assert decoded == []
    kept_candidates._in_memory.clear()
    slow = retrack(trial, tracks, 6)
    assert decoded == [(0, N)]
    xr.testing.assert_identical(quick, slow)


def test_an_interrupted_command_says_so_and_keeps_what_is_done(
    small_trial, tmp_path, capsys, monkeypatch
):
    out = tmp_path / "out"
    plain = ViewSet.frames

    def frames(self, start, stop, **options):
        for i, pictures in plain(self, start, stop, **options):
            if i == 6:
                signal.raise_signal(signal.SIGINT)
            yield i, pictures

    monkeypatch.setattr(ViewSet, "frames", frames)
    assert cli.main(["track", str(small_trial), "--out", str(out)]) == cli.EXIT_INTERRUPTED
    said = capsys.readouterr()
    assert "tracked 6 frames" in said.out
    assert "interrupted" in said.err
    assert read_tracks(out / "tracks.nc").sizes["time"] == 6


def test_an_interrupted_run_leaves_the_whole_tracks_of_an_earlier_one(small_trial):
    """Stopped while it ran again with another setting, it put 0 frames in the place of all."""
    trial, out, done = load_trial(small_trial), small_trial / "results", []
    whole = track(trial, frames=(0, N), out=out)
    before = {name: (out / name).read_bytes() for name in WRITTEN}
    kept_candidates._in_memory.clear()
    ask = {"progress": lambda n, _total: done.append(n), "stop": lambda: len(done) > 3}
    with pytest.warns(InputWarning, match="whole and of an earlier run; they stay until"):
        part = track(trial, frames=(0, N), out=out, settings={"noise": 2.0}, **ask)
    assert part.sizes["time"] < N
    assert {name: (out / name).read_bytes() for name in before} == before
    xr.testing.assert_identical(read_tracks(out / "tracks.nc"), whole)


def test_interrupted_before_the_first_frame_there_is_nothing_to_keep(small_trial, monkeypatch):
    plain = ViewSet.frames

    def frames(self, start, stop, **options):
        signal.raise_signal(signal.SIGINT)
        return plain(self, start, stop, **options)

    monkeypatch.setattr(ViewSet, "frames", frames)
    with pytest.raises(KeyboardInterrupt):
        track(load_trial(small_trial))


@pytest.fixture
def clicked_late(small_trial):
    """The small trial, clicked in frame 8."""
    truth = pd.read_csv(small_trial / "truth" / "tracks.csv").query("frame == 8 and visible == 1")
    clicks = pd.read_csv(small_trial / "start.csv")[["view", "point"]].merge(truth)
    clicks = clicks[["frame", "view", "point", "u", "v"]]
    assert clicks["point"].nunique() == 4
    clicks.to_csv(small_trial / "start.csv", index=False)
    return load_trial(small_trial)


def test_interrupted_before_the_clicks_it_keeps_what_was_searched(clicked_late, tmp_path, decoded):
    """Without a frame in which the paws are known there are no tracks yet."""
    ask = {"frames": (0, N), "progress": interrupt_at(4)}
    whole = track(clicked_late, frames=(0, N))
    kept_candidates._in_memory.clear()
    said = "interrupted before every point was placed; run it again to go on from there"
    with pytest.raises(KeyboardInterrupt, match=said):
        track(clicked_late, **ask, out=tmp_path)
    decoded.clear()
    again = track(clicked_late, frames=(0, N), out=tmp_path)
    back, ahead = decoded
    assert back == (8, -1)  # a few frames tell where the animal was
    assert 4 <= ahead[0] < 8
    assert ahead[1] == N
    xr.testing.assert_identical(again, whole)


def test_interrupted_after_the_clicks_it_keeps_the_frames_before_them(clicked_late, tmp_path):
    whole = track(clicked_late, frames=(0, N))
    kept_candidates._in_memory.clear()
    with pytest.warns(InputWarning, match="interrupted: frames 0 to"):
        part = track(clicked_late, frames=(0, N), out=tmp_path, progress=interrupt_at(9))
    assert 9 <= part.sizes["time"] < N
    assert np.isfinite(part["position"]).all()
    again = track(clicked_late, frames=(0, N), out=tmp_path)
    xr.testing.assert_identical(again, whole)


def test_a_command_interrupted_before_the_clicks_says_how_to_go_on(
    clicked_late, tmp_path, capsys, monkeypatch
):
    plain = ViewSet.frames

    def frames(self, start, stop, **options):
        for i, pictures in plain(self, start, stop, **options):
            if i == 4 and options.get("step", 1) == 1:
                signal.raise_signal(signal.SIGINT)
            yield i, pictures

    monkeypatch.setattr(ViewSet, "frames", frames)
    asked = ["track", str(clicked_late.folder), "--out", str(tmp_path)]
    assert cli.main(asked) == cli.EXIT_INTERRUPTED
    assert "tracked 0 frames" in capsys.readouterr().out


def test_a_correction_before_the_clicks_decodes_nothing(clicked_late, tmp_path, decoded):
    tracks = track(clicked_late, frames=(0, N), out=tmp_path)
    decoded.clear()
    retrack(clicked_late, tracks, 3, out=tmp_path)
    assert decoded == []
