"""Evidence of points that a correction leaves as it is: which, in which rows, and for how long."""

from __future__ import annotations

import numpy as np
import pytest

from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.evidence import Detections
from pawnb.core.paws.offline.reuse.point_evidence import PointEvidence

FR, HR = 0, 1


def clicks(*placed):
    """What is placed: row, point and u, at v = 5."""
    places = {}
    for row, point, u in placed:
        places.setdefault(row, {})[point] = np.array([u, 5.0])
    return Annotations(places)


FIRST = clicks((2, FR, 10.0), (2, HR, 20.0))


def found_in(begin, end, placed, value):
    """Evidence of both points in each of some rows, all of it with one value."""
    row, point = (a.ravel() for a in np.meshgrid(np.arange(end - begin), [FR, HR]))
    filled = np.full(len(row), float(value))
    detections = Detections(row, point, np.stack([filled, filled], 1), filled, filled)
    looks = {p: np.full((end - begin, 3, 4), value, np.float32) for p in (FR, HR)}
    spans = dict.fromkeys(looks, (begin, end))
    return PointEvidence(begin, end, placed, detections, detections, looks, spans)


def values_of(evidence, point):
    """Row of the whole view to what the three kinds say there of a point."""
    kinds = {}
    for found in (evidence.followed, evidence.correlated):
        own = found.of([point])
        for row, value in zip(own.row, own.log_odds, strict=True):
            kinds.setdefault(int(evidence.begin + row), set()).add(float(value))
    for i, look in enumerate(evidence.looks[point]):
        kinds.setdefault(evidence.begin + i, set()).update(map(float, np.unique(look)))
    return {row: said.pop() if len(said) == 1 else said for row, said in kinds.items()}


def test_points_that_were_not_clicked_anew_are_known_in_the_rows_that_are_asked_for():
    same = found_in(0, 10, FIRST, 3).unchanged(clicks((2, FR, 10), (2, HR, 20), (4, FR, 9)), (4, 7))
    assert list(same.looks) == [HR]
    assert values_of(same, HR) == dict.fromkeys([4, 5, 6], 3.0)
    assert not len(same.followed.of([FR]).row)


@pytest.mark.parametrize(
    ("now", "known"),
    [
        (FIRST, [FR, HR]),
        (clicks((2, FR, 10.01), (2, HR, 20)), [FR, HR]),  # as it comes back from a file
        (clicks((2, FR, 11), (2, HR, 20)), [HR]),  # moved
        (clicks((2, HR, 20)), [HR]),  # taken back
    ],
)
def test_a_point_is_known_while_its_clicks_are_the_same(now, known):
    assert list(found_in(0, 10, FIRST, 3).unchanged(now, (0, 10)).looks) == known


@pytest.mark.parametrize("rows", [(1, 5), (5, 9), (4, 4)])
def test_nothing_is_known_of_other_rows(rows):
    assert found_in(2, 8, FIRST, 3).unchanged(FIRST, rows) is None


MORE = clicks((2, FR, 10), (2, HR, 20), (4, FR, 9))


def test_a_point_that_was_clicked_anew_is_known_where_it_was_followed_anew():
    now = found_in(0, 10, FIRST, 3).compact().updated(found_in(4, 7, MORE, 5))
    assert values_of(now.unchanged(MORE, (4, 7)), FR) == dict.fromkeys([4, 5, 6], 5.0)
    assert values_of(now.unchanged(MORE, (4, 7)), HR) == dict.fromkeys([4, 5, 6], 3.0)


@pytest.mark.parametrize("rows", [(2, 7), (0, 4), (4, 10)])
def test_elsewhere_it_has_to_be_followed_from_that_click_too(rows):
    """Of two corrections the later one was tracked again first, or another point further back."""
    now = found_in(0, 10, FIRST, 3).updated(found_in(4, 7, MORE, 5))
    assert list(now.unchanged(MORE, rows).looks) == [HR]
    again = now.updated(found_in(*rows, MORE, 6))
    assert values_of(again.unchanged(MORE, rows), FR) == dict.fromkeys(range(*rows), 6.0)


def test_a_click_that_was_taken_back_leaves_nothing_of_itself():
    undone = found_in(0, 10, FIRST, 3).updated(found_in(4, 7, MORE, 5))
    now = undone.updated(found_in(7, 9, FIRST, 6))
    assert list(now.unchanged(FIRST, (4, 7)).looks) == [HR]
    assert values_of(now.unchanged(FIRST, (7, 9)), FR) == {7: 6.0, 8: 6.0}


def test_evidence_of_rows_that_were_not_known_is_kept_alone():
    new = found_in(6, 12, FIRST, 5)
    assert found_in(0, 10, FIRST, 3).updated(new) is new
