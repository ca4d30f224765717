"""The look of the synthetic spider's legs: they taper, pale towards the tip, add up in crossing."""

import dataclasses

import numpy as np
import pytest

from pawnb.synthetic.spider_paint import SpiderPainter
from pawnb.synthetic.spider_recording import record_spider
from pawnb.synthetic.spider_scene import draw_individual, spider_scene


def shade(**changes):
    """Paint one posture; return the recording's joints (legs, joints, 2) in the crop, and it."""
    scene = dataclasses.replace(spider_scene("easy", motion="still", seed=6, scale=1.0), **changes)
    individual = draw_individual(scene)
    recording = record_spider(scene, individual, 12)
    painted = SpiderPainter(scene, individual).paint(recording.joints_px[0], recording.bodies[0])
    return recording.joints_px[0, 0] - (painted.u0, painted.v0), painted


def sections(joints, painted, segment):
    """Light through along lines across the middle of a segment of each leg, (legs, 61)."""
    a, b = joints[:, segment], joints[:, segment + 1]
    step = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    k = np.arange(-7.5, 7.51, 0.25)
    at = 0.5 * (a + b)[:, None] + k[:, None] * np.stack([-step[:, 1], step[:, 0]], axis=1)[:, None]
    u, v = at.round().astype(int).transpose(2, 0, 1)
    return painted.through[v, u]


FEMUR, TIBIA, TARSUS = 2, 4, 6


def test_legs_taper_and_pale_towards_the_tip():
    joints, painted = shade()
    darkest = [np.median(sections(joints, painted, j).min(axis=1)) for j in (FEMUR, TIBIA, TARSUS)]
    assert darkest[0] < darkest[1] < darkest[2] < 0.5
    # as dark at the tip as at the root, only thin, the same leg lets less light through
    _, dark = shade(tip_density=3.2)
    thin = np.median(sections(joints, dark, TARSUS).min(axis=1))
    assert thin < darkest[2] - 0.08
    wide = [np.median((sections(joints, painted, j) < 0.6).sum(axis=1)) for j in (TIBIA, 5, TARSUS)]
    assert wide[0] > wide[1] > wide[2] > 0


def test_presets_differ_in_how_pale_tips_are():
    tips = []
    for name in ("easy", "normal", "hard"):
        joints, painted = shade(tip_density=spider_scene(name).tip_density)
        tips.append(np.median(sections(joints, painted, TARSUS).min(axis=1)))
    assert np.diff(tips).min() > 0.05


def test_what_is_stopped_is_replaced_by_the_grey_of_the_animal():
    _, painted = shade()
    assert painted.through.min() < 0.02
    assert painted.through.max() == pytest.approx(1.0)
    clear = painted.through > 0.999
    assert painted.own[clear].max() < 0.2
    assert 15.0 < painted.own[painted.through < 0.05].mean() < 60.0


def test_a_leg_over_a_leg_stops_the_light_of_both():
    scene = spider_scene("easy", motion="still", seed=6, scale=1.0)
    individual = draw_individual(scene)
    recording = record_spider(scene, individual, 12)
    painter = SpiderPainter(scene, individual)

    def through(joints):
        body = np.array([[-300.0, joints[0, 0, 1], 0.0]])  # away from the legs
        painted = painter.paint(joints[None], body)
        u, v = (joints[0, 6:8].mean(axis=0) - (painted.u0, painted.v0)).round().astype(int)
        return painted.through[v, u]

    apart = recording.joints_px[0, 0]
    alone = through(apart)
    crossed = apart.copy()
    crossed[1] = apart[0]  # the second leg lies exactly over the first
    # densities add up; blur lets in a little light from beside them
    assert alone**2 < through(crossed) < 0.5 * alone
