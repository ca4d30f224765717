"""The first fit of an animal whose body is small between long, thick legs."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from painted_walk import PX_PER_MM, PaintedReader, painted_walk

from pawnb.core.pose.fit.candidates.limb_kernels import chains_apart
from pawnb.core.pose.fit.fitter import make_fitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.learning.anatomy import anatomy
from pawnb.core.pose.fit.rendering.evidence import make_evidence
from pawnb.core.pose.fit.rendering.gauss_newton_kernels import ImageEvidence
from pawnb.core.pose.fit.rendering.paint_kernels import leg_chain, make_canvas, paint
from pawnb.core.pose.fit.sequence import first_frame
from pawnb.core.pose.fit.settings import PoseSettings
from pawnb.core.pose.poses import natural_pose
from pawnb.core.pose.species_file import load_species

SMALL = 0.4


def test_a_small_body_is_not_turned_onto_its_legs():
    animal, poses, reader, background = painted_walk(1)
    body = [
        dataclasses.replace(
            part, centre=(SMALL * part.centre[0], 0.0), length=SMALL * part.length,
            width=SMALL * part.width,
        )
        for part in animal.body
    ]  # fmt: skip
    legs = [
        dataclasses.replace(leg, attach=(SMALL * leg.attach[0], SMALL * leg.attach[1]))
        for leg in animal.legs
    ]
    animal = dataclasses.replace(animal, body=tuple(body), legs=tuple(legs))
    layout = make_layout(animal, px_per_unit=PX_PER_MM, dark=0.75)
    true = pose_vectors(animal, poses)[0]
    canvas = make_canvas(reader.height, reader.width, layout)
    paint(layout, true, 1.8, np.zeros(2), *canvas)
    picture = (background.mean * (1.0 - canvas[0])).astype(np.uint8)
    settings = PoseSettings()
    fitter = make_fitter(
        animal, layout,
        evidence=make_evidence(background, factor=1, light=0.0, spread=settings.unexplained_sd),
        anatomy=anatomy(animal, true, foreshortening_sd=settings.foreshortening_sd),
        settings=settings,
    )  # fmt: skip
    # as a person puts it on: a few pixels, a few degrees, each joint a little wrong
    rng = np.random.default_rng(4)
    clicked = true.copy()
    clicked[:2] += (2.0, -2.0)
    clicked[2] += np.radians(3.0)
    clicked[fitter.index.angles] += rng.normal(
        0.0, np.radians(3.0), len(clicked[fitter.index.angles])
    )
    found = first_frame._fit_body(
        fitter, PaintedReader([picture]).frame(0), clicked, first_frame.start_prior(fitter, clicked)
    )
    assert abs(np.degrees(found[2] - true[2])) < 8.0
    assert np.hypot(*(found[:2] - true[:2])) < 2.0


@pytest.mark.parametrize("name", ["spider", "dolomedes", "insect"])
def test_a_leg_is_slid_along_its_own_way(name):
    animal = load_species(name)
    layout = make_layout(animal, px_per_unit=2.0)
    at = natural_pose(animal, xy=(100.0, 80.0), heading_deg=35.0, scale=2.0)
    pose = pose_vectors(animal, at)[0]
    joints = np.zeros((2, layout.radius.shape[1], 2))
    for leg in range(len(animal.legs)):
        n = int(layout.n_segments[leg])
        numbers = pose[int(layout.first[leg]) :][: 2 * layout.n_links[leg]]
        np.testing.assert_allclose(
            first_frame.slid_leg(layout, pose, leg, factor=1.0), numbers, atol=1e-9
        )
        longer = pose.copy()
        longer[int(layout.first[leg]) :][: len(numbers)] = first_frame.slid_leg(
            layout, pose, leg, factor=1.1
        )
        for one, way in zip((pose, longer), joints, strict=True):
            leg_chain(layout, one, leg, way)
        assert chains_apart(joints[0], joints[1], n) < 0.1 * layout.length[leg].sum() + 0.6
        ahead = joints[0, n] - joints[0, n - 1]
        away = joints[1, n] - joints[0, n]
        assert np.hypot(*away) == pytest.approx(0.1 * layout.length[leg].sum(), abs=0.1)
        assert away @ ahead == pytest.approx(np.hypot(*away) * np.hypot(*ahead))


def test_a_leg_that_stops_short_of_a_bent_end_is_slid_out_to_it():
    animal = load_species("spider")
    at = natural_pose(animal, xy=(120.0, 120.0), scale=2.2)
    pose = pose_vectors(animal, at)[0]
    layout = make_layout(animal, px_per_unit=2.2, dark=0.75)
    leg = animal.leg_names.index("R1")
    numbers = int(layout.first[leg]) + np.arange(2 * layout.n_links[leg])
    true = pose.copy()
    links = layout.n_links[leg]
    true[numbers[links - 2 : links]] += np.radians(40.0)  # tarsus and metatarsus are bent
    canvas = make_canvas(240, 240, layout)
    paint(layout, true, 0.9, np.zeros(2), *canvas)
    image_evidence = ImageEvidence(
        canvas[0].copy(), np.full((240, 240), 1.0 / 0.12**2), np.zeros(2)
    )
    settings = PoseSettings()
    background = SimpleNamespace(mean=np.full((240, 240), 200.0), sd=np.ones((240, 240)))
    fitter = make_fitter(
        animal,
        layout,
        evidence=make_evidence(background, factor=1, light=0.0, spread=0.12),
        anatomy=anatomy(animal, pose, foreshortening_sd=0.12),
        settings=settings,
    )
    fitter = fitter.with_appearance(layout, blur=0.9)
    short = true.copy()
    short[numbers] = first_frame.slid_leg(layout, true, leg, factor=0.88)
    prior = first_frame.start_prior(fitter, pose)
    tip = fitter.joints(true)[leg, layout.n_segments[leg]]

    def off(found):
        return np.hypot(*(fitter.joints(found)[leg, layout.n_segments[leg]] - tip))

    assert off(fitter.fit(short, image_evidence, prior, rounds=30)[0]) > 2.0
    assert off(first_frame._slid_along(fitter, short, image_evidence, prior)) < 0.6
