"""A view from below: spots, places on a plane, and heights from the side."""

import numpy as np
import pytest

from pawnb.core.paws.layout import Placement
from pawnb.core.paws.offline.association.network_flow.triangulation import Volume
from pawnb.core.paws.offline.detection.colour.blob_detection import detect_blobs
from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.label_offsets import Offsets
from pawnb.core.paws.offline.detection.colour.likelihood import AppearanceLikelihood
from pawnb.core.paws.offline.detection.colour.observations import read_observations
from pawnb.core.paws.offline.projection import Projection
from pawnb.core.paws.offline.scene.bottom_view import BottomView, find_bottom_view

# the side view is u = x, v = 168 - z; the one from below a perspective u = x / w, v = y / w
# with w = 1 + 0.001 z, so that its places move when they are lifted
COEFS = np.zeros((11, 2))
COEFS[[0, 6, 7], 0] = 1.0, -1.0, 168.0
COEFS[[0, 5, 10], 1] = 1.0, 1.0, 0.001
RIG = Projection(COEFS)
UP = np.array([0.0, 0.0, 1.0])
THICKNESS = np.array([12.0, 12.0])
VOLUME = Volume(UP, np.array([0.0, 1.0, 0.0]), (0.0, 120.0), (0.0, 240.0))
LEAD = BottomView(RIG, 12.0, THICKNESS, [(0.7, 0.7), (1.0, 0.0)], VOLUME, 1, 50.0)
NOWHERE = Offsets(np.zeros(1), np.zeros(1), np.zeros(1))


def rows(*at):
    """Detections that look like paws."""
    table = np.zeros((len(at), 8), np.float32)
    for row, uv in zip(table, at, strict=True):
        row[:2], row[2:6] = uv, (3.0, 0.0, 0.0, 4.0)
    return ColourDetections(table)


def test_a_spot_is_found_at_its_middle_and_judged_by_its_score():
    v, u = np.mgrid[:60, :80]
    score = -3.0 + np.zeros((60, 80), np.float32)
    for (cu, cv), top in (((20.3, 30.0), 9.0), ((60.0, 20.6), 5.0)):
        score += top * np.exp(-((u - cu) ** 2 + (v - cv) ** 2) / 32.0).astype(np.float32)
    at, likeness = detect_blobs(score, 6, 6.0)
    order = np.argsort(-likeness)
    np.testing.assert_allclose(at[order], [[20.3, 30.0], [60.0, 20.6]], atol=0.3)
    assert len(at) == 2
    assert 1.0 >= likeness[order][0] > 1.5 * likeness[order][1] > 0.0


def test_a_spot_is_as_likely_a_paw_as_clicked_ones_whatever_their_score():
    v, u = np.mgrid[:60, :80]
    score = np.float32(6.0) * np.exp(-((u - 20.0) ** 2 + (v - 30.0) ** 2) / 32.0) - 1.0
    score = score.astype(np.float32)
    _, plain = detect_blobs(score, 6, 6.0)
    _, faint = detect_blobs(0.4 * score, 6, 2.4)
    np.testing.assert_allclose(faint, plain, atol=1e-4)
    assert detect_blobs(3.0 * score, 6, 6.0)[1].max() <= 1.0


def test_only_a_view_along_the_vertical_with_every_click_leads():
    J = RIG.jacobian(np.array([100.0, 100.0, 50.0]))
    clicks = [Placement(1, p, np.zeros(2), "edited") for p in range(2)]
    assert find_bottom_view(J, UP, clicks, n_points=2) == 1
    assert find_bottom_view(J, UP, clicks[:1], n_points=2) is None
    assert find_bottom_view(J, np.array([0.0, 1.0, 0.0]), clicks, n_points=2) is None
    assert find_bottom_view(J[1:], UP, [Placement(0, 0, np.zeros(2), "edited")], n_points=1) is None


def test_heights_are_told_by_each_of_several_other_views():
    # a third view, from behind: u = y, v = 168 - z
    behind = np.zeros((11, 1))
    behind[[1, 6, 7], 0] = 1.0, -1.0, 168.0
    coefs = np.hstack([COEFS, behind])
    bottom_view = BottomView(
        Projection(coefs), 12.0, np.full(3, 12.0), [(0.7, 0.7), (1.0, 0), (0, 1.0)], VOLUME, 1, 50.0
    )
    place = np.array([150.0, 90.0, 62.0])
    uv = Projection(coefs).project(place)
    seen = [uv[0][None], uv[1][None], uv[2][None]]
    heights, price = bottom_view.heights(uv[1][None], seen, [np.ones(1)] * 3)
    np.testing.assert_allclose(heights, [[62.0, 62.0]], atol=0.01)
    assert (price < 0.01).all()


def test_places_lie_on_the_plane_and_are_cheaper_where_the_side_agrees():
    seen = np.array([150.0, 90.0, 50.0])
    below = RIG.project(seen)[1]
    found = [rows(RIG.project(seen)[0]), rows(below, (300.0, 60.0), below + 5.0)]
    (places,) = LEAD.hypotheses([found], most=16, likelihood=None)
    # the third spot is nearer to the first than a paw is thick
    assert len(places.at) == 2
    np.testing.assert_allclose(places.at @ UP, 50.0)
    np.testing.assert_allclose(places.at[0], seen, atol=1e-4)
    assert places.cost[0] < places.cost[1] - 0.3


@pytest.mark.parametrize("hidden", [(), range(18, 22)])
def test_heights_come_from_the_side_view_through_what_is_wrong_there(hidden):
    n = 40
    t = np.arange(n)
    truth = np.column_stack([100.0 + 3.0 * t, 90.0 + 0.0 * t, 50.0 + 30.0 * np.sin(t / 12.0) ** 2])
    uv = RIG.project(truth)
    found = []
    for i in t:
        side = [] if i in hidden else [uv[i, 0]]
        # another paw crosses, and something bright always fits, but below the ground
        sunk = RIG.project(LEAD.on_plane(uv[i, 1], np.array(20.0)))[0]
        side += [(320.0 - 3.0 * i, 100.0), sunk, (40.0, 90.0)]
        found.append([rows(*side), rows(uv[i, 1])])
    observations = read_observations(
        found,
        NOWHERE,
        facing=(1, 1),
        likelihood=AppearanceLikelihood([(0.7, 0.7), (1.0, 0.0)], THICKNESS),
    )
    flat = LEAD.flat(truth)[:, None]
    assert np.abs(flat[:, 0] - truth).max() > 10.0
    lifted = LEAD.to_space(flat, observations, 1.5)[:, 0]
    np.testing.assert_allclose(lifted, truth, atol=3.0 if len(hidden) else 0.01)


def test_where_no_view_tells_the_height_it_is_that_of_the_ground():
    truth = np.array([[[100.0, 90.0, 50.0]], [[103.0, 90.0, 50.0]]])
    found = [[rows(), rows(RIG.project(x[0])[1])] for x in truth]
    observations = read_observations(
        found,
        NOWHERE,
        facing=(1, 1),
        likelihood=AppearanceLikelihood([(0.7, 0.7), (1.0, 0.0)], THICKNESS),
    )
    np.testing.assert_allclose(LEAD.to_space(LEAD.flat(truth), observations, 1.5), truth, atol=1e-6)
