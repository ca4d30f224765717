"""Clicks followed by a network: pixels, pieces, what is kept, and how far paths are believed."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pawnb.core.parameters import parameters_set, read_parameters
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.detection.point_tracking.point_tracker import (
    PointTracker,
    _follow,
    _queries,
)
from pawnb.errors import InputError

SIDE = 64
SPEED = np.array([0.5, 0.25])


class Line:
    """A network that says that all points move evenly, and notes what it was asked."""

    def __init__(self, speed=SPEED, probability=0.9):
        self.speed, self.probability, self.asked = np.array(speed), probability, []

    def follow(self, pictures, queries):
        assert pictures.dtype == np.uint8
        assert pictures.shape[1:] == (SIDE, SIDE, 3)
        self.asked.append((pictures[:, 0, 0, 0].tolist(), queries.tolist()))
        rows = np.arange(len(pictures)) - queries[:, :1]
        places = queries[:, None, 1:] + rows[..., None] * self.speed
        return places, np.full(rows.shape, self.probability)

    @property
    def rows(self):
        """The rows of each look: pictures have their number as their grey value."""
        return [(rows[0], rows[-1]) for rows, _ in self.asked]


def at(row, point=0, start=(20.0, 20.0)):
    """Where a point is that is at a place in row 0 and moves evenly."""
    return np.array(start) + 5 * point + row * SPEED


def clicks(*rows, points=(0,)):
    return Annotations({row: {p: at(row, p) for p in points} for row in rows})


@pytest.fixture
def stack(make_stack):
    """Forty pictures, the size of the network's, each of its number."""
    return make_stack(np.repeat(np.arange(40, dtype=np.uint8), SIDE * SIDE).reshape(40, SIDE, SIDE))


@pytest.fixture(autouse=True)
def _small():
    with parameters_set({"point_tracker": {"side_px": SIDE, "piece_rows": 12, "overlap_rows": 3}}):
        yield


def detect(network, stack, placed, **more):
    return PointTracker(network, **more).detect("side", stack, placed, points=("FR", "HR"))


def follow(network, stack, row):
    """Follow one click; the rows in which it was found, where, and how surely."""
    (path,) = _follow(stack, _queries(clicks(row), len(stack.grey)), network, None)
    rows = np.flatnonzero(path.probability)
    return rows.tolist(), path.xy[rows], path.probability[rows]


def test_every_click_is_followed_to_the_next_ones_and_to_the_ends(stack):
    network = Line()
    found = detect(network, stack, clicks(10, 25, points=(0, 1)))
    # the middle of the first pixel is at 0 in pawnb, and at half a pixel in tapnet's README
    row, x, y = network.asked[0][1][0]
    np.testing.assert_allclose([row, x - 0.5, y - 0.5], [10, *at(10)])
    for point in (0, 1):
        own = found.point == point
        # ahead from 10 and 25, behind from 25 and 10
        assert sorted(found.row[own]) == sorted([*range(11, 40), *range(25)])
        expected = np.array([at(row, point) for row in found.row[own]])
        np.testing.assert_allclose(found.uv[own], expected, atol=1e-9)


def test_long_recordings_are_looked_at_in_pieces_that_overlap(stack):
    network = Line()
    rows, places, _ = follow(network, stack, 10)
    # three rows are shared; ahead, then behind what was looked at already
    assert network.rows == [(0, 11), (9, 20), (18, 29), (27, 38), (36, 39)]
    starts = [seen[int(queries[0][0])] for seen, queries in network.asked]
    # the click itself where it is seen; then the surest of the rows that are shared
    assert starts[:2] == [10, 10]
    for (seen, _), start in zip(network.asked[2:], starts[2:], strict=True):
        assert start in seen[:3]
    np.testing.assert_allclose(places, [at(row) for row in rows], atol=1e-9)
    assert rows == [*range(10), *range(11, 40)]


def test_behind_a_click_it_goes_from_piece_to_piece_as_well(stack):
    network = Line()
    rows, places, _ = follow(network, stack, 38)
    assert network.rows == [(27, 38), (36, 39), (18, 29), (9, 20), (0, 11)]
    assert rows == [*range(38), 39]
    np.testing.assert_allclose(places, [at(row) for row in rows], atol=1e-9)


def test_a_path_that_is_not_sure_where_pieces_meet_ends_there(stack):
    network = Line(probability=0.4)
    rows, _, _ = follow(network, stack, 2)
    assert network.rows == [(0, 11)]
    assert max(rows) == 11


def test_a_path_is_no_surer_than_where_it_went_on_from(stack):
    """Of 0.8, 0.8 x 0.8 = 0.64 and 0.51 the third piece is the last from which it goes on."""
    network = Line(probability=0.8)
    rows, _, sure = follow(network, stack, 0)
    assert network.rows == [(0, 11), (9, 20), (18, 29), (27, 38)]
    assert max(rows) == 38
    np.testing.assert_allclose(sure[[0, 37]], [0.8, 0.8**4])


def test_pixels_of_the_view_are_those_of_its_pictures(make_stack, make_texture):
    """A square of noise goes through a picture that is no square, and the network's is smaller."""
    n, (height, width) = 8, (128, 192)
    truth = np.stack([30.0 + 14 * np.arange(n), 40.0 + 6 * np.arange(n)], -1)
    film = np.repeat(make_texture(height, width, seed=0, low=90, high=120)[None], n, axis=0)
    patch = make_texture(25, 25, seed=7, low=0, high=255)
    for picture, (u, v) in zip(film, truth.astype(int), strict=True):
        picture[v - 12 : v + 13, u - 12 : u + 13] = patch

    class Matching:
        """Finds the patch about a query again; its pixels begin at the corner."""

        def follow(self, pictures, queries):
            found = [self.one(pictures, query) for query in queries]
            places, probability = zip(*found, strict=True)
            return np.array(places), np.array(probability)

        def one(self, pictures, query):
            (row, x, y), half = query, 3
            i, j = int(y), int(x)
            own = pictures[int(row), i - half : i + half + 1, j - half : j + half + 1]
            best = [cv2.minMaxLoc(cv2.matchTemplate(p, own, cv2.TM_CCOEFF_NORMED))
                    for p in pictures]  # fmt: skip
            places = np.array([[where[0] + half + x % 1, where[1] + half + y % 1]
                               for _, _, _, where in best])  # fmt: skip
            return places, [value for _, value, _, _ in best]

    found = detect(Matching(), make_stack(film), Annotations({t: {0: truth[t]} for t in (2, 6)}))
    assert set(found.row) == set(range(n))
    # its pixels are 3 wide and 2 high
    assert (np.abs(found.uv - truth[found.row]) <= [1.6, 1.1]).all()


def test_colour_is_handed_on_as_colour(make_stack):
    """Red in CIE Lab (8 bit: 136, 208, 195, from OpenCV's formula) and back."""
    grey = np.full((2, SIDE, SIDE), 136, np.uint8)
    ab = np.broadcast_to(np.uint8([208, 195]), (2, SIDE, SIDE, 2))
    seen = []

    class Look(Line):
        def follow(self, pictures, queries):
            seen.append(pictures[0, 0, 0].tolist())
            return super().follow(pictures, queries)

    detect(Look(), make_stack(grey, colour=ab), clicks(0, 1))
    np.testing.assert_allclose(seen, [[255, 0, 0]], atol=4)


def test_a_click_that_is_added_is_followed_alone(stack):
    network = Line()
    tracker = PointTracker(network)
    tracker.detect("side", stack, clicks(0, 39), points=("FR",))
    before = len(network.asked)
    found = tracker.detect("side", stack, clicks(0, 20, 39), points=("FR",))
    new = network.asked[before:]
    assert all(len(queries) == 1 for _, queries in new)
    first = [rows[int(queries[0][0])] for rows, queries in new]
    assert first[0] == 20
    # 0 and 39 are taken as far as 20 from what was kept
    assert sorted(found.row) == sorted([*range(1, 40), *range(39)])
    tracker.detect("side", stack, clicks(0, 20, 39), points=("FR",))
    assert len(network.asked) == before + len(new)


def test_between_two_clicks_no_other_rows_are_looked_at(stack):
    network = Line()
    tracker = PointTracker(network)
    tracker.detect("side", stack, clicks(0, 18, 24, 39), points=("FR",))
    before = len(network.rows)
    tracker.detect("side", stack, clicks(0, 18, 21, 24, 39), points=("FR",))
    assert network.rows[before:] == [(18, 24)]


def test_of_other_pictures_nothing_is_kept(stack, make_stack):
    network = Line()
    tracker = PointTracker(network)
    tracker.detect("side", stack, clicks(5, 20), points=("FR",))
    asked = len(network.asked)
    tracker.detect("side", make_stack(stack.grey.copy()), clicks(5, 20), points=("FR",))
    assert len(network.asked) == 2 * asked


def test_by_other_parameters_nothing_is_kept(stack):
    network = Line()
    tracker = PointTracker(network)
    tracker.detect("side", stack, clicks(5, 20), points=("FR",))
    asked = len(network.asked)
    with parameters_set({"point_tracker": {"piece_rows": 40}}):
        tracker.detect("side", stack, clicks(5, 20), points=("FR",))
    assert len(network.asked) == asked + 1


def test_where_it_is_stopped_nothing_is_found_or_kept(stack):
    network = Line()
    answers = iter([False, True])
    tracker = PointTracker(network, stop=lambda: next(answers, False))
    assert not len(tracker.detect("side", stack, clicks(5, 20), points=("FR",)).row)
    assert len(network.asked) == 1
    assert len(tracker.detect("side", stack, clicks(5, 20), points=("FR",)).row) > 39


def test_paths_that_end_on_clicks_are_believed_and_others_say_nothing(stack):
    """Six clicks of two points: ten paths end on clicks ahead, and ten behind."""
    placed = clicks(0, 8, 16, 24, 32, 39, points=(0, 1))
    with parameters_set({"point_tracker": {"piece_rows": 40}}):
        right = detect(Line(), stack, placed)
    # 2 clicks' worth of 0.5, and 20 of all or 10 of the point with 0.9 each; gain 15
    of_all = (2 * 0.5 + 18) / (2 + 18)
    own = (2 * of_all + 9) / (2 + 9)
    np.testing.assert_allclose(right.log_odds, np.log(15 * 0.9 * (2 * own - 1)))
    # 5.2 px squared, 2 clicks' worth, and 18 of 0 px
    np.testing.assert_allclose(right.sd_px, np.sqrt(2 * 5.2**2 / 20))
    wrong = detect(Line(speed=[-5.0, 5.0]), stack, placed)
    assert not len(wrong.row)


def test_a_point_that_is_lost_is_not_believed_for_the_others(stack):
    placed = clicks(0, 8, 16, 24, 32, 39, points=(0, 1))

    class LosesOne(Line):
        def follow(self, pictures, queries):
            places, probability = super().follow(pictures, queries)
            off = abs(queries[:, 1] - at(0)[0] - 0.5 - SPEED[0] * 20) > 12.6  # of the other one
            places[off] += 30.0
            return places, probability

    other = Annotations({
        row: {0: here[0], 1: here[1] + [20.0, 0.0]} for row, here in placed.places.items()
    })  # fmt: skip
    found = detect(LosesOne(), stack, other)
    assert set(found.point) == {0}


def test_from_one_clicked_frame_nothing_is_asked_and_nothing_said(stack):
    """Nothing would tell whether it is right."""
    network = Line()
    assert not len(detect(network, stack, clicks(20, points=(0, 1))).row)
    assert not network.asked


def test_nothing_is_said_far_from_the_clicks_of_a_long_recording(stack):
    found = detect(Line(), stack, clicks(3, 8))
    assert found.row.max() == 18  # twice 5 after 8
    assert found.row.min() == 0


def test_what_the_network_itself_calls_hidden_counts_for_less(stack):
    class Hiding(Line):
        def follow(self, pictures, queries):
            places, probability = super().follow(pictures, queries)
            probability[:, len(pictures) // 2 :] = 0.15
            return places, probability

    found = detect(Hiding(), stack.part(0, 12), clicks(0, 5))
    early, late = (found.log_odds[rows] for rows in (found.row < 5, found.row > 5))
    np.testing.assert_allclose(np.exp(early[0] - late), 6)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [("side_px", 100, "expected a multiple of 8"), ("overlap_rows", 48, "fewer than piece_rows")],
)
def test_parameters_that_no_network_could_take_are_refused(name, value, said):
    with pytest.raises(InputError, match=said):
        read_parameters({f"point_tracker.{name}": value}, ("point_tracker",), where="settings")
