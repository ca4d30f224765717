"""Which figures of a whole study there are: by what it has, and whether it has groups."""

from __future__ import annotations

import numpy as np
import pytest
from test_save_figures import events

from pawnb.errors import InputError
from pawnb.gait import analyse_events, pool
from pawnb.gait.cycles import LegSignals
from pawnb.workflow.gait.drawing.overview_drawings import (
    curve_clusters,
    group_of_animals,
    overview_drawings,
)

JOINT = LegSignals(
    animal="a", trial="t1", legs=("L1",), time_s=np.arange(10) / 100.0,
    samples=np.zeros((10, 1)), signal="FP joint angle",
)  # fmt: skip


def tables(n=2):
    parts = [analyse_events(events().assign(animal=f"m{k}")) for k in range(n)]
    return pool(parts)


@pytest.mark.slow
def test_joints_are_compared_where_there_are_groups():
    groups = {("m0", "t1"): "a", ("m1", "t1"): "b"}
    alone = {"phase_density", "measure_heat_map", "measure_components"}
    assert {one.name for one in overview_drawings(tables(), joints=[JOINT])} == alone
    with_groups = overview_drawings(tables(), groups=groups, joints=[JOINT])
    assert {one.name for one in with_groups} == alone | {"curves_FP_joint_angle"}
    one_group = dict.fromkeys(groups, "a")
    assert {one.name for one in overview_drawings(tables(), groups=one_group)} == alone


def test_clusters_of_every_signal_are_one_table():
    """Joints of four animals in two groups; in the second one they are 10 degrees higher."""
    found = tables(4)
    groups = {(f"m{k}", "t1"): "ab"[k % 2] for k in range(4)}
    time_s = np.arange(120) / 100.0
    joints = [
        LegSignals(
            animal=f"m{k}", trial="t1", legs=("L1", "R1"), time_s=time_s, signal="FP joint angle",
            samples=np.full((120, 2), 10.0 * (k % 2) + 0.1 * k),
        )
        for k in range(4)
    ]  # fmt: skip
    table = curve_clusters(found, groups=groups, joints=joints)
    assert table["signal"].unique().tolist() == ["FP joint angle"]
    np.testing.assert_allclose(table["mean_difference"], 10.1)
    assert (table["method"] == "all 6 arrangements").all()
    assert curve_clusters(found, groups=None, joints=joints).empty
    assert curve_clusters(found, groups={("m0", "t1"): "a", ("m1", "t1"): "b"}).empty


def test_what_cannot_be_drawn_says_why():
    drawings = {one.name: one for one in overview_drawings(tables())}
    with pytest.raises(InputError, match="no signal of the legs; events alone"):
        drawings["phase_density"].draw()
    with pytest.raises(InputError, match="2 animals; expected 3 or more"):
        drawings["measure_heat_map"].draw()


def test_animals_of_several_conditions_have_no_group():
    groups = {("m1", "t1"): "a", ("m1", "t2"): "b", ("m2", "t1"): "a"}
    assert group_of_animals(groups) == {"m2": "a"}
    assert group_of_animals(None) == {}
