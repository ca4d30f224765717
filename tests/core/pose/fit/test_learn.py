"""Thickness and darkness of a painted animal are learnt from its picture."""

import numpy as np

from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learn import learn_look
from pawnb.core.pose.fit.paint_loops import make_canvas, paint
from pawnb.core.pose.fit.solve_loops import Sight
from pawnb.core.pose.fit.start import partners
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species


def test_thickness_and_darkness_come_back():
    animal = load_species("dolomedes")
    pose = pose_vectors(animal, natural_pose(animal, xy=(100.0, 100.0), scale=2.4))[0]
    first = make_layout(animal, px_per_unit=2.4, dark=0.8)
    true = make_layout(animal, px_per_unit=2.4, dark=0.65, size=1.25)
    true.ellipse[:, 3] *= 1.08
    true.ellipse[:, 5] = 0.1
    canvas = make_canvas(200, 200, true)
    paint(true, pose, 2.0, np.zeros(2), *canvas)
    sight = Sight(canvas[0].copy(), np.full((200, 200), 70.0), np.zeros(2))
    found = learn_look(
        first, [(pose, sight)], first=first, partner=partners(animal), blur=2.0, soft=0.45,
        rounds=8,
    )  # fmt: skip
    # the femora lie clear of the body and of each other
    np.testing.assert_allclose(found.radius[:, 3:6], true.radius[:, 3:6], rtol=0.06)
    np.testing.assert_allclose(found.dark[:, 3:6], true.dark[:, 3:6], atol=0.05)
    np.testing.assert_allclose(found.ellipse[:, 3], true.ellipse[:, 3], rtol=0.03)
    assert (found.ellipse[:, 5] > 0.03).all()


def test_partners_are_the_legs_across():
    animal = load_species("dolomedes")
    names = animal.leg_names
    for i, j in enumerate(partners(animal)):
        assert names[i][1] == names[j][1]
        assert names[i][0] != names[j][0]
    lone = animal.without(["L1"])
    assert lone.leg_names[partners(lone)[lone.leg_names.index("R1")]] == "R1"
