"""Lamps of the synthetic treadmill that flicker, and that stand below it."""

import numpy as np

from pawnb.synthetic.lamps import brightness, cast_shadow, lamp_direction
from pawnb.synthetic.scene import scene_settings
from pawnb.synthetic.surfaces import Mesh


def test_flicker_is_fast_and_about_the_mean():
    settings = scene_settings(changes={"flicker": 0.2})
    values = np.array([brightness(settings, t) for t in np.arange(0.0, 2.0, 0.0005)])
    assert abs(values.mean() - 1.0) < 0.01
    assert 0.15 < values.max() - 1.0 <= 0.2
    # lamps on mains of 50 Hz brighten a hundred times a second
    power = np.abs(np.fft.rfft(values - values.mean()))
    assert abs(np.fft.rfftfreq(len(values), 0.0005)[power.argmax()] - 100.0) < 1.0
    assert brightness(scene_settings(), 0.123) == 1.0


def test_lamps_below_cast_no_shadow_on_glass():
    usual, below = scene_settings(), scene_settings(changes={"below": True})
    np.testing.assert_allclose(lamp_direction(below), lamp_direction(usual) * [1, 1, -1])
    lid = np.array([[-9.0, -9, 20], [9, -9, 20], [9, 9, 20]])
    none = np.zeros((3, 2))
    mesh = Mesh(lid, lid, lid, none, none[:, 0], np.array([[0, 1, 2]]), np.array([0]))
    assert cast_shadow(mesh, usual).grid.max() > 0.0
    assert cast_shadow(mesh, below).grid.max() == 0.0
