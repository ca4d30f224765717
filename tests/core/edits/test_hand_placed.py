"""Two views in which a person placed a point say where it is; a third that disagrees does not."""

from __future__ import annotations

import numpy as np
import pytest
from cage import read_cage

from pawnb.core.edits.hand_placed import views_in_force
from pawnb.core.edits.log import apply_edit
from pawnb.core.edits.records import Move
from pawnb.core.rig import Rig
from pawnb.schema import ORIGIN_CODE, make_tracks

NAMES = ("back", "mid", "side", "top")


def cage_tracks(real_data):
    """Proofread points of a mouse in four cameras, all marked as tracked, and their places."""
    coefs, uv, _, names = read_cage(real_data("mouse-4cam-cage"))
    rig = Rig(names=NAMES, coefs=coefs)
    tracks = make_tracks(np.arange(len(uv)), names, fps=30.0, views=NAMES, unit="mm")
    tracks["image_position"].values[..., 0] = uv.transpose(0, 2, 3, 1)
    tracks["image_origin"].values[:] = ORIGIN_CODE["measured"]
    tracks["image_confidence"].values[:] = 1.0
    return tracks, rig, np.asarray(rig.triangulate(uv).xyz), uv


def placed_twice(tracks, rig, uv, *, views=("mid", "top"), point="Head", frame=10):
    """The place of a point after a person placed it in two views, where it was proofread."""
    p = list(tracks["keypoint"].to_numpy()).index(point)
    for view in views:
        u, v = uv[frame, p, NAMES.index(view)]
        tracks = apply_edit(tracks, Move(frame=frame, view=view, point=point, u=u, v=v), rig=rig)
    return tracks["position"].sel(keypoint=point).values[frame, :, 0], tracks, p


@pytest.mark.parametrize("off", [(80.0, 0.0), (0.0, -80.0)])
def test_a_tracked_view_on_something_else_does_not_pull_what_a_person_placed(real_data, off):
    """It counted alike: the head was 4 and 28 mm off, now 2 (as the two views give it)."""
    tracks, rig, xyz, uv = cage_tracks(real_data)
    k = list(tracks["keypoint"].to_numpy()).index("Head")
    # "side" is left out: proofread, its calibration is off by 10 px
    tracks["image_origin"].loc[{"view": "side"}] = ORIGIN_CODE["missing"]
    tracks["image_position"].values[10, 0, :, k, 0] += off
    place, after, p = placed_twice(tracks, rig, uv)
    own = uv[10, p][[1, 3]]
    by_hand = np.full((4, 2), np.nan)
    by_hand[[1, 3]] = own
    np.testing.assert_allclose(place, rig.triangulate(by_hand).xyz, atol=1e-9)
    assert np.linalg.norm(place - xyz[10, p]) < 5.0
    # what was tracked there is kept, to be seen and corrected
    assert (
        after["image_origin"].sel(view="back", keypoint="Head").values[10, 0]
        == (ORIGIN_CODE["measured"])
    )


def test_a_tracked_view_that_agrees_counts_as_before(real_data):
    """Views from the back and the top give the distance badly; that from the middle helps."""
    tracks, rig, _, uv = cage_tracks(real_data)
    tracks["image_origin"].loc[{"view": "side"}] = ORIGIN_CODE["missing"]
    place, _, p = placed_twice(tracks, rig, uv, views=("back", "top"))
    three = uv[10, p].copy()
    three[2] = np.nan
    np.testing.assert_allclose(place, rig.triangulate(three).xyz, atol=1e-9)


def test_one_view_by_hand_or_none_leaves_all_as_it_was():
    uv = np.arange(24.0).reshape(3, 4, 2)
    used = np.ones((3, 4), bool)
    by_hand = np.zeros((3, 4), bool)
    by_hand[1, 2] = True
    by_hand[2] = True  # nothing tracked is left

    def never(*_):
        raise AssertionError

    found = views_in_force(uv, used=used, by_hand=by_hand, triangulate=never, project=never)
    np.testing.assert_array_equal(found, used)
