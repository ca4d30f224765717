"""What no picture shows is known the less the longer it is hidden."""

import numpy as np
import pytest

from pawnb.core.paws.offline.treadmill.hidden import body_size, frames_hidden, with_hidden_sd
from pawnb.core.paws.offline.treadmill.parameters import TREADMILL
from pawnb.schema import ORIGIN_CODE, make_tracks

FPS, BODY, SD = 100.0, 50.0, 0.3


def hidden_tracks(hidden, *, space=("x", "y", "z"), frames=None):
    """Two points a body apart in two views; the second is in neither in the ``hidden`` frames."""
    frames = np.arange(20) if frames is None else frames
    tracks = make_tracks(
        frames, ("FR", "HR"), fps=FPS, views=("a", "b"), space=space, individual="mouse", unit="mm"
    )
    tracks["sd"] = tracks["position"].copy()
    tracks["sd"][:] = SD
    tracks["position"][:] = 0.0
    tracks["position"].loc[{"keypoint": "HR", "space": "x"}] = BODY
    tracks["image_origin"][:] = ORIGIN_CODE["measured"]
    tracks["image_origin"].loc[{"view": "b"}] = ORIGIN_CODE["reprojected"]
    tracks["image_origin"][np.isin(frames, hidden)] = tracks["image_origin"][
        np.isin(frames, hidden)
    ].where(tracks["keypoint"] != "HR", ORIGIN_CODE["predicted"])
    return tracks


def stated(tracks, point):
    """Return the standard deviations of a point along the first axis."""
    return tracks["sd"].isel(individual=0).sel(keypoint=point).isel(space=0).to_numpy()


def test_the_standard_deviation_grows_from_either_end_and_position_stays():
    tracks = hidden_tracks([5, 6, 7, 8, 9])
    grown = with_hidden_sd(tracks, (0, 20))
    away = np.zeros(20)
    away[5:10] = [1, 2, 3, 2, 1]
    more = TREADMILL.hidden_speed * away / FPS * BODY
    np.testing.assert_allclose(stated(grown, "HR"), np.hypot(SD, more))
    np.testing.assert_array_equal(stated(grown, "FR"), SD)
    np.testing.assert_array_equal(grown["position"], tracks["position"])
    np.testing.assert_array_equal(tracks["sd"], SD)  # what was given is as it was


def test_it_grows_no_further_than_a_stride_goes():
    frames = np.arange(200)
    grown = with_hidden_sd(hidden_tracks(frames[50:], frames=frames), (0, 200))
    assert stated(grown, "HR").max() == pytest.approx(np.hypot(SD, TREADMILL.hidden_most * BODY))
    assert (np.diff(stated(grown, "HR")) >= 0).all()


def test_what_was_tracked_before_has_grown_already():
    grown = with_hidden_sd(hidden_tracks(np.arange(20)), (12, 20))
    np.testing.assert_array_equal(stated(grown, "HR")[:12], SD)
    assert (stated(grown, "HR")[12:] > SD).all()


def test_one_view_that_has_the_point_is_enough_and_pictures_have_no_depth_to_tell():
    tracks = hidden_tracks([])
    np.testing.assert_array_equal(with_hidden_sd(tracks, (0, 20))["sd"], tracks["sd"])
    flat = hidden_tracks([5, 6, 7], space=("x", "y"))
    assert with_hidden_sd(flat, (0, 20)) is flat


def test_frames_are_counted_by_their_numbers():
    seen = np.array([[True, False], [False, False], [False, False], [True, False]])
    np.testing.assert_array_equal(
        frames_hidden(seen, np.array([0, 1, 7, 9])), [[0, 10], [1, 10], [2, 10], [0, 10]]
    )


def test_the_body_is_as_long_as_its_farthest_points():
    x = np.zeros((3, 2, 3))
    x[:, 1, 0] = [40.0, 50.0, 70.0]
    assert body_size(x) == 50.0
