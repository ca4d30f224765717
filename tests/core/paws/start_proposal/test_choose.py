"""Which place is which paw: a stage and four paws whose places are known."""

import numpy as np
import pytest

from pawnb.core.paws.start_proposal.choose import Paw, ViewGeometry, choose_places
from pawnb.core.paws.start_proposal.places import CandidatePlaces, Stage, join
from pawnb.core.rig import Rig

# cameras infinitely far away, two on each side, 30 degrees apart and looking down a little
COEFS = np.array(
    [
        [2, 0.6, 0, 300, 0, 0.3, -2, 200, 0, 0, 0],
        [2, -0.6, 0, 300, 0, 0.3, -2, 200, 0, 0, 0],
        [-2, 0.6, 0, 300, 0, -0.3, -2, 200, 0, 0, 0],
        [-2, -0.6, 0, 300, 0, -0.3, -2, 200, 0, 0, 0],
    ],
    float,
).T
RIG = Rig(("cam1", "cam2", "cam3", "cam4"), COEFS)
GROUPS = (("cam1", "cam2"), ("cam3", "cam4"))
SIGHTS = ViewGeometry(RIG, GROUPS, dict.fromkeys(RIG.names, 20.0))
# forward is +X, to the right -Y; hind paws stand about -20, front paws about 20
STAGE = Stage(np.array([[1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0]]), 2.0, 0.0, -20.0, 20.0)
PAWS = [Paw("FR", 0, 1, True), Paw("HR", 0, 1, False),
        Paw("FL", 1, -1, True), Paw("HL", 1, -1, False)]  # fmt: skip
TRUE = {"FR": (25, -10, 2), "HR": (-10, -12, 2), "FL": (10, 10, 2), "HL": (-25, 12, 2)}


def places(*xyz, strength=1.0):
    """Return places on which views agree well."""
    at = np.array(xyz, float).reshape(-1, 3)
    return CandidatePlaces(at, np.full(len(at), strength), np.full(len(at), 0.02))


def choose(right, left):
    """Return place and sureness of each paw by its name."""
    chosen = choose_places((right, left), paws=PAWS, stage=STAGE, geometry=SIGHTS)
    return {paw.point: found for paw, found in chosen.items()}


def test_front_and_hind_are_told_by_place_and_sides_by_views():
    everything = places(*TRUE.values())
    for point, (xyz, sure) in choose(everything, everything).items():
        np.testing.assert_array_equal(xyz, TRUE[point])
        assert sure > 0.5


def test_a_place_off_the_ground_is_no_paw():
    ankle = np.add(TRUE["HR"], (-8, 0, 20))
    found = choose(join([places(TRUE["FR"], TRUE["HR"]), places(ankle)]), places())
    np.testing.assert_array_equal(found["HR"][0], TRUE["HR"])
    assert set(found) == {"FR", "HR"}


def test_a_front_and_a_hind_paw_that_touch_are_not_told():
    near = np.add(TRUE["HR"], (8, 0, 0))
    assert choose(places(near, TRUE["HR"]), places()) == {}


def test_one_place_is_not_two_paws():
    shared = (20, 0, 2)
    found = choose(
        places(shared, TRUE["HR"]), join([places(shared, strength=0.5), places(TRUE["HL"])])
    )
    assert set(found) == {"FR", "HR", "HL"}


@pytest.mark.parametrize("away", [0.0, 0.4, 0.8])
def test_a_paw_in_line_with_a_surer_one_is_doubted(away):
    """FR is so many paw lengths from FL in cam3, farther in cam4."""
    left = np.array((20.0, 10.0, 2.0))
    # along this line cam3 sees the same place; 0.5 mm along x are 1 px there
    line = np.cross(COEFS[0:3, 2], COEFS[4:7, 2])
    right = left - 20.0 * line / abs(line[1]) * np.sign(line[1]) - (away * 20.0 * 0.5, 0, 0)
    uv = RIG.project(np.stack([left, right]))
    assert right[1] == -10.0
    assert np.linalg.norm(uv[0] - uv[1], axis=-1)[2] == pytest.approx(away * 20.0, abs=1e-9)
    unsure = places(left, TRUE["HL"], strength=0.2)
    clear = choose(places(), unsure)["FL"][1]
    doubted = choose(places(right, TRUE["HR"]), unsure)["FL"][1]
    assert doubted / clear == pytest.approx(1 - np.exp(-0.5 * (away / 0.5) ** 2), abs=1e-6)
    # the surer one is not doubted
    alone = choose(places(right, TRUE["HR"]), places())["FR"][1]
    assert choose(places(right, TRUE["HR"]), unsure)["FR"][1] == alone
