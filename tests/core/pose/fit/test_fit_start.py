"""The first fit of an animal whose body is small between long, thick legs."""

from __future__ import annotations

import dataclasses

import numpy as np
from painted_walk import PX_PER_MM, PaintedReader, painted_walk

from pawnb.core.pose.fit import start
from pawnb.core.pose.fit.evidence import Evidence
from pawnb.core.pose.fit.fitter import FrameFitter
from pawnb.core.pose.fit.layout import make_layout, pose_vectors
from pawnb.core.pose.fit.paint_loops import make_canvas, paint
from pawnb.core.pose.fit.priors import anatomy
from pawnb.core.pose.fit.settings import PoseSettings

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
    fitter = FrameFitter(
        animal, layout,
        evidence=Evidence(background, factor=1, light=0.0, spread=settings.unexplained_sd),
        anatomy=anatomy(animal, true, foreshortening_sd=settings.foreshortening_sd),
        settings=settings,
    )  # fmt: skip
    # as a person puts it on: a few pixels, a few degrees, each joint a little wrong
    rng = np.random.default_rng(4)
    clicked = true.copy()
    clicked[:2] += (2.0, -2.0)
    clicked[2] += np.radians(3.0)
    clicked[fitter.angles] += rng.normal(0.0, np.radians(3.0), len(clicked[fitter.angles]))
    found = start._fit_body(
        fitter, PaintedReader([picture]).frame(0), clicked, start.start_prior(fitter, clicked)
    )
    assert abs(np.degrees(found[2] - true[2])) < 8.0
    assert np.hypot(*(found[:2] - true[:2])) < 2.0
