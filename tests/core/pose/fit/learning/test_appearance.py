"""Thickness and darkness of a painted animal are learnt from its picture."""

import dataclasses

import numpy as np
import pytest

from pawnb.core.pose.fit.layout import make_layout, meeting, pose_vectors
from pawnb.core.pose.fit.learning.appearance import learn_appearance
from pawnb.core.pose.fit.pose_index import partners
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence, Prior, fit_pose
from pawnb.core.pose.fit.rendering.paint_kernels import make_canvas, paint
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species


def unknown(n):
    """A prior that says nothing."""
    zero = np.zeros(n)
    return Prior(
        zero, zero, zero - 1e9, zero + 1e9, zero, np.full(n, -1), np.zeros(1), zero,
        np.zeros((0, 0)),
    )  # fmt: skip


def known(pose, sd):
    """A prior that says where a pose is."""
    precision = np.full(len(pose), 1.0 / sd**2)
    return unknown(len(pose))._replace(middle=pose, precision=precision)


@pytest.mark.slow
def test_thickness_and_darkness_come_back():
    animal = load_species("dolomedes")
    pose = pose_vectors(animal, natural_pose(animal, xy=(100.0, 100.0), scale=2.4))[0]
    first = make_layout(animal, px_per_unit=2.4, dark=0.8)
    true = make_layout(animal, px_per_unit=2.4, dark=0.65, size=1.25)
    true.ellipse[:, 3] *= 1.08
    true.ellipse[:2, 5] = 0.1
    canvas = make_canvas(200, 200, true)
    paint(true, pose, 2.0, np.zeros(2), *canvas)
    image_evidence = ImageEvidence(canvas[0].copy(), np.full((200, 200), 70.0), np.zeros(2))
    found = learn_appearance(
        first, [(pose, image_evidence)], first=first, partner=partners(animal),
        prior=known(pose, 0.01), blur=2.0, soft=0.45, rounds=8,
    )  # fmt: skip
    # the femora lie clear of the body and of each other
    np.testing.assert_allclose(found.radius[:, 3:6], true.radius[:, 3:6], rtol=0.06)
    np.testing.assert_allclose(found.dark[:, 3:6], true.dark[:, 3:6], atol=0.05)
    np.testing.assert_allclose(found.ellipse[:, 3], true.ellipse[:, 3], rtol=0.03)
    np.testing.assert_allclose(found.ellipse[:2, 5], 0.1, atol=0.02)


def test_where_a_body_of_unknown_shape_lies_is_told_by_its_waist():
    animal = load_species("dolomedes")
    pose = pose_vectors(animal, natural_pose(animal, xy=(100.0, 100.0), scale=2.4))[0]
    first = make_layout(animal, px_per_unit=2.4)
    true = make_layout(animal, px_per_unit=2.4)
    true.ellipse[0, [0, 2]] *= 1.10  # longer in front, wider behind, parts that overlap
    true.ellipse[1, 3] *= 1.06
    true.ellipse[:2, 0] -= np.array([0.4, -0.4])
    true.ellipse[-1, 3] *= 1.5
    canvas = make_canvas(200, 200, true)
    paint(true, pose, 2.0, np.zeros(2), *canvas)
    image_evidence = ImageEvidence(canvas[0].copy(), np.full((200, 200), 70.0), np.zeros(2))
    away = pose.copy()
    away[0] += 0.8
    found = first
    sd = np.full(len(pose), 0.2)
    sd[:2] = np.inf
    around = known(pose, sd)
    for _ in range(3):
        found = learn_appearance(
            found, [(away, image_evidence)], first=first, partner=partners(animal),
            prior=around, blur=2.0, soft=0.45,
        )  # fmt: skip
        away, _ = fit_pose(
            found,
            away,
            image_evidence,
            unknown(len(pose)),
            np.arange(3),
            np.ones(9, bool),
            2.0,
            0.45,
            8,
            1e-3,
            *canvas,
        )
    assert away[:2] == pytest.approx(pose[:2], abs=0.05)
    np.testing.assert_allclose(found.ellipse[:2, :4], true.ellipse[:2, :4], atol=0.25)
    assert found.ellipse[-1, 3] == pytest.approx(true.ellipse[-1, 3], rel=0.1)


def test_a_look_is_learnt_where_legs_and_body_disagree_about_its_place():
    animal = load_species("spider")
    pose = pose_vectors(animal, natural_pose(animal, xy=(100.0, 100.0), scale=1.6))[0]
    first = make_layout(animal, px_per_unit=1.6)
    ahead = first._replace(attach=first.attach + np.array([2.0, 0.0]))
    canvas = make_canvas(200, 200, first)
    paint(ahead, pose, 1.8, np.zeros(2), *canvas)
    image_evidence = ImageEvidence(canvas[0].copy(), np.full((200, 200), 70.0), np.zeros(2))
    prior, look, costs = known(pose, 0.14), first, []
    for _ in range(4):
        pose, cost = fit_pose(
            look,
            pose,
            image_evidence,
            prior,
            np.arange(len(pose)),
            np.ones(9, bool),
            1.8,
            0.45,
            20,
            0.1,
            *canvas,
        )
        costs.append(cost)
        look = learn_appearance(
            look,
            [(pose, image_evidence)],
            first=first,
            partner=partners(animal),
            prior=prior,
            blur=1.8,
            soft=0.45,
        )
    # a step that heeds only what the body says runs away: the cost rose from -4277 to -3609
    assert np.diff(costs).max() < 1.0, costs


def test_a_body_whose_parts_do_not_meet_has_no_waist():
    animal = load_species("dolomedes")
    ellipse = make_layout(animal, px_per_unit=2.0).ellipse
    assert meeting(ellipse).tolist() == [1.0, -1.0, 0.0]
    ahead = dataclasses.replace(animal, body=animal.body[:1])
    assert len(make_layout(ahead, px_per_unit=2.0).ellipse) == 1
    assert meeting(ellipse + np.array([4.0, 0, 0, 0, 0, 0, 0])).tolist() == [0.0, 0.0, 0.0]


def test_partners_are_the_legs_across():
    animal = load_species("dolomedes")
    names = animal.leg_names
    for i, j in enumerate(partners(animal)):
        assert names[i][1] == names[j][1]
        assert names[i][0] != names[j][0]
    lone = animal.without(["L1"])
    assert lone.leg_names[partners(lone)[lone.leg_names.index("R1")]] == "R1"


def test_a_pattern_in_the_middle_of_a_part_does_not_move_its_edge():
    animal = load_species("dolomedes")
    pose = pose_vectors(animal, natural_pose(animal, xy=(100.0, 100.0), scale=2.4))[0]
    first = make_layout(animal, px_per_unit=2.4)
    true = make_layout(animal, px_per_unit=2.4)
    true.ellipse[1, 6] -= 0.2
    canvas = make_canvas(200, 200, true)
    paint(true, pose, 2.0, np.zeros(2), *canvas)
    image_evidence = ImageEvidence(canvas[0].copy(), np.full((200, 200), 70.0), np.zeros(2))
    found = learn_appearance(
        first,
        [(pose, image_evidence)],
        first=first,
        partner=partners(animal),
        prior=unknown(len(pose)),
        blur=2.0,
        soft=0.45,
        rounds=8,
    )
    assert found.ellipse[1, 4] - found.ellipse[1, 6] == pytest.approx(0.2, abs=0.02)
    np.testing.assert_allclose(found.ellipse[1, :4], true.ellipse[1, :4], atol=0.05)
