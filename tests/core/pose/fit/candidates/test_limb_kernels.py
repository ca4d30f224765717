"""Limbs are found where they were painted, from the body's place alone."""

import numpy as np
import pytest
from painted_walk import PX_PER_MM, painted_walk

from pawnb.core.parameters import parameters_set
from pawnb.core.pose.fit.candidates.leg_candidates import limb_search
from pawnb.core.pose.fit.candidates.limb_kernels import chains_apart, chains_cross, find_limbs
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import paint_some
from pawnb.core.pose.fit.rendering.paint_kernels import leg_chain, make_canvas
from pawnb.core.pose.poses import joint_positions


def test_distance_of_chains_is_blind_to_joints_along_the_limb():
    one = np.array([[0.0, 0.0], [5.0, 0.0], [10.0, 0.0]])
    other = np.array([[0.0, 0.0], [3.0, 0.0], [10.0, 0.0]])
    assert chains_apart(one, other, 2) == pytest.approx(0.0, abs=1e-12)
    assert chains_apart(one, other + np.array([0.0, 4.0]), 2) == pytest.approx(4.0)


def test_crossing():
    one = np.array([[0.0, 0.0], [10.0, 10.0]])
    assert chains_cross(one, 1, np.array([[0.0, 10.0], [10.0, 0.0]]), 1)
    assert not chains_cross(one, 1, np.array([[0.0, 10.0], [4.0, 6.0]]), 1)


@pytest.mark.slow
def test_one_of_the_best_limbs_of_each_leg_is_the_painted_one():
    animal, poses, reader, _ = painted_walk(1)
    pose = pose_vectors(animal, poses)[0]
    layout = make_layout(animal, px_per_unit=PX_PER_MM, dark=0.75)
    canvas = make_canvas(reader.height, reader.width, layout)
    prior = anatomy(animal, pose, foreshortening_sd=0.12)
    body = pose.copy()
    body[3:] = 0.0
    true = joint_positions(animal, poses)[0]
    for leg in range(8):
        # one leg alone: where all eight are seen, a neighbour's limb may offer more
        shown = np.arange(9) == leg
        paint_some(layout, pose, 1.8, np.zeros(2), shown, *canvas)
        numbers, support = find_limbs(
            layout, body, leg, canvas[0], np.zeros(2), prior, limb_search(), 5, 5.0
        )
        assert (np.diff(support) <= 0).all()
        trial, joints, away = body.copy(), np.zeros((8, 2)), []
        for found in numbers:
            trial[layout.first[leg] : layout.first[leg] + 10] = found
            leg_chain(layout, trial, leg, joints)
            away.append(chains_apart(joints, true[leg], 7))
        assert min(away) < 8.0


def test_a_limb_goes_on_behind_what_hides_it():
    animal, poses, reader, _ = painted_walk(1)
    pose = pose_vectors(animal, poses)[0]
    layout = make_layout(animal, px_per_unit=PX_PER_MM, dark=0.75)
    canvas = make_canvas(reader.height, reader.width, layout)
    prior = anatomy(animal, pose, foreshortening_sd=0.12)
    leg, body = 1, pose.copy()
    body[3:] = 0.0
    true = joint_positions(animal, poses)[0][leg]
    paint_some(layout, pose, 1.8, np.zeros(2), np.arange(9) == leg, *canvas)
    v, u = np.mgrid[: reader.height, : reader.width]
    veil = (u - true[4, 0]) ** 2 + (v - true[4, 1]) ** 2 < 22**2

    def nearest(hidden):
        seen = np.where(veil, hidden, canvas[0])
        numbers, _ = find_limbs(layout, body, leg, seen, np.zeros(2), prior, limb_search(), 2, 5.0)
        trial, joints, away = body.copy(), np.zeros((8, 2)), []
        for found in numbers:
            trial[layout.first[leg] : layout.first[leg] + 10] = found
            leg_chain(layout, trial, leg, joints)
            away.append(np.hypot(*(joints[7] - true[7])))
        return min(away)

    # where nothing can be seen it is found; where the ground is seen, it ends before
    assert nearest(np.nan) < 8.0
    assert nearest(0.0) > 12.0
    # how much counts as seen there can be set: light ground is nothing
    with parameters_set({"candidates": {"limb_hidden": 0.0}}):
        assert nearest(np.nan) > 12.0
