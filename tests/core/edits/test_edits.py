"""Corrections: what they do to Tracks, and that the file gives back the present state.

The scene: three pinhole-like views of a wand with two points. View a looks along y
(u = x, v = -z), view b along x (u = y, v = -z), view c along both (u = x + y, v = -z),
so every position can be worked out by hand.
"""

import json
import os
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from pawnb.core.edits import log as edits
from pawnb.core.edits.log import (
    Accept,
    Delete,
    EditLog,
    Hide,
    Interpolate,
    Move,
    Retrack,
    Swap,
    apply_edit,
    replay,
)  # fmt: skip
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks

AXES = {
    "a": np.array([[1.0, 0, 0], [0, 0, -1]]),
    "b": np.array([[0.0, 1, 0], [0, 0, -1]]),
    "c": np.array([[1.0, 1, 0], [0, 0, -1]]),
}


class FlatRig:
    """Orthographic views: least squares by numpy, written independently of pawnb."""

    def __init__(self, names=("a", "b", "c")):
        self.names = names

    def project(self, xyz):
        return np.stack([np.asarray(xyz) @ AXES[n].T for n in self.names], axis=-2)

    def nearest_in_sight(self, name, uv, *, xyz):
        # the view's own two directions by hand, the third as it was
        return xyz + np.linalg.pinv(AXES[name]) @ (uv - AXES[name] @ xyz)

    def triangulate(self, uv):
        flat = np.asarray(uv).reshape(-1, len(self.names), 2)
        xyz, residual = [], []
        for one in flat:
            keep = np.isfinite(one).all(axis=1)
            if keep.sum() < 2:
                xyz.append([np.nan] * 3)
                residual.append(np.nan)
                continue
            matrix = np.concatenate([AXES[n] for n, k in zip(self.names, keep, strict=True) if k])
            found = np.linalg.lstsq(matrix, one[keep].ravel(), rcond=None)[0]
            off = (matrix @ found - one[keep].ravel()).reshape(-1, 2)
            xyz.append(found)
            residual.append(np.sqrt((off**2).sum(axis=1).mean()))
        shape = np.shape(uv)[:-2]
        return SimpleNamespace(
            xyz=np.reshape(xyz, (*shape, 3)), residual_px=np.reshape(residual, shape)
        )


def wand(n=6, views=("a", "b", "c")):
    """Point P goes along x by 1 mm a frame, point Q stands at (0, 10, 5): constant residual 0."""
    tracks = make_tracks(np.arange(3, 3 + n), ["P", "Q"], fps=100.0, views=views, unit="mm")
    xyz = np.zeros((n, 2, 3))
    xyz[:, 0, 0] = np.arange(n)
    xyz[:, 1] = [0, 10, 5]
    tracks["position"].values[..., 0] = np.moveaxis(xyz, 2, 1)
    uv = FlatRig(views).project(xyz)  # (n, point, view, 2)
    tracks["image_position"].values[..., 0] = np.transpose(uv, (0, 2, 3, 1))
    for name in ("origin", "image_origin"):
        tracks[name].values[:] = ORIGIN_CODE["measured"]
    for name in ("confidence", "image_confidence"):
        tracks[name].values[:] = 0.5
    tracks["residual"].values[:] = 0.0
    return tracks


def origin(tracks, frame, point, view=None):
    name = "origin" if view is None else "image_origin"
    where = {"time": int(frame - tracks["frame"].values[0])}
    chosen = tracks[name].isel(**where).sel(keypoint=point)
    code = int(chosen.squeeze() if view is None else chosen.sel(view=view).squeeze())
    return next(word for word, c in ORIGIN_CODE.items() if c == code)


def xyz_of(tracks, frame, point):
    row = int(frame - tracks["frame"].values[0])
    return tracks["position"].isel(time=row).sel(keypoint=point).values[:, 0]


def uv_of(tracks, frame, view, point):
    row = int(frame - tracks["frame"].values[0])
    return tracks["image_position"].isel(time=row).sel(view=view, keypoint=point).values[:, 0]


def test_move_solves_the_point_again_and_nothing_else():
    tracks = wand()
    # P in frame 5 is at x = 2; the true place seen by a and b is x = 4, y = 1
    new = apply_edit(tracks, Move(frame=5, view="a", point="P", u=4, v=-3), rig=FlatRig())
    np.testing.assert_array_equal(uv_of(new, 5, "a", "P"), [4, -3])
    assert origin(new, 5, "P", "a") == "edited"
    assert origin(new, 5, "P") == "edited"
    # by hand: min (x-4)^2 + y^2 + (x+y-2)^2 gives x = 10/3, y = -2/3; z = mean(3, 0, 0) = 1
    np.testing.assert_allclose(xyz_of(new, 5, "P"), [10 / 3, -2 / 3, 1], atol=1e-12)
    # squared distances: a 4/9 + 4, b 4/9 + 1, c 4/9 + 1; RMS over three views
    residual = float(new["residual"].isel(time=2).sel(keypoint="P").squeeze())
    assert residual == pytest.approx(np.sqrt((3 * 4 / 9 + 6) / 3))
    # confidence: mean of 1, 0.5 and 0.5
    assert float(new["confidence"].isel(time=2).sel(keypoint="P").squeeze()) == pytest.approx(2 / 3)
    # the original is untouched, and so is every other frame and point
    assert origin(tracks, 5, "P", "a") == "measured"
    rest = [0, 1, 3, 4, 5]
    xr.testing.assert_identical(new.isel(time=rest), tracks.isel(time=rest))
    xr.testing.assert_identical(new.sel(keypoint="Q"), tracks.sel(keypoint="Q"))


def test_what_a_tracker_said_of_a_point_is_not_said_of_a_persons_word():
    tracks = wand()
    for name in ("image_residual", "image_separation"):
        tracks[name] = tracks["image_confidence"].copy()
    for name in ("revision", "passes_apart"):
        tracks[name] = tracks["residual"].copy()
    tracks["image_offset"] = tracks["image_position"].copy()
    # the third frame
    new = apply_edit(tracks, Move(frame=5, view="a", point="P", u=4, v=-3), rig=FlatRig())
    told = ("image_residual", "image_offset", "image_separation", "revision", "passes_apart")
    for name in told:
        gone = np.isnan(new[name].sel(keypoint="P").isel(individual=0).to_numpy())
        np.testing.assert_array_equal(np.flatnonzero(gone.reshape(6, -1).all(axis=1)), [2], name)
        assert not np.isnan(new[name].sel(keypoint="Q")).any()


def test_hide_leaves_the_point_to_the_other_views_then_to_none():
    tracks, rig = wand(), FlatRig()
    one = apply_edit(tracks, Hide(frame=4, view="a", point="Q"), rig=rig)
    assert np.isnan(uv_of(one, 4, "a", "Q")).all()
    assert origin(one, 4, "Q", "a") == "missing"
    np.testing.assert_allclose(xyz_of(one, 4, "Q"), [0, 10, 5], atol=1e-12)
    two = apply_edit(one, Hide(frame=4, view="b", point="Q"), rig=rig)
    assert np.isnan(xyz_of(two, 4, "Q")).all()
    assert origin(two, 4, "Q") == "missing"
    assert float(two["confidence"].isel(time=1).sel(keypoint="Q").squeeze()) == 0
    # one view is not enough for a 3D point, though it still sees it
    assert origin(two, 4, "Q", "c") == "measured"


def test_predicted_views_count_only_where_fewer_than_two_see_the_point():
    tracks = wand()
    tracks["image_origin"].loc[{"view": "c"}] = ORIGIN_CODE["predicted"]
    tracks["image_position"].loc[{"view": "c"}] += 30.0
    rig = FlatRig()
    new = apply_edit(tracks, Move(frame=3, view="a", point="P", u=0, v=0), rig=rig)
    np.testing.assert_allclose(xyz_of(new, 3, "P"), [0, 0, 0], atol=1e-12)
    new = apply_edit(new, Hide(frame=3, view="b", point="P"), rig=rig)
    # now a (0, 0) and the prediction of c (30, 30): x = 0, y = 30, z = (0 - 30) / 2
    np.testing.assert_allclose(xyz_of(new, 3, "P"), [0, 30, -15], atol=1e-12)


def test_a_point_of_one_view_stays_as_far_from_its_camera_when_a_person_places_it():
    """It had a place in space by what the tracker knew of it; a correction took that away."""
    tracks, rig = wand(), FlatRig()
    tracks["image_origin"].values[2, 1:, 0] = ORIGIN_CODE["reprojected"]
    tracks["origin"].values[2, 0] = ORIGIN_CODE["resolved"]
    u, v = uv_of(tracks, 5, "a", "P")
    same = apply_edit(tracks, Accept(frame=5, view="a", point="P", u=u, v=v), rig=rig)
    np.testing.assert_allclose(xyz_of(same, 5, "P"), xyz_of(tracks, 5, "P"), atol=1e-12)
    # view a looks along y: x and z are what the person says, y stays 0
    new = apply_edit(tracks, Move(frame=5, view="a", point="P", u=4, v=-3), rig=rig)
    np.testing.assert_allclose(xyz_of(new, 5, "P"), [4, 0, 3], atol=1e-12)
    assert origin(new, 5, "P") == "resolved"
    np.testing.assert_allclose(uv_of(new, 5, "b", "P"), [0, -3], atol=1e-12)
    np.testing.assert_allclose(uv_of(new, 5, "c", "P"), [4, -3], atol=1e-12)
    # placed in a second view it is where both lines of sight meet: y = 2
    new = apply_edit(new, Move(frame=5, view="b", point="P", u=2, v=-3), rig=rig)
    np.testing.assert_allclose(xyz_of(new, 5, "P"), [4, 2, 3], atol=1e-12)
    assert origin(new, 5, "P") == "edited"
    # what was taken away in space has no distance that could be kept
    gone = apply_edit(new, Delete(frame=5, stop=6, point="P"), rig=rig)
    gone = apply_edit(gone, Move(frame=5, view="a", point="P", u=4, v=-3), rig=rig)
    assert np.isnan(xyz_of(gone, 5, "P")).all()
    assert origin(gone, 5, "P") == "missing"


def test_reprojected_positions_follow_the_3d_point_and_never_count():
    tracks = wand()
    tracks["image_origin"].loc[{"view": "c"}] = ORIGIN_CODE["reprojected"]
    rig = FlatRig(("c", "a", "b"))  # another order than the tracks'
    new = apply_edit(tracks, Move(frame=3, view="a", point="P", u=8, v=0), rig=rig)
    np.testing.assert_allclose(xyz_of(new, 3, "P"), [8, 0, 0], atol=1e-12)
    np.testing.assert_allclose(uv_of(new, 3, "c", "P"), [8, 0], atol=1e-12)
    assert origin(new, 3, "P", "c") == "reprojected"


def test_accept_marks_a_predicted_point_as_a_persons_word():
    tracks = wand()
    tracks["image_origin"].loc[{"view": "a"}] = ORIGIN_CODE["predicted"]
    u, v = uv_of(tracks, 6, "a", "P")
    new = apply_edit(tracks, Accept(frame=6, view="a", point="P", u=u, v=v), rig=FlatRig())
    assert origin(new, 6, "P", "a") == "edited"
    np.testing.assert_array_equal(uv_of(new, 6, "a", "P"), [u, v])


def test_swap_everywhere_exchanges_from_that_frame_on():
    tracks = wand()
    new = apply_edit(tracks, Swap(frame=5, first="P", second="Q"), rig=FlatRig())
    xr.testing.assert_identical(new.isel(time=[0, 1]), tracks.isel(time=[0, 1]))
    for name in ("position", "image_position", "origin", "image_confidence"):
        later = {"time": slice(2, None)}
        np.testing.assert_array_equal(
            new[name].isel(later).sel(keypoint=["P", "Q"]).values,
            tracks[name].isel(later).sel(keypoint=["Q", "P"]).values,
        )


def test_swap_in_one_view_is_that_views_mistake_mended():
    right = wand()
    wrong = right.copy(deep=True)
    later = {"time": slice(2, None)}
    values = wrong["image_position"].values
    values[2:, 0] = values[2:, 0][:, :, ::-1]  # view a mistook P for Q from frame 5 on
    wrong["position"].values[2:] = -99
    mended = apply_edit(wrong, Swap(frame=5, first="P", second="Q", view="a"), rig=FlatRig())
    np.testing.assert_array_equal(mended["image_position"], right["image_position"])
    np.testing.assert_allclose(
        mended["position"].isel(later), right["position"].isel(later), atol=1e-12
    )
    np.testing.assert_allclose(mended["residual"].isel(later), 0, atol=1e-12)


def flat_wand():
    tracks = make_tracks([0, 1], ["P"], fps=50.0, views=["a", "b"], space=("x", "y"))
    tracks["image_position"].values[:] = 1.0
    tracks["image_origin"].values[:] = ORIGIN_CODE["measured"]
    return tracks


def test_uncalibrated_position_is_that_of_the_first_view_that_has_the_point():
    new = apply_edit(flat_wand(), Move(frame=1, view="b", point="P", u=20, v=30))
    np.testing.assert_array_equal(xyz_of(new, 1, "P"), [1, 1])
    new = apply_edit(new, Hide(frame=1, view="a", point="P"))
    np.testing.assert_array_equal(xyz_of(new, 1, "P"), [20, 30])
    scaled = apply_edit(new, Move(frame=1, view="a", point="P", u=8, v=4), px_per_unit=4.0)
    np.testing.assert_array_equal(xyz_of(scaled, 1, "P"), [2, 1])


def shift_by_100(tracks, frame):
    """A tracker that finds everything 100 px further right from a frame on, hidden or not."""
    new = tracks.copy(deep=True)
    later = new["frame"].values >= frame
    found = np.nan_to_num(new["image_position"].values[later], nan=7.0)
    found[:, :, 0] += 100
    new["image_position"].values[later] = found
    new["image_origin"].values[later] = ORIGIN_CODE["measured"]
    return new


def test_tracking_again_keeps_what_a_person_corrected_from_there_on():
    log = EditLog(wand(), rig=FlatRig(), retrack=shift_by_100)
    log.apply(Move(frame=6, view="a", point="P", u=50, v=60))
    log.apply(Hide(frame=7, view="b", point="Q"))
    log.apply(Swap(frame=7, first="P", second="Q", view="b"))  # the hidden one is P now
    before = log.tracks
    log.apply(Retrack(frame=4))
    new = log.tracks
    np.testing.assert_array_equal(uv_of(new, 6, "a", "P"), [50, 60])
    assert origin(new, 6, "P", "a") == "edited"
    assert np.isnan(uv_of(new, 7, "b", "P")).all()
    assert np.isfinite(uv_of(new, 7, "b", "Q")).all()
    np.testing.assert_array_equal(
        uv_of(new, 5, "a", "P"), np.add(uv_of(before, 5, "a", "P"), [100, 0])
    )
    xr.testing.assert_identical(new.isel(time=[0]), before.isel(time=[0]))
    log.undo()
    xr.testing.assert_identical(log.tracks, before)


def test_tracking_again_without_a_tracker_says_so():
    with pytest.raises(InputError) as error:
        apply_edit(wand(), Retrack(frame=4), rig=FlatRig())
    assert str(error.value) == (
        "tracking again from frame 4 is not possible here: no tracker was given; "
        "open the tracks together with their trial."
    )


@pytest.mark.parametrize(
    ("edit", "text"),
    [
        (
            Move(frame=99, view="a", point="P", u=1, v=1),
            "frame 99 is not in the tracks (3 to 8).",
        ),
        (
            Move(frame=4, view="aa", point="P", u=1, v=1),
            "the tracks have no view 'aa' (did you mean 'a'?); expected a, b, c.",
        ),
        (
            Hide(frame=4, view="a", point="R"),
            "the tracks have no point 'R'; expected P, Q.",
        ),
        (
            Swap(frame=4, first="P", second="P"),
            "a point cannot be exchanged with itself ('P').",
        ),
    ],
)
def test_an_edit_that_does_not_fit_is_refused_and_changes_nothing(tmp_path, edit, text):
    log = EditLog(wand(), tmp_path / "edits.jsonl", rig=FlatRig())
    with pytest.raises(InputError) as error:
        log.apply(edit)
    assert str(error.value) == text
    assert not (tmp_path / "edits.jsonl").exists()
    xr.testing.assert_identical(log.tracks, wand())


def test_tracks_in_3d_need_the_rig():
    with pytest.raises(InputError, match=r"no calibration was given .* give rig=\.$"):
        apply_edit(wand(), Hide(frame=4, view="a", point="P"))


# --- the file -------------------------------------------------------------------------

FRAMES = st.integers(3, 8)
VIEWS = st.sampled_from(["a", "b", "c"])
POINTS = st.sampled_from(["P", "Q"])
PIXELS = st.floats(-1e3, 1e3)
EARLY, STOPS = st.integers(3, 5), st.integers(6, 9)
RECORDS = st.one_of(
    st.builds(Move, frame=FRAMES, view=VIEWS, point=POINTS, u=PIXELS, v=PIXELS),
    st.builds(Accept, frame=FRAMES, view=VIEWS, point=POINTS, u=PIXELS, v=PIXELS),
    st.builds(Hide, frame=FRAMES, view=VIEWS, point=POINTS),
    st.builds(Swap, frame=FRAMES, first=st.just("P"), second=st.just("Q"), view=st.none() | VIEWS),
    st.builds(Retrack, frame=FRAMES),
    # stretches: frames 3 to 5 at the latest, up to frame 8 at the latest
    st.builds(Hide, frame=EARLY, view=st.none() | VIEWS, point=POINTS, stop=STOPS),
    st.builds(Delete, frame=EARLY, view=st.none() | VIEWS, point=POINTS, stop=STOPS),
    st.builds(Swap, frame=EARLY, first=st.just("P"), second=st.just("Q"), stop=STOPS),
    st.builds(Retrack, frame=EARLY, stop=STOPS),
)


@given(RECORDS)
def test_a_line_gives_back_the_very_record(record):
    assert edits.EDIT_LINES.from_line(edits.EDIT_LINES.to_line(record), where="here") == record


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.lists(st.one_of(RECORDS, st.sampled_from(["undo", "redo"])), max_size=12), st.data())
def test_replay_gives_the_present_state_whatever_was_done(tmp_path_factory, steps, data):
    path = tmp_path_factory.mktemp("log") / "edits.jsonl"
    options = {"rig": FlatRig(), "retrack": shift_by_100}
    base = wand()
    log = EditLog(base, path, **options)
    states = [base]  # the plain account of undo: a list of states and a place in it
    place = 0
    for step in steps:
        if data.draw(st.integers(0, 4)) == 0:  # closed and opened again in between
            log = EditLog(base, path, **options)
        if step == "undo":
            log.undo()
            place = max(place - 1, 0)
        elif step == "redo":
            log.redo()
            place = min(place + 1, len(states) - 1)
        else:
            log.apply(step)
            states[place + 1 :] = [log.tracks]
            place += 1
        xr.testing.assert_allclose(log.tracks, states[place], rtol=0, atol=1e-9)
    again = EditLog(base, path, **options)
    xr.testing.assert_allclose(again.tracks, log.tracks, rtol=0, atol=1e-9)
    assert again.active == log.active
    assert (again.can_undo, again.can_redo) == (log.can_undo, log.can_redo)


def test_every_line_is_on_disk_when_apply_returns(tmp_path):
    path = tmp_path / "results" / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    log.apply(Move(frame=4, view="a", point="P", u=1.5, v=2.25))
    assert [json.loads(line) for line in path.read_text().splitlines()] == [
        {"edit": "move", "frame": 4, "view": "a", "point": "P", "u": 1.5, "v": 2.25}
    ]
    log.undo()
    log.redo()
    log.undo()
    kinds = [json.loads(line)["edit"] for line in path.read_text().splitlines()]
    assert kinds == ["move", "undo", "redo", "undo"]


def test_a_line_is_forced_to_the_disk_whole_before_the_tracks_change(tmp_path, monkeypatch):
    path = tmp_path / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    forced = []
    monkeypatch.setattr("os.fsync", lambda descriptor: forced.append(path.read_text()))
    log.apply(Hide(frame=4, view="a", point="P"))
    # the file, and, where folders can be forced, that there is one
    times = 1 if os.name == "nt" else 2
    assert forced == ['{"edit": "hide", "frame": 4, "view": "a", "point": "P"}\n'] * times
    log.undo()
    assert len(forced) == times + 1


def test_undo_with_nothing_to_undo_writes_nothing(tmp_path):
    path = tmp_path / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    assert log.undo() is None
    assert log.redo() is None
    assert not path.exists()


def test_a_new_edit_after_undo_forgets_the_redo(tmp_path):
    log = EditLog(wand(), tmp_path / "edits.jsonl", rig=FlatRig())
    log.apply(Hide(frame=4, view="a", point="P"))
    log.undo()
    assert log.can_redo
    log.apply(Hide(frame=5, view="a", point="P"))
    assert not log.can_redo
    assert log.redo() is None


def test_half_written_last_line_is_reported_skipped_and_kept(tmp_path):
    path = tmp_path / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    log.apply(Hide(frame=4, view="a", point="P"))
    log.apply(Hide(frame=5, view="a", point="P"))
    whole = path.read_bytes()
    path.write_bytes(whole[:-9])
    again = EditLog(wand(), path, rig=FlatRig())
    assert again.active == (Hide(frame=4, view="a", point="P"),)
    fragment = whole.splitlines()[1][:-8].decode()
    assert again.notes == [
        "edits.jsonl: the last line was only half written when the program ended, and is left "
        f"out: {fragment!r}. Everything before it is there."
    ]
    assert path.read_bytes() == whole[:-9]  # opening alone changes nothing
    again.apply(Hide(frame=6, view="a", point="P"))
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert lines[1] == {"edit": "unfinished", "text": fragment}
    last = EditLog(wand(), path, rig=FlatRig())
    assert last.notes == []
    assert [edit.frame for edit in last.active] == [4, 6]


@pytest.mark.slow
def test_every_cut_of_the_file_can_be_opened_and_gone_on_with(tmp_path):
    path = tmp_path / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    for frame in (4, 5):
        log.apply(Move(frame=frame, view="a", point="P", u=frame, v=0.5))
    whole = path.read_bytes()
    ends = [i + 1 for i, byte in enumerate(whole) if byte == ord("\n")]
    for cut in range(len(whole) + 1):
        path.write_bytes(whole[:cut])
        again = EditLog(wand(), path, rig=FlatRig())
        # a line counts once its closing brace is there, with or without its end of line
        assert len(again.active) == sum(cut >= end - 1 for end in ends)
        again.apply(Hide(frame=8, view="b", point="Q"))
        reread = EditLog(wand(), path, rig=FlatRig())
        assert reread.active == again.active
        assert reread.notes == []


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("{oops", "edits.jsonl, line 1: not a JSON object: '{oops'; mend or remove that line."),
        (
            '{"edit": "mvoe", "frame": 1}',
            "edits.jsonl, line 1: unknown kind of edit 'mvoe' (did you mean 'move'?); expected "
            "move, accept, hide, delete, interpolate, swap, pose, retrack, undo, redo.",
        ),
        (
            '{"edit": "hide", "frame": 1, "view": "a"}',
            "edits.jsonl, line 1: a hide needs 'point'; mend or remove that line.",
        ),
        (
            '{"edit": "hide", "frame": 1.5, "view": "a", "point": "P"}',
            "edits.jsonl, line 1: frame is 1.5; expected a whole number.",
        ),
        (
            '{"edit": "move", "frame": 1, "view": "a", "point": "P", "u": NaN, "v": 1}',
            "edits.jsonl, line 1: u is nan; expected a number.",
        ),
        (
            '{"edit": "retrack", "frame": 1, "veiw": "a"}',
            "edits.jsonl, line 1: unknown field 'veiw'; a retrack has frame, learn, since, stop.",
        ),
        (
            "[1]",
            "edits.jsonl, line 1: unknown kind of edit None; expected "
            "move, accept, hide, delete, interpolate, swap, pose, retrack, undo, redo.",
        ),
    ],
)
def test_a_damaged_line_in_the_middle_is_named(tmp_path, line, text):
    path = tmp_path / "edits.jsonl"
    path.write_text(line + '\n{"edit": "undo"}\n')
    with pytest.raises(InputError) as error:
        EditLog(wand(), path, rig=FlatRig())
    assert str(error.value) == text


def test_tracking_again_with_new_colours_is_kept_and_done_again(tmp_path):
    path = tmp_path / "edits.jsonl"
    asked = []

    def tracker(tracks, frame, **options):
        asked.append((frame, options))
        return tracks

    log = EditLog(wand(), path, rig=FlatRig(), retrack=tracker)
    log.apply(Retrack(frame=4))
    log.apply(Retrack(frame=5, learn=True))
    assert path.read_text().splitlines() == [
        '{"edit": "retrack", "frame": 4}',
        '{"edit": "retrack", "frame": 5, "learn": true}',
    ]
    again = EditLog(wand(), path, rig=FlatRig(), retrack=tracker)
    assert again.active == (Retrack(frame=4), Retrack(frame=5, learn=True))
    assert asked == [(4, {}), (5, {"learn": True})] * 2
    path.write_text('{"edit": "retrack", "frame": 5, "learn": 1}\n{"edit": "undo"}\n')
    with pytest.raises(InputError, match="learn is 1; expected true or false"):
        EditLog(wand(), path, rig=FlatRig(), retrack=tracker)


def test_two_windows_on_one_file_do_not_mix_their_lines(tmp_path):
    path = tmp_path / "edits.jsonl"
    first = EditLog(wand(), path, rig=FlatRig())
    second = EditLog(wand(), path, rig=FlatRig())
    second.apply(Hide(frame=4, view="a", point="P"))
    before = first.tracks
    with pytest.raises(InputError, match=r"changed by another window .* this correction was not"):
        first.apply(Hide(frame=5, view="a", point="P"))
    xr.testing.assert_identical(first.tracks, before)
    assert not first.can_undo
    assert len(path.read_text().splitlines()) == 1


def test_a_line_that_cannot_be_written_changes_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    log = EditLog(wand(), tmp_path / "file" / "edits.jsonl", rig=FlatRig())
    with pytest.raises(InputError, match="cannot be written"):
        log.apply(Hide(frame=5, view="a", point="P"))
    xr.testing.assert_identical(log.tracks, wand())
    assert not log.can_undo


# --- saved tracks ---------------------------------------------------------------------


def test_saved_tracks_get_only_what_came_after(tmp_path):
    path = tmp_path / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    log.apply(Swap(frame=4, first="P", second="Q"))
    saved = log.stamped()
    log.apply(Move(frame=5, view="a", point="P", u=3, v=3))
    again = EditLog(saved, path, rig=FlatRig())
    xr.testing.assert_allclose(again.tracks.drop_attrs(), log.tracks.drop_attrs())
    assert again.notes == []
    assert len(again.active) == 2
    again.undo()
    assert not again.can_undo  # the swap is in the saved tracks
    fresh = replay(wand(), path, rig=FlatRig())
    np.testing.assert_array_equal(fresh["image_position"], saved["image_position"])


def test_tracks_saved_before_an_undo_are_refused_with_the_way_out(tmp_path):
    path = tmp_path / "edits.jsonl"
    log = EditLog(wand(), path, rig=FlatRig())
    log.apply(Swap(frame=4, first="P", second="Q"))
    saved = log.stamped()
    log.undo()
    with pytest.raises(InputError) as error:
        EditLog(saved, path, rig=FlatRig())
    assert str(error.value) == (
        "these tracks contain corrections that were undone after they were saved (1 then, 0 now); "
        "track the trial again, or open the tracks from before: the corrections in force are "
        "applied to them by themselves."
    )


def test_tracks_saved_with_another_file_get_all_of_this_one(tmp_path):
    other = EditLog(wand(), tmp_path / "other.jsonl", rig=FlatRig())
    other.apply(Hide(frame=4, view="b", point="Q"))
    saved = other.stamped()
    path = tmp_path / "edits.jsonl"
    EditLog(wand(), path, rig=FlatRig()).apply(Hide(frame=5, view="a", point="P"))
    log = EditLog(saved, path, rig=FlatRig())
    assert np.isnan(uv_of(log.tracks, 4, "b", "Q")).all()
    assert np.isnan(uv_of(log.tracks, 5, "a", "P")).all()
    assert log.notes == [
        "these tracks contain corrections that this edits.jsonl does not list (1); "
        "they cannot be undone."
    ]


def test_replay_of_no_file_says_which():
    with pytest.raises(InputError, match=r"nowhere\.jsonl: no such file; expected the edits"):
        replay(wand(), "nowhere.jsonl")


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (Move(frame=4, view="a", point="P", u=1, v=1), "P in a moved in frame 4"),
        (Accept(frame=4, view="a", point="P", u=1, v=1), "P in a accepted in frame 4"),
        (Hide(frame=4, view="a", point="P"), "P in a marked as not visible in frame 4"),
        (Swap(frame=4, first="P", second="Q"), "P and Q exchanged from frame 4 on"),
        (Swap(frame=4, first="P", second="Q", view="a"), "P and Q exchanged in a from frame 4 on"),
        (Hide(frame=4, view=None, point="P", stop=7), "P marked as not visible in frames 4 to 6"),
        (Delete(frame=4, stop=5, point="P", view="a"), "P in a deleted in frame 4"),
        (Interpolate(frame=4, stop=7, point="P"), "P interpolated in frames 4 to 6"),
        (Swap(frame=4, first="P", second="Q", stop=7), "P and Q exchanged in frames 4 to 6"),
        (Retrack(frame=4, since=3, stop=7), "tracked again in frames 3 to 6"),
        (Retrack(frame=4), "tracked again from frame 4 on"),
        (Retrack(frame=4, learn=True), "tracked again from frame 4 on, colours learnt there"),
    ],
)
def test_edits_in_words(edit, words):
    assert edits.describe_edit(edit) == words
