"""A trial that is mended after it was tracked: nothing goes on in the old terms unsaid."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

import pawnb
from pawnb.core.edits.log import Accept, EditLog, Move
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


def tracked(trial, *, time_s=None, **more):
    tracks = make_tracks(
        range(N), ["FR"], fps=trial.fps, space=("x", "y"), views=["side"], individual="a",
        time_s=time_s,
    )  # fmt: skip
    for name in ("position", "image_position"):
        shape = tracks[name].shape
        tracks[name] = (tracks[name].dims, np.arange(float(np.prod(shape))).reshape(shape),
                        tracks[name].attrs)  # fmt: skip
    tracks = describe_trial(tracks, trial)
    step = build_step("track", command=None, settings={}, inputs=trial_checksums(trial), **more)
    return add_provenance(tracks, **step)


def test_nothing_is_done_or_said_where_nothing_was_mended(trial, recwarn):
    tracks = tracked(trial)
    assert as_described_now(tracks, trial) is tracks
    assert not recwarn.list


@pytest.mark.parametrize("given", ["", "results", "results/tracks.nc"])
def test_a_frame_rate_that_was_wrong(trial, given):
    (trial.folder / "results").mkdir()
    write_tracks(tracked(trial), trial.folder / "results" / "tracks.nc")
    mended = replace(trial, fps=24.0)
    (trial.folder / "trial.toml").unlink()
    pawnb.save_trial(mended, trial.folder / "trial.toml")
    with pytest.warns(InputWarning) as told:
        tracks = read_source(trial.folder / given).tracks
    assert any("fps was changed from 240 to 24" in str(one.message) for one in told)
    np.testing.assert_allclose(tracks["time"], np.arange(N) / 24.0)
    assert tracks.attrs["fps"] == 24.0
    assert '"fps": 24.0' in tracks.attrs["trial"]
    assert tracks.attrs["units"] == "px"


def test_a_film_that_was_replaced_is_said_whatever_the_clocks_say(trial, recwarn):
    """A study that was copied has new times, and the clock of another drive may be behind."""
    size = (trial.folder / "v.avi").stat().st_size
    tracks = tracked(trial, film_bytes={"v.avi": size})
    (trial.folder / "results").mkdir()
    assert as_described_now(tracks, trial) is tracks
    (trial.folder / "v.avi").write_bytes(b"quite another film")
    write_tracks(tracks, trial.folder / "results" / "tracks.nc")  # as the last file that is copied
    with pytest.warns(InputWarning, match=r"v\.avi was replaced by another film: clicks, tracks"):
        as_described_now(tracks, trial)


def test_a_film_on_another_drive_that_was_replaced_is_said(trial, tmp_path_factory):
    """Records hold no absolute path: such films were never looked at."""
    far = tmp_path_factory.mktemp("drive") / "w.avi"
    far.write_bytes(b"no video")
    trial = replace(trial, views=(replace(trial.views[0], video=str(far)),))
    tracks = tracked(trial)
    written = trial.folder / "results" / "tracks.nc"
    written.parent.mkdir()
    write_tracks(tracks, written)
    far.write_bytes(b"NO VIDEO")
    later = written.stat().st_mtime + 9
    os.utime(far, (later, later))
    with pytest.warns(InputWarning, match=r"w\.avi was replaced by another film: clicks, tracks"):
        as_described_now(tracks, trial)


def test_films_that_views_exchanged_in_trial_toml_are_said(trial, recwarn):
    """Every film is there, under its name, and in the other view; renamed ones are fine."""
    side = trial.views[0]
    (trial.folder / "w.avi").write_bytes(b"other one")
    two = replace(trial, views=(side, replace(side, name="top", video="w.avi")))
    tracks = tracked(two, films={"side": "v.avi", "top": "w.avi"})
    exchanged = replace(
        trial, views=(replace(side, video="w.avi"), replace(side, name="top", video="v.avi"))
    )
    with pytest.warns(InputWarning, match=r"view side was given w\.avi, the film that top had, in"):
        as_described_now(tracks, exchanged)
    recwarn.clear()
    (trial.folder / "v.avi").rename(trial.folder / "new.avi")
    renamed = replace(two, views=(replace(side, video="new.avi"), two.views[1]))
    assert as_described_now(tracks, renamed) is tracks
    # both files have the other's name, and so has trial.toml
    (trial.folder / "w.avi").rename(trial.folder / "v.avi")
    (trial.folder / "new.avi").rename(trial.folder / "w.avi")
    as_described_now(tracks, exchanged)
    assert not recwarn.list


def test_another_film_of_the_same_name_is_said(trial, recwarn):
    tracks = tracked(trial)
    written = trial.folder / "results" / "tracks.nc"
    written.parent.mkdir()
    write_tracks(tracks, written)
    film = trial.folder / "v.avi"
    film.touch()  # as after a copy of the folder
    later = written.stat().st_mtime + 9
    os.utime(film, (later, later))
    assert as_described_now(tracks, trial) is tracks
    assert not recwarn.list
    film.write_bytes(b"another film")
    os.utime(film, (later, later))
    with pytest.warns(InputWarning, match=r"v\.avi was replaced by another film: clicks, tracks"):
        as_described_now(tracks, trial)
    film.unlink()  # put away
    assert as_described_now(tracks, trial) is tracks


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


@pytest.mark.slow
def test_a_belt_speed_that_was_wrong(trial, recwarn):
    """The tracks carry that which was stated when they were made."""
    slow = tracked(replace(trial, belt_speed=100.0))
    assert as_described_now(slow, replace(trial, belt_speed=100.0)) is slow
    assert not recwarn.list
    with pytest.warns(InputWarning, match=r"^t: since .*, belt_speed was changed from 100 to 300"):
        now = as_described_now(slow, replace(trial, belt_speed=300.0))
    assert (now["belt_speed"] == 300.0).all()
    with pytest.warns(InputWarning, match="belt_speed was changed from 100 to none"):
        assert "belt_speed" not in as_described_now(slow, trial)
    (trial.folder / "belt.csv").write_text("frame,speed\n0,100\n39,178\n")
    by_file = replace(trial, belt_speed="belt.csv")
    with pytest.warns(InputWarning, match="belt_speed was changed from 100 to 100 ... 178"):
        now = as_described_now(slow, by_file)
    assert now["belt_speed"].to_numpy()[-1] == 178.0
    (trial.folder / "belt.csv").unlink()  # results alone were brought to another computer
    recwarn.clear()
    assert as_described_now(now, by_file) is now
    assert not recwarn.list


def test_clicks_and_calibrations_that_were_changed_need_tracking_again(trial):
    tracks = tracked(trial)
    (trial.folder / "DLT.csv").write_text("1\n" * 11)
    calibrated = replace(trial, calibration=pawnb.Calibration(dlt="DLT.csv"))
    with pytest.warns(InputWarning, match=r"DLT.csv changed: pawnb track again"):
        as_described_now(tracks, calibrated)
    (trial.folder / "start.csv").write_text("frame,view,point,u,v\n0,side,FR,9,2\n")
    with pytest.warns(InputWarning, match=r"start.csv changed: pawnb track again"):
        assert as_described_now(tracks, trial) is tracks


@pytest.mark.slow
def test_corrections_that_were_not_saved_are_not_passed_over(trial, recwarn):
    (trial.folder / "results").mkdir()
    write_tracks(tracked(trial), trial.folder / "results" / "tracks.nc")
    edits = trial.folder / "results" / "edits.jsonl"
    log = EditLog(read_source(trial.folder).tracks, edits)
    u, v = log.tracks["image_position"].values[2, 0, :, 0, 0].tolist()
    log.apply(Accept(frame=2, view="side", point="FR", u=u, v=v))
    read_source(trial.folder)
    assert not [one for one in recwarn if "edits.jsonl" in str(one.message)]
    log.apply(Move(frame=3, view="side", point="FR", u=1.0, v=2.0))
    for given in (trial.folder, trial.folder / "results", trial.folder / "results" / "tracks.nc"):
        with pytest.warns(InputWarning, match=r"1 correction is not in the tracks; open the rev"):
            read_source(given)
    write_tracks(log.stamped(), trial.folder / "results" / "tracks.nc")
    recwarn.clear()
    read_source(trial.folder)
    assert not [one for one in recwarn if "edits.jsonl" in str(one.message)]
    log.undo()  # and the tracks were not saved again, as where the program was ended
    with pytest.warns(InputWarning, match="contain corrections that were undone"):
        read_source(trial.folder)


@pytest.mark.parametrize(
    ("view", "said"),
    [
        (
            {"crop": (10, 0, 90, 60)},
            r"crop \(from none to \[10, 0, 90, 60\]\) of side changed: clicks",
        ),
        ({"mirror": True}, "mirror of side changed: clicks, tracks and corrections are in pixels"),
        ({"offset": 3}, "offset of side was changed from 0 to 3: pawnb track again"),
    ],
)
def test_other_pictures_than_those_that_were_tracked(trial, view, said, recwarn):
    """And there and back: what was tracked with it needs it."""
    other = replace(trial, views=(replace(trial.views[0], **view),))
    with pytest.warns(InputWarning, match=said):
        as_described_now(tracked(trial), other)
    with pytest.warns(InputWarning, match=r"of side (was )?changed"):
        as_described_now(tracked(other), trial)
    # what was mended beside it does not hide it once the tracks are saved
    mended = replace(other, fps=24.0)
    with pytest.warns(InputWarning):
        saved = as_described_now(tracked(trial), mended)
    with pytest.warns(InputWarning, match=said):
        as_described_now(saved, mended)
    recwarn.clear()
    as_described_now(tracked(other), other)
    assert not recwarn.list


def test_tracks_made_before_crops_were_kept_know_their_size(trial, recwarn):
    tracks = tracked(trial)
    tracks.attrs["trial"] = tracks.attrs["trial"].replace(', "offset": 0', "")
    tracks.attrs["pictures_px"] = '{"side": [80, 60]}'
    assert "offset" not in tracks.attrs["trial"]
    same = replace(trial, views=(replace(trial.views[0], crop=(10, 0, 90, 60)),))
    as_described_now(tracks, same)
    assert not recwarn.list
    other = replace(trial, views=(replace(trial.views[0], crop=(10, 0, 80, 60)),))
    with pytest.warns(InputWarning, match="crop .from none to"):
        as_described_now(tracks, other)


def test_other_frames_than_those_that_were_tracked(trial):
    with pytest.warns(InputWarning, match=r"frames was changed from none to \[3, 30\]"):
        as_described_now(tracked(trial), replace(trial, frames=(3, 30)))


def test_points_that_were_clicked_again_are_said_where_trial_toml_does_not_name_them(trial):
    own = replace(trial, start_points=None)  # as the workbench writes it
    tracks = tracked(own)
    clicks = own.folder / "start.csv"
    clicks.write_text(clicks.read_text().replace("1,2", "8,9"))
    with pytest.warns(InputWarning, match="start.csv changed: pawnb track again"):
        as_described_now(tracks, own)
