"""Method pawnb tracks only the stretch again that a correction touches, however good the hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.core.edits.log import EditLog, Move, Retrack, Swap
from pawnb.core.rig import load_rig
from pawnb.synthetic import render_mouse_trial
from pawnb.trial import load_trial
from pawnb.workflow.tracking.track import retrack, track


def quiet(_done, _total):
    """No bar."""


class Corrected:
    """A tracked trial that is corrected as in the reviewer's window."""

    def __init__(self, folder, start=None):
        self.trial = load_trial(folder)
        self.rig = load_rig(self.trial)
        # a small scene is not good by colour, and stretches are what colour is tracked again in
        by_colour = {"evidence": "colour"}
        self.tracks = track(self.trial, start=start, settings=by_colour, progress=quiet)

    def log(self, path):
        return EditLog(
            self.tracks, path, rig=self.rig,
            retrack=lambda tracks, frame, **o: retrack(
                self.trial, tracks, frame, progress=quiet, **o
            ),
        )  # fmt: skip

    def move(self, log, point, frame, *, off_px=0.0):
        """Put a point where it was tracked, so many px to the right, in its own views."""
        for view in self.trial.views:
            if point in view.points:
                at = self.tracks["image_position"].sel(view=view.name, keypoint=point)[frame, :, 0]
                place = {"u": float(at[0]) + off_px, "v": float(at[1])}
                log.apply(Move(frame=frame, view=view.name, point=point, **place))


def changed_rows(new, old, point):
    """Return the rows in which anything of a point differs."""
    rows = np.zeros(old.sizes["time"], dtype=bool)
    for name, variable in old.data_vars.items():
        if "keypoint" not in variable.dims:
            continue
        a, b = (t[name].sel(keypoint=point).to_numpy() for t in (new, old))
        same = (a == b) | (np.isnan(a) & np.isnan(b))
        rows |= ~same.reshape(len(rows), -1).all(axis=1)
    return np.flatnonzero(rows)


def assert_others_stay(new, old, points):
    for point in points:
        assert not len(changed_rows(new, old, point)), point


@pytest.fixture(scope="module")
def short(rendered_trial):
    return Corrected(rendered_trial)


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stretch") / "mouse"
    render_mouse_trial(folder, frames=110, scale=0.2, seed=1)
    return Corrected(folder)


@pytest.mark.slow
def test_a_hand_that_is_a_pixel_off_moves_the_track_about_its_frame_only(short, tmp_path):
    """Ten rows on the old track end the stretch; a pixel may pull a few rows before them."""
    log = short.log(tmp_path / "edits.jsonl")
    short.move(log, "HL", 15, off_px=1.0)
    before = log.tracks
    log.apply(Retrack(frame=15))
    rows = changed_rows(log.tracks, before, "HL")
    assert len(rows)
    assert rows[0] >= 15
    assert rows[-1] <= 15 + 10 + 5
    assert_others_stay(log.tracks, before, ["FR", "HR", "FL"])
    place = {"time": 15, "individual": 0}
    for name in ("image_position", "image_origin"):
        np.testing.assert_array_equal(
            log.tracks[name].isel(place).sel(view=["cam3", "cam4"], keypoint="HL"),
            before[name].isel(place).sel(view=["cam3", "cam4"], keypoint="HL"),
        )


@pytest.fixture(scope="module")
def clicked_late(rendered_trial):
    """The same trial, clicked in frame 30 of 40."""
    truth = pd.read_csv(rendered_trial / "truth" / "tracks.csv")
    truth = truth.query("frame == 30 and visible == 1")
    start = pd.read_csv(rendered_trial / "start.csv")[["view", "point"]].merge(truth)
    return Corrected(rendered_trial, start[["frame", "view", "point", "u", "v"]])


@pytest.mark.slow
def test_a_correction_before_the_clicks_changes_its_stretch_only(clicked_late, tmp_path):
    log = clicked_late.log(tmp_path / "edits.jsonl")
    clicked_late.move(log, "HL", 5, off_px=1.0)
    before = log.tracks
    log.apply(Retrack(frame=5))
    rows = changed_rows(log.tracks, before, "HL")
    assert len(rows)
    assert rows[0] >= 5
    assert rows[-1] <= 5 + 10 + 5
    assert_others_stay(log.tracks, before, ["FR", "HR", "FL"])


@pytest.mark.slow
def test_colours_learnt_anew_before_the_clicks_leave_the_rest_as_clicked(clicked_late, tmp_path):
    """One paw is put right in frame 5: the animal's size is still told by frame 30, where all are.

    A pixel is 5 px at full scale: the paw stays where it was to within that.
    """
    log = clicked_late.log(tmp_path / "edits.jsonl")
    clicked_late.move(log, "HR", 5)
    before = log.tracks
    log.apply(Retrack(frame=5, learn=True))
    own = {"keypoint": "HR", "view": ["cam1", "cam2"]}
    away = (log.tracks["image_position"] - before["image_position"]).sel(own)
    assert np.abs(away).max() < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("point", "frame"), [("HR", 50), ("FL", 50)])
def test_a_correction_of_three_pixels_changes_rows_near_it_only(long, tmp_path, point, frame):
    """3 px here are 15 px at full scale: a third of a hind paw.

    Where the paw is hidden soon after, as in a swing that begins then, it is on its old track
    again when it is seen again; ten rows on it end the stretch, and a few before them may be
    pulled.
    """
    truth = pd.read_csv(long.trial.folder / "truth" / "tracks.csv").query("point == @point")
    own = truth[
        truth["view"].isin([view.name for view in long.trial.views if point in view.points])
    ]
    seen = own.loc[own["visible"] > 0, "frame"]
    back = seen[seen >= frame + 10].min()
    log = long.log(tmp_path / "edits.jsonl")
    long.move(log, point, frame, off_px=3.0)
    before = log.tracks
    log.apply(Retrack(frame=frame))
    rows = changed_rows(log.tracks, before, point)
    assert len(rows)
    assert frame <= rows[0]
    assert rows[-1] <= back + 10 + 5
    assert_others_stay(log.tracks, before, {"FR", "HR", "FL", "HL"} - {point})


@pytest.mark.slow
@pytest.mark.parametrize("corrected", [["FR", "HR"], ["FR"]])
def test_a_swapped_stretch_is_replaced_whole_and_nothing_else(long, tmp_path, corrected):
    """FR and HR change names in frames 40 to 69; one of them put right sets both right."""
    log = long.log(tmp_path / "edits.jsonl")
    for frame in (40, 70):
        log.apply(Swap(frame=frame, first="FR", second="HR"))
    for point in corrected:
        long.move(log, point, 40)
    before = log.tracks
    log.apply(Retrack(frame=40))
    for point in ("FR", "HR"):
        rows = changed_rows(log.tracks, before, point)
        assert rows[0] == 40 or point in corrected  # its own row is as it was put
        assert rows[-1] <= 70 + 10 + 10
        at = {"keypoint": point, "view": ["cam1", "cam2"]}
        away = log.tracks["image_position"].sel(at) - long.tracks["image_position"].sel(at)
        assert np.abs(away).max() < 1.0  # the two are 15 px apart and more
    assert_others_stay(log.tracks, before, ["FL", "HL"])


@pytest.mark.slow
def test_what_was_learnt_anew_stays_when_tracking_again_later(long, tmp_path):
    """HL is clicked 3 px farther on in three frames, and that is learnt; then comes a pixel."""
    log = long.log(tmp_path / "edits.jsonl")
    for frame in (10, 20, 28):
        long.move(log, "HL", frame, off_px=3.0)
    log.apply(Retrack(frame=28, learn=True))
    assert changed_rows(log.tracks, long.tracks, "HL")[-1] == 109
    long.move(log, "HL", 50, off_px=3.0)
    before = log.tracks
    log.apply(Retrack(frame=50))
    rows = changed_rows(log.tracks, before, "HL")
    assert len(rows)
    assert rows[-1] <= 50 + 10 + 10
    # the paws of its own side may make way for it about there
    assert_others_stay(log.tracks, before, ["FR", "HR"])
