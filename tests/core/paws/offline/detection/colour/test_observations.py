"""What detections say of the tracked points: moved by their offsets, exactly."""

from dataclasses import replace

import numpy as np

from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.label_offsets import Offsets
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.detection.colour.observations import read_observations, tracked_points
from pawnb.core.paws.offline.projection import Projection

THICKNESS = np.array([8.0, 10.0, 9.0])
LINEAR = np.zeros((11, 3))
LINEAR[:8] = np.array(
    [[4, 0, 0, 9, 0, 0, -4, 7], [0, 3, 1, -5, 1, 0, -4, 2], [2, -2, 0.5, 0, 0, 1, -3, 1]]
).T
RIG = Projection(LINEAR)


def rows(*ends):
    """ColourDetections (u, v, du, dv) that look like ends."""
    table = np.zeros((len(ends), 8), np.float32)
    for row, end in zip(table, ends, strict=True):
        row[:4], row[4], row[5] = end, 0.22, 4.0
    return ColourDetections(table)


def read(found, offsets, facing=(1, 1, 1)):
    n_views = len(found[0])
    return read_observations(
        found, offsets, facing=facing[:n_views],
        likelihood=AppearanceLikelihood([(0.6, 0.8)] * n_views, THICKNESS[:n_views]),
    )  # fmt: skip


def test_candidates_are_moved_along_and_across_their_own_direction():
    offsets = Offsets(np.array([0.5, 0.0]), np.array([0.25, -1.0]), np.zeros(2))
    found = [[rows((100, 50, 3, 4), (200, 60, 0, 2)), rows((10, 20, 5, 0))]]
    observations = read(found, offsets, facing=(1, -1))
    np.testing.assert_array_equal(observations.is_there, [[[True, True], [True, False]]])
    # 8 px thick: 4 along (3, 4)/5 and 2 to its right (-4, 3)/5; then 4 down and 2 to its right
    np.testing.assert_allclose(
        observations.at[0, 0, 0], [[100 + 2.4 - 1.6, 50 + 3.2 + 1.2], [198, 64]]
    )
    np.testing.assert_allclose(observations.at[0, 1, 0], [[100 + 6.4, 50 - 4.8], [208, 60]])
    # an animal that faces left has its other side to the right of the same direction
    np.testing.assert_allclose(observations.at[0, 0, 1, 0], [10 + 5.0, 20 - 2.5])
    np.testing.assert_allclose(observations.raw[0, 0], [[100, 50], [200, 60]])


def test_tracked_points_are_moved_as_their_candidates_say():
    # a displacement in space, seen by each camera as a direction and a length
    shift = np.array([0.9, -0.5, 0.4])
    places = np.array([[3.0, -2.0, 1.0], [-4.0, 6.0, 2.0]])
    uv = RIG.project(places)
    step = RIG.project(places + shift) - uv
    found = [[rows(*np.hstack([uv[:, v], step[:, v]])) for v in range(3)]]
    observations = read(found, Offsets(np.zeros(2), np.zeros(2), np.zeros(2)))
    at = observations.raw[:, None] + step.transpose(1, 0, 2)[None, None]
    observations = type(observations)(
        observations.raw,
        np.repeat(at, 2, axis=1),
        observations.detection_probability,
        observations.is_there,
    )
    moved = tracked_points(places[None], observations, geometry=RIG, paw_width_px=THICKNESS)
    # a trace of what holds the unseen back: a hundredth
    np.testing.assert_allclose(moved[0], places + shift, atol=0.04)


def clicked_in_the_middle():
    """A place where three views see ends, and the point 1.5 to 1.9 paw widths behind it."""
    place, point = np.array([3.0, -2.0, 1.0]), np.array([3.0, 1.0, 3.0])
    ends, middles = RIG.project(place), RIG.project(point)
    found = [[rows((*end, 1, 0)) for end in ends]]
    plain = read(found, Offsets(*np.zeros((3, 1))))
    step = (middles - ends)[None, None, :, None]
    return place, point, replace(plain, at=plain.raw[:, None] + step)


def test_places_of_one_view_are_moved_only_as_that_view_says():
    place, point, observations = clicked_in_the_middle()
    moved = tracked_points(
        place[None, None], observations, geometry=RIG, paw_width_px=THICKNESS, view=0
    )
    shift = (RIG.project(moved[0, 0]) - RIG.project(place))[0]
    np.testing.assert_allclose(shift, (RIG.project(point) - RIG.project(place))[0], atol=0.2)
    # the first camera looks along y, of which it says nothing
    assert moved[0, 0, 1] == place[1]


def test_only_what_a_view_tells_is_changed():
    place = np.array([[[3.0, -2.0, 1.0], [np.nan] * 3]])
    uv = RIG.project(place[0, 0])
    none = rows()
    far = rows((*(uv[1] + 15.0), 1, 0))
    one = read([[rows((*uv[0], 1, 0)), far, none]], Offsets(np.full(2, 0.5), *np.zeros((2, 2))))
    moved = tracked_points(place, one, geometry=RIG, paw_width_px=THICKNESS)
    # the first camera sees x at 4 px, so half a paw width of 8 px to its right is 1; its line
    # of sight is along y, of which it says nothing, and the other cameras are too far away
    np.testing.assert_allclose(moved[0, 0], [4.0, -2.0, 1.0], atol=0.02)
    assert np.isnan(moved[0, 1]).all()
