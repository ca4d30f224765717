"""A trial that is mended after it was tracked: nothing goes on in the old terms unsaid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pawnb
from pawnb.errors import InputWarning
from pawnb.io.native import write_tracks
from pawnb.schema import add_provenance, make_tracks
from pawnb.workflow.gait.sources import read_source
from pawnb.workflow.provenance import build_step, trial_checksums
from pawnb.workflow.provenance.mended_trial import as_described_now
from pawnb.workflow.provenance.results import describe_trial

N = 40


@pytest.fixture
def trial(tmp_path):
    """A trial of one view and one paw, with the tracks that pawnb left of it."""
    (tmp_path / "start.csv").write_text("frame,view,point,u,v\n0,side,FR,1,2\n")
    (tmp_path / "v.avi").write_bytes(b"no video")
    made = pawnb.Trial(
        kind="paws", name="t", fps=240.0, animal=pawnb.Animal(id="a"), folder=tmp_path,
        views=(pawnb.View(name="side", video="v.avi", points=("FR",)),), start_points="start.csv",
    )  # fmt: skip
    pawnb.save_trial(made, tmp_path / "trial.toml")
    return made


def tracked(trial, *, time_s=None):
    tracks = make_tracks(
        range(N), ["FR"], fps=trial.fps, space=("x", "y"), views=["side"], individual="a",
        time_s=time_s,
    )  # fmt: skip
    for name in ("position", "image_position"):
        shape = tracks[name].shape
        tracks[name] = (tracks[name].dims, np.arange(float(np.prod(shape))).reshape(shape),
                        tracks[name].attrs)  # fmt: skip
    tracks = describe_trial(tracks, trial)
    step = build_step("track", command=None, settings={}, inputs=trial_checksums(trial))
    return add_provenance(tracks, **step)


def test_nothing_is_done_or_said_where_nothing_was_mended(trial, recwarn):
    tracks = tracked(trial)
    assert as_described_now(tracks, trial) is tracks
    assert not recwarn.list


def test_a_frame_rate_that_was_wrong(trial):
    (trial.folder / "results").mkdir()
    write_tracks(tracked(trial), trial.folder / "results" / "tracks.nc")
    mended = replace(trial, fps=24.0)
    (trial.folder / "trial.toml").unlink()
    pawnb.save_trial(mended, trial.folder / "trial.toml")
    with pytest.warns(InputWarning) as told:
        tracks = read_source(trial.folder).tracks
    assert any("fps was changed from 240 to 24" in str(one.message) for one in told)
    np.testing.assert_allclose(tracks["time"], np.arange(N) / 24.0)
    assert tracks.attrs["fps"] == 24.0
    assert '"fps": 24.0' in tracks.attrs["trial"]
    assert tracks.attrs["units"] == "px"


def test_times_of_the_file_are_left_and_said(trial):
    stamps = np.arange(N) / 240.0
    stamps[20:] += 0.1
    tracks = tracked(trial, time_s=stamps)
    with pytest.warns(InputWarning, match="own stamps: pawnb track again"):
        now = as_described_now(tracks, replace(trial, fps=24.0))
    np.testing.assert_array_equal(now["time"], stamps)


def test_a_scale_that_comes_later_changes_or_goes(trial):
    tracks = tracked(trial)
    scaled = replace(trial, calibration=pawnb.Calibration(px_per_unit=2.0, unit="cm"))
    with pytest.warns(InputWarning, match="from none to 2 .positions are in cm"):
        once = as_described_now(tracks, scaled)
    np.testing.assert_allclose(once["position"], tracks["position"] / 2.0)
    np.testing.assert_array_equal(once["image_position"], tracks["image_position"])
    assert (once.attrs["units"], once["position"].attrs["units"]) == ("cm", "cm")
    other = replace(trial, calibration=pawnb.Calibration(px_per_unit=4.0, unit="mm"))
    with pytest.warns(InputWarning, match="from 2 to 4"):
        twice = as_described_now(once, other)
    np.testing.assert_allclose(twice["position"], tracks["position"] / 4.0)
    with pytest.warns(InputWarning, match="from 4 to none .positions are in px"):
        back = as_described_now(twice, trial)
    np.testing.assert_allclose(back["position"], tracks["position"])


def test_clicks_and_calibrations_that_were_changed_need_tracking_again(trial):
    tracks = tracked(trial)
    (trial.folder / "DLT.csv").write_text("1\n" * 11)
    calibrated = replace(trial, calibration=pawnb.Calibration(dlt="DLT.csv"))
    with pytest.warns(InputWarning, match=r"DLT.csv changed: pawnb track again"):
        as_described_now(tracks, calibrated)
    (trial.folder / "start.csv").write_text("frame,view,point,u,v\n0,side,FR,9,2\n")
    with pytest.warns(InputWarning, match=r"start.csv changed: pawnb track again"):
        assert as_described_now(tracks, trial) is tracks
