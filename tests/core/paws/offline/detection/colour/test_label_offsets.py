"""Where a tracked point lies relative to detections, learnt from clicks put at a known offset."""

import numpy as np
import pytest

from pawnb.core.paws.offline.detection.colour.detections import ColourDetections
from pawnb.core.paws.offline.detection.colour.label_offsets import learn_offsets

THICKNESS = 10.0


def end(u, v, *, share=0.22, direction=(5.0, 2.0)):
    """A detection; 0.22 is the share of mask at an end, 0.45 that along a limb."""
    row = np.zeros(8, np.float32)
    row[:6] = u, v, *direction, share, 4.0
    return row


def learn(clicks, rows):
    return learn_offsets(
        np.asarray(clicks, float)[None], {0: [ColourDetections(one) for one in rows]},
        paw_width_px=np.full(len(rows), THICKNESS),
        facing=[1] * len(rows), limb_direction=[(0.8, 0.6)] * len(rows), kinds=["front"],
    )  # fmt: skip


def test_the_offset_put_in_comes_out_though_a_heel_is_nearer():
    along, across = 0.4, 0.1
    e = np.array([5.0, 2.0]) / np.hypot(5.0, 2.0)
    shift = THICKNESS * (along * e + across * np.array([-e[1], e[0]]))
    rows = [np.stack([end(100, 50), end(*(np.array([100, 50]) + shift + 1.0), share=0.45)])]
    found = learn([[shift + 100.0 * np.array([1.0, 0.5])]], rows)
    np.testing.assert_allclose([found.along[0], found.across[0]], [along, across], atol=1e-6)


def test_a_click_in_the_middle_is_told_by_the_toes_however_near_the_heel():
    # half a long foot is 1.8 paw widths; the heel is nearer, and points back
    toes, heel = end(118, 50, direction=(5.0, 0.5)), end(88, 50, direction=(-5.0, 0.0))
    found = learn([[[100, 50]]], [np.stack([heel, toes])])
    e = np.array([5.0, 0.5]) / np.hypot(5.0, 0.5)
    assert found.along[0] == pytest.approx(-1.8 * e[0], abs=1e-6)


def test_the_end_of_another_paw_farther_away_is_not_the_clicked_one():
    found = learn([[[101, 50]]], [np.stack([end(100, 50, share=0.33), end(122, 50)])])
    assert abs(found.along[0]) < 0.2


def test_an_end_to_the_side_of_the_click_is_another_paw():
    # the click lies on the axis of the first, and beside that of the second, which looks better
    own, other = end(110, 54, share=0.33), end(96, 70)
    found = learn([[[100, 50]]], [np.stack([own, other])])
    assert found.along[0] < -1.0
    assert abs(found.across[0]) < 0.1


def test_a_candidate_without_a_direction_far_from_the_click_says_nothing():
    found = learn([[[100, 50]]], [np.stack([end(106, 50), end(160, 90, direction=(0.0, 0.0))])])
    assert found.along[0] == pytest.approx(-0.6 * 5.0 / np.hypot(5.0, 2.0), abs=1e-6)


def test_a_view_that_sees_no_end_does_not_count():
    rows = [
        np.stack([end(100, 50)]),
        np.stack([end(200, 80, share=0.5, direction=(-1.0, 0.2))]),
    ]
    found = learn([[[102, 51], [207, 80]]], rows)
    alone = learn([[[102, 51]]], rows[:1])
    assert found.along[0] == pytest.approx(alone.along[0])
    assert found.across[0] == pytest.approx(alone.across[0])


def test_without_a_candidate_near_the_click_there_is_no_offset():
    found = learn([[[100, 50]]], [np.stack([end(130, 50)])])
    assert (found.along[0], found.across[0]) == (0.0, 0.0)


def test_where_paws_meet_each_click_has_an_end_of_its_own():
    # the better end lies within reach of both clicks; a paw cannot be where the other is
    rows = np.stack([end(100, 50, direction=(3.0, -6.0)), end(96, 57, share=0.37)])
    found = learn_offsets(
        np.array([[[[101.0, 50.0]], [[96.0, 58.0]]]]), {0: [ColourDetections(rows)]},
        paw_width_px=np.array([THICKNESS]), facing=[1], limb_direction=[(0.8, 0.6)],
        kinds=["front", "hind"],
    )  # fmt: skip
    np.testing.assert_allclose(np.hypot(found.along, found.across), 0.1, atol=1e-6)
