"""Corrections of a stretch of frames, on the wand of ``test_edits`` and on paths known by hand."""

import numpy as np
import pytest
import xarray as xr
from test_edits import FlatRig, origin, uv_of, wand, xyz_of

from pawnb.core.edits.log import (
    Delete,
    EditLog,
    Hide,
    Interpolate,
    Move,
    Retrack,
    Swap,
    apply_edit,
)  # fmt: skip
from pawnb.errors import InputError

RIG = FlatRig()


def rows(tracks, *frames):
    return tracks.isel(time=np.isin(tracks["frame"], frames))


def test_a_swap_of_a_stretch_leaves_what_is_around_it():
    tracks = wand()
    new = apply_edit(tracks, Swap(frame=4, stop=6, first="P", second="Q"), rig=RIG)
    for frame in (4, 5):
        np.testing.assert_array_equal(xyz_of(new, frame, "P"), xyz_of(tracks, frame, "Q"))
        np.testing.assert_array_equal(uv_of(new, frame, "a", "Q"), uv_of(tracks, frame, "a", "P"))
    rest = (3, 6, 7, 8)
    xr.testing.assert_identical(rows(new, *rest), rows(tracks, *rest))
    # the same exchange again undoes it
    again = apply_edit(new, Swap(frame=4, stop=6, first="Q", second="P"), rig=RIG)
    xr.testing.assert_identical(again, tracks)


def test_a_stretch_is_hidden_in_one_view_and_deleted_in_all():
    tracks = wand()
    new = apply_edit(tracks, Hide(frame=4, stop=7, view="a", point="P"), rig=RIG)
    assert [origin(new, f, "P", "a") for f in range(3, 9)] == [
        "measured", "missing", "missing", "missing", "measured", "measured",
    ]  # fmt: skip
    # the others still see it
    np.testing.assert_allclose(xyz_of(new, 5, "P"), [2, 0, 0], atol=1e-12)
    gone = apply_edit(tracks, Delete(frame=4, stop=7, point="P"), rig=RIG)
    assert np.isnan(xyz_of(gone, 5, "P")).all()
    assert origin(gone, 5, "P") == "missing"
    xr.testing.assert_identical(rows(gone, 3, 7, 8), rows(tracks, 3, 7, 8))
    xr.testing.assert_identical(gone.sel(keypoint="Q"), tracks.sel(keypoint="Q"))


def test_a_straight_path_is_interpolated_straight_in_every_view_and_in_space():
    """A cubic through points on a line is that line."""
    tracks = wand()
    broken = tracks.copy(deep=True)
    broken["image_position"].values[2:4, :, :, 0] += 50.0
    new = apply_edit(broken, Interpolate(frame=5, stop=7, point="P"), rig=RIG)
    np.testing.assert_allclose(new["image_position"], tracks["image_position"], atol=1e-9)
    np.testing.assert_allclose(new["position"], tracks["position"], atol=1e-9)
    assert [origin(new, f, "P", "b") for f in (4, 5, 6, 7)] == [
        "measured", "predicted", "predicted", "measured",
    ]  # fmt: skip
    # in one view only
    one = apply_edit(broken, Interpolate(frame=5, stop=7, point="P", view="a"), rig=RIG)
    np.testing.assert_allclose(uv_of(one, 5, "a", "P"), uv_of(tracks, 5, "a", "P"))
    np.testing.assert_allclose(uv_of(one, 5, "b", "P"), uv_of(broken, 5, "b", "P"))


def test_what_was_placed_by_hand_within_the_stretch_stays_on_the_path():
    tracks = apply_edit(wand(), Move(frame=6, view="a", point="P", u=9.0, v=-2.0), rig=RIG)
    new = apply_edit(tracks, Interpolate(frame=5, stop=8, point="P", view="a"), rig=RIG)
    np.testing.assert_array_equal(uv_of(new, 6, "a", "P"), [9.0, -2.0])
    assert [origin(new, f, "P", "a") for f in (5, 6, 7)] == ["predicted", "edited", "predicted"]
    # no overshoot: between its neighbours' values
    assert 1.0 < uv_of(new, 5, "a", "P")[0] < 9.0
    assert -2.0 < uv_of(new, 7, "a", "P")[1] < 0.0


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (Interpolate(frame=5, stop=9, point="P"), "P is not known both before frame 5 and after"),
        (Swap(frame=5, stop=5, first="P", second="Q"), "the stretch from frame 5 ends before"),
        (Hide(frame=5, stop=4, view=None, point="P"), "the stretch from frame 5 ends before"),
        (Delete(frame=5, stop=7, point="X"), "the tracks have no point 'X'"),
        (Delete(frame=5, stop=7, point="P", view="z"), "the tracks have no view 'z'"),
    ],
)
def test_a_stretch_that_makes_no_sense_is_refused(edit, words):
    with pytest.raises(InputError, match=words):
        apply_edit(wand(), edit, rig=RIG)


def shifted(tracks, _frame):
    new = tracks.copy(deep=True)
    new["position"].values[:] += 100.0
    return new


def test_only_the_stretch_is_taken_over_from_tracking_again():
    tracks = wand()
    new = apply_edit(tracks, Retrack(frame=5, since=4, stop=6), rig=RIG, retrack=shifted)
    np.testing.assert_allclose(new["position"][1:3], tracks["position"][1:3] + 100.0)
    xr.testing.assert_identical(rows(new, 3, 6, 7, 8), rows(tracks, 3, 6, 7, 8))


def test_a_hidden_stretch_stays_hidden_when_tracked_again_and_a_deleted_one_is_found(tmp_path):
    def found_again(tracks, _frame):
        return wand()

    log = EditLog(wand(), tmp_path / "edits.jsonl", rig=RIG, retrack=found_again)
    log.apply(Hide(frame=4, stop=7, view=None, point="P"))
    log.apply(Delete(frame=4, stop=7, point="Q"))
    log.apply(Retrack(frame=3))
    assert [origin(log.tracks, f, "P", "b") for f in (3, 4, 6, 7)] == [
        "measured", "missing", "missing", "measured",
    ]  # fmt: skip
    assert np.isnan(xyz_of(log.tracks, 5, "P")).all()
    assert origin(log.tracks, 5, "Q", "b") == "measured"


def test_undo_gives_back_a_stretch_and_the_file_makes_it_again(tmp_path):
    base, path = wand(), tmp_path / "edits.jsonl"
    log = EditLog(base, path, rig=RIG)
    for edit in (
        Swap(frame=4, stop=6, first="P", second="Q"),
        Delete(frame=5, stop=7, point="P"),
        Interpolate(frame=5, stop=7, point="P"),
    ):
        log.apply(edit)
    xr.testing.assert_identical(EditLog(base, path, rig=RIG).tracks, log.tracks)
    now = log.tracks
    for _ in range(3):
        log.undo()
    xr.testing.assert_identical(log.tracks, base)
    for _ in range(3):
        log.redo()
    xr.testing.assert_identical(log.tracks, now)
    # lines of files from before have no stop, and stay as they are
    assert '"stop"' not in path.read_text().splitlines()[3]
    log.apply(Swap(frame=4, first="P", second="Q"))
    assert path.read_text().splitlines()[-1] == (
        '{"edit": "swap", "frame": 4, "first": "P", "second": "Q", "view": null}'
    )


def taken_back(tracks, _frame):
    """A tracker that finds P and Q where it found them at first."""
    new = wand()
    new["image_origin"].values[:] = tracks["image_origin"].values
    return new


@pytest.mark.parametrize("view", [None, "b"])
def test_what_was_exchanged_by_hand_stays_so_when_tracked_again(tmp_path, view):
    log = EditLog(wand(), tmp_path / "edits.jsonl", rig=RIG, retrack=taken_back)
    log.apply(Swap(frame=4, stop=7, first="P", second="Q", view=view))
    before = log.tracks["image_position"].to_numpy()
    log.apply(Retrack(frame=4))
    np.testing.assert_array_equal(log.tracks["image_position"], before)
    if view is None:
        np.testing.assert_allclose(xyz_of(log.tracks, 5, "P"), [0, 10, 5])
    again = EditLog(wand(), tmp_path / "edits.jsonl", rig=RIG, retrack=taken_back)
    np.testing.assert_array_equal(again.tracks["image_position"], before)
    # an exchange that was taken back by a person is none
    log.apply(Swap(frame=4, stop=7, first="Q", second="P", view=view))
    log.apply(Retrack(frame=4))
    np.testing.assert_array_equal(log.tracks["image_position"], wand()["image_position"])


def test_beside_a_point_that_was_placed_its_partner_stays_too():
    log = EditLog(wand(), rig=RIG, retrack=taken_back)
    log.apply(Swap(frame=4, first="P", second="Q"))
    for view in ("a", "b", "c"):
        u, v = uv_of(log.tracks, 6, view, "P")
        log.apply(Move(frame=6, view=view, point="P", u=u + 0.25, v=v))
    before = log.tracks
    log.apply(Retrack(frame=6))
    for name in ("image_position", "image_origin", "position"):
        np.testing.assert_allclose(log.tracks[name], before[name])


@pytest.mark.parametrize("points", ["PQ", "P", "Q"])
def test_who_puts_a_point_where_the_other_is_has_changed_their_mind(points):
    log = EditLog(wand(), rig=RIG, retrack=taken_back)
    log.apply(Swap(frame=4, first="P", second="Q"))
    for view in ("a", "b", "c"):
        for point in points:
            u, v = uv_of(wand(), 6, view, point)
            log.apply(Move(frame=6, view=view, point=point, u=u, v=v))
    log.apply(Retrack(frame=6))
    np.testing.assert_array_equal(log.tracks["image_position"], wand()["image_position"])


def test_a_hidden_point_that_was_exchanged_stays_hidden_and_its_partner_in_its_place():
    log = EditLog(wand(), rig=RIG, retrack=lambda _tracks, _frame: wand())
    log.apply(Hide(frame=4, stop=7, view=None, point="P"))
    log.apply(Swap(frame=4, stop=7, first="P", second="Q"))
    before = log.tracks
    log.apply(Retrack(frame=4))
    for name in ("image_position", "image_origin", "position"):
        np.testing.assert_allclose(log.tracks[name], before[name])
