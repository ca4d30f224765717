"""Pictures of the synthetic scene: visibility, the belt, the sensor."""

import dataclasses

import numpy as np
import pytest

from pawnb.synthetic.camera import make_cameras
from pawnb.synthetic.gait_model import plan_gait
from pawnb.synthetic.lamps import cast_shadow
from pawnb.synthetic.mouse import PAW, Mouse
from pawnb.synthetic.render import ViewRenderer, cover, paw_fractions
from pawnb.synthetic.scene import LEGS, scene_settings

QUIET = {"scale": 0.25, "read_noise": 0.0, "shot_noise": 0.0, "blur_px": 0.0}


def make_scene(**changes):
    """Settings, cameras and mouse of a small normal scene."""
    settings = scene_settings("normal", changes={"scale": 0.25, **changes})
    return settings, make_cameras(settings), Mouse(settings, plan_gait(settings, 0.5))


def only(mesh, keep):
    """The triangles of a mesh that ``keep`` marks, and nothing else."""
    return dataclasses.replace(mesh, faces=mesh.faces[keep], part=mesh.part[keep])


def test_a_paw_alone_is_seen_whole_and_none_where_there_is_none():
    settings, cameras, mouse = make_scene()
    mesh = mouse.mesh(1.03)
    for leg in LEGS:
        alone = only(mesh, mesh.part == PAW[leg])
        for camera in cameras:
            fractions = paw_fractions(alone, cover(alone, camera, settings))
            assert fractions[leg] == 1.0
            assert sum(fractions.values()) == 1.0


def test_the_fraction_is_what_a_count_of_samples_gives():
    settings, cameras, mouse = make_scene()
    for time_s in (1.0, 1.05, 1.1):
        mesh = mouse.mesh(time_s)
        for camera in cameras[:2]:
            whole = cover(mesh, camera, settings)
            claimed = paw_fractions(mesh, whole)
            seen = whole.fragments.winner >= 0
            part = mesh.part[whole.fragments.triangle[whole.fragments.winner[seen]]]
            for leg in LEGS:
                paw = only(mesh, mesh.part == PAW[leg])
                alone = np.count_nonzero(cover(paw, camera, settings).fragments.winner >= 0)
                # the box of a paw alone has its own corner, on whole pixels: same samples
                assert claimed[leg] == pytest.approx(np.count_nonzero(part == PAW[leg]) / alone)


@pytest.mark.slow
def test_marks_travel_with_the_belt():
    settings, cameras, mouse = make_scene(**QUIET, belt_marks=3.0)
    camera = cameras[0]
    renderer = ViewRenderer(camera, settings, 0)
    mesh = mouse.mesh(1.0)
    shadow = cast_shadow(mesh, settings)
    dt = 0.04
    frames = [
        renderer.render(mesh, shadow, frame=0, time_s=1.0 + k * dt)[0].astype(float).mean(axis=2)
        for k in range(12)
    ]
    still = np.mean(frames, axis=0)  # what does not move: light, walls, animal
    marks = np.array(frames) - still
    x, y = np.meshgrid(np.linspace(70, 150, 60), np.linspace(-50, 50, 40))
    here = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    carried = here - [settings.belt_speed_mm_s * dt, 0.0, 0.0]

    def sample(frame, ground):
        u, v = camera.project(ground)[0].round().astype(int).T
        return marks[frame][v, u]

    moved = np.corrcoef(sample(0, here), sample(1, carried))[0, 1]
    stayed = np.corrcoef(sample(0, here), sample(1, here))[0, 1]
    wrong_way = np.corrcoef(sample(0, here), sample(1, 2 * here - carried))[0, 1]
    assert moved > 0.6
    assert moved > stayed + 0.3
    assert moved > wrong_way + 0.3


@pytest.mark.slow
def test_noise_has_the_variance_that_was_asked_for():
    settings, cameras, mouse = make_scene(read_noise=3.0, shot_noise=8.0, belt_marks=0.0)
    renderer = ViewRenderer(cameras[0], settings, 0)
    quiet = dataclasses.replace(settings, read_noise=0.0, shot_noise=0.0)
    clean = ViewRenderer(cameras[0], quiet, 0)
    mesh = mouse.mesh(1.0)
    shadow = cast_shadow(mesh, settings)
    level = clean.render(mesh, shadow, frame=0, time_s=1.0)[0].astype(float)
    noise = [
        renderer.render(mesh, shadow, frame=k, time_s=1.0)[0].astype(float) - level
        for k in range(3)
    ]
    for low, high in ((20, 60), (90, 110), (140, 170)):
        here = (level >= low) & (level < high)
        expected = np.mean(3.0**2 + 8.0**2 * level[here] / 255.0)
        # rounding twice adds a little: 1/12 each
        assert np.var([n[here] for n in noise]) == pytest.approx(expected + 1 / 6, rel=0.05)
        assert abs(np.mean([n[here] for n in noise])) < 0.1
    correlation = np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]
    assert abs(correlation) < 0.02  # does not stay from frame to frame


def test_the_animal_darkens_the_belt_under_it_and_not_beside_it():
    settings, _, mouse = make_scene()
    mesh = mouse.mesh(1.0)
    shadow = cast_shadow(mesh, settings)
    middle = np.median(mesh.vertices[:, :2], axis=0)
    u, v = (middle - shadow.corner).round().astype(int)
    assert shadow.grid[v, u] > 0.25
    assert shadow.grid[2, 2] < 0.01
    assert shadow.grid.max() < 0.9


@pytest.mark.slow
def test_light_and_colours_are_those_of_the_settings():
    def picture(**changes):
        settings, cameras, mouse = make_scene(**QUIET, belt_marks=0.0, **changes)
        mesh = mouse.mesh(1.0)
        shadow = cast_shadow(mesh, settings)
        renderer = ViewRenderer(cameras[0], settings, 0)
        image = renderer.render(mesh, shadow, frame=0, time_s=1.0)[0].astype(float)
        u, v = cameras[0].project(np.array([100.0, 0.0, 0.0]))[0].round().astype(int)
        return image, image[v, u]

    usual, green = picture()
    # the belt as asked for, but for the veil of the wall and the fall of the light
    np.testing.assert_allclose(green, [108.0, 148.0, 108.0], atol=16.0)
    assert green[1] - green[0] > 25
    darker, _ = picture(light=0.5)
    assert darker.mean() == pytest.approx(0.5 * usual.mean(), rel=0.03)
    _, blue = picture(belt_rgb=[60.0, 80.0, 190.0])
    assert blue.argmax() == 2
