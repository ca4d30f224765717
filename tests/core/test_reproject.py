"""Points shown in views that do not track them: where the DLT puts them, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.reproject import reproject_tracks
from pawnb.core.rig import Rig
from pawnb.errors import InputError
from pawnb.schema import ORIGIN_CODE, make_tracks

# u = X, v = -Z in the first view; u = Y + 10, v = -Z in the second (no perspective)
RIG = Rig(
    ("a", "b"),
    np.array(
        [[1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0], [0, 1, 0, 10, 0, 0, -1, 0, 0, 0, 0]], dtype=float
    ).T,
)


def tracks_of():
    """Two points in five frames: P is tracked by a alone, Q by both."""
    tracks = make_tracks(range(5), ["P", "Q"], fps=100.0, views=["a", "b"], unit="mm")
    t = np.arange(5)
    tracks["position"][:, :, 0, 0] = np.stack([t, 2.0 * t, -3.0 - t], axis=1)
    tracks["position"][:, :, 1, 0] = np.stack([t, t, -t], axis=1)
    tracks["origin"][:] = ORIGIN_CODE["measured"]
    tracks["confidence"][:] = 0.7
    tracks["image_position"][:, 0, :, 0, 0] = np.stack([t + 0.5, 3.0 + t], axis=1)
    tracks["image_position"][:, :, :, 1, 0] = 7.0
    tracks["image_origin"][:, 0] = ORIGIN_CODE["measured"]
    tracks["image_origin"][:, 1, 1] = ORIGIN_CODE["measured"]
    tracks["image_confidence"][:] = 0.9
    return tracks


def test_a_missing_position_is_filled_by_projection_and_others_stay():
    tracks = tracks_of()
    shown = reproject_tracks(tracks, RIG)
    t = np.arange(5)
    # by hand from the two lines of the cameras: u = Y + 10, v = -Z
    place = shown["image_position"].sel(view="b", keypoint="P").isel(individual=0)
    np.testing.assert_allclose(place, np.stack([2.0 * t + 10, 3.0 + t], axis=1))
    label = {"view": "b", "keypoint": "P"}
    assert (shown["image_origin"].sel(label) == ORIGIN_CODE["reprojected"]).all()
    np.testing.assert_allclose(shown["image_confidence"].sel(label), 0.7)
    for view, point in (("a", "P"), ("a", "Q"), ("b", "Q")):
        for name in ("image_position", "image_origin", "image_confidence"):
            old, new = (x[name].sel(view=view, keypoint=point) for x in (tracks, shown))
            assert new.equals(old)
    assert np.isnan(tracks["image_position"].sel(label)).all()  # not changed in place
    assert shown["position"].equals(tracks["position"])


def test_only_known_positions_inside_the_picture_are_shown():
    tracks = tracks_of()
    tracks["origin"][1, 0] = ORIGIN_CODE["predicted"]
    shown = reproject_tracks(tracks, RIG, sizes={"a": (100, 100), "b": (15, 100)})
    origin = shown["image_origin"].sel(view="b", keypoint="P").isel(individual=0).to_numpy()
    # u is 10, 12, 14, 16, 18; frame 1 is only predicted; the picture ends at 14.5
    expected = ["reprojected", "missing", "reprojected", "missing", "missing"]
    assert origin.tolist() == [ORIGIN_CODE[name] for name in expected]
    u = shown["image_position"].sel(view="b", keypoint="P", image_space="u").isel(individual=0)
    np.testing.assert_array_equal(np.isnan(u), [False, True, False, True, True])


def test_after_a_correction_it_is_made_anew():
    first = reproject_tracks(tracks_of(), RIG)
    moved = first.copy(deep=True)
    moved["position"][2, 1, 0, 0] = 90.0
    moved["origin"][3, 0] = ORIGIN_CODE["missing"]
    again = reproject_tracks(moved, RIG)
    u = again["image_position"].sel(view="b", keypoint="P", image_space="u").isel(individual=0)
    np.testing.assert_allclose(u, [10, 12, 100, np.nan, 18])


def test_tracks_without_space_are_refused():
    flat = make_tracks(range(2), ["P"], fps=1.0, views=["a"], space=("x", "y"))
    with pytest.raises(InputError, match="reprojection needs Tracks with image positions and"):
        reproject_tracks(flat, RIG)
