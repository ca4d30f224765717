"""Names of legs, their order, and the pairs that are compared by default."""

from __future__ import annotations

import pytest

from pawnb.gait.legs import LegPlace, default_pairs, find_leg_place, sort_legs


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("FR", ("R", 1)), ("HL", ("L", 3)), ("L1", ("L", 1)), ("R12", ("R", 12)),
        ("LM", ("L", 2)), ("RH", ("R", 3)), ("MR", ("R", 2)),
        ("nose", None), ("L", None), ("fr", None), ("FRx", None),
    ],
)  # fmt: skip
def test_places_from_names(name, place):
    assert find_leg_place(name) == (None if place is None else LegPlace(*place))


def test_anatomical_order():
    assert sort_legs(["HL", "FL", "HR", "FR"]) == ["FR", "HR", "FL", "HL"]
    assert sort_legs(["R2", "L10", "R1", "L2", "L1"]) == ["L1", "L2", "L10", "R1", "R2"]
    assert sort_legs(["RH", "LF", "RF", "LM"]) == ["LF", "LM", "RF", "RH"]
    assert sort_legs(["tail", "b", "FL"]) == ["FL", "b", "tail"]


def test_pairs_of_four_paws():
    # left to right, fore to hind on each side, diagonals: the pairs of Hildebrand's gaits
    assert default_pairs(["FL", "FR", "HL", "HR"]) == [
        ("FL", "FR"), ("HL", "HR"), ("FR", "HR"), ("FL", "HL"), ("FR", "HL"), ("FL", "HR"),
    ]  # fmt: skip


def test_pairs_of_eight_legs():
    legs = [f"{side}{k}" for side in "LR" for k in range(1, 5)]
    pairs = default_pairs(legs)
    # paper 2009, section 4.2.4: four contralateral pairs, on each side six adjacent, four
    # adjacent but one and two adjacent but two
    assert len(pairs) == 16
    assert pairs[:4] == [("L1", "R1"), ("L2", "R2"), ("L3", "R3"), ("L4", "R4")]
    assert set(pairs[4:10]) == {(f"{s}{k}", f"{s}{k + 1}") for s in "LR" for k in (1, 2, 3)}
    assert set(pairs[10:14]) == {(f"{s}{k}", f"{s}{k + 2}") for s in "LR" for k in (1, 2)}
    assert set(pairs[14:]) == {("L1", "L4"), ("R1", "R4")}


def test_pairs_need_partners():
    assert default_pairs(["FR", "HR"]) == [("FR", "HR")]
    assert default_pairs(["a", "b"]) == []
