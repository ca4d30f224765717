"""How large the animal is in each view, as all calibrated views say it together."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pawnb.core.paws.offline import learnt_run
from pawnb.core.paws.offline.annotations import Annotations
from pawnb.core.paws.offline.scene.extents import with_extents
from pawnb.core.paws.request import TrackingRequest
from pawnb.core.rig import Rig

SIZES = [(200, 100)] * 4
# along x and y of space, and along x and z, by DLT coefficients: u = x, v = y and u = x, v = z + 50
FLAT, UPRIGHT = ([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0, 1, 50, 0, 0, 0])
RIG = Rig(("a", "b", "c", "d"), np.array([FLAT, UPRIGHT, FLAT, UPRIGHT], float).T)
# legs of one side pass each other, those of the other are 80 apart
SPACE = {0: (60.0, 20.0, 0.0), 1: (64.0, 23.0, 0.0), 2: (20.0, 80.0, 0.0), 3: (100.0, 80.0, 0.0)}


def clicks(view, points, space=SPACE):
    uv = RIG.project(np.array([space[p] for p in points]))[:, view]
    return Annotations({0: dict(zip(points, uv, strict=True))})


@pytest.fixture
def each_side():
    return [clicks(0, (0, 1)), clicks(1, (0, 1)), clicks(2, (2, 3)), clicks(3, (2, 3))]


def test_a_view_of_legs_that_pass_each_other_has_the_extent_of_the_whole_animal(each_side):
    assert each_side[0].extent() == pytest.approx(5.0)  # 3, 4, 5
    found = with_extents(each_side, SIZES, RIG)
    # from above and from the side 80 px between 2 and 3; the others are nearer to each other
    assert [own.extent() for own in found] == pytest.approx([80.0] * 4)
    for own, before in zip(found, each_side, strict=True):
        assert own.places is before.places
    assert found[0].without(0).extent() == found[0].part(0, 1).extent() == pytest.approx(80.0)


def test_where_each_view_has_all_points_nothing_changes():
    every = [clicks(v, (0, 1, 2, 3)) for v in range(4)]
    found = with_extents(every, SIZES, RIG)
    assert [own.extent() for own in found] == [own.extent() for own in every]


def test_without_a_rig_each_view_says_it_by_itself(each_side):
    assert with_extents(each_side, SIZES, None)[0].extent() == pytest.approx(5.0)


def test_points_of_one_view_and_those_that_views_disagree_about_say_nothing(each_side):
    lonely = [*each_side[:3], Annotations({})]
    found = with_extents(lonely, SIZES, RIG)
    assert found[0].extent() == pytest.approx(5.0)
    assert found[3].rows == []
    wrong = {p: (x + 60.0, y, z) for p, (x, y, z) in SPACE.items()}  # u of view d is off by 60 px
    found = with_extents([*each_side[:3], clicks(3, (2, 3), wrong)], SIZES, RIG)
    assert found[0].extent() == pytest.approx(5.0)


def test_a_point_beyond_the_edge_of_a_view_is_no_part_of_what_it_shows(each_side):
    found = with_extents(each_side, [(90, 100), *SIZES[1:]], RIG)
    # point 3 lies at u = 100: the farthest from 2 is then 0, by (40, 60) px
    assert found[0].extent() == pytest.approx(np.hypot(40, 60))
    assert found[2].extent() == pytest.approx(80.0)


def test_pictures_are_scaled_to_it(each_side, array_views, monkeypatch):
    extents = []

    def read_stacks(_views, annotations, **_kept):
        extents.extend(own.extent() for own in annotations)  # and stops the run

    monkeypatch.setattr(learnt_run, "read_stacks", read_stacks)
    names = ("FR", "HR", "FL", "HL")
    start = pd.DataFrame(
        [
            (0, view, names[p], *uv)
            for view, own in zip(RIG.names, each_side, strict=True)
            for p, uv in own.places[0].items()
        ],
        columns=["frame", "view", "point", "u", "v"],
    )
    views = array_views({view: np.zeros((3, 100, 200), np.uint8) for view in RIG.names})
    learnt_run.track_learnt(views, start, TrackingRequest(frames=(0, 3), fps=100.0, rig=RIG))
    assert extents == pytest.approx([80.0] * 4)
